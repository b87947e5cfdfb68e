//! Wahba's problem: the pairs with their weights.

use nalgebra::{Matrix3, RealField, UnitQuaternion, Vector3};

use super::observation::Observation;
use super::{NoAttitude, number};

/// The pairs (b_i, r_i) with weights a_i = σ_i⁻² / Σ σ_j⁻², which sum to one.
///
/// The *sharpest* pair, the one with the smallest σ, has a part of its own: see
/// [`information`](super::information).
#[derive(Debug, Clone, Copy)]
pub(super) struct Problem<'a, T: RealField + Copy> {
    observations: &'a [Observation<T>],
    sharpest: &'a Observation<T>,
    sharpest_index: usize,
    /// 1 / Σ (σ_min / σ_j)², the weight of the sharpest pair.
    largest_weight: T,
}

/// One pair of the problem.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pair<T> {
    /// a
    pub weight: T,
    /// b, Body.
    pub body: Vector3<T>,
    /// r, Eci.
    pub reference: Vector3<T>,
    /// Whether it is the pair with the smallest σ.
    pub is_sharpest: bool,
}

impl<'a, T: RealField + Copy> Problem<'a, T> {
    /// The problem that these observations pose.
    ///
    /// # Errors
    /// [`NoAttitude::TooFew`] when they are fewer than two.
    pub fn new(observations: &'a [Observation<T>]) -> Result<Self, NoAttitude> {
        let (sharpest_index, sharpest) = observations
            .iter()
            .enumerate()
            .reduce(|best, next| if next.1.sigma_rad() < best.1.sigma_rad() { next } else { best })
            .filter(|_| observations.len() >= 2)
            .ok_or(NoAttitude::TooFew { found: observations.len() })?;
        let total = observations
            .iter()
            .fold(T::zero(), |sum, observation| sum + relative_weight(sharpest, observation));
        Ok(Self { observations, sharpest, sharpest_index, largest_weight: T::one() / total })
    }

    /// The pairs, in the order in which they were given.
    pub fn pairs(&self) -> impl Iterator<Item = Pair<T>> + use<'a, T> {
        let Self { observations, sharpest, sharpest_index, largest_weight } = *self;
        observations.iter().enumerate().map(move |(index, observation)| {
            let (body, reference) = observation.units();
            let weight = relative_weight(sharpest, observation) * largest_weight;
            Pair { weight, body, reference, is_sharpest: index == sharpest_index }
        })
    }

    /// ½ Σ a_i |b_i − A r_i|².
    pub fn loss(&self, attitude: &UnitQuaternion<T>) -> T {
        let a = attitude.to_rotation_matrix();
        let sum = self.pairs().fold(T::zero(), |sum, pair| {
            sum + pair.weight * (pair.body - a * pair.reference).norm_squared()
        });
        sum * number(0.5)
    }

    /// (Σ σ_j⁻²)⁻¹, rad²: what turns a matrix made with the weights into one made with σ_i⁻².
    pub fn variance_rad2(&self) -> T {
        self.sharpest.sigma_rad() * self.sharpest.sigma_rad() * self.largest_weight
    }

    /// Rotation matrix from Body to axes of which the first is the sharpest measurement.
    pub fn sharpest_body_axes(&self) -> Matrix3<T> {
        axes_along(&self.sharpest.units().0)
    }

    /// An attitude matrix under which the sharpest pair agrees; the turn about it is arbitrary.
    pub fn aligned_with_sharpest(&self) -> Matrix3<T> {
        let (body, reference) = self.sharpest.units();
        axes_along(&body).transpose() * axes_along(&reference)
    }
}

/// (σ_min / σ)², from 0 (beyond the range of the type) to 1: the quotient first, so that no σ⁻²
/// overflows.
fn relative_weight<T: RealField + Copy>(sharpest: &Observation<T>, other: &Observation<T>) -> T {
    let ratio = sharpest.sigma_rad() / other.sigma_rad();
    ratio * ratio
}

/// A right-handed triad of unit rows, the first being `n`.
///
/// Source: Duff et al. (2017), Building an Orthonormal Basis, Revisited, listing 3: one division,
/// and no direction for which it fails.
fn axes_along<T: RealField + Copy>(n: &Vector3<T>) -> Matrix3<T> {
    let sign = T::one().copysign(n.z);
    let a = -T::one() / (sign + n.z);
    let b = n.x * n.y * a;
    Matrix3::new(
        n.x,
        n.y,
        n.z,
        T::one() + sign * n.x * n.x * a,
        sign * b,
        -sign * n.x,
        b,
        sign + n.y * n.y * a,
        -n.y,
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frames::{Body, Vector};
    use proptest::prelude::*;

    /// Rounding of products of order one.
    const ROUNDING: f64 = 4e-15;

    proptest! {
        #[test]
        fn axes_along_any_direction_are_a_right_handed_triad(v in [-1.0..1.0, -1.0..1.0, -1.0..1.0_f64]) {
            let v = Vector3::from(v);
            prop_assume!(v.norm() > 1e-3);
            let axes = axes_along(&v.normalize());
            prop_assert!((axes * axes.transpose() - Matrix3::identity()).norm() < ROUNDING);
            prop_assert!((axes.determinant() - 1.0).abs() < ROUNDING);
            prop_assert!((axes * v.normalize() - Vector3::x()).norm() < ROUNDING);
        }
    }

    #[test]
    fn weights_sum_to_one_and_go_as_the_inverse_square_of_sigma() {
        let x: Vector<Body, f64> = Vector::new(1.0, 0.0, 0.0);
        let sigmas = [0.02, 0.01, 0.04];
        let observations = sigmas.map(|sigma| Observation::new(x, x.relabel(), sigma).unwrap());
        let problem = Problem::new(&observations).unwrap();
        let weights: [f64; 3] =
            core::array::from_fn(|i| problem.pairs().nth(i).map_or(0.0, |pair| pair.weight));
        // 25 : 100 : 6.25
        for (weight, expected) in weights.iter().zip([25.0, 100.0, 6.25]) {
            assert!((weight - expected / 131.25).abs() < ROUNDING);
        }
        assert!(problem.pairs().map(|pair| pair.is_sharpest).eq([false, true, false]));
        assert!((problem.variance_rad2() - 1.0 / (131.25 * 100.0)).abs() < ROUNDING);
    }

    #[test]
    fn one_pair_is_no_problem() {
        let x: Vector<Body> = Vector::new(1.0, 0.0, 0.0);
        let one = [Observation::new(x, x.relabel(), 0.1).unwrap()];
        assert_eq!(Problem::new(&one).unwrap_err(), NoAttitude::TooFew { found: 1 });
        assert_eq!(Problem::<f32>::new(&[]).unwrap_err(), NoAttitude::TooFew { found: 0 });
    }
}
