//! The ellipsoid that fits the readings best, as a start.
//!
//! Written out, |s ∘ V + b|² = I² is linear in a_i = s_i², c_i = 2 s_i b_i and d = Σ b_i²:
//!
//! Σ (a_i V_i² + c_i V_i) + d = I²
//!
//! Seven unknowns, of which d is taken to be free: hence not the optimum of E, but near it.

use nalgebra::{RealField, SMatrix, SVector};

use super::symmetric::Spectrum;
use super::{CalibrationError, Sample, UNKNOWNS, joined, number};

/// Scales and biases of the ellipsoid.
pub(super) fn start<T: RealField + Copy>(
    samples: impl Iterator<Item = Sample<T>>,
) -> Result<SVector<T, UNKNOWNS>, CalibrationError> {
    let mut normal = SMatrix::<T, 7, 7>::zeros();
    let mut gradient = SVector::<T, 7>::zeros();
    for Sample { reading: [x, y, z], intensity } in samples {
        let row = SVector::from([x * x, y * y, z * z, x, y, z, T::one()]);
        normal += row * row.transpose();
        gradient -= row * (intensity * intensity);
    }
    let [a_x, a_y, a_z, c_x, c_y, c_z, _] = Spectrum::of(&normal).step(&gradient, T::zero()).into();
    let (mut scale, mut bias) = ([T::zero(); 3], [T::zero(); 3]);
    let axes = scale.iter_mut().zip(&mut bias).zip([a_x, a_y, a_z]).zip([c_x, c_y, c_z]);
    for ((((scale, bias), a), c), axis) in axes.zip(0..) {
        // A NaN fails the comparison.
        let real = a > T::zero();
        if !real {
            return Err(CalibrationError::NoEllipsoid { axis });
        }
        *scale = a.sqrt();
        *bias = c / (*scale * number(2.0));
    }
    Ok(joined(scale, bias))
}
