//! Sun pointing: one axis of Body to the Sun, a second one towards celestial north; or spinning.
//!
//! ```text
//! R_ti = R(boresight, Ω t) · R(boresight → Sun, second → north),   ω_ti = Ω · boresight
//! ```
//!
//! | symbol | code | meaning |
//! |---|---|---|
//! | Ω | `spin_rad_s` | rate about the boresight, right-handed, rad/s |
//! | t | | time since 2000-01-01, so that the turn is the same whoever computes it, and needs no memory |
//!
//! North (z of Eci) settles the turn about the Sun because it is always known and never nearer to the
//! Sun than 66.6 deg; the orbit normal would do neither in a dawn-dusk orbit, where it *is* the Sun. The
//! Sun's own motion, 2e-7 rad/s, is left out of the rate: 1e-5 deg/s is below what any sensor shows.

use nalgebra::UnitQuaternion;
use serde::{Deserialize, Serialize};

use super::two_axes::{BodyAxes, BodyAxesParameters};
use super::{AimError, Goal};
use crate::frames::{Direction, Eci, Rotation, Target, Vector};
use crate::time::Utc;

/// A satellite that spins faster turns by more than a right angle while a command of 10 s is held,
/// rad/s (9 deg/s).
pub(super) const FASTEST_SPIN_RAD_S: f32 = 0.157;

/// Sun pointing as stored and uplinked.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SunAimParameters {
    /// The axis to the Sun, and the one that is brought towards north.
    pub axes: BodyAxesParameters,
    /// Ω, rad/s; 0 to stand still.
    pub spin_rad_s: f32,
}

/// Accepted Sun pointing.
#[derive(Debug, Clone, Copy)]
pub struct SunAim {
    axes: BodyAxes,
    spin_rad_s: f32,
}

impl SunAim {
    /// Accepts it.
    ///
    /// # Errors
    /// [`AimError::Axes`], [`AimError::Spin`].
    pub fn new(parameters: &SunAimParameters) -> Result<Self, AimError> {
        let SunAimParameters { axes, spin_rad_s } = *parameters;
        let axes = BodyAxes::new(&axes)?;
        // False for a NaN.
        if spin_rad_s.abs() <= FASTEST_SPIN_RAD_S {
            Ok(Self { axes, spin_rad_s })
        } else {
            Err(AimError::Spin { found: spin_rad_s })
        }
    }

    /// The goal with the Sun there.
    pub fn goal(&self, now: Utc, sun: Direction<Eci>) -> Option<Goal> {
        let north = Vector::new(0.0, 0.0, 1.0).direction()?;
        let still = self.axes.towards(sun, north)?;
        let boresight = self.axes.boresight();
        let since_2000_s = now.seconds_since(Utc::from_micros_since_2000(0));
        // In f64: of 1e9 s a turn keeps 1e-7 rad.
        let turns = f64::from(self.spin_rad_s) * since_2000_s * (1.0 / core::f64::consts::TAU);
        let turned = (turns - libm::floor(turns)) as f32 * core::f32::consts::TAU;
        let spin: Rotation<Target, Target> =
            Rotation::from_hamilton(UnitQuaternion::from_scaled_axis(boresight * -turned));
        Some(Goal {
            r_ti: spin * still.r_ti,
            omega_ti: Vector::from_xyz(boresight * self.spin_rad_s),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::rate_by_difference;
    use super::*;

    fn sun() -> Direction<Eci> {
        Vector::new(-0.6, -0.73, -0.32).direction().unwrap()
    }

    fn aim(spin_rad_s: f32) -> Result<SunAim, AimError> {
        let axes = BodyAxesParameters { boresight: [0.0, 1.0, 0.0], second: [1.0, 0.0, 0.0] };
        SunAim::new(&SunAimParameters { axes, spin_rad_s })
    }

    #[test]
    fn the_axis_looks_at_the_sun_and_the_second_one_northwards() {
        let now = Utc::parse("2015-11-19T03:31:21Z").unwrap();
        let goal = aim(0.0).unwrap().goal(now, sun()).unwrap();
        // Rounding of f32.
        assert!((goal.r_ti * sun().vector() - Vector::new(0.0, 1.0, 0.0)).norm() < 1e-6);
        let north = goal.r_ti * Vector::new(0.0, 0.0, 1.0);
        assert!(north.xyz.x > 0.9 && north.xyz.z.abs() < 1e-6, "{north:?}");
        assert_eq!(goal.omega_ti, Vector::zero());
    }

    #[test]
    fn while_it_spins_the_sun_stays_and_the_rate_is_that_of_the_attitude() {
        const SPIN_RAD_S: f32 = 0.01;
        let aim = aim(SPIN_RAD_S).unwrap();
        let start = Utc::parse("2026-11-21T12:00:00Z").unwrap();
        let at = |s: f64| aim.goal(start.plus_micros((s * 1e6) as i64), sun()).unwrap();
        for seconds in [0.0, 100.0, 777.0] {
            let goal = at(seconds);
            assert!((goal.r_ti * sun().vector() - Vector::new(0.0, 1.0, 0.0)).norm() < 1e-6);
            assert_eq!(goal.omega_ti, Vector::new(0.0, SPIN_RAD_S, 0.0));
            // Rounding of an attitude in f32, over the two steps.
            let off = rate_by_difference(at, seconds, 10.0) - goal.omega_ti;
            assert!(off.norm() < 1e-7, "{off:?}");
        }
    }

    #[test]
    fn a_spin_that_no_command_can_follow_is_refused() {
        for bad in [0.2, -0.2, f32::NAN, f32::INFINITY] {
            assert!(matches!(aim(bad), Err(AimError::Spin { .. })), "{bad}");
        }
    }
}
