//! Inertial hold: an attitude that stands still among the stars.

use super::{AimError, Goal};
use crate::frames::{Eci, Rotation, Target, Vector};

/// Accepts the attitude quaternion to be held, `[q_x, q_y, q_z, q_w]`, Eci to Body.
///
/// # Errors
/// [`AimError::Attitude`] when it is zero or not finite.
pub fn accept(attitude_xyzw: [f32; 4]) -> Result<Rotation<Target, Eci>, AimError> {
    Rotation::from_attitude_quaternion(attitude_xyzw).ok_or(AimError::Attitude)
}

/// That attitude, and no rate.
pub fn goal(r_ti: Rotation<Target, Eci>) -> Goal {
    Goal { r_ti, omega_ti: Vector::zero() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_attitude_is_kept_and_does_not_turn() {
        let attitude_xyzw = [0.5, -0.5, 0.5, 0.5];
        let goal = goal(accept(attitude_xyzw).unwrap());
        assert_eq!(goal.omega_ti, Vector::zero());
        assert_eq!(goal.r_ti.attitude_quaternion(), attitude_xyzw);
    }

    #[test]
    fn an_attitude_that_is_none_is_refused() {
        for attitude_xyzw in [[0.0; 4], [f32::NAN, 0.0, 0.0, 1.0], [f32::INFINITY; 4]] {
            assert!(matches!(accept(attitude_xyzw), Err(AimError::Attitude)));
        }
    }
}
