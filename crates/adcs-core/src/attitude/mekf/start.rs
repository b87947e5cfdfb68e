//! Attitude from field and Sun of one instant: how the filter starts by itself, and starts again.
//!
//! The filter's equations are linear about an estimate. Where there is none, or none to speak of, the
//! attitude is solved for by a method that needs no estimate ([`Method`](crate::attitude::Method)), and
//! its covariance becomes the filter's. Whether the two measurements can be believed is asked of what is
//! the same in every attitude:
//!
//! | symbol | meaning | its variance |
//! |---|---|---|
//! | Δα | angle from field to Sun, measured minus modelled, rad | σ_sun² + (σ_field / B)² |
//! | ΔB | strength of the field, measured minus modelled, T | σ_field² |

use nalgebra::{Matrix3, RealField, convert};

use super::{FieldPair, Mekf, SunPair};
use crate::attitude::Observation;
use crate::frames::{Body, Eci, Rotation};

/// An attitude found without the filter.
#[derive(Debug, Clone, Copy)]
pub(super) struct Alignment<T: RealField + Copy> {
    pub(super) r_bi: Rotation<Body, Eci, T>,
    /// Of the attitude error, Body, rad².
    pub(super) covariance: Matrix3<T>,
}

/// Largest sum of Δα² and ΔB², each in units of its variance: good sensors exceed it once in 1e5 (χ²
/// quantile, 2 degrees of freedom).
const AGREEMENT_GATE: f64 = 23.03;

impl<T: RealField + Copy> Mekf<T> {
    /// Whether field and Sun fit each other. This judges the sensors and not the estimate, of which
    /// it knows nothing.
    pub(super) fn agree(&self, field: &FieldPair<T>, sun: &SunPair<T>) -> bool {
        let (b_norm, i_norm) = (field.body.norm(), field.eci.norm());
        let (sun_b, sun_i) = (sun.body.vector(), sun.eci.vector());
        // Sine and cosine of the angle in Body, in Eci, and of their difference.
        let b = (sun_b.cross(&field.body).norm() / b_norm, sun_b.dot(&field.body) / b_norm);
        let i = (sun_i.cross(&field.eci).norm() / i_norm, sun_i.dot(&field.eci) / i_norm);
        let (sine, cosine) = (b.0 * i.1 - b.1 * i.0, b.1 * i.1 + b.0 * i.0);

        let strength = (b_norm - i_norm) / self.field_noise_t;
        let squares = sine * sine / self.angle_variance(sun, i_norm) + strength * strength;
        cosine > T::zero() && squares <= convert(AGREEMENT_GATE)
    }

    /// Attitude from one field and one Sun. `None` when they are too close to parallel to know the
    /// attitude within the limit of linearity.
    pub(super) fn align(&self, field: &FieldPair<T>, sun: &SunPair<T>) -> Option<Alignment<T>> {
        let sun_noise = sun.sigma_rad(self.parameters.sun_noise_rad);
        let field_noise = self.field_noise_t / field.eci.norm();
        let observations = [
            Observation::new(sun.body.vector(), sun.eci.vector(), sun_noise).ok()?,
            Observation::new(field.body, field.eci, field_noise).ok()?,
        ];
        let solution = self.parameters.start.solve(&observations).ok()?;
        let limit = self.parameters.limits.linear_rad;
        let known = solution.covariance_rad2.diagonal().max() <= limit * limit;
        let (r_bi, covariance) = (solution.attitude, solution.covariance_rad2);
        known.then_some(Alignment { r_bi, covariance })
    }

    /// Variance of the angle between Sun and a field of `strength_t`, rad².
    fn angle_variance(&self, sun: &SunPair<T>, strength_t: T) -> T {
        let sun = sun.sigma_rad(self.parameters.sun_noise_rad);
        let field = self.field_noise_t / strength_t;
        sun * sun + field * field
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::attitude::mekf::MekfParameters;
    use crate::frames::Vector;

    fn mekf() -> Mekf<f32> {
        Mekf::new(&MekfParameters::default()).unwrap()
    }

    /// Field and Sun 60 deg apart, as two frames see them that are turned by 90 deg about z.
    fn pairs() -> (FieldPair, SunPair) {
        let (c, s) = (0.5, 0.866_025_4);
        let field =
            FieldPair { body: Vector::new(0.0, -3e-5, 0.0), eci: Vector::new(3e-5, 0.0, 0.0) };
        let sun = SunPair {
            body: Vector::new(s, -c, 0.0).direction().unwrap(),
            eci: Vector::new(c, s, 0.0).direction().unwrap(),
            sigma_rad: None,
        };
        (field, sun)
    }

    #[test]
    fn field_and_sun_of_any_attitude_agree() {
        let (field, sun) = pairs();
        assert!(mekf().agree(&field, &sun));
        let Alignment { r_bi, covariance } = mekf().align(&field, &sun).unwrap();
        let [.., q_z, q_w] = r_bi.attitude_quaternion();
        let half = core::f32::consts::FRAC_1_SQRT_2;
        assert!((q_z - half).abs() < 1e-6 && (q_w - half).abs() < 1e-6);
        // About the Sun, where the field alone knows: 1.1 deg over sin 60 deg.
        let about_sun = (covariance * sun.body.vector().xyz).norm().sqrt().to_degrees();
        assert!((about_sun - 1.31).abs() < 0.15, "{about_sun}");
    }

    #[test]
    fn what_no_attitude_can_explain_does_not_agree() {
        let (field, sun) = pairs();
        // 8 deg of angle are 6 σ; 5 µT of strength are 8 σ; the Sun on the other side.
        let turned = FieldPair { body: Vector::new(4.2e-6, -2.97e-5, 0.0), ..field };
        assert!(!mekf().agree(&turned, &sun));
        let stronger = FieldPair { body: Vector::new(0.0, -3.5e-5, 0.0), ..field };
        assert!(!mekf().agree(&stronger, &sun));
        let opposite = SunPair { eci: (-sun.eci.vector()).direction().unwrap(), ..sun };
        assert!(!mekf().agree(&field, &opposite));
    }

    #[test]
    fn there_is_no_attitude_from_a_sun_along_the_field() {
        let (field, sun) = pairs();
        // 2 deg apart: the turn about both is known to 1.3 deg / sin 2 deg.
        let along = |x: f32, y: f32| Vector::new(x, y, 0.0).direction().unwrap();
        let (c, s) = (0.999_39, 0.034_9);
        let eci = along(c, s);
        let body = Vector::new(s, -c, 0.0).direction().unwrap();
        assert!(mekf().align(&field, &SunPair { body, eci, sigma_rad: None }).is_none());
        assert!(mekf().align(&field, &sun).is_some());
    }
}
