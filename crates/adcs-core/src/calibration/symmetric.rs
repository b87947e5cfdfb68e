//! Eigenvalues of a small symmetric matrix, and what they are good for: damped solutions, inverses,
//! the condition, and which unknown the data say least about.
//!
//! Source: Golub & Van Loan, Matrix Computations, 4th ed., §8.5 (the cyclic Jacobi method).

use nalgebra::{Matrix3, RealField, SMatrix, SVector};

use super::number;
use crate::rolled::{product, product_transposed};

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
    #[inline(never)]
    pub fn of(normal: &SMatrix<T, N, N>) -> Self {
        let inverse_scale =
            normal.diagonal().map(|d| if d > T::zero() { T::one() / d.sqrt() } else { T::zero() });
        let mut a = normal.component_mul(&(inverse_scale * inverse_scale.transpose()));
        let vectors = diagonalise(&mut a);
        Self { inverse_scale, values: a.diagonal(), vectors }
    }

    /// −(N + damping D²)⁻¹ g.
    #[inline(never)]
    pub fn step(&self, gradient: &SVector<T, N>, damping: T) -> SVector<T, N> {
        let scaled = self.vectors.tr_mul(&gradient.component_mul(&self.inverse_scale));
        let solved = scaled.zip_map(&self.values, |g, value| {
            -g / (value.max(T::zero()) + damping.max(self.rounding()))
        });
        product(&self.vectors, &solved).component_mul(&self.inverse_scale)
    }

    /// N⁻¹. Eigenvalues below rounding count as rounding.
    #[inline(never)]
    pub fn inverse(&self) -> SMatrix<T, N, N> {
        let mut half = self.vectors;
        for (mut column, value) in half.column_iter_mut().zip(self.values.iter()) {
            column.component_mul_assign(&self.inverse_scale);
            column /= value.max(self.rounding()).sqrt();
        }
        product_transposed(&half, &half)
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
    sweep(a.as_mut_slice(), vectors.as_mut_slice(), N);
    vectors
}

/// The same for a matrix of any size, column by column: the code is there once.
#[inline(never)]
fn sweep<T: RealField + Copy>(a: &mut [T], vectors: &mut [T], size: usize) {
    for _ in 0..MAX_SWEEPS {
        let mut turned = false;
        for p in 0..size {
            for q in p + 1..size {
                let turn = turn_of(a, size, (p, q));
                turned |= turn.is_some();
                if let Some(turn) = turn {
                    turn.mix_columns(a, size, (p, q));
                    turn.mix_columns(vectors, size, (p, q));
                    turn.mix_rows(a, size, (p, q));
                }
            }
        }
        if !turned {
            break;
        }
    }
}

/// A turn in the plane of two axes.
struct Turn<T> {
    cos: T,
    sin: T,
}

/// What makes the coupling of `p` and `q` zero; `None` when there is none.
fn turn_of<T: RealField + Copy>(a: &[T], size: usize, (p, q): (usize, usize)) -> Option<Turn<T>> {
    let at = |row: usize, column: usize| a.get(row + column * size).copied();
    let coupling = at(p, q)?;
    let negligible = T::default_epsilon() * number(0.1);
    // Of a diagonal of ones; a NaN fails the comparison.
    let couples = coupling.abs() > negligible;
    if !couples {
        return None;
    }
    let tau = (at(q, q)? - at(p, p)?) / (coupling + coupling);
    let t = T::one().copysign(tau) / (tau.abs() + (T::one() + tau * tau).sqrt());
    let cos = T::one() / (T::one() + t * t).sqrt();
    Some(Turn { cos, sin: t * cos })
}

impl<T: RealField + Copy> Turn<T> {
    fn mix(&self, p: &mut T, q: &mut T) {
        (*p, *q) = (self.cos * *p - self.sin * *q, self.sin * *p + self.cos * *q);
    }

    fn mix_columns(&self, matrix: &mut [T], size: usize, (p, q): (usize, usize)) {
        let mut columns = matrix.chunks_exact_mut(size).skip(p);
        // The second is counted from behind the first.
        if let (Some(left), Some(right)) = (columns.next(), columns.nth(q - p - 1)) {
            left.iter_mut().zip(right).for_each(|(p, q)| self.mix(p, q));
        }
    }

    fn mix_rows(&self, matrix: &mut [T], size: usize, (p, q): (usize, usize)) {
        for column in matrix.chunks_exact_mut(size) {
            let mut rows = column.iter_mut().skip(p);
            if let (Some(upper), Some(lower)) = (rows.next(), rows.nth(q - p - 1)) {
                self.mix(upper, lower);
            }
        }
    }
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
