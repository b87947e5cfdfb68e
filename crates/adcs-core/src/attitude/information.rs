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

    /// Adds `weight` times (b·c) I − ½ (b cᵀ + c bᵀ), but with c bᵀ alone in the coupling, where the
    /// sharpest pair, b = (1, 0, 0), then gives nothing at all. What is left out is a component of g,
    /// which is zero where H counts.
    #[must_use]
    pub fn plus(self, weight: T, b: &Vector3<T>, c: &Vector3<T>) -> Self {
        let half = number::<T>(0.5);
        let (x, y, z) = (b.x * c.x, b.y * c.y, b.z * c.z);
        let yz = (b.y * c.z + b.z * c.y) * half;
        Self {
            roll: self.roll + weight * (y + z),
            coupling: self.coupling - b.yz() * (weight * c.x),
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
    /// With q the mean eigenvalue and D = H − q I, the characteristic polynomial is y³ − J₂y − J₃ in
    /// y = x − q, J₂ = ½ tr D², J₃ = det D, which stays exact when the eigenvalues are nearly equal.
    /// Its *largest* root y₃ is found by Newton's method from the bound 2 √(J₂/3); the distance of
    /// the other two is √(4 J₂ − 3 y₃²) and their product det H / x₃, where det H is a product of
    /// determinants without cancellation: so a smallest eigenvalue of 10⁻¹² keeps its digits.
    ///
    /// Where x₂ and x₃ nearly coincide the steps only halve the error, but there an error δ of x₃
    /// makes one of −δ in x₂, and x₁ = det H / (x₂ x₃) has δ² of it.
    pub fn smallest_eigenvalue(&self, eliminated: &Eliminated<T>) -> T {
        const MAX_STEPS: usize = 12;
        /// Squared, this is less than anyone asks of a margin.
        const RELATIVE_STEP: f64 = 1e-4;
        let (two, three, four) = (number::<T>(2.0), number::<T>(3.0), number::<T>(4.0));
        let t = &self.transverse;
        let q = (self.roll + t.trace()) / three;
        let (d1, d2, d3) = (self.roll - q, t.m11 - q, t.m22 - q);
        let (c2, c3) = (self.coupling.x, self.coupling.y);
        let off = c2 * c2 + c3 * c3 + t.m12 * t.m12;
        let j2 = (d1 * d1 + d2 * d2 + d3 * d3) / two + off;
        let j3 = d1 * (d2 * d3 - t.m12 * t.m12) - c2 * (c2 * d3 - t.m12 * c3)
            + c3 * (c2 * t.m12 - d2 * c3);
        let mut y3 = two * (j2 / three).sqrt();
        for _ in 0..MAX_STEPS {
            let p = (y3 * y3 - j2) * y3 - j3;
            let slope = three * y3 * y3 - j2;
            // Only rounding makes them negative here, or zero all eigenvalues being equal.
            if p <= T::zero() || slope <= T::zero() {
                break;
            }
            let step = p / slope;
            y3 -= step;
            if step <= y3 * number(RELATIVE_STEP) {
                break;
            }
        }
        let product = eliminated.transverse_determinant * eliminated.roll / (q + y3);
        let distance = (four * j2 - three * y3 * y3).max(T::zero()).sqrt();
        two * product / (two * q - y3 + distance)
    }
}

impl<T: RealField + Copy> Eliminated<T> {
    /// n = (1, −u), the direction about which a rotation is known least.
    pub fn weak_direction(&self) -> Vector3<T> {
        Vector3::new(T::one(), -self.u.x, -self.u.y)
    }

    /// The inverse of the matrix, n nᵀ / roll + (transverse)⁻¹, in the axes from which `axes`
    /// leads to those of the matrix. Sums of squares stand on its diagonal; `roll` must be positive.
    pub fn inverse_in(&self, axes: &Matrix3<T>) -> Matrix3<T> {
        let n = axes.tr_mul(&self.weak_direction());
        let (y, z) = (axes.row(1).transpose(), axes.row(2).transpose());
        let t = &self.transverse_inverse;
        let yz = y * z.transpose();
        n * n.transpose() / self.roll
            + y * y.transpose() * t.m11
            + (yz + yz.transpose()) * t.m12
            + z * z.transpose() * t.m22
    }
}
