//! Gauss–Newton for axes that are not square and for currents nearby, and without the shift that noise
//! makes in |B|².
//!
//! | symbol | code | meaning |
//! |---|---|---|
//! | β | `Parameters::field` | C (s ∘ V) + b + Σ k_j I_j |
//! | r = \|β\|² − I² | `residual` | E = Σ r², the paper's eq. (4) with more unknowns |
//! | Φ = ∂β/∂x | `jacobian` | 3×N; a row of J is 2 Φᵀβ |
//! | M = C diag(s) | `matrix` | what noise of a reading is turned into |
//!
//! **The shift by noise.** Readings with noise σ make β = β₀ + ε, ε = M δV, and Φ = Φ₀ + Σ δV_i Φ_i. The
//! gradient Σ r j then does not vanish at the truth, but has the mean
//!
//! h = 2 Σ [ tr(Σ_ε) Φᵀβ + 2 Φᵀ Σ_ε β + 2 σ² Σ_i (β · M e_i) Φ_iᵀ β ],  Σ_ε = σ² M Mᵀ
//!
//! up to σ⁴: the corrected estimate solves Σ r j = h (x) with σ² from the residuals, whose variance is
//! 4 βᵀ Σ_ε β. For three equal scales seen from all directions this is the shift −3.5 σ² Σ I² / Σ I⁴.
//!
//! Sources: Springmann & Cutler (2012), J. Guid. Control Dyn. 35(4), for couplings to currents; Nakamura
//! (1990), Biometrika 77(1), 127–137, for corrected scores.

use nalgebra::{Matrix3, RealField, SMatrix, SVector, Vector3};

use super::descent::{MAX_PASSES, Pass, Problem, descend};
use super::error::CalibrationError;
use super::gauss_newton::{Units, answering, supported};
use super::parameters::Parameters;
use super::symmetric::{Spectrum, sigmas};
use super::{Sample, Start, UNKNOWNS, linear, number, shown};

/// Steps of the correction for noise. Each leaves a part σ²/I² of the error: four are plenty.
const NOISE_STEPS: u32 = 6;

/// A reading of the magnetometer beside what flows nearby.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CoupledSample<T, const C: usize> {
    /// The reading, and the strength of the model's field.
    pub sample: Sample<T>,
    /// Currents of panels or torquers, A; or dipoles of torquers, A·m².
    pub currents: [T; C],
}

impl<T> From<Sample<T>> for CoupledSample<T, 0> {
    fn from(sample: Sample<T>) -> Self {
        Self { sample, currents: [] }
    }
}

/// What is done about the shift that noise makes in |B|².
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NoiseShift {
    /// Nothing: the result is the optimum of E.
    Kept,
    /// It is taken out, with the noise that the residuals show.
    Removed,
}

/// A calibration with N unknowns: 6 (scale, bias), or 9 (cross-axis terms) and three for each current.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Extended<T: RealField + Copy, const N: usize> {
    /// The result.
    pub parameters: Parameters<T, N>,
    /// Its covariance, from the residuals; of noise that is new in every sample, and of nothing else.
    pub covariance: SMatrix<T, N, N>,
    /// E = Σ (|B|² − |B_IGRF|²)².
    pub cost: T,
    /// Root mean square of (|B|² − |B_IGRF|²) / 2 |B_IGRF|: the error of the norm, but for its square.
    pub norm_error_rms: T,
    /// Noise of an axis of the sensor that would leave these residuals, in units of a reading.
    pub noise: T,
    /// Condition of JᵀJ with its columns scaled to equal length.
    pub condition: T,
    /// How many samples there were.
    pub samples: u32,
    /// Steps taken.
    pub iterations: u32,
}

impl<T: RealField + Copy, const N: usize> Extended<T, N> {
    /// Standard deviations of the unknowns.
    pub fn sigma(&self) -> Parameters<T, N> {
        Parameters(sigmas(&self.covariance))
    }

    fn is_finite(&self) -> bool {
        let others = [self.cost, self.norm_error_rms, self.noise, self.condition];
        let all = self.parameters.0.iter().chain(&others).chain(self.covariance.iter());
        all.copied().all(|value| value.is_finite())
    }
}

/// Finds scale, bias, cross-axis terms and couplings of `C` currents with the least E.
///
/// `N` is 6 with `C` = 0 for the paper's model, and 9 + 3 `C` otherwise; anything else does not compile.
/// Readings with currents are welcome: what the currents do is found from them.
///
/// # Errors
/// [`CalibrationError`], as of [`calibrate`](super::calibrate); a current that never changes cannot be
/// told from a bias.
pub fn calibrate_extended<T, const C: usize, const N: usize, I>(
    samples: I,
    start: &Start<T>,
    shift: NoiseShift,
) -> Result<Extended<T, N>, CalibrationError>
where
    T: RealField + Copy,
    I: IntoIterator<Item = CoupledSample<T, C>>,
    I::IntoIter: Clone,
{
    const { assert!(N == 9 + 3 * C || (N == UNKNOWNS && C == 0), "6, or 9 and 3 for each current") };
    let samples = samples.into_iter();
    let (Start::DataSheet(super::DataSheet { zero, .. }) | Start::Linear { zero }) = *start;
    let units = CoupledUnits::<T, C>::of(samples.clone(), zero)?;
    units.of_readings.at_least(2 * N as u32)?;
    let walk = Walk(samples.map(move |sample| units.scaled(sample)));
    let six = match start {
        Start::DataSheet(data_sheet) => units.of_readings.start(data_sheet)?,
        Start::Linear { .. } => linear::start(walk.0.clone().map(|coupled| coupled.sample))?,
    };
    let found = descend(&walk, widened(&six))?;
    supported(&found.pass.normal)?;
    if !found.converged {
        return Err(CalibrationError::NotConverged { passes: MAX_PASSES });
    }
    let mut x = Parameters(found.x).with_positive_scales();
    let variance = units.of_readings.reading.map(|unit| T::one() / (unit * unit));
    let mut noise = walk.noise(&x, variance, units.of_readings.samples);
    if shift == NoiseShift::Removed {
        for _ in 0..NOISE_STEPS {
            let pass = walk.pass(&x.0);
            let mean = walk.gradient_of_noise(&x, variance.map(|one| one * noise * noise));
            let step = Spectrum::of(&pass.normal).step(&(pass.gradient - mean), T::zero());
            x = Parameters(x.0 + step);
        }
        noise = walk.noise(&x, variance, units.of_readings.samples);
    }
    units.finished(&walk, x, found.steps, noise)
}

/// Six unknowns as the first of N.
fn widened<T: RealField + Copy, const N: usize>(six: &SVector<T, UNKNOWNS>) -> SVector<T, N> {
    let mut x = SVector::<T, N>::zeros();
    for (wide, value) in x.iter_mut().zip(six.iter()) {
        *wide = *value;
    }
    x
}

/// B by the zero of the data sheet as B of readings counted from nothing: b − C (s V₀).
pub(super) fn from_zero<T: RealField + Copy, const N: usize>(
    x: &Parameters<T, N>,
    zero: T,
) -> (Parameters<T, N>, SMatrix<T, N, N>) {
    // ∂(b − C (s V₀)) / ∂x, the reading being −V₀.
    let slope = x.jacobian([-zero; 3], T::one(), &[]);
    let moved = x.matrix() * Vector3::repeat(-zero) + Vector3::from(x.bias());
    let mut parameters = *x;
    for (value, bias) in parameters.0.iter_mut().skip(3).zip(moved.iter()) {
        *value = *bias;
    }
    let transform = SMatrix::from_fn(|i, j| match i {
        3..6 => slope.get((i - 3, j)).copied().unwrap_or(T::zero()),
        _ if i == j => T::one(),
        _ => T::zero(),
    });
    (parameters, transform)
}

/// Units in which readings, fields and currents are of order one.
#[derive(Debug, Clone, Copy)]
struct CoupledUnits<T, const C: usize> {
    of_readings: Units<T>,
    of_currents: [T; C],
}

impl<T: RealField + Copy, const C: usize> CoupledUnits<T, C> {
    fn of(
        samples: impl Iterator<Item = CoupledSample<T, C>> + Clone,
        zero: T,
    ) -> Result<Self, CalibrationError> {
        let of_readings = Units::of(samples.clone().map(|coupled| coupled.sample), zero)?;
        let mut of_currents = [T::zero(); C];
        let mut first = None;
        let mut varies = [false; C];
        for (sample, CoupledSample { currents, .. }) in (0..).zip(samples) {
            if !currents.iter().all(T::is_finite) {
                return Err(CalibrationError::NotFinite { sample });
            }
            let first = *first.get_or_insert(currents);
            for (((largest, varies), value), first) in
                of_currents.iter_mut().zip(&mut varies).zip(currents).zip(first)
            {
                *largest = largest.max(value.abs());
                *varies |= value != first;
            }
        }
        for ((varies, current), index) in varies.into_iter().zip(of_currents).zip(0..) {
            if !varies {
                return Err(CalibrationError::ConstantCurrent { index, found: shown(current) });
            }
        }
        Ok(Self { of_readings, of_currents })
    }

    fn scaled(&self, coupled: CoupledSample<T, C>) -> CoupledSample<T, C> {
        let mut currents = coupled.currents;
        for (current, unit) in currents.iter_mut().zip(self.of_currents) {
            *current /= unit;
        }
        CoupledSample { sample: self.of_readings.scaled(coupled.sample), currents }
    }

    fn of_unknowns<const N: usize>(&self) -> SVector<T, N> {
        let (field, one) = (self.of_readings.intensity, T::one());
        let [x, y, z] = self.of_readings.reading.map(|reading| field / reading);
        let first = [x, y, z, field, field, field, one, one, one].into_iter();
        let currents = self.of_currents.iter().flat_map(|&current| [field / current; 3]);
        let mut units = SVector::<T, N>::zeros();
        for (unit, value) in units.iter_mut().zip(first.chain(currents)) {
            *unit = value;
        }
        units
    }

    fn finished<const N: usize>(
        &self,
        walk: &Walk<impl Iterator<Item = CoupledSample<T, C>> + Clone>,
        x: Parameters<T, N>,
        iterations: u32,
        noise: T,
    ) -> Result<Extended<T, N>, CalibrationError> {
        let Units { zero, intensity, samples, .. } = self.of_readings;
        let pass = walk.pass(&x.0);
        let spectrum = Spectrum::of(&pass.normal);
        let count = number::<T>(f64::from(samples));
        let freedom = count / (count - number(N as f64));
        let inverse = spectrum.inverse();
        let covariance = inverse * walk.scatter(&x) * inverse * freedom;
        let units = self.of_unknowns();
        let (parameters, transform) = from_zero(&Parameters(x.0.component_mul(&units)), zero);
        let covariance = covariance.component_mul(&(units * units.transpose()));
        let squared = intensity * intensity;
        let found = Extended {
            parameters,
            covariance: transform * covariance * transform.transpose(),
            cost: pass.cost * squared * squared,
            norm_error_rms: (walk.norm_error_squared(&x) / count).sqrt() * intensity,
            noise,
            condition: spectrum.condition(),
            samples,
            iterations,
        };
        answering(found.parameters.scale(), found.sigma().scale())?;
        if found.is_finite() { Ok(found) } else { Err(CalibrationError::OutOfRange) }
    }
}

/// The samples, walked through at each x.
struct Walk<I>(I);

impl<T, const C: usize, const N: usize, I> Problem<T, N> for Walk<I>
where
    T: RealField + Copy,
    I: Iterator<Item = CoupledSample<T, C>> + Clone,
{
    fn pass(&self, x: &SVector<T, N>) -> Pass<T, N> {
        let mut sums = Pass::zero();
        for sample in self.0.clone() {
            let (residual, row) = linearised(&sample, &Parameters(*x));
            sums.add(residual, &row);
        }
        sums
    }
}

impl<I> Walk<I> {
    /// Σ r² j jᵀ (White 1980): how much the gradient scatters with the noise.
    fn scatter<T, const C: usize, const N: usize>(&self, x: &Parameters<T, N>) -> SMatrix<T, N, N>
    where
        T: RealField + Copy,
        I: Iterator<Item = CoupledSample<T, C>> + Clone,
    {
        self.0.clone().fold(SMatrix::zeros(), |sum, sample| {
            let (residual, row) = linearised(&sample, x);
            let row = row * residual;
            sum + row * row.transpose()
        })
    }

    /// Σ (r / 2 I)²
    fn norm_error_squared<T, const C: usize, const N: usize>(&self, x: &Parameters<T, N>) -> T
    where
        T: RealField + Copy,
        I: Iterator<Item = CoupledSample<T, C>> + Clone,
    {
        self.0.clone().fold(T::zero(), |sum, coupled| {
            let (residual, _) = linearised(&coupled, x);
            let error = residual / (coupled.sample.intensity * number(2.0));
            sum + error * error
        })
    }

    /// σ: Σ r² = 4 σ² Σ βᵀ M D Mᵀ β, the reading's axes having the variances σ² D.
    fn noise<T, const C: usize, const N: usize>(
        &self,
        x: &Parameters<T, N>,
        variance: [T; 3],
        samples: u32,
    ) -> T
    where
        T: RealField + Copy,
        I: Iterator<Item = CoupledSample<T, C>> + Clone,
    {
        let matrix = x.matrix();
        let covariance = matrix * Matrix3::from_diagonal(&variance.into()) * matrix.transpose();
        let (mut squares, mut expected) = (T::zero(), T::zero());
        for coupled in self.0.clone() {
            let (residual, _) = linearised(&coupled, x);
            let field = Vector3::from(x.field(coupled.sample.reading, &coupled.currents));
            squares += residual * residual;
            expected += (covariance * field).dot(&field) * number(4.0);
        }
        let count = number::<T>(f64::from(samples));
        let freedom = count / (count - number(N as f64));
        if expected > T::zero() { (squares / expected * freedom).sqrt() } else { T::zero() }
    }

    /// h, the mean of the gradient by noise of the readings with these variances.
    fn gradient_of_noise<T, const C: usize, const N: usize>(
        &self,
        x: &Parameters<T, N>,
        variance: [T; 3],
    ) -> SVector<T, N>
    where
        T: RealField + Copy,
        I: Iterator<Item = CoupledSample<T, C>> + Clone,
    {
        let matrix = x.matrix();
        let covariance = matrix * Matrix3::from_diagonal(&variance.into()) * matrix.transpose();
        let (zero, one, two) = (T::zero(), T::one(), number::<T>(2.0));
        let units = [[one, zero, zero], [zero, one, zero], [zero, zero, one]];
        // Φ_i = ∂Φ/∂V_i
        let slopes = units.map(|unit| x.jacobian(unit, zero, &[]));
        self.0.clone().fold(SVector::zeros(), |sum, CoupledSample { sample, currents }| {
            let field = Vector3::from(x.field(sample.reading, &currents));
            let jacobian = x.jacobian(sample.reading, one, &currents);
            let mut mean: SVector<T, N> =
                jacobian.tr_mul(&(field * covariance.trace() + covariance * field * two));
            for ((slope, column), variance) in slopes.iter().zip(matrix.column_iter()).zip(variance)
            {
                mean += slope.tr_mul(&field) * (field.dot(&column) * variance * two);
            }
            sum + mean * two
        })
    }
}

/// r and a row of J.
fn linearised<T: RealField + Copy, const C: usize, const N: usize>(
    CoupledSample { sample, currents }: &CoupledSample<T, C>,
    x: &Parameters<T, N>,
) -> (T, SVector<T, N>) {
    let Sample { reading, intensity } = *sample;
    let field = Vector3::from(x.field(reading, currents));
    let residual = field.norm_squared() - intensity * intensity;
    let row = x.jacobian(reading, T::one(), currents).tr_mul(&field) * number::<T>(2.0);
    (residual, row)
}
