//! TWOSTEP: bias, scale and axes from the strength alone, without a start.
//!
//! | symbol | code | meaning |
//! |---|---|---|
//! | x | `reading` | the field by the data sheet |
//! | D, b | `distortion`, `bias` | B = (I + D) x − b, D symmetric |
//! | E = 2D + D², c = (I + D) b | `theta` | what \|B\|² is linear in |
//! | z = \|x\|² − I² | `z` | z = L θ − φ + v, L = (2x, −x∘x, −2xy, −2xz, −2yz), φ = \|b\|² |
//! | μ, w | `mean`, `weight` | mean of v, and one over its variance 4 σ² \|B\|² + 6 σ⁴ |
//!
//! φ = cᵀ (I + E)⁻¹ c is all that is not linear, and it is the same for all samples: their centre is
//! taken off, and what remains is linear, solved at once. The second step brings the one equation of the centre
//! back in, by Gauss–Newton from there.
//!
//! The mean of v is taken as −3σ² as in the source: the mean over the noise alone, the reading being given.
//!
//! Source: Alonso & Shuster (2002), J. Astronaut. Sci. 50(4), 433–451 (TWOSTEP) and 477–490 (complete
//! calibration).

use nalgebra::{ComplexField, Matrix3, RealField, SMatrix, SVector, Vector3};

use super::error::CalibrationError;
use super::gauss_newton::{Units, supported};
use super::parameters::Parameters;
use super::symmetric::{Spectrum, square_root};
use super::{DataSheet, Sample, number};

/// c and E.
const UNKNOWNS: usize = 9;
/// Two samples for each.
const MIN_SAMPLES: u32 = 2 * UNKNOWNS as u32;
/// Rounds, because the weights need D and b, and σ.
const ROUNDS: u32 = 5;
/// Gauss–Newton steps of the second step; it begins a fraction of sigma away.
const STEPS: u32 = 8;
/// Steps that tell scale from shear; each leaves a part c² of the error.
const GAUGE_STEPS: u32 = 30;

/// What TWOSTEP finds: B = (I + D) k (V − V₀) − b, k and V₀ being the data sheet's.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TwoStep<T: RealField + Copy> {
    /// D, symmetric.
    pub distortion: [[T; 3]; 3],
    /// b, *subtracted*; field.
    pub bias: [T; 3],
    /// Covariance of b_x, b_y, b_z, D_xx, D_yy, D_zz, D_xy, D_xz, D_yz.
    pub covariance: SMatrix<T, UNKNOWNS, UNKNOWNS>,
    /// σ: the noise of an axis that the residuals show, field.
    pub noise: T,
    /// How many samples there were.
    pub samples: u32,
}

/// Finds D and b.
///
/// # Errors
/// [`CalibrationError`]: samples that are too few, not finite, or from too few directions; readings on no
/// ellipsoid.
pub fn twostep<T, I>(samples: I, data_sheet: DataSheet<T>) -> Result<TwoStep<T>, CalibrationError>
where
    T: RealField + Copy,
    I: IntoIterator<Item = Sample<T>>,
    I::IntoIter: Clone,
{
    let samples = samples.into_iter();
    let DataSheet { sensitivity, zero } = data_sheet;
    let units = Units::of(samples.clone(), zero)?;
    units.at_least(MIN_SAMPLES)?;
    // Refuses a sensitivity that is none.
    units.start(&data_sheet)?;
    let unit = units.intensity;
    let in_units = samples.map(move |Sample { reading, intensity }| Sample {
        reading: reading.map(|v| (v - zero) * sensitivity / unit),
        intensity: intensity / unit,
    });
    let count = number::<T>(f64::from(units.samples));
    let mut noise = T::zero();
    let mut at = Estimate { theta: SVector::zeros(), shape: Shape::none() };
    let mut information = SMatrix::zeros();
    for _ in 0..ROUNDS {
        (at, information) = round(&in_units, &at, noise)?;
        let chi_squared = in_units.clone().fold(T::zero(), |sum, sample| {
            let error = at.residual(&sample) / (sample.intensity * number(2.0));
            sum + error * error
        });
        noise = (chi_squared / (count - number(UNKNOWNS as f64))).sqrt();
    }
    // Weights are those of a noise of one until the noise is known.
    let variance = noise * noise;
    let to_theta = at.shape.slope();
    let back = to_theta.try_inverse().ok_or(CalibrationError::NoEllipsoid { axis: 0 })?;
    let covariance = back * Spectrum::of(&information).inverse() * back.transpose() * variance;
    let of_unknowns = SVector::<T, UNKNOWNS>::from_fn(|i, _| if i < 3 { unit } else { T::one() });
    let covariance = covariance.component_mul(&(of_unknowns * of_unknowns.transpose()));
    let found = TwoStep {
        distortion: (at.shape.root - Matrix3::identity()).transpose().into(),
        bias: (at.shape.bias * unit).into(),
        covariance,
        noise: noise * unit,
        samples: units.samples,
    };
    let finite = found.covariance.iter().chain(&found.bias).all(ComplexField::is_finite);
    if finite { Ok(found) } else { Err(CalibrationError::OutOfRange) }
}

impl<T: RealField + Copy> TwoStep<T> {
    /// Standard deviations of b and of D's six entries xx, yy, zz, xy, xz, yz.
    pub fn sigma(&self) -> ([T; 3], [T; 6]) {
        let sigma = self.covariance.diagonal().map(|variance| variance.max(T::zero()).sqrt());
        let [x, y, z, d_xx, d_yy, d_zz, d_xy, d_xz, d_yz] = sigma.into();
        ([x, y, z], [d_xx, d_yy, d_zz, d_xy, d_xz, d_yz])
    }

    /// The same calibration as scale, bias and cross-axis terms: its twin with the same strength, turned
    /// as [`Parameters`] are.
    pub fn parameters(&self, DataSheet { sensitivity, zero }: DataSheet<T>) -> Parameters<T, 9> {
        let root = Matrix3::from(self.distortion) + Matrix3::identity();
        let (scale, cross_axis) = scale_and_shear(&root);
        let [x, y, z] = cross_axis;
        let one = T::one();
        let shear = Matrix3::new(one, x, y, x, one, z, y, z, one);
        let matrix = shear * Matrix3::from_diagonal(&scale.into());
        // R (I + D) = C diag(s); b goes along.
        let turn = root.try_inverse().map_or(Matrix3::identity(), |inverse| matrix * inverse);
        let bias = turn * -Vector3::from(self.bias) - matrix * Vector3::repeat(sensitivity * zero);
        let [s_x, s_y, s_z] = scale.map(|s| s * sensitivity);
        Parameters(SVector::from([s_x, s_y, s_z, bias.x, bias.y, bias.z, x, y, z]))
    }
}

/// s and C's entries with C diag(s) = R M for some rotation R: diag(s) C² diag(s) = MᵀM.
///
/// With s known, C is the root of MᵀM scaled; its diagonal says what is wrong with s.
fn scale_and_shear<T: RealField + Copy>(matrix: &Matrix3<T>) -> ([T; 3], [T; 3]) {
    let observable = matrix.tr_mul(matrix);
    let mut scale = observable.diagonal().map(|square| square.max(T::zero()).sqrt());
    let mut shear = Matrix3::identity();
    for _ in 0..GAUGE_STEPS {
        let inverse = scale.map(|s| if s > T::zero() { T::one() / s } else { T::zero() });
        shear = square_root(&observable.component_mul(&(inverse * inverse.transpose())));
        scale = scale.component_mul(&shear.diagonal());
    }
    let [[_, xy, xz], [_, _, yz], _] = shear.into();
    (scale.into(), [xy, xz, yz])
}

/// D and b with what follows from them.
#[derive(Debug, Clone, Copy)]
struct Shape<T: RealField + Copy> {
    /// I + D.
    root: Matrix3<T>,
    bias: Vector3<T>,
}

impl<T: RealField + Copy> Shape<T> {
    fn none() -> Self {
        Self { root: Matrix3::identity(), bias: Vector3::zeros() }
    }

    /// From c and E; an error when I + E has no root.
    fn of(theta: &SVector<T, UNKNOWNS>) -> Result<Self, CalibrationError> {
        let (c, e) = unpacked(theta);
        let root = square_root(&(e + Matrix3::identity()));
        let inverse = root.try_inverse().ok_or(CalibrationError::NoEllipsoid { axis: 0 })?;
        let bias = inverse * c;
        let finite = bias.iter().all(ComplexField::is_finite);
        if finite { Ok(Self { root, bias }) } else { Err(CalibrationError::OutOfRange) }
    }

    /// ∂(c, E)/∂(b, D): dc = (I + D) db + dD b, dE = (I + D) dD + dD (I + D).
    fn slope(&self) -> SMatrix<T, UNKNOWNS, UNKNOWNS> {
        let mut slope = SMatrix::<T, UNKNOWNS, UNKNOWNS>::zeros();
        for (index, mut column) in slope.column_iter_mut().enumerate() {
            let mut unit = SVector::<T, UNKNOWNS>::zeros();
            for (i, value) in unit.iter_mut().enumerate() {
                *value = if i == index { T::one() } else { T::zero() };
            }
            let (b, d) = unpacked(&unit);
            let c = self.root * b + d * self.bias;
            let e = self.root * d + d * self.root;
            column.copy_from(&packed(&c, &e));
        }
        slope
    }
}

#[derive(Debug, Clone, Copy)]
struct Estimate<T: RealField + Copy> {
    theta: SVector<T, UNKNOWNS>,
    shape: Shape<T>,
}

impl<T: RealField + Copy> Estimate<T> {
    /// z − L θ + φ
    fn residual(&self, sample: &Sample<T>) -> T {
        let (z, row) = linear(sample);
        z - row.dot(&self.theta) + self.shape.bias.norm_squared()
    }
}

/// Both steps, with the weights of the round before; and the information on (c, E) for a noise of one.
fn round<T: RealField + Copy>(
    samples: &(impl Iterator<Item = Sample<T>> + Clone),
    before: &Estimate<T>,
    noise: T,
) -> Result<(Estimate<T>, SMatrix<T, UNKNOWNS, UNKNOWNS>), CalibrationError> {
    let (two, four, six) = (number::<T>(2.0), number::<T>(4.0), number::<T>(6.0));
    let weight = |Sample { reading, .. }: &Sample<T>| {
        let field = before.shape.root * Vector3::from(*reading) - before.shape.bias;
        let floor = number(1e-6);
        T::one() / (field.norm_squared().max(floor) * four + noise * noise * six)
    };
    let mean = -noise * noise * number(3.0);
    let mut weights = T::zero();
    let mut centre_z = T::zero();
    let mut centre_row = SVector::<T, UNKNOWNS>::zeros();
    for sample in samples.clone() {
        let (w, (z, row)) = (weight(&sample), linear(&sample));
        weights += w;
        centre_z += z * w;
        centre_row += row * w;
    }
    let (centre_z, centre_row) = (centre_z / weights, centre_row / weights);

    // First step: off the centre.
    let mut information = SMatrix::<T, UNKNOWNS, UNKNOWNS>::zeros();
    let mut gradient = SVector::<T, UNKNOWNS>::zeros();
    for sample in samples.clone() {
        let (w, (z, row)) = (weight(&sample), linear(&sample));
        let (z, row) = (z - centre_z, row - centre_row);
        information += row * row.transpose() * w;
        gradient -= row * (z * w);
    }
    supported(&information)?;
    let centred = Spectrum::of(&information).step(&gradient, T::zero());

    // Second step: the centre, whose φ is not linear.
    let mut theta = centred;
    let mut whole = information;
    for _ in 0..STEPS {
        let shape = Shape::of(&theta)?;
        // (I + E)⁻¹ c = (I + D)⁻¹ b
        let inverse = shape.root.try_inverse().ok_or(CalibrationError::NoEllipsoid { axis: 0 })?;
        let q = inverse * shape.bias;
        // ∂φ/∂c = 2 q, ∂φ/∂E = −q qᵀ
        let of_phi = SVector::from([
            q.x * two,
            q.y * two,
            q.z * two,
            -q.x * q.x,
            -q.y * q.y,
            -q.z * q.z,
            -q.x * q.y * two,
            -q.x * q.z * two,
            -q.y * q.z * two,
        ]);
        let row = centre_row - of_phi;
        let residual = centre_z - centre_row.dot(&theta) + shape.bias.norm_squared() - mean;
        whole = information + row * row.transpose() * weights;
        let gradient = information * (theta - centred) - row * (residual * weights);
        theta += Spectrum::of(&whole).step(&gradient, T::zero());
    }
    Ok((Estimate { theta, shape: Shape::of(&theta)? }, whole))
}

/// z and L.
fn linear<T: RealField + Copy>(
    &Sample { reading: [x, y, z], intensity }: &Sample<T>,
) -> (T, SVector<T, UNKNOWNS>) {
    let two = number::<T>(2.0);
    let row = [
        x * two,
        y * two,
        z * two,
        -x * x,
        -y * y,
        -z * z,
        -x * y * two,
        -x * z * two,
        -y * z * two,
    ];
    (x * x + y * y + z * z - intensity * intensity, SVector::from(row))
}

/// A vector and a symmetric matrix from nine numbers.
fn unpacked<T: RealField + Copy>(theta: &SVector<T, UNKNOWNS>) -> (Vector3<T>, Matrix3<T>) {
    let [x, y, z, xx, yy, zz, xy, xz, yz] = (*theta).into();
    (Vector3::new(x, y, z), Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz))
}

fn packed<T: RealField + Copy>(c: &Vector3<T>, e: &Matrix3<T>) -> SVector<T, UNKNOWNS> {
    let [[xx, xy, xz], [_, yy, yz], [_, _, zz]] = (*e).into();
    SVector::from([c.x, c.y, c.z, xx, yy, zz, xy, xz, yz])
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Of 30 steps whose error falls with c² each, and of roots in f64.
    const GAUGE: f64 = 1e-9;

    proptest! {
        #[test]
        fn scale_and_shear_have_the_strength_of_the_matrix(
            scale in prop::array::uniform3(0.4..2.0_f64),
            cross in prop::array::uniform3(-0.15..0.15_f64),
        ) {
            let [x, y, z] = cross;
            let shear = Matrix3::new(1.0, x, y, x, 1.0, z, y, z, 1.0);
            let matrix = shear * Matrix3::from_diagonal(&scale.into());
            let (found_scale, found_cross) = scale_and_shear(&matrix);
            for i in 0..3 {
                prop_assert!((found_scale[i] - scale[i]).abs() < GAUGE, "{found_scale:?} {scale:?}");
                prop_assert!((found_cross[i] - cross[i]).abs() < GAUGE, "{found_cross:?} {cross:?}");
            }
        }

        #[test]
        fn the_slope_is_the_derivative_of_c_and_e(
            d in prop::array::uniform9(-0.2..0.2_f64),
        ) {
            const STEP: f64 = 1e-5;
            let at = SVector::from(d);
            let theta = |x: &SVector<f64, 9>| {
                let (b, d) = unpacked(x);
                let root = d + Matrix3::identity();
                packed(&(root * b), &(root * root - Matrix3::identity()))
            };
            let (b, d) = unpacked(&at);
            let slope = Shape { root: d + Matrix3::identity(), bias: b }.slope();
            for i in 0..9 {
                let mut step = SVector::<f64, 9>::zeros();
                step[i] = STEP;
                let numeric = (theta(&(at + step)) - theta(&(at - step))) / (2.0 * STEP);
                prop_assert!((numeric - slope.column(i)).norm() < 1e-9);
            }
        }
    }
}
