//! Eigenvalues of a small symmetric matrix, and what they are good for: damped solutions, inverses,
//! the condition, and which unknown the data say least about.
//!
//! Source: Golub & Van Loan, Matrix Computations, 4th ed., §8.5 (the cyclic Jacobi method).

use nalgebra::{Matrix3, RealField, SMatrix, SVector};

use super::number;

/// Sweeps over all pairs. Convergence is quadratic; six do for 7×7 in f64.
const MAX_SWEEPS: usize = 12;

/// A symmetric matrix taken apart after its rows and columns were scaled to a diagonal of ones:
/// D⁻¹ N D⁻¹ = Q diag(λ) Qᵀ, D² = diag(N).
#[derive(Debug, Clone, Copy)]
pub(crate) struct Spectrum<T: RealField + Copy, const N: usize> {
    /// 1 / D
    inverse_scale: SVector<T, N>,
    values: SVector<T, N>,
    vectors: SMatrix<T, N, N>,
}

impl<T: RealField + Copy, const N: usize> Spectrum<T, N> {
    /// Takes a positive semidefinite matrix apart. A zero on its diagonal becomes a zero eigenvalue.
    pub fn of(normal: &SMatrix<T, N, N>) -> Self {
        let inverse_scale =
            normal.diagonal().map(|d| if d > T::zero() { T::one() / d.sqrt() } else { T::zero() });
        let mut a = normal.component_mul(&(inverse_scale * inverse_scale.transpose()));
        let vectors = diagonalise(&mut a);
        Self { inverse_scale, values: a.diagonal(), vectors }
    }

    /// −(N + damping D²)⁻¹ g.
    pub fn step(&self, gradient: &SVector<T, N>, damping: T) -> SVector<T, N> {
        let scaled = self.vectors.tr_mul(&gradient.component_mul(&self.inverse_scale));
        let solved = scaled.zip_map(&self.values, |g, value| {
            -g / (value.max(T::zero()) + damping.max(self.rounding()))
        });
        (self.vectors * solved).component_mul(&self.inverse_scale)
    }

    /// N⁻¹. Eigenvalues below rounding count as rounding.
    pub fn inverse(&self) -> SMatrix<T, N, N> {
        let mut half = self.vectors;
        for (mut column, value) in half.column_iter_mut().zip(self.values.iter()) {
            column.component_mul_assign(&self.inverse_scale);
            column /= value.max(self.rounding()).sqrt();
        }
        half * half.transpose()
    }

    /// Largest over smallest eigenvalue; never above one over rounding.
    pub fn condition(&self) -> T {
        self.values.max() / self.values.min().max(self.rounding())
    }

    /// The index of the unknown with the largest part in the direction that is known least.
    pub fn weakest(&self) -> usize {
        self.vectors.column(self.values.imin()).iamax()
    }

    /// What an eigenvalue of a matrix of this size, its diagonal of ones, is uncertain by.
    fn rounding(&self) -> T {
        T::default_epsilon() * number(4.0 * N as f64)
    }
}

/// Standard deviations by a covariance.
pub(crate) fn sigmas<T: RealField + Copy, const N: usize>(
    covariance: &SMatrix<T, N, N>,
) -> SVector<T, N> {
    covariance.diagonal().map(|variance| variance.max(T::zero()).sqrt())
}

/// The symmetric root of a positive matrix whose entries are of order one; eigenvalues below zero count
/// as zero.
pub(super) fn square_root<T: RealField + Copy>(matrix: &Matrix3<T>) -> Matrix3<T> {
    let mut a = *matrix;
    let vectors = diagonalise(&mut a);
    let roots = a.diagonal().map(|value| value.max(T::zero()).sqrt());
    vectors * Matrix3::from_diagonal(&roots) * vectors.transpose()
}

/// Turns a symmetric matrix until it is diagonal; the columns of the result are its eigenvectors.
fn diagonalise<T: RealField + Copy, const N: usize>(a: &mut SMatrix<T, N, N>) -> SMatrix<T, N, N> {
    let mut vectors = SMatrix::<T, N, N>::identity();
    for _ in 0..MAX_SWEEPS {
        let mut turned = false;
        for p in 0..N {
            for q in p + 1..N {
                turned |= annihilate(a, &mut vectors, p, q);
            }
        }
        if !turned {
            break;
        }
    }
    vectors
}

/// Turns the plane of `p` and `q` until their coupling is zero; whether there was any.
fn annihilate<T: RealField + Copy, const N: usize>(
    a: &mut SMatrix<T, N, N>,
    vectors: &mut SMatrix<T, N, N>,
    p: usize,
    q: usize,
) -> bool {
    let coupling = a[(p, q)];
    let negligible = T::default_epsilon() * number(0.1);
    // Of a diagonal of ones; a NaN fails the comparison.
    let couples = coupling.abs() > negligible;
    if !couples {
        return false;
    }
    let tau = (a[(q, q)] - a[(p, p)]) / (coupling + coupling);
    let t = T::one().copysign(tau) / (tau.abs() + (T::one() + tau * tau).sqrt());
    let cos = T::one() / (T::one() + t * t).sqrt();
    let sin = t * cos;
    for k in 0..N {
        let (kp, kq) = (a[(k, p)], a[(k, q)]);
        a[(k, p)] = cos * kp - sin * kq;
        a[(k, q)] = sin * kp + cos * kq;
        let (kp, kq) = (vectors[(k, p)], vectors[(k, q)]);
        vectors[(k, p)] = cos * kp - sin * kq;
        vectors[(k, q)] = sin * kp + cos * kq;
    }
    for k in 0..N {
        let (pk, qk) = (a[(p, k)], a[(q, k)]);
        a[(p, k)] = cos * pk - sin * qk;
        a[(q, k)] = sin * pk + cos * qk;
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;
    use proptest::prelude::*;

    /// Of products of numbers of order one whose condition is up to 10⁴.
    const ROUNDING: f64 = 1e-10;

    proptest! {
        #[test]
        fn a_step_solves_the_normal_equations(rows in prop::array::uniform9(-1.0..1.0_f64), g in [-1.0..1.0, -1.0..1.0, -1.0..1.0_f64]) {
            let rows = Matrix3::from_row_slice(&rows);
            let normal = rows.tr_mul(&rows);
            let spectrum = Spectrum::of(&normal);
            prop_assume!(spectrum.condition() < 1e4);
            let g = Vector3::from(g);
            let step = spectrum.step(&g, 0.0);
            prop_assert!((normal * step + g).norm() < ROUNDING * (1.0 + step.norm()));
            prop_assert!((spectrum.inverse() * g + step).norm() < ROUNDING * (1.0 + step.norm()));
        }
    }

    #[test]
    fn units_of_the_unknowns_do_not_count_for_the_condition() {
        let normal = Matrix3::<f64>::new(1e20, 5e9, 0.0, 5e9, 1.0, 0.0, 0.0, 0.0, 1e-20);
        let spectrum = Spectrum::of(&normal);
        // 1 ± 0.5 and 1.
        assert!((spectrum.condition() - 3.0).abs() < ROUNDING);
    }

    #[test]
    fn what_the_data_do_not_see_is_named() {
        let normal = Matrix3::<f32>::from_diagonal(&Vector3::new(1.0, 0.0, 1.0));
        let spectrum = Spectrum::of(&normal);
        assert_eq!(spectrum.weakest(), 1);
        assert!(spectrum.condition() > 1e5);
    }
}
