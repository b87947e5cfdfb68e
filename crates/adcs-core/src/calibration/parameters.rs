//! Calibrations of more than scale and bias: axes that are not square, and currents nearby.
//!
//! B = C (s ∘ V) + b + Σ k_j I_j
//!
//! | symbol | code | meaning |
//! |---|---|---|
//! | V | `reading` | what the three axes show |
//! | s, b | `scale`, `bias` | as in the paper's eq. (5) |
//! | C | `cross_axis` | symmetric, ones on its diagonal; c_xy, c_xz, c_yz beside it |
//! | I_j, k_j | `currents`, `coupling` | a current (or a dipole) nearby, and the field it makes here |
//!
//! The strength of the field tells MᵀM of B = M V + b, six numbers, and nothing of a rotation in front
//! of M. Which M is meant has to be said. A triangular M holds one axis of the sensor to be where the
//! drawing has it, and charges the others with all angles. A symmetric C charges both axes of a pair with half of
//! the angle between them: of independent errors of mounting it leaves the least rotation, and no axis
//! has to be chosen. With c = 0 it is the paper's model, so that the two can be compared.

use nalgebra::{Matrix3, RealField, SMatrix, SVector, Vector3};

use super::DataSheet;
use crate::frames::{Body, MagnetometerAxes, Rotation, SignedPermutation};
use crate::sensing::TriadParameters;

/// Scale, bias, cross-axis terms and couplings, in this order: N = 6, or 9 and three for each current.
///
/// The units are those of the samples: field per reading, field, none, field per current.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parameters<T: RealField + Copy, const N: usize>(pub SVector<T, N>);

/// A calibration as [`TriadParameters`] have it: C (s ∘ x) − b of what the driver shows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Correction<T> {
    /// s, no unit.
    pub scale: [T; 3],
    /// c_xy, c_xz, c_yz.
    pub cross_axis: [T; 3],
    /// b, *subtracted*; field.
    pub bias: [T; 3],
}

impl<T: RealField + Copy> Correction<T> {
    /// The same for a sensor whose axes were found to be `axes` of Body's: signs of single axes go into
    /// scale, cross-axis terms and bias; what remains is the rotation from the sensor's axes to Body.
    ///
    /// P (C (s ∘ x) − b) = R (D C D (D s ∘ x) − D b), P = R D, D diagonal of ones and minus ones.
    pub fn along(self, axes: SignedPermutation) -> (Self, Rotation<Body, MagnetometerAxes, T>) {
        let (rotation, signs) = axes.rotation_and_signs();
        let [x, y, z] = signs;
        let signed = |[a, b, c]: [T; 3], [p, q, r]: [i8; 3]| {
            let signed = |value: T, sign: i8| if sign < 0 { -value } else { value };
            [signed(a, p), signed(b, q), signed(c, r)]
        };
        let turned = Self {
            scale: signed(self.scale, signs),
            cross_axis: signed(self.cross_axis, [x * y, x * z, y * z]),
            bias: signed(self.bias, signs),
        };
        (turned, rotation.turn())
    }
}

impl Correction<f32> {
    /// The parameters with this in place of what they had; the alignment stays.
    pub fn applied_to(self, parameters: &TriadParameters) -> TriadParameters {
        let Self { scale, cross_axis, bias } = self;
        TriadParameters { scale, cross_axis, bias, ..*parameters }
    }
}

impl<T: RealField + Copy, const N: usize> Parameters<T, N> {
    /// The three unknowns from this one on; zeros behind the last.
    fn three(&self, from: usize) -> [T; 3] {
        let mut found = [T::zero(); 3];
        for (found, value) in found.iter_mut().zip(self.0.iter().skip(from)) {
            *found = *value;
        }
        found
    }

    /// s.
    pub fn scale(&self) -> [T; 3] {
        self.three(0)
    }

    /// b, *added*.
    pub fn bias(&self) -> [T; 3] {
        self.three(3)
    }

    /// c_xy, c_xz, c_yz; zeros when they are no unknowns.
    pub fn cross_axis(&self) -> [T; 3] {
        self.three(6)
    }

    /// Field per current `index`; zeros when there is no such current.
    pub fn coupling(&self, index: usize) -> [T; 3] {
        self.three(9 + 3 * index)
    }

    /// C.
    pub fn shear(&self) -> Matrix3<T> {
        let ([xy, xz, yz], one) = (self.cross_axis(), T::one());
        Matrix3::new(one, xy, xz, xy, one, yz, xz, yz, one)
    }

    /// M = C diag(s): field per reading.
    pub fn matrix(&self) -> Matrix3<T> {
        self.shear() * Matrix3::from_diagonal(&Vector3::from(self.scale()))
    }

    /// What the flight software takes behind a driver that turns readings into field by this data sheet.
    ///
    /// The driver gives x = k (V − V₀), the flight software makes C (s′ ∘ x) − b′ of it. So
    /// s′ = s / k, b′ = −(b + C (s V₀)).
    pub fn correction(&self, driver: DataSheet<T>) -> Correction<T> {
        let at_zero = self.matrix() * Vector3::repeat(driver.zero) + Vector3::from(self.bias());
        Correction {
            scale: self.scale().map(|scale| scale / driver.sensitivity),
            cross_axis: self.cross_axis(),
            bias: (-at_zero).into(),
        }
    }

    /// The calibrated field.
    pub fn field(&self, reading: [T; 3], currents: &[T]) -> [T; 3] {
        let mut field = self.matrix() * Vector3::from(reading) + Vector3::from(self.bias());
        for (index, &current) in currents.iter().enumerate() {
            field += Vector3::from(self.coupling(index)) * current;
        }
        field.into()
    }

    /// ∂B/∂x for a reading, `one` times the bias, and currents: linear in all of these.
    pub(super) fn jacobian(&self, reading: [T; 3], one: T, currents: &[T]) -> SMatrix<T, 3, N> {
        let shear = self.shear();
        let [v_x, v_y, v_z] = reading;
        let [s_x, s_y, s_z] = self.scale();
        let ([x, y, z], zero) = ([s_x * v_x, s_y * v_y, s_z * v_z], T::zero());
        let of_scale = |axis: usize, v: T| -> Vector3<T> { shear.column(axis) * v };
        let unit =
            |axis: usize, value: T| Vector3::from_fn(|i, _| if i == axis { value } else { zero });
        let mut columns = [
            of_scale(0, v_x),
            of_scale(1, v_y),
            of_scale(2, v_z),
            unit(0, one),
            unit(1, one),
            unit(2, one),
            Vector3::new(y, x, zero),
            Vector3::new(z, zero, x),
            Vector3::new(zero, z, y),
        ]
        .into_iter()
        .chain(currents.iter().flat_map(|&current| [0, 1, 2].map(|axis| unit(axis, current))));
        let mut jacobian = SMatrix::<T, 3, N>::zeros();
        for mut column in jacobian.column_iter_mut() {
            if let Some(value) = columns.next() {
                column.copy_from(&value);
            }
        }
        jacobian
    }

    /// Of the mirror images that the strength cannot tell apart, the one with s > 0.
    pub(super) fn with_positive_scales(&self) -> Self {
        let sign = self.scale().map(|s| if s < T::zero() { -T::one() } else { T::one() });
        let [x, y, z] = sign;
        let of_pair = [x * y, x * z, y * z];
        let factors = sign.into_iter().chain(sign).chain(of_pair).chain(sign.into_iter().cycle());
        let mut mirrored = *self;
        for (value, factor) in mirrored.0.iter_mut().zip(factors) {
            *value *= factor;
        }
        mirrored
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reading::Reading;
    use crate::sensing::Triad;
    use proptest::prelude::*;

    /// Of central differences with steps of 1e-5 of functions that are quadratic at most.
    const DIFFERENCES: f64 = 1e-9;

    #[test]
    fn any_of_the_48_wirings_is_put_right_by_what_the_flight_software_takes() {
        /// T, of fields of 5e-5 T in single precision.
        const ROUNDING: f32 = 2e-11;
        let correction = Correction {
            scale: [0.9_f32, 1.2, 1.1],
            cross_axis: [0.03, -0.02, 0.05],
            bias: [3e-6, -5e-6, 1e-5],
        };
        let (shown, as_drawn) = ([2e-5, -3e-5, 1e-5], TriadParameters::default());
        let field = |parameters: &TriadParameters| {
            let triad: Triad<MagnetometerAxes> = Triad::new(parameters).unwrap();
            triad.to_body(shown.map(Reading::Fresh)).value().unwrap().xyz
        };
        let along_axes = field(&correction.applied_to(&as_drawn));
        for axes in SignedPermutation::all() {
            let (turned, alignment) = correction.along(axes);
            let parameters = TriadParameters {
                alignment_xyzw: alignment.attitude_quaternion(),
                ..turned.applied_to(&as_drawn)
            };
            let error = field(&parameters) - axes.apply(along_axes);
            assert!(error.norm() < ROUNDING, "{axes:?}: {error}");
        }
    }

    proptest! {
        #[test]
        fn the_jacobian_is_the_derivative_of_the_field(
            x in prop::array::uniform12(-1.0..1.0_f64),
            v in prop::array::uniform3(-1.0..1.0_f64),
            current in -1.0..1.0_f64,
        ) {
            const STEP: f64 = 1e-5;
            let at = Parameters::<f64, 12>(SVector::from(x));
            let jacobian = at.jacobian(v, 1.0, &[current]);
            for i in 0..12 {
                let moved = |by: f64| {
                    let mut moved = at;
                    moved.0[i] += by;
                    Vector3::from(moved.field(v, &[current]))
                };
                let slope = (moved(STEP) - moved(-STEP)) / (2.0 * STEP);
                prop_assert!((slope - jacobian.column(i)).norm() < DIFFERENCES);
            }
        }

        #[test]
        fn a_mirror_image_has_the_same_strength(
            x in prop::array::uniform12(-1.0..1.0_f64),
            v in prop::array::uniform3(-1.0..1.0_f64),
            current in -1.0..1.0_f64,
        ) {
            let at = Parameters::<f64, 12>(SVector::from(x));
            let mirrored = at.with_positive_scales();
            prop_assert!(mirrored.scale().iter().all(|&s| s >= 0.0));
            let [a, b] = [at, mirrored].map(|it| Vector3::from(it.field(v, &[current])).norm());
            prop_assert!((a - b).abs() < DIFFERENCES);
        }
    }
}
