//! Slews: the satellite is led to its target at a limited rate, beginning from where it is.
//!
//! A reference is kept that starts at the attitude the satellite has, is carried along with the target
//! from call to call, and closes in on the target by at most Ω Δt about the shortest way:
//!
//! ```text
//! φ = rotation vector of R_rt = R_ri R_ti⁻¹,   φ ← φ (1 − Ω Δt / |φ|),   R_ri = R(φ) R_ti
//! ω_ri = R(φ) ω_ti + Ω φ/|φ|
//! ```
//!
//! | symbol | code | meaning |
//! |---|---|---|
//! | R_ri, R_ti | `reference`, `goal` | attitude of the reference and of the target |
//! | Ω | `rate_rad_s` | limit, against the target, rad/s |
//!
//! φ turns components from the target's axes to the reference's, so the reference itself has to turn by
//! +φ to get there. A target that jumps, as from a place on the ground to nadir, is followed in the same
//! way: nothing but the reference is remembered, so there is no switching to be told of.

use nalgebra::UnitQuaternion;

use super::{AimError, Goal};
use crate::frames::{Body, Eci, Rotation, Target, Vector};
use crate::time::Utc;

/// After so long without a call the reference says nothing any more, s: the satellite has flown without
/// it for some rounds of the schedule.
const LONGEST_GAP_S: f32 = 60.0;

/// An accepted limit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Slew {
    rate_rad_s: f32,
}

/// Where the reference stands. `Default` is nowhere: the next call begins at the satellite's attitude.
#[derive(Debug, Clone, Copy, Default)]
pub struct SlewState {
    /// When the reference was asked for, it, and the rate at which the target carries it along.
    last: Option<(Utc, Goal)>,
}

impl SlewState {
    /// The reference carried on to `now`, and the time since, s.
    fn carried_to(&self, now: Utc) -> Option<(Rotation<Target, Eci>, f32)> {
        let (at, goal) = self.last?;
        let dt_s = now.seconds_since(at) as f32;
        let turn = UnitQuaternion::from_scaled_axis(goal.omega_ti.xyz * -dt_s);
        // Refuses a time that runs backwards too.
        (0.0..=LONGEST_GAP_S)
            .contains(&dt_s)
            .then(|| (Rotation::from_hamilton(turn * goal.r_ti.hamilton()), dt_s))
    }
}

impl Slew {
    /// Accepts the largest rate against the target, rad/s.
    ///
    /// # Errors
    /// [`AimError::Slew`] when it is not positive and finite.
    pub fn new(rate_rad_s: f32) -> Result<Self, AimError> {
        if rate_rad_s.is_finite() && rate_rad_s > 0.0 {
            Ok(Self { rate_rad_s })
        } else {
            Err(AimError::Slew { found: rate_rad_s })
        }
    }

    /// What to ask for now on the way from `r_bi` to `goal`.
    pub fn towards(
        &self,
        state: &mut SlewState,
        now: Utc,
        r_bi: Rotation<Body, Eci>,
        goal: &Goal,
    ) -> Goal {
        let here = Rotation::from_hamilton(r_bi.hamilton());
        let (reference, dt_s) = state.carried_to(now).unwrap_or((here, 0.0));
        let offset: Rotation<Target, Target> = reference * goal.r_ti.inverse();
        let offset = offset.hamilton().scaled_axis();
        let (angle, step) = (offset.norm(), self.rate_rad_s * dt_s);
        // Else on target, or lost in numbers that are none.
        let (along, asked) = if angle.is_finite() && angle > step {
            let left: Rotation<Target, Target> = Rotation::from_hamilton(
                UnitQuaternion::from_scaled_axis(offset * (1.0 - step / angle)),
            );
            let along = Goal { r_ti: left * goal.r_ti, omega_ti: left * goal.omega_ti };
            let approach = Vector::from_xyz(offset * (self.rate_rad_s / angle));
            (along, Goal { omega_ti: along.omega_ti + approach, ..along })
        } else {
            (*goal, *goal)
        };
        state.last = Some((now, along));
        asked
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::in_orbit;
    use super::super::{inertial, nadir};
    use super::*;

    const RATE_RAD_S: f32 = 2e-3;
    const ROUND_S: f64 = 7.5;

    fn at(seconds: f64) -> Utc {
        Utc::from_micros_since_2000((seconds * 1e6) as i64)
    }

    fn angle(a: &Goal, b: &Goal) -> f32 {
        (a.r_ti * b.r_ti.inverse()).angle_rad()
    }

    #[test]
    fn it_begins_where_the_satellite_is_and_arrives_at_the_limited_rate() {
        let slew = Slew::new(RATE_RAD_S).unwrap();
        let mut state = SlewState::default();
        let r_bi = Rotation::from_attitude_quaternion([0.3, -0.8, 0.1, 0.4]).unwrap();
        let goal = |s: f64| nadir::goal(&in_orbit(s)).unwrap();
        let first = slew.towards(&mut state, at(0.0), r_bi, &goal(0.0));
        let here = Goal { r_ti: Rotation::from_hamilton(r_bi.hamilton()), ..first };
        // Rounding of f32 near small angles.
        assert!(angle(&first, &here) < 1e-3);
        let whole = angle(&first, &goal(0.0));
        let rounds = (f64::from(whole / RATE_RAD_S) / ROUND_S).ceil() as u32;
        let mut before = first;
        for k in 1..=rounds {
            let s = f64::from(k) * ROUND_S;
            let asked = slew.towards(&mut state, at(s), r_bi, &goal(s));
            let left = (whole - RATE_RAD_S * s as f32).max(0.0);
            // Rounding, as above.
            assert!((angle(&asked, &goal(s)) - left).abs() < 1e-3, "{k}");
            // The rate that is asked for is the one at which the reference moves; the last round is shorter.
            if k < rounds {
                let turn = (asked.r_ti * before.r_ti.inverse()).hamilton().scaled_axis();
                let moved = Vector::from_xyz(turn * (-1.0 / ROUND_S) as f32);
                // Over a round both target and reference turn by half a degree.
                assert!((moved - before.omega_ti).norm() < 2e-5, "{k}: {moved:?} {before:?}");
            }
            before = asked;
        }
        assert!(angle(&before, &goal(f64::from(rounds) * ROUND_S)) < 1e-3, "arrived");
        assert_eq!(before.omega_ti, goal(f64::from(rounds) * ROUND_S).omega_ti);
    }

    #[test]
    fn a_target_that_jumps_is_followed_from_where_the_reference_stands() {
        let slew = Slew::new(RATE_RAD_S).unwrap();
        let mut state = SlewState::default();
        let held = |xyzw| inertial::goal(inertial::accept(xyzw).unwrap());
        let (one, two) = (held([0.0, 0.0, 0.0, 1.0]), held([0.0, 0.6, 0.0, 0.8]));
        let r_bi = Rotation::identity();
        slew.towards(&mut state, at(0.0), r_bi, &one);
        let asked = slew.towards(&mut state, at(ROUND_S), r_bi, &two);
        let moved = angle(&asked, &one);
        assert!((moved - RATE_RAD_S * ROUND_S as f32).abs() < 1e-4, "{moved}");
        // After a long silence it begins again at the satellite.
        let turned = Rotation::from_attitude_quaternion([0.0, 0.0, 0.6, 0.8]).unwrap();
        let asked = slew.towards(&mut state, at(1_000.0), turned, &two);
        let here = Goal { r_ti: Rotation::from_hamilton(turned.hamilton()), ..asked };
        assert!(angle(&asked, &here) < 1e-3);
    }

    #[test]
    fn numbers_that_are_none_end_at_the_goal() {
        let slew = Slew::new(RATE_RAD_S).unwrap();
        let mut state = SlewState::default();
        let goal = Goal { omega_ti: Vector::new(f32::NAN, 0.0, 0.0), ..in_goal() };
        slew.towards(&mut state, at(0.0), Rotation::identity(), &goal);
        let good = in_goal();
        let asked = slew.towards(&mut state, at(1.0), Rotation::identity(), &good);
        assert_eq!(asked.omega_ti, good.omega_ti);
        assert!(angle(&asked, &good) < 1e-6);
    }

    fn in_goal() -> Goal {
        nadir::goal(&in_orbit(0.0)).unwrap()
    }

    #[test]
    fn a_limit_that_is_none_is_refused() {
        for bad in [0.0, -1e-3, f32::NAN, f32::INFINITY] {
            assert!(matches!(Slew::new(bad), Err(AimError::Slew { .. })));
        }
    }
}
