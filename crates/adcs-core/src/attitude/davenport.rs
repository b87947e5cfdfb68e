//! What all optimal methods share: Davenport's matrices and the largest eigenvalue.
//!
//! Wahba's loss of an attitude matrix A is linear in A:
//!
//! L(A) = ½ Σ a_i |b_i − A r_i|² = 1 − tr(A Bᵀ), B = Σ a_i b_i r_iᵀ (Σ a_i = 1)
//!
//! and with A written in the quaternion q = (e, w) it is a quadratic form, L = 1 − qᵀ K q,
//!
//! ```text
//! K = | S − (tr B) I   z    |    S = B + Bᵀ,   z = (B23 − B32, B31 − B13, B12 − B21)
//!     | zᵀ             tr B |
//! ```
//!
//! so that the best q is the eigenvector of the largest eigenvalue λ of K, and L = 1 − λ.
//!
//! | symbol | code | meaning |
//! |---|---|---|
//! | B | `b` | attitude profile matrix |
//! | cof B | `cofactor` | matrix of cofactors, (adj B)ᵀ = adj Bᵀ |
//! | det B, \|B\|² | `determinant`, `norm_squared` | determinant; squared Frobenius norm |
//! | λ | `lambda` | largest eigenvalue of K |
//!
//! Source: Markley & Crassidis (2014), §§5.2, 5.3.1. B is made as b rᵀ: some texts make
//! r bᵀ, and then every A is transposed.

use nalgebra::{Matrix3, Matrix4, RealField, Vector3};

use super::number;
use super::problem::Problem;

/// B with what is computed from it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Profile<T> {
    pub b: Matrix3<T>,
    pub cofactor: Matrix3<T>,
    pub determinant: T,
    pub norm_squared: T,
    pub lambda: T,
}

impl<T: RealField + Copy> Profile<T> {
    /// The attitude profile matrix of a problem.
    pub fn of(problem: &Problem<'_, T>) -> Self {
        let b = problem.pairs().fold(Matrix3::zeros(), |b, pair| {
            b + pair.body * (pair.reference * pair.weight).transpose()
        });
        let [c1, c2, c3] = [b.column(0), b.column(1), b.column(2)];
        let cofactor = Matrix3::from_columns(&[c2.cross(&c3), c3.cross(&c1), c1.cross(&c2)]);
        let determinant = c1.dot(&cofactor.column(0));
        let norm_squared = b.norm_squared();
        let lambda = largest_eigenvalue(norm_squared, determinant, cofactor.norm_squared());
        Self { b, cofactor, determinant, norm_squared, lambda }
    }

    /// z = (B23 − B32, B31 − B13, B12 − B21).
    pub fn z(&self) -> Vector3<T> {
        let b = &self.b;
        Vector3::new(b.m23 - b.m32, b.m31 - b.m13, b.m12 - b.m21)
    }

    /// K.
    pub fn k(&self) -> Matrix4<T> {
        let trace = self.b.trace();
        let mut k = Matrix4::zeros();
        let upper_left = self.b + self.b.transpose() - Matrix3::identity() * trace;
        k.fixed_view_mut::<3, 3>(0, 0).copy_from(&upper_left);
        k.fixed_view_mut::<3, 1>(0, 3).copy_from(&self.z());
        k.fixed_view_mut::<1, 3>(3, 0).copy_from(&self.z().transpose());
        k.m44 = trace;
        k
    }
}

/// Newton steps for λ: two or three when the pairs nearly agree. From far above λ a step still gains a
/// quarter, so this is enough for pairs that contradict each other as well.
const MAX_NEWTON_STEPS: usize = 20;
/// Rounding errors of order ε that meet in one value of the polynomial.
const ROUNDINGS: f64 = 16.0;

/// λ, the largest root of the characteristic polynomial of K, which Markley writes as
///
/// p(λ) = (λ² − |B|²)² − 8 λ det B − 4 |adj B|²
///
/// by Newton's method from 1 = Σ a_i ≥ λ, from where p falls and is convex down to λ, so that the
/// steps never overshoot.
///
/// QUEST's polynomial is the same, written out in powers of λ; there, with nearly parallel vectors
/// or one heavy weight, the coefficients cancel to half the digits. In this form p is known to about
/// ε |λ² − |B|²|, and with such vectors p′ is as large as |λ² − |B|²|, so that λ is good to a few ε.
/// Steps end where p is nothing but rounding.
///
/// Source: Markley (1993), J. Astronaut. Sci. 41(2), eq. (23).
fn largest_eigenvalue<T: RealField + Copy>(norm_squared: T, det: T, adj_squared: T) -> T {
    let (four, eight) = (number::<T>(4.0), number::<T>(8.0));
    let rounding = number::<T>(ROUNDINGS) * T::default_epsilon();
    let mut lambda = T::one();
    for _ in 0..MAX_NEWTON_STEPS {
        let excess = lambda * lambda - norm_squared;
        let p = excess * excess - eight * lambda * det - four * adj_squared;
        let slope = four * lambda * excess - eight * det;
        let noise = rounding * (excess.abs() + eight * det.abs());
        if p <= noise || slope <= T::zero() {
            break;
        }
        lambda -= p / slope;
    }
    lambda
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::attitude::Observation;
    use crate::frames::Vector;
    use proptest::prelude::*;

    /// Components that do not all vanish.
    const DIRECTION: [core::ops::Range<f64>; 3] = [0.01..1.0, -1.0..1.0, -1.0..1.0];
    /// Rounding of the polynomial's root beside nalgebra's eigenvalue, for pairs in general position.
    const ROUNDING: f64 = 1e-12;

    proptest! {
        #[test]
        fn lambda_is_the_largest_eigenvalue_of_k_and_one_minus_it_the_loss(
            bodies in [DIRECTION, DIRECTION, DIRECTION],
            references in [DIRECTION, DIRECTION, DIRECTION],
            sigmas in [0.1..1.0, 0.1..1.0, 0.1..1.0_f64],
        ) {
            let observations = core::array::from_fn::<_, 3, _>(|i| {
                Observation::new(Vector::from_xyz(bodies[i].into()), Vector::from_xyz(references[i].into()), sigmas[i]).unwrap()
            });
            let problem = Problem::new(&observations).unwrap();
            let profile = Profile::of(&problem);
            let eigen = profile.k().symmetric_eigen();
            let largest = eigen.eigenvalues.max();
            // Where the two largest eigenvalues meet, the root of a polynomial is worth half its digits.
            let gap = eigen.eigenvalues.iter().filter(|x| **x < largest).fold(2.0, |gap: f64, x| gap.min(largest - x));
            prop_assert!((profile.lambda - largest).abs() < ROUNDING / gap, "{} {largest}", profile.lambda);
        }
    }
}
