//! TWOSTEP's first step: a calibration without a start, but for what is not linear.
//!
//! With θ in place of x the cost is linear least squares: A θ = u. That θ is of ten numbers, and x only of
//! nine, is the source's observation: the constant of |B|² is |b|², and no unknown of its own. Left free it takes the
//! centre of all samples with it, where all that is not linear stands; what the others say is within a few
//! sigma of the truth. The second step brings the constant back in, by Gauss–Newton from there (`sums`).
//!
//! Source: Alonso & Shuster (2002), J. Astronaut. Sci. 50(4), 433–451 (TWOSTEP) and 477–490 (complete
//! calibration). There the noise is taken to be −3σ² in the mean, the reading being given; here see `sums`.

use nalgebra::{ComplexField, Matrix3, RealField, SMatrix, SVector, Vector3};

use super::error::CalibrationError;
use super::gauss_newton::Units;
use super::moments::OF_TWO;
use super::quadratic::Quadratic;
use super::sums::{Recursive, Sums};
use super::symmetric::{Spectrum, square_root};
use super::{DataSheet, Sample, number};

/// Steps that tell scale from shear; each leaves a part c² of the error, and this is a start.
const GAUGE_STEPS: u32 = 5;

/// Scale, bias and cross-axis terms by TWOSTEP, without a start and without the shift by noise.
///
/// # Errors
/// [`CalibrationError`]: samples that are too few, not finite, or from too few directions.
pub fn twostep<T, I>(
    samples: I,
    data_sheet: DataSheet<T>,
) -> Result<Recursive<T, 9>, CalibrationError>
where
    T: RealField + Copy,
    I: IntoIterator<Item = Sample<T>>,
    I::IntoIter: Clone,
{
    let samples = samples.into_iter();
    let units = Units::of(samples.clone(), data_sheet.zero)?;
    let mut sums = Sums::new(data_sheet, units.intensity)?;
    for sample in samples {
        sums.add(sample)?;
    }
    sums.calibration()
}

/// The unknowns of the ellipsoid with the least cost: scale and bias (`N` = 6), or shear too (9).
#[inline(never)]
pub(super) fn first_step<T: RealField + Copy, const N: usize>(
    quadratic: &Quadratic<T>,
) -> Result<SVector<T, N>, CalibrationError> {
    let crossed = |i: usize| N == 6 && matches!(i, 5 | 6 | 8);
    let a = SMatrix::from_fn(|i, j| match quadratic.a.get((i, j)) {
        Some(value) if !crossed(i) && !crossed(j) => *value,
        _ => T::zero(),
    });
    let theta: SVector<T, OF_TWO> = Spectrum::of(&a).step(&-quadratic.u, T::zero());
    let half = number::<T>(0.5);
    let [_, x, y, z, xx, xy, xz, yy, yz, zz] = theta.into();
    let (xy, xz, yz) = (xy * half, xz * half, yz * half);
    for (axis, square) in (0..).zip([xx, yy, zz]) {
        // A NaN fails the comparison.
        let real = square > T::zero();
        if !real {
            return Err(CalibrationError::NoEllipsoid { axis });
        }
    }
    let (scale, shear) = scale_and_shear(&Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz));
    // 2 Mᵀ b = (x, y, z), M = C diag(s)
    let matrix = shear * Matrix3::from_diagonal(&scale);
    let inverse = matrix.try_inverse().ok_or(CalibrationError::NoEllipsoid { axis: 0 })?;
    let bias = inverse.tr_mul(&Vector3::new(x, y, z)) * half;
    let [[_, c_xy, c_xz], [_, _, c_yz], _] = shear.into();
    let all = scale.iter().chain(bias.iter()).chain([&c_xy, &c_xz, &c_yz]);
    let mut found = SVector::<T, N>::zeros();
    found.iter_mut().zip(all).for_each(|(to, from)| *to = *from);
    let finite = found.iter().all(ComplexField::is_finite);
    if finite { Ok(found) } else { Err(CalibrationError::OutOfRange) }
}

/// s and C with diag(s) C² diag(s) = MᵀM, C symmetric with ones on its diagonal.
///
/// With s known, C is the root of MᵀM scaled; its diagonal says what is wrong with s.
fn scale_and_shear<T: RealField + Copy>(observable: &Matrix3<T>) -> (Vector3<T>, Matrix3<T>) {
    let mut scale = observable.diagonal().map(|square| square.max(T::zero()).sqrt());
    let mut shear = Matrix3::identity();
    for _ in 0..GAUGE_STEPS {
        let inverse = scale.map(|s| if s > T::zero() { T::one() / s } else { T::zero() });
        shear = square_root(&observable.component_mul(&(inverse * inverse.transpose())));
        scale = scale.component_mul(&shear.diagonal());
    }
    (scale, shear)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Of five steps whose error falls with c² each.
    const GAUGE: f64 = 1e-3;

    proptest! {
        #[test]
        fn scale_and_shear_have_the_strength_of_the_matrix(
            scale in prop::array::uniform3(0.4..2.0_f64),
            cross in prop::array::uniform3(-0.15..0.15_f64),
        ) {
            let [x, y, z] = cross;
            let shear = Matrix3::new(1.0, x, y, x, 1.0, z, y, z, 1.0);
            let matrix = shear * Matrix3::from_diagonal(&scale.into());
            let (found, found_shear) = scale_and_shear(&matrix.tr_mul(&matrix));
            prop_assert!((found - Vector3::from(scale)).norm() < GAUGE, "{found} {scale:?}");
            prop_assert!((found_shear - shear).norm() < GAUGE, "{found_shear} {cross:?}");
        }
    }
}
