//! Sums of products of a reading's components, and what noise does to them.
//!
//! A polynomial p(V) of degree D has one coefficient for each x^i y^j z^k with i + j + k ≤ D: 10 of them
//! for D = 2, 35 for 4, 84 for 6. Its sum over all readings is linear in the sums μ_ijk = Σ w x^i y^j z^k.
//! They stand in the order of their degree, then of that in y and z, then of that in z:
//!
//! 1, x, y, z, x², xy, xz, y², yz, z², x³, …
//!
//! so that those of a lower degree are the first of those of a higher one.
//!
//! **Noise.** With readings V = V₀ + ε, ε being Gaussian of σ in every component, a polynomial has the mean
//!
//! E p(V) = exp(½ σ² ∇²) p(V₀),
//!
//! the solution of the heat equation. So exp(−½ σ² ∇²) p has the mean p(V₀): its sums are free of
//! noise on average, and the series ends, being of a polynomial. Source: Stefanski (1989), Commun. Stat.
//! Theory Methods 18(12), 4335–4358; for ellipsoids Markovsky, Kukush & Van Huffel (2004), Numer. Math. 98,
//! 177–194.

use nalgebra::{RealField, SMatrix, SVector};

use super::number;

/// Monomials of degree 2, 4, 6 at most.
pub(super) const OF_TWO: usize = 10;
pub(super) const OF_FOUR: usize = 35;
pub(super) const OF_SIX: usize = 84;

/// Exponents of the monomials of degree two at most.
const SQUARES: [[usize; 3]; OF_TWO] = [
    [0, 0, 0],
    [1, 0, 0],
    [0, 1, 0],
    [0, 0, 1],
    [2, 0, 0],
    [1, 1, 0],
    [1, 0, 1],
    [0, 2, 0],
    [0, 1, 1],
    [0, 0, 2],
];

/// Exponents of all monomials, in their order.
fn exponents() -> impl Iterator<Item = [usize; 3]> {
    (0..=6).flat_map(|degree| {
        (0..=degree).flat_map(move |of_yz| (0..=of_yz).map(move |k| [degree - of_yz, of_yz - k, k]))
    })
}

/// Where a monomial stands.
fn place([i, j, k]: [usize; 3]) -> usize {
    let of_yz = j + k;
    let degree = i + of_yz;
    degree * (degree + 1) * (degree + 2) / 6 + of_yz * (of_yz + 1) / 2 + k
}

/// All monomials of a reading.
pub(super) fn monomials<T: RealField + Copy>(reading: [T; 3]) -> SVector<T, OF_SIX> {
    let [x, y, z] = reading.map(|v| {
        let v2 = v * v;
        let v3 = v2 * v;
        [T::one(), v, v2, v3, v2 * v2, v2 * v3, v3 * v3]
    });
    let mut found = [T::zero(); OF_SIX];
    let mut places = found.iter_mut();
    // As `exponents` has them, in loops that the compiler sees through: this is done for every reading.
    for degree in 0..7 {
        for of_yz in 0..degree + 1 {
            let of_x = x.get(degree - of_yz);
            for k in 0..of_yz + 1 {
                let factors = (places.next(), of_x, y.get(of_yz - k), z.get(k));
                if let (Some(place), Some(of_x), Some(of_y), Some(of_z)) = factors {
                    *place = *of_x * *of_y * *of_z;
                }
            }
        }
    }
    SVector::from(found)
}

/// Σ w m mᵀ, m being the monomials of degree two at most.
pub(super) fn squares<T: RealField + Copy>(
    sums: &SVector<T, OF_FOUR>,
) -> SMatrix<T, OF_TWO, OF_TWO> {
    let mut found = SMatrix::<T, OF_TWO, OF_TWO>::zeros();
    for (mut column, right) in found.column_iter_mut().zip(SQUARES) {
        for (value, left) in column.iter_mut().zip(SQUARES) {
            *value = at(sums, added(left, right));
        }
    }
    found
}

/// Σ w p m, m being the monomials of degree four at most and p a polynomial of degree two.
pub(super) fn times<T: RealField + Copy>(
    sums: &SVector<T, OF_SIX>,
    polynomial: &SVector<T, OF_TWO>,
) -> SVector<T, OF_FOUR> {
    let mut found = SVector::<T, OF_FOUR>::zeros();
    for (value, left) in found.iter_mut().zip(exponents()) {
        for (factor, right) in polynomial.iter().zip(SQUARES) {
            *value += *factor * at(sums, added(left, right));
        }
    }
    found
}

/// Σ w ∇²m for each monomial m.
pub(super) fn laplacian<T: RealField + Copy, const L: usize>(
    sums: &SVector<T, L>,
) -> SVector<T, L> {
    let mut found = SVector::<T, L>::zeros();
    for (value, [i, j, k]) in found.iter_mut().zip(exponents()) {
        let mut second = |n: usize, lowered: Option<[usize; 3]>| {
            if let Some(lowered) = lowered {
                *value += at(sums, lowered) * number((n * (n - 1)) as f64);
            }
        };
        second(i, i.checked_sub(2).map(|i| [i, j, k]));
        second(j, j.checked_sub(2).map(|j| [i, j, k]));
        second(k, k.checked_sub(2).map(|k| [i, j, k]));
    }
    found
}

fn added([i, j, k]: [usize; 3], [l, m, n]: [usize; 3]) -> [usize; 3] {
    [i + l, j + m, k + n]
}

fn at<T: RealField + Copy, const L: usize>(sums: &SVector<T, L>, exponents: [usize; 3]) -> T {
    sums.get(place(exponents)).copied().unwrap_or(T::zero())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Of sums of products of numbers of order one.
    const ROUNDING: f64 = 1e-12;

    /// The sums without noise, on average: μ − ½ σ² ∇²μ + ⅛ σ⁴ ∇²∇²μ.
    fn without_noise(sums: &SVector<f64, OF_FOUR>, sigma: f64) -> SVector<f64, OF_FOUR> {
        let (once, variance) = (laplacian(sums), sigma * sigma);
        sums - once * (0.5 * variance) + laplacian(&once) * (0.125 * variance * variance)
    }

    #[test]
    fn every_monomial_stands_in_its_place() {
        assert_eq!(exponents().count(), OF_SIX);
        for (index, exponents) in exponents().enumerate() {
            assert_eq!(place(exponents), index);
        }
        assert!(exponents().zip(SQUARES).all(|(a, b)| a == b));
    }

    proptest! {
        #[test]
        fn sums_of_products_are_products_of_their_factors(
            v in prop::array::uniform3(-1.0..1.0_f64),
            p in prop::array::uniform10(-1.0..1.0_f64),
        ) {
            let all = monomials(v);
            for (value, [i, j, k]) in all.iter().zip(exponents()) {
                let expected = v[0].powi(i as i32) * v[1].powi(j as i32) * v[2].powi(k as i32);
                prop_assert!((value - expected).abs() < ROUNDING);
            }
            let four: SVector<f64, OF_FOUR> = all.fixed_rows::<OF_FOUR>(0).into();
            let ten: SVector<f64, OF_TWO> = all.fixed_rows::<OF_TWO>(0).into();
            let p = SVector::from(p);
            let squares = squares(&four);
            prop_assert!((squares - ten * ten.transpose()).norm() < ROUNDING);
            let times = times(&all, &p);
            prop_assert!((times - four * p.dot(&ten)).norm() < ROUNDING);
        }

        #[test]
        fn the_mean_over_noise_of_a_corrected_sum_is_the_sum_without_noise(
            v in prop::array::uniform3(-1.0..1.0_f64),
            sigma in 0.0..0.5_f64,
        ) {
            // Three points in each component have the moments of a Gaussian up to the fifth.
            let points = [(0.0, 2.0 / 3.0), (-3.0_f64, 1.0 / 6.0), (3.0, 1.0 / 6.0)]
                .map(|(square, weight)| (square.signum() * square.abs().sqrt() * sigma, weight));
            let mut mean = SVector::<f64, OF_FOUR>::zeros();
            for (x, w_x) in points {
                for (y, w_y) in points {
                    for (z, w_z) in points {
                        let noisy = monomials([v[0] + x, v[1] + y, v[2] + z]);
                        let noisy = without_noise(&noisy.fixed_rows::<OF_FOUR>(0).into(), sigma);
                        mean += noisy * (w_x * w_y * w_z);
                    }
                }
            }
            prop_assert!((mean - monomials(v).fixed_rows::<OF_FOUR>(0)).norm() < ROUNDING);
        }
    }
}
