//! Calibration without keeping a single reading: 66 sums are all that its optimum depends on.
//!
//! |B|² = m(V)ᵀ θ(x), m = (V_x², V_y², V_z², V_xV_y, V_xV_z, V_yV_z, V_x, V_y, V_z, 1)
//!
//! so that with the weight w = 1 / 4I², which makes the residuals scatter alike (they are then the
//! errors of the norm, but for their squares),
//!
//! Σ w (|B|² − I²)² = θᵀ A θ − 2 θᵀ u + v,  A = Σ w m mᵀ, u = Σ w I² m, v = Σ w I⁴
//!
//! for *any* x. A reading costs 66 multiplications when it comes and is then forgotten; Gauss–Newton runs
//! over the sums, at any time, for scale and bias alone (N = 6) or with cross-axis terms (N = 9). With a
//! factor below one the past fades, and the calibration follows a sensor that changes.
//!
//! The cost is a small difference of large numbers: 1e-3 of them for a noise of 600 nT. In f32 it takes
//! away some digits of sigma, and none from the result that sigma would not cover.

use nalgebra::{ComplexField, Matrix3, RealField, SMatrix, SVector, Vector3};

use super::descent::{MAX_PASSES, Pass, Problem, descend};
use super::error::CalibrationError;
use super::extended::from_zero;
use super::gauss_newton::{answering, supported};
use super::parameters::Parameters;
use super::symmetric::Spectrum;
use super::{DataSheet, Sample, number, shown};

/// How many monomials there are.
const MONOMIALS: usize = 10;
/// How uncertain the cost is, in roundings of v for each sample.
const COST_ROUNDINGS: f64 = 10.0;

/// The sums so far.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sums<T: RealField + Copy> {
    data_sheet: DataSheet<T>,
    unit: T,
    a: SMatrix<T, MONOMIALS, MONOMIALS>,
    u: SVector<T, MONOMIALS>,
    v: T,
    /// Samples, faded ones as fractions.
    weight: T,
    samples: u32,
}

/// A calibration from sums.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Recursive<T: RealField + Copy, const N: usize> {
    /// The result.
    pub parameters: Parameters<T, N>,
    /// Its covariance, from the residuals.
    pub covariance: SMatrix<T, N, N>,
    /// Root mean square of (|B|² − |B_IGRF|²) / 2 |B_IGRF|.
    pub norm_error_rms: T,
    /// Condition of JᵀJ with its columns scaled to equal length.
    pub condition: T,
}

impl<T: RealField + Copy, const N: usize> Recursive<T, N> {
    /// Standard deviations of the unknowns.
    pub fn sigma(&self) -> Parameters<T, N> {
        Parameters(self.covariance.diagonal().map(|variance| variance.max(T::zero()).sqrt()))
    }
}

impl<T: RealField + Copy> Sums<T> {
    /// Sums of nothing, for a sensor by this data sheet in fields of about `strength`.
    ///
    /// # Errors
    /// [`CalibrationError`] when one of these is no number that a sensor or a field can have.
    pub fn new(data_sheet: DataSheet<T>, strength: T) -> Result<Self, CalibrationError> {
        let DataSheet { sensitivity, zero } = data_sheet;
        let positive = |x: T| x.is_finite() && x > T::zero();
        if !positive(sensitivity) {
            return Err(CalibrationError::Sensitivity { found: shown(sensitivity) });
        }
        if !zero.is_finite() {
            return Err(CalibrationError::Zero { found: shown(zero) });
        }
        if !positive(strength) {
            return Err(CalibrationError::Intensity { sample: 0, found: shown(strength) });
        }
        Ok(Self {
            data_sheet,
            unit: strength,
            a: SMatrix::zeros(),
            u: SVector::zeros(),
            v: T::zero(),
            weight: T::zero(),
            samples: 0,
        })
    }

    /// How many readings went in.
    pub fn samples(&self) -> u32 {
        self.samples
    }

    /// Takes a reading in; the sums stay as they are when it is refused.
    ///
    /// # Errors
    /// [`CalibrationError`]: a reading that is not finite, or a strength that is not positive.
    pub fn add(
        &mut self,
        Sample { reading, intensity }: Sample<T>,
    ) -> Result<(), CalibrationError> {
        let sample = self.samples;
        if !reading.iter().all(T::is_finite) || !intensity.is_finite() {
            return Err(CalibrationError::NotFinite { sample });
        }
        if intensity <= T::zero() {
            return Err(CalibrationError::Intensity { sample, found: shown(intensity) });
        }
        let DataSheet { sensitivity, zero } = self.data_sheet;
        let [x, y, z] = reading.map(|value| (value - zero) * sensitivity / self.unit);
        let strength = intensity / self.unit;
        let squared = strength * strength;
        let half_root = T::one() / (strength * number(2.0));
        let m = SVector::from([x * x, y * y, z * z, x * y, x * z, y * z, x, y, z, T::one()])
            * half_root;
        let next = Self {
            a: self.a + m * m.transpose(),
            u: self.u + m * (squared * half_root),
            v: self.v + squared * number(0.25),
            weight: self.weight + T::one(),
            samples: self.samples.saturating_add(1),
            ..*self
        };
        if !next.is_finite() {
            return Err(CalibrationError::OutOfRange);
        }
        *self = next;
        Ok(())
    }

    fn is_finite(&self) -> bool {
        self.a.iter().chain(self.u.iter()).chain([&self.v]).all(ComplexField::is_finite)
    }

    /// Lets the past fade: it counts for `factor` (0 to 1) of what it did.
    pub fn fade(&mut self, factor: T) {
        let usable = factor >= T::zero() && factor <= T::one();
        if usable {
            self.a *= factor;
            self.u *= factor;
            self.v *= factor;
            self.weight *= factor;
        }
    }

    /// Scale and bias (`N` = 6), or cross-axis terms too (`N` = 9), from the data sheet on.
    ///
    /// # Errors
    /// [`CalibrationError`]: what the readings so far cannot support. The sums stay.
    pub fn calibration<const N: usize>(&self) -> Result<Recursive<T, N>, CalibrationError> {
        const { assert!(N == 6 || N == 9, "sums know scale, bias and cross-axis terms") };
        let needed = 2 * N as u32;
        let enough = self.weight >= number(f64::from(needed));
        if !enough {
            return Err(CalibrationError::TooFew { found: self.samples, needed });
        }
        let start = SVector::<T, N>::from_fn(|i, _| if i < 3 { T::one() } else { T::zero() });
        let found = descend(self, start)?;
        supported(&found.pass.normal)?;
        if !found.converged {
            return Err(CalibrationError::NotConverged { passes: MAX_PASSES });
        }
        let x = Parameters(found.x).with_positive_scales();
        let pass = self.pass(&x.0);
        let spectrum = Spectrum::of(&pass.normal);
        let variance = pass.cost.max(T::zero()) / (self.weight - number(N as f64));
        let field_per_reading = self.data_sheet.sensitivity;
        let units = SVector::<T, N>::from_fn(|i, _| match i {
            0..3 => field_per_reading,
            3..6 => self.unit,
            _ => T::one(),
        });
        let (parameters, transform) =
            from_zero(&Parameters(x.0.component_mul(&units)), self.data_sheet.zero);
        let covariance =
            (spectrum.inverse() * variance).component_mul(&(units * units.transpose()));
        let found = Recursive {
            parameters,
            covariance: transform * covariance * transform.transpose(),
            norm_error_rms: (pass.cost.max(T::zero()) / self.weight).sqrt() * self.unit,
            condition: spectrum.condition(),
        };
        let mut values = found.parameters.0.iter().chain(found.covariance.iter());
        if !values.all(ComplexField::is_finite) {
            return Err(CalibrationError::OutOfRange);
        }
        answering(found.parameters.scale(), found.sigma().scale())?;
        Ok(found)
    }
}

impl<T: RealField + Copy, const N: usize> Problem<T, N> for Sums<T> {
    fn pass(&self, x: &SVector<T, N>) -> Pass<T, N> {
        let x = Parameters(*x);
        let theta = monomial_factors(&x);
        let slope = monomial_slopes(&x);
        let a_theta = self.a * theta;
        Pass {
            cost: theta.dot(&(a_theta - self.u * number::<T>(2.0))) + self.v,
            gradient: slope.tr_mul(&(a_theta - self.u)),
            normal: slope.tr_mul(&(self.a * slope)),
        }
    }

    fn cancellation(&self) -> T {
        self.v * T::default_epsilon() * number(COST_ROUNDINGS)
    }
}

/// Six numbers of a symmetric matrix, those beside the diagonal twice, then the three of a vector and one.
fn row_of<T: RealField + Copy>(
    square: &Matrix3<T>,
    linear: &Vector3<T>,
    constant: T,
) -> SVector<T, MONOMIALS> {
    let [[xx, xy, xz], [_, yy, yz], [_, _, zz]] = (*square).into();
    let two = number::<T>(2.0);
    SVector::from([
        xx,
        yy,
        zz,
        xy * two,
        xz * two,
        yz * two,
        linear.x,
        linear.y,
        linear.z,
        constant,
    ])
}

/// θ: |C S V + b|² = Vᵀ (S C² S) V + 2 (S C b) · V + |b|², S = diag(s).
fn monomial_factors<T: RealField + Copy, const N: usize>(
    x: &Parameters<T, N>,
) -> SVector<T, MONOMIALS> {
    let (matrix, bias) = (x.matrix(), Vector3::from(x.bias()));
    let linear = matrix.tr_mul(&bias) * number::<T>(2.0);
    row_of(&matrix.tr_mul(&matrix), &linear, bias.norm_squared())
}

/// ∂θ/∂x. With dM and db: Mᵀ dM + dMᵀ M, 2 (dMᵀ b + Mᵀ db), 2 b · db.
fn monomial_slopes<T: RealField + Copy, const N: usize>(
    x: &Parameters<T, N>,
) -> SMatrix<T, MONOMIALS, N> {
    let (matrix, bias) = (x.matrix(), Vector3::from(x.bias()));
    let (zero, one, two) = (T::zero(), T::one(), number::<T>(2.0));
    // ∂B/∂x is linear in the reading and in what stands beside it: the columns of dM, and db.
    let axes = [[one, zero, zero], [zero, one, zero], [zero, zero, one]];
    let [of_x, of_y, of_z] = axes.map(|axis| x.jacobian(axis, zero, &[]));
    let of_bias = x.jacobian([zero; 3], one, &[]);
    let mut slopes = SMatrix::<T, MONOMIALS, N>::zeros();
    let columns = of_x.column_iter().zip(of_y.column_iter()).zip(of_z.column_iter());
    for ((mut slope, ((x, y), z)), db) in
        slopes.column_iter_mut().zip(columns).zip(of_bias.column_iter())
    {
        let dm = Matrix3::from_columns(&[x, y, z]);
        let half = matrix.tr_mul(&dm);
        let linear = (dm.tr_mul(&bias) + matrix.tr_mul(&db)) * two;
        slope.copy_from(&row_of(&(half + half.transpose()), &linear, bias.dot(&db) * two));
    }
    slopes
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Of central differences of polynomials of degree four, of order one.
    const DIFFERENCES: f64 = 1e-7;

    proptest! {
        #[test]
        fn the_slopes_are_derivatives_and_the_factors_give_the_strength(
            x in prop::array::uniform9(-1.0..1.0_f64),
            v in prop::array::uniform3(-1.0..1.0_f64),
        ) {
            const STEP: f64 = 1e-5;
            let at = Parameters::<f64, 9>(SVector::from(x));
            let [a, b, c] = v;
            let m = SVector::from([a * a, b * b, c * c, a * b, a * c, b * c, a, b, c, 1.0]);
            let strength = Vector3::from(at.field(v, &[])).norm_squared();
            prop_assert!((m.dot(&monomial_factors(&at)) - strength).abs() < DIFFERENCES);
            let slopes = monomial_slopes(&at);
            for i in 0..9 {
                let moved = |by: f64| {
                    let mut moved = at;
                    moved.0[i] += by;
                    monomial_factors(&moved)
                };
                let numeric = (moved(STEP) - moved(-STEP)) / (2.0 * STEP);
                prop_assert!((numeric - slopes.column(i)).norm() < DIFFERENCES);
            }
        }
    }
}
