//! Products of matrices of any size by one loop each.
//!
//! nalgebra's own products are unrolled for every size they are used with: right for 3 × 3, and tens of kilobytes
//! for the estimates that commissioning makes, of up to 18 states. Here a matrix is a slice, column by column as
//! nalgebra keeps it, and the code is there once. Sums are made in nalgebra's order, so that it gives the same bits.
//!
//! Sizes come from the slices. Slices that do not belong together give products of the part that does.

use nalgebra::{RealField, SMatrix, SVector};

/// A B.
pub(crate) fn product<T, const R: usize, const K: usize, const C: usize>(
    a: &SMatrix<T, R, K>,
    b: &SMatrix<T, K, C>,
) -> SMatrix<T, R, C>
where
    T: RealField + Copy,
{
    let mut to = SMatrix::<T, R, C>::zeros();
    multiply(to.as_mut_slice(), a.as_slice(), b.as_slice(), R, K);
    to
}

/// A Bᵀ.
pub(crate) fn product_transposed<T, const R: usize, const K: usize, const C: usize>(
    a: &SMatrix<T, R, K>,
    b: &SMatrix<T, C, K>,
) -> SMatrix<T, R, C>
where
    T: RealField + Copy,
{
    let mut to = SMatrix::<T, R, C>::zeros();
    multiply_transposed(to.as_mut_slice(), a.as_slice(), b.as_slice(), R, C);
    to
}

/// Aᵀ B. The bits are nalgebra's from five rows on; shorter columns it adds up otherwise.
pub(crate) fn transposed_product<T, const R: usize, const K: usize, const C: usize>(
    a: &SMatrix<T, K, R>,
    b: &SMatrix<T, K, C>,
) -> SMatrix<T, R, C>
where
    T: RealField + Copy,
{
    let mut to = SMatrix::<T, R, C>::zeros();
    dot_columns(to.as_mut_slice(), a.as_slice(), b.as_slice(), R, K);
    to
}

/// A − (x yᵀ) c.
pub(crate) fn subtract_outer<T, const R: usize, const C: usize>(
    a: &mut SMatrix<T, R, C>,
    x: &SVector<T, R>,
    y: &SVector<T, C>,
    factor: T,
) where
    T: RealField + Copy,
{
    subtract(a.as_mut_slice(), x.as_slice(), y.as_slice(), factor);
}

#[inline(never)]
fn multiply<T: RealField + Copy>(to: &mut [T], a: &[T], b: &[T], rows: usize, inner: usize) {
    for (to, factors) in to.chunks_exact_mut(rows).zip(b.chunks_exact(inner)) {
        combine(to, a, factors.iter());
    }
}

#[inline(never)]
fn multiply_transposed<T: RealField + Copy>(
    to: &mut [T],
    a: &[T],
    b: &[T],
    rows: usize,
    rows_of_b: usize,
) {
    for (row, to) in to.chunks_exact_mut(rows).enumerate() {
        combine(to, a, b.iter().skip(row).step_by(rows_of_b));
    }
}

/// Sum of the columns of A, each times its factor.
fn combine<'a, T: RealField + Copy>(to: &mut [T], a: &[T], factors: impl Iterator<Item = &'a T>) {
    // −0, to which every number can be added without a change, 0 and −0 included.
    to.fill(-T::zero());
    for (column, factor) in a.chunks_exact(to.len()).zip(factors) {
        for (to, a) in to.iter_mut().zip(column) {
            *to += *a * *factor;
        }
    }
}

#[inline(never)]
fn dot_columns<T: RealField + Copy>(to: &mut [T], a: &[T], b: &[T], rows: usize, inner: usize) {
    for (to, right) in to.chunks_exact_mut(rows).zip(b.chunks_exact(inner)) {
        for (to, left) in to.iter_mut().zip(a.chunks_exact(inner)) {
            *to = dot(left, right);
        }
    }
}

/// In eight sums that are added at the end, and what eight do not divide.
fn dot<T: RealField + Copy>(a: &[T], b: &[T]) -> T {
    let (a, b) = (a.chunks_exact(8), b.chunks_exact(8));
    let rest = a.remainder().iter().zip(b.remainder());
    let mut sums = [T::zero(); 8];
    for (a, b) in a.zip(b) {
        for (sum, (a, b)) in sums.iter_mut().zip(a.iter().zip(b)) {
            *sum += *a * *b;
        }
    }
    let [s0, s1, s2, s3, s4, s5, s6, s7] = sums;
    let eights = T::zero() + (s0 + s4) + (s1 + s5) + (s2 + s6) + (s3 + s7);
    rest.fold(eights, |sum, (a, b)| sum + *a * *b)
}

#[inline(never)]
fn subtract<T: RealField + Copy>(from: &mut [T], x: &[T], y: &[T], factor: T) {
    for (column, y) in from.chunks_exact_mut(x.len()).zip(y) {
        for (from, x) in column.iter_mut().zip(x) {
            *from -= *x * *y * factor;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    type Tall = SMatrix<f32, 18, 8>;

    /// Signs, sizes and zeros of both signs in no order.
    fn numbers<const R: usize, const C: usize>(seed: usize) -> SMatrix<f32, R, C> {
        SMatrix::from_fn(|row, column| {
            let k = (seed + 7 * row + 31 * column) % 97;
            if k % 9 == 0 { -0.0 } else { libm::sinf(k as f32) * libm::exp2f((k % 13) as f32) }
        })
    }

    fn bits<const R: usize, const C: usize>(matrix: &SMatrix<f32, R, C>) -> SMatrix<u32, R, C> {
        matrix.map(f32::to_bits)
    }

    #[test]
    fn every_product_has_the_bits_of_nalgebras() {
        let square: SMatrix<f32, 18, 18> = numbers(1);
        let (tall, other): (Tall, Tall) = (numbers(2), numbers(3));
        assert_eq!(bits(&product(&square, &tall)), bits(&(square * tall)));
        assert_eq!(bits(&product_transposed(&tall, &other)), bits(&(tall * other.transpose())));
        let x: SVector<f32, 18> = numbers(4);
        assert_eq!(bits(&product(&square, &x)), bits(&(square * x)));
        assert_eq!(bits(&transposed_product(&tall, &x)), bits(&tall.tr_mul(&x)));
        assert_eq!(bits(&transposed_product(&tall, &other)), bits(&tall.tr_mul(&other)));
        let (y, factor): (SVector<f32, 8>, f32) = (numbers(5), 0.37);
        let mut found = tall;
        subtract_outer(&mut found, &x, &y, factor);
        assert_eq!(bits(&found), bits(&(tall - x * y.transpose() * factor)));
    }
}
