//! Curvature of Wahba's loss, held so that a heavy weight does not drown a light one.
//!
//! The loss after a further small rotation δ of the attitude is L − gᵀδ + ½ δᵀ H δ with
//!
//! g = Σ a_i c_i × b_i, H = Σ a_i [(b_i·c_i) I − ½ (b_i c_iᵀ + c_i b_iᵀ)], c_i = A r_i
//!
//! Let one pair be 10⁶ times sharper than the others: its weight is 10¹² times theirs. What it says
//! about rotations across its line of sight then stands in every component of H at order one, and
//! what the others say about the turn about that line, at 10⁻¹², falls off the end of an f32 and
//! nearly off that of an f64. But in axes of which the first, x, is along the sharp pair that pair
//! contributes nothing to the xx and x-transverse components, not even rounding; the others'
//! information stands there alone, with all its digits:
//!
//! ```text
//! H = | roll      couplingᵀ  |   roll ~ a₂ sin²,  coupling ~ a₂ sin cos
//!     | coupling  transverse |   transverse ~ 1
//! ```
//!
//! Eliminating the large block first keeps them (graded matrices: Stewart & Sun (1990), Matrix
//! Perturbation Theory; Demmel & Veselić (1992)).

use nalgebra::{Matrix2, Matrix3, RealField, Vector2, Vector3};

use super::number;

/// A symmetric 3×3 matrix in axes of which the first is along the sharpest measurement.
#[derive(Debug, Clone, Copy)]
pub(super) struct Information<T> {
    roll: T,
    coupling: Vector2<T>,
    transverse: Matrix2<T>,
}

/// The matrix with its transverse block eliminated.
#[derive(Debug, Clone, Copy)]
pub(super) struct Eliminated<T> {
    /// (transverse)⁻¹
    pub transverse_inverse: Matrix2<T>,
    /// (transverse)⁻¹ coupling: the weak direction is n = (1, −u).
    pub u: Vector2<T>,
    /// roll − couplingᵀ u = nᵀ H n: information about the turn about n, the others being free.
    pub roll: T,
    /// det(transverse).
    pub transverse_determinant: T,
}

impl<T: RealField + Copy> Information<T> {
    /// No information.
    pub fn zero() -> Self {
        Self { roll: T::zero(), coupling: Vector2::zeros(), transverse: Matrix2::zeros() }
    }

    /// Adds `weight` times (b·c) I − ½ (b cᵀ + c bᵀ).
    #[must_use]
    pub fn plus(self, weight: T, b: &Vector3<T>, c: &Vector3<T>) -> Self {
        let half = number::<T>(0.5);
        let (x, y, z) = (b.x * c.x, b.y * c.y, b.z * c.z);
        let yz = (b.y * c.z + b.z * c.y) * half;
        Self {
            roll: self.roll + weight * (y + z),
            coupling: self.coupling - (c.yz() * b.x + b.yz() * c.x) * (weight * half),
            transverse: self.transverse + Matrix2::new(x + z, -yz, -yz, x + y) * weight,
        }
    }

    /// Eliminates the transverse block; `None` when that is not positive beyond rounding, given as
    /// the smallest value (relative to weights of sum one) that counts.
    pub fn eliminate(&self, rounding: T) -> Option<Eliminated<T>> {
        let t = &self.transverse;
        let transverse_determinant = t.m11 * t.m22 - t.m12 * t.m12;
        // The smaller eigenvalue is at least det / trace. A NaN fails the comparison.
        let positive = t.m11 > T::zero() && transverse_determinant > rounding * t.trace();
        if !positive {
            return None;
        }
        let transverse_inverse =
            Matrix2::new(t.m22, -t.m12, -t.m12, t.m11) / transverse_determinant;
        let u = transverse_inverse * self.coupling;
        let roll = self.roll - self.coupling.dot(&u);
        Some(Eliminated { transverse_inverse, u, roll, transverse_determinant })
    }

    /// The smallest eigenvalue of a positive matrix.
    ///
    /// Laguerre's iteration on the characteristic polynomial x³ − I₁x² + I₂x − I₃ from zero, from
    /// where it rises to the smallest root and no further. I₃ is the product of `eliminated`'s
    /// determinants, so a root of 10⁻¹² keeps its digits.
    pub fn smallest_eigenvalue(&self, eliminated: &Eliminated<T>) -> T {
        /// Cubic convergence; where two roots coincide, linear.
        const STEPS: usize = 4;
        let (two, three, six) = (number::<T>(2.0), number::<T>(3.0), number::<T>(6.0));
        let t = &self.transverse;
        let i1 = self.roll + t.trace();
        let i2 = eliminated.transverse_determinant + self.roll * t.trace()
            - self.coupling.norm_squared();
        let i3 = eliminated.transverse_determinant * eliminated.roll;
        let mut x = T::zero();
        for _ in 0..STEPS {
            let p = ((x - i1) * x + i2) * x - i3;
            let p1 = (three * x - two * i1) * x + i2;
            let p2 = six * x - two * i1;
            let root = (two * (two * p1 * p1 - three * p * p2)).max(T::zero()).sqrt();
            let denominator = p1 + root;
            // Beyond the root only by rounding, or three roots in one.
            if p >= T::zero() || denominator <= T::zero() {
                break;
            }
            x -= three * p / denominator;
        }
        x
    }
}

impl<T: RealField + Copy> Eliminated<T> {
    /// n = (1, −u), the direction about which a rotation is known least.
    pub fn weak_direction(&self) -> Vector3<T> {
        Vector3::new(T::one(), -self.u.x, -self.u.y)
    }

    /// The inverse of the matrix; `roll` must be positive.
    pub fn inverse(&self) -> Matrix3<T> {
        let n = self.weak_direction();
        let t = &self.transverse_inverse;
        let zero = T::zero();
        n * (n / self.roll).transpose()
            + Matrix3::new(zero, zero, zero, zero, t.m11, t.m12, zero, t.m21, t.m22)
    }
}
