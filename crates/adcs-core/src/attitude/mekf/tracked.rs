//! The estimate while there is one: attitude, bias and their covariance.

use nalgebra::{
    ComplexField, Matrix3, Matrix6, Quaternion, RealField, Unit, Vector3, Vector6, convert,
};

use super::propagation::{ProcessNoise, Step};
use super::update::Correction;
use crate::frames::{Body, Eci, Rotation};

/// Attitude and gyro bias, with the covariance of their errors (θ, Δβ).
#[derive(Debug, Clone, Copy)]
pub(super) struct Tracked<T: RealField + Copy> {
    pub(super) r_bi: Rotation<Body, Eci, T>,
    /// Body, rad/s.
    pub(super) bias_b: Vector3<T>,
    pub(super) covariance: Matrix6<T>,
}

impl<T: RealField + Copy> Tracked<T> {
    /// From an attitude and a bias that have nothing to do with each other; `attitude` is the
    /// covariance of the first, rad², `bias_variance` that of each axis of the second.
    pub(super) fn new(
        r_bi: Rotation<Body, Eci, T>,
        attitude: &Matrix3<T>,
        bias_b: Vector3<T>,
        bias_variance: T,
    ) -> Self {
        let mut tracked = Self { r_bi, bias_b, covariance: Matrix6::zeros() };
        let bias = Matrix3::from_diagonal_element(bias_variance);
        tracked.covariance.fixed_view_mut::<3, 3>(3, 3).copy_from(&bias);
        tracked.realign(r_bi, attitude);
        tracked
    }

    /// Another attitude; of how its error goes with the bias nothing is known.
    pub(super) fn realign(&mut self, r_bi: Rotation<Body, Eci, T>, attitude: &Matrix3<T>) {
        self.r_bi = r_bi;
        self.covariance.fixed_view_mut::<3, 3>(0, 0).copy_from(attitude);
        self.covariance.fixed_view_mut::<3, 3>(0, 3).fill(T::zero());
        self.covariance.fixed_view_mut::<3, 3>(3, 0).fill(T::zero());
    }

    /// `dt_s` later, with the measured rate `rate_b` (bias not removed).
    pub(super) fn propagate(&mut self, rate_b: Vector3<T>, dt_s: T, noise: &ProcessNoise<T>) {
        let step = Step::new(rate_b - self.bias_b, dt_s);
        self.turn(step.rotation.into_inner());
        self.covariance = step.covariance(&self.covariance, noise);
    }

    /// Takes what a measurement says of (θ, Δβ) into the estimate, after which their mean is zero
    /// again.
    pub(super) fn correct(&mut self, correction: &Correction<T, 6>) {
        let e = correction.states.fixed_rows::<3>(0) * convert::<f64, T>(-0.5);
        self.turn(Quaternion::new(T::one(), e.x, e.y, e.z));
        self.bias_b += correction.states.fixed_rows::<3>(3);
        self.covariance = correction.covariance;
    }

    /// q_bi⁺ = q ⊗ q_bi, brought to unit length.
    fn turn(&mut self, q: Quaternion<T>) {
        let turned = q * self.r_bi.hamilton().into_inner();
        self.r_bi = Rotation::from_hamilton(Unit::new_normalize(turned));
    }

    /// Variance of the attitude about the Body axis about which least is known, rad².
    pub(super) fn largest_attitude_variance(&self) -> T {
        self.covariance.fixed_view::<3, 3>(0, 0).diagonal().max()
    }

    /// σ of θ and of Δβ.
    pub(super) fn sigma(&self) -> (Vector3<T>, Vector3<T>) {
        let sigma: Vector6<T> = self.covariance.diagonal().map(ComplexField::sqrt);
        (sigma.fixed_rows::<3>(0).into_owned(), sigma.fixed_rows::<3>(3).into_owned())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::UnitQuaternion;

    #[test]
    fn a_correction_by_a_gibbs_vector_turns_by_its_angle() {
        // θ is 2 tan(α/2) long: 1.2 rad about an axis.
        let axis = Vector3::new(0.6_f64, -0.48, 0.64);
        let before = Rotation::from_attitude_quaternion([0.1, -0.7, 0.3, 0.4]).unwrap();
        let mut tracked = Tracked::new(before, &Matrix3::identity(), Vector3::zeros(), 1.0);
        let mut states = Vector6::zeros();
        states.fixed_rows_mut::<3>(0).copy_from(&(axis * (2.0 * libm::tan(0.6))));
        states.fixed_rows_mut::<3>(3).copy_from(&Vector3::new(0.1, 0.2, 0.3));
        tracked.correct(&Correction { states, covariance: Matrix6::identity(), nis: 0.0 });
        let turned = UnitQuaternion::from_scaled_axis(-axis * 1.2) * before.hamilton();
        assert!((tracked.r_bi.hamilton().coords - turned.coords).norm() < 1e-15);
        assert_eq!(tracked.bias_b, Vector3::new(0.1, 0.2, 0.3));
    }

    #[test]
    fn realigning_keeps_what_is_known_of_the_bias() {
        let r_bi = Rotation::identity();
        let mut tracked = Tracked::new(r_bi, &Matrix3::identity(), Vector3::x(), 4.0_f32);
        tracked.propagate(Vector3::y(), 0.5, &ProcessNoise::new(0.1, 0.1, 0.5));
        assert!(tracked.covariance[(0, 3)] != 0.0);
        let bias_before = tracked.covariance[(4, 4)];
        tracked.realign(r_bi, &(Matrix3::identity() * 0.25));
        assert_eq!(tracked.sigma().0, Vector3::new(0.5, 0.5, 0.5));
        assert_eq!(tracked.covariance[(4, 4)], bias_before);
        assert_eq!(tracked.covariance.fixed_view::<3, 3>(0, 3).norm(), 0.0);
    }
}
