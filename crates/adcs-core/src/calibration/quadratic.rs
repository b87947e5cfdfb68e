//! The cost as a form of second order in θ, and what noise makes of it.

use nalgebra::{Matrix3, RealField, SMatrix, SVector, Vector3};

use super::descent::{Pass, Problem};
use super::moments::{OF_FOUR, OF_TWO, laplacian, squares};
use super::number;
use super::parameters::Parameters;
use crate::rolled::{product, transposed_product};

/// How uncertain the cost is, in roundings of v.
const COST_ROUNDINGS: f64 = 10.0;

/// θᵀ A θ − 2 θᵀ u + v
pub(super) struct Quadratic<T: RealField + Copy> {
    pub a: SMatrix<T, OF_TWO, OF_TWO>,
    pub u: SVector<T, OF_TWO>,
    v: T,
}

impl<T: RealField + Copy> Quadratic<T> {
    pub fn of(fourth: &SVector<T, OF_FOUR>, second: &SVector<T, OF_TWO>, v: T) -> Self {
        Self { a: squares(fourth), u: *second, v }
    }

    #[inline(never)]
    fn cost(&self, theta: &SVector<T, OF_TWO>) -> T {
        theta.dot(&(product(&self.a, theta) - self.u * number::<T>(2.0))) + self.v
    }
}

/// What the roundings of sums leave uncertain.
pub(super) struct Rounding<T: RealField + Copy, const N: usize> {
    /// Of the cost.
    pub cost: T,
    /// Of the gradient.
    pub gradient: SVector<T, N>,
}

impl<T: RealField + Copy> Quadratic<T> {
    /// Of sums that are uncertain by this part of themselves: everything added as if it had one sign.
    #[inline(never)]
    pub fn rounding<const N: usize>(&self, x: &Parameters<T, N>, part: T) -> Rounding<T, N> {
        let theta = monomial_factors(x).abs();
        let (a_theta, u) = (product(&self.a.abs(), &theta), self.u.abs());
        Rounding {
            cost: (theta.dot(&(a_theta + u * number::<T>(2.0))) + self.v) * part,
            gradient: transposed_product(&monomial_slopes(x).abs(), &(a_theta + u)) * part,
        }
    }
}

impl<T: RealField + Copy, const N: usize> Problem<T, N> for Quadratic<T> {
    #[inline(never)]
    fn pass(&self, x: &SVector<T, N>) -> Pass<T, N> {
        let x = Parameters(*x);
        let (theta, slope) = (monomial_factors(&x), monomial_slopes(&x));
        Pass {
            cost: self.cost(&theta),
            gradient: transposed_product(&slope, &(product(&self.a, &theta) - self.u)),
            normal: transposed_product(&slope, &product(&self.a, &slope)),
        }
    }

    fn cancellation(&self) -> T {
        self.v * T::default_epsilon() * number(COST_ROUNDINGS)
    }
}

/// Q − Q_σ = σ² q₁ − σ⁴ q₂: what noise makes of the cost, on average.
pub(super) struct ByNoise<T: RealField + Copy> {
    /// q₁ = θᵀ A₁ θ − 2 θᵀ u₁, A₁ and u₁ being Σ ½∇² of what is summed in A and u.
    first: Quadratic<T>,
    /// q₂ = θᵀ A₂ θ, A₂ being Σ ⅛∇²∇².
    second: SMatrix<T, OF_TWO, OF_TWO>,
}

impl<T: RealField + Copy> ByNoise<T> {
    /// From the sums that the cost is made of.
    #[inline(never)]
    pub fn of(fourth: &SVector<T, OF_FOUR>, second: &SVector<T, OF_TWO>) -> Self {
        let (half, eighth) = (number::<T>(0.5), number::<T>(0.125));
        let once = laplacian(fourth);
        Self {
            first: Quadratic::of(&(once * half), &(laplacian(second) * half), T::zero()),
            second: squares(&(laplacian(&once) * eighth)),
        }
    }

    /// q₁ − σ² q₂
    #[inline(never)]
    pub fn cost<const N: usize>(&self, x: &Parameters<T, N>, variance: T) -> T {
        let theta = monomial_factors(x);
        self.first.cost(&theta) - theta.dot(&product(&self.second, &theta)) * variance
    }

    /// Half the derivative of σ² q₁ − σ⁴ q₂ by x.
    #[inline(never)]
    pub fn gradient<const N: usize>(&self, x: &Parameters<T, N>, variance: T) -> SVector<T, N> {
        let theta = monomial_factors(x);
        let first = product(&self.first.a, &theta) - self.first.u;
        let left = first - product(&self.second, &theta) * variance;
        transposed_product(&monomial_slopes(x), &left) * variance
    }
}

/// Six numbers of a symmetric matrix, those beside the diagonal twice, then the three of a vector and one,
/// in the order of the monomials.
fn row_of<T: RealField + Copy>(
    square: &Matrix3<T>,
    linear: &Vector3<T>,
    constant: T,
) -> SVector<T, OF_TWO> {
    let [[xx, xy, xz], [_, yy, yz], [_, _, zz]] = (*square).into();
    let two = number::<T>(2.0);
    let [x, y, z] = (*linear).into();
    SVector::from([constant, x, y, z, xx, xy * two, xz * two, yy, yz * two, zz])
}

/// θ: |C S V + b|² = Vᵀ (S C² S) V + 2 (S C b) · V + |b|², S = diag(s).
#[inline(never)]
fn monomial_factors<T: RealField + Copy, const N: usize>(
    x: &Parameters<T, N>,
) -> SVector<T, OF_TWO> {
    let (matrix, bias) = (x.matrix(), Vector3::from(x.bias()));
    let linear = matrix.tr_mul(&bias) * number::<T>(2.0);
    row_of(&matrix.tr_mul(&matrix), &linear, bias.norm_squared())
}

/// |Mᵀβ|² = |MᵀM V + Mᵀb|² in the same form.
pub(super) fn noise_gain<T: RealField + Copy, const N: usize>(
    x: &Parameters<T, N>,
) -> SVector<T, OF_TWO> {
    let matrix = x.matrix();
    let (square, bias) = (matrix.tr_mul(&matrix), matrix.tr_mul(&Vector3::from(x.bias())));
    row_of(&(square * square), &(square * bias * number::<T>(2.0)), bias.norm_squared())
}

/// ∂θ/∂x. With dM and db: Mᵀ dM + dMᵀ M, 2 (dMᵀ b + Mᵀ db), 2 b · db.
#[inline(never)]
pub(super) fn monomial_slopes<T: RealField + Copy, const N: usize>(
    x: &Parameters<T, N>,
) -> SMatrix<T, OF_TWO, N> {
    let (matrix, bias) = (x.matrix(), Vector3::from(x.bias()));
    let (zero, one, two) = (T::zero(), T::one(), number::<T>(2.0));
    // ∂B/∂x is linear in the reading and in what stands beside it: the columns of dM, and db.
    let axes = [[one, zero, zero], [zero, one, zero], [zero, zero, one]];
    let [of_x, of_y, of_z] = axes.map(|axis| x.jacobian(axis, zero, &[]));
    let of_bias = x.jacobian([zero; 3], one, &[]);
    let mut slopes = SMatrix::<T, OF_TWO, N>::zeros();
    let columns = of_x.column_iter().zip(of_y.column_iter()).zip(of_z.column_iter());
    for ((mut slope, ((x, y), z)), db) in
        slopes.column_iter_mut().zip(columns).zip(of_bias.column_iter())
    {
        let dm = Matrix3::from_columns(&[x, y, z]);
        let half = matrix.tr_mul(&dm);
        let linear = (dm.tr_mul(&bias) + matrix.tr_mul(&db)) * two;
        slope.copy_from(&row_of(&(half + half.transpose()), &linear, bias.dot(&db) * two));
    }
    slopes
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Of central differences of polynomials of degree four, of order one.
    const DIFFERENCES: f64 = 1e-7;

    proptest! {
        #[test]
        fn the_slopes_are_derivatives_and_the_factors_give_the_strength(
            x in prop::array::uniform9(-1.0..1.0_f64),
            v in prop::array::uniform3(-1.0..1.0_f64),
        ) {
            const STEP: f64 = 1e-5;
            let at = Parameters::<f64, 9>(SVector::from(x));
            let [a, b, c] = v;
            let m = SVector::from([1.0, a, b, c, a * a, a * b, a * c, b * b, b * c, c * c]);
            let strength = Vector3::from(at.field(v, &[])).norm_squared();
            prop_assert!((m.dot(&monomial_factors(&at)) - strength).abs() < DIFFERENCES);
            let slopes = monomial_slopes(&at);
            for i in 0..9 {
                let moved = |by: f64| {
                    let mut moved = at;
                    moved.0[i] += by;
                    monomial_factors(&moved)
                };
                let numeric = (moved(STEP) - moved(-STEP)) / (2.0 * STEP);
                prop_assert!((numeric - slopes.column(i)).norm() < DIFFERENCES);
            }
        }
    }
}
