//! The 48 ways in which three wires can be exchanged and turned round.

use core::fmt;

use nalgebra::{Matrix3, RealField, Rotation3, UnitQuaternion, Vector3, convert};
use serde::{Deserialize, Serialize};

use super::Rotation;

/// One of the 48 signed permutations of three axes: row `i` shows ± the axis `axes[i]`.
///
/// P v = (± v_a, ± v_b, ± v_c). Half of them are rotations (det P = 1), half mirror (det P = −1).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[serde(try_from = "u8", into = "u8")]
pub struct SignedPermutation {
    index: u8,
}

/// The axes that each order shows, and the determinant of the order.
const ORDERS: [([usize; 3], i8); 6] = [
    ([0, 1, 2], 1),
    ([1, 2, 0], 1),
    ([2, 0, 1], 1),
    ([0, 2, 1], -1),
    ([2, 1, 0], -1),
    ([1, 0, 2], -1),
];

impl SignedPermutation {
    /// How many there are.
    pub const COUNT: u8 = 48;
    /// Everything as it should be.
    pub const IDENTITY: Self = Self { index: 0 };
    /// Every axis turned round.
    pub const REVERSED: Self = Self { index: 7 };

    /// Number `index`, 0 to 47, the identity being 0; `None` beyond.
    pub fn new(index: u8) -> Option<Self> {
        (index < Self::COUNT).then_some(Self { index })
    }

    /// All of them in the order of their numbers.
    pub fn all() -> impl Iterator<Item = Self> {
        (0..Self::COUNT).map(|index| Self { index })
    }

    /// Its number, 0 to 47.
    pub fn index(self) -> u8 {
        self.index
    }

    /// Which axis each row shows, and det of the order alone.
    fn order(self) -> ([usize; 3], i8) {
        // The index is below 48, so the default is never taken.
        ORDERS.get(usize::from(self.index / 8)).copied().unwrap_or(([0, 1, 2], 1))
    }

    /// The sign of each row.
    fn signs(self) -> [f32; 3] {
        [1, 2, 4].map(|bit| if self.index & bit == 0 { 1.0 } else { -1.0 })
    }

    /// P v.
    pub fn apply<T: RealField + Copy>(self, v: Vector3<T>) -> Vector3<T> {
        let (axes, _) = self.order();
        let mut shown = Vector3::zeros();
        for ((shown, axis), sign) in shown.iter_mut().zip(axes).zip(self.signs()) {
            let value = v.get(axis).copied().unwrap_or(T::zero());
            *shown = if sign < 0.0 { -value } else { value };
        }
        shown
    }

    /// P as a matrix.
    pub fn matrix(self) -> Matrix3<f32> {
        let (axes, _) = self.order();
        let signs = self.signs();
        Matrix3::from_fn(|row, column| match (axes.get(row), signs.get(row)) {
            (Some(axis), Some(sign)) if *axis == column => *sign,
            _ => 0.0,
        })
    }

    /// P⁻¹ = Pᵀ.
    pub fn inverse(self) -> Self {
        Self::of(&self.matrix().transpose())
    }

    /// −P.
    pub fn negated(self) -> Self {
        Self { index: self.index ^ 7 }
    }

    /// Whether it is a rotation, det P = 1.
    pub fn is_rotation(self) -> bool {
        let (_, order) = self.order();
        (order == 1) == (self.index & 7).count_ones().is_multiple_of(2)
    }

    /// The rotation of P and −P: det(P) P.
    pub fn rotation(self) -> Self {
        if self.is_rotation() { self } else { self.negated() }
    }

    /// P as a rotation R behind signs of single axes: P v = R (± v_x, ± v_y, ± v_z).
    ///
    /// Where no axes are exchanged, R is the identity.
    pub fn rotation_and_signs(self) -> (Self, [i8; 3]) {
        // The order itself, or what is a rotation of it and its negative.
        let rotation = Self { index: self.index & !7 }.rotation();
        let signs = (rotation.inverse().matrix() * self.matrix()).diagonal();
        (rotation, signs.map(|sign| if sign < 0.0 { -1 } else { 1 }).into())
    }

    /// det(P) P with frames.
    pub fn turn<To, From, T: RealField + Copy>(self) -> Rotation<To, From, T> {
        let matrix = self.rotation().matrix().map(|entry| convert(f64::from(entry)));
        let rotation = Rotation3::from_matrix_unchecked(matrix);
        Rotation::from_hamilton(UnitQuaternion::from_rotation_matrix(&rotation))
    }

    /// The signed permutation with this matrix; the identity when there is none.
    fn of(matrix: &Matrix3<f32>) -> Self {
        Self::all().find(|it| it.matrix() == *matrix).unwrap_or(Self::IDENTITY)
    }
}

/// A number of a signed permutation that there is not.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PermutationError {
    /// What was given.
    pub found: u8,
}

impl fmt::Display for PermutationError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "there is no signed permutation number {}, they are 0 to 47", self.found)
    }
}

impl core::error::Error for PermutationError {}

impl TryFrom<u8> for SignedPermutation {
    type Error = PermutationError;

    fn try_from(index: u8) -> Result<Self, PermutationError> {
        Self::new(index).ok_or(PermutationError { found: index })
    }
}

impl From<SignedPermutation> for u8 {
    fn from(it: SignedPermutation) -> Self {
        it.index
    }
}

impl fmt::Display for SignedPermutation {
    /// What the rows show: `+y -x +z`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (axes, _) = self.order();
        for (row, (axis, sign)) in axes.into_iter().zip(self.signs()).enumerate() {
            let space = if row == 0 { "" } else { " " };
            let sign = if sign < 0.0 { '-' } else { '+' };
            let name = ["x", "y", "z"].get(axis).copied().unwrap_or("?");
            write!(f, "{space}{sign}{name}")?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use crate::frames::{Body, MagnetometerAxes};
    use std::string::ToString as _;

    #[test]
    fn there_are_48_orthogonal_ones_and_no_two_are_alike() {
        for a in SignedPermutation::all() {
            let matrix = a.matrix();
            assert_eq!(matrix * matrix.transpose(), Matrix3::identity());
            assert_eq!(matrix.determinant() > 0.0, a.is_rotation());
            assert_eq!(a.inverse().matrix() * matrix, Matrix3::identity());
            assert_eq!(a.negated().matrix(), -matrix);
            let v = Vector3::new(1.0, 2.0, 3.0);
            assert_eq!(a.apply(v), matrix * v);
            assert!(a.rotation().is_rotation());
            assert_eq!(SignedPermutation::all().filter(|b| b.matrix() == matrix).count(), 1);
        }
        assert_eq!(SignedPermutation::all().filter(|it| it.is_rotation()).count(), 24);
        assert_eq!(SignedPermutation::new(48), None);
    }

    #[test]
    fn each_is_a_rotation_behind_signs_and_that_rotation_has_a_quaternion() {
        /// Of a product of two roots of one half.
        const ROUNDING: f64 = 1e-15;
        for it in SignedPermutation::all() {
            let (rotation, signs) = it.rotation_and_signs();
            assert!(rotation.is_rotation());
            let signs = Vector3::from(signs.map(f32::from));
            assert_eq!(rotation.matrix() * Matrix3::from_diagonal(&signs), it.matrix());
            let turn: Rotation<Body, MagnetometerAxes, f64> = rotation.turn();
            let again = Rotation::from_attitude_quaternion(turn.attitude_quaternion()).unwrap();
            let again: Rotation<Body, MagnetometerAxes, f64> = again;
            assert!((again.matrix() - rotation.matrix().map(f64::from)).norm() < 4.0 * ROUNDING);
        }
        let exchanged = SignedPermutation::all().find(|it| it.to_string() == "-x +y -z").unwrap();
        let in_place = (SignedPermutation::IDENTITY, [-1, 1, -1]);
        assert_eq!(exchanged.rotation_and_signs(), in_place);
    }

    #[test]
    fn its_name_says_what_the_axes_show() {
        let named = |name: &str| SignedPermutation::all().find(|it| it.to_string() == name);
        assert_eq!(named("+x +y +z"), Some(SignedPermutation::IDENTITY));
        assert_eq!(named("-x -y -z"), Some(SignedPermutation::REVERSED));
        let turned = named("+y -x +z").unwrap();
        assert_eq!(turned.apply(Vector3::new(1.0, 2.0, 3.0)), Vector3::new(2.0, -1.0, 3.0));
    }
}
