//! Where the satellite should point, and how fast that turns.
//!
//! | aim | R_ti | ω_ti |
//! |---|---|---|
//! | nadir | Orbit axes: Z to the Earth's centre, X forwards | the orbit's own, about −Y |
//! | inertial | a fixed attitude quaternion | 0 |
//!
//! On target Body coincides with [`Target`].

use core::fmt;

use nalgebra::RealField;
use serde::{Deserialize, Serialize};

use crate::frames::{Eci, Rotation, Target, Vector};
use crate::orbit::OrbitState;
use crate::orbit::frame::OrbitFrame;

/// Where to point, as stored and uplinked.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum AimParameters {
    /// Body along the Orbit axes, the paper's reference frame.
    Nadir,
    /// A fixed attitude.
    Inertial {
        /// Attitude quaternion `[q_x, q_y, q_z, q_w]`, Eci to Body.
        attitude_xyzw: [f32; 4],
    },
}

/// The attitude quaternion of an inertial aim is zero or not finite.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct AimError;

impl fmt::Display for AimError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the attitude to be held must not be a zero quaternion")
    }
}

impl core::error::Error for AimError {}

/// The attitude and rate that Body should have at an instant.
#[derive(Debug, Clone, Copy)]
pub struct Goal<T: RealField + Copy = f32> {
    /// From Eci to the target's axes.
    pub r_ti: Rotation<Target, Eci, T>,
    /// Rate of the target relative to Eci, along its own axes, rad/s.
    pub omega_ti: Vector<Target, T>,
}

/// An accepted aim.
#[derive(Debug, Clone, Copy)]
pub enum Aim {
    /// Body along the Orbit axes.
    Nadir,
    /// A fixed attitude.
    Inertial(Rotation<Target, Eci>),
}

impl Aim {
    /// Accepts an aim.
    ///
    /// # Errors
    /// [`AimError`] when an attitude to be held is none.
    pub fn new(parameters: &AimParameters) -> Result<Self, AimError> {
        match *parameters {
            AimParameters::Nadir => Ok(Self::Nadir),
            AimParameters::Inertial { attitude_xyzw } => {
                Rotation::from_attitude_quaternion(attitude_xyzw)
                    .map(Self::Inertial)
                    .ok_or(AimError)
            }
        }
    }

    /// The goal now; `None` when the aim needs an orbit and there is none.
    pub fn goal(&self, orbit: Option<&OrbitState>) -> Option<Goal> {
        match self {
            Self::Inertial(r_ti) => Some(Goal { r_ti: *r_ti, omega_ti: Vector::zero() }),
            Self::Nadir => OrbitFrame::of(orbit?).map(|frame| Goal {
                r_ti: Rotation::from_hamilton(frame.r_oi.hamilton().cast()),
                omega_ti: frame.omega_oi.to_f32().relabel(),
            }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn over_the_equator() -> OrbitState {
        OrbitState { position: Vector::new(7e6, 0.0, 0.0), velocity: Vector::new(0.0, 0.0, 7.5e3) }
    }

    #[test]
    fn at_nadir_z_is_down_x_forwards_and_the_frame_turns_once_an_orbit() {
        let goal = Aim::Nadir.goal(Some(&over_the_equator())).unwrap();
        // Rounding of f32.
        let near = |v: Vector<Target>, to: [f32; 3]| {
            v.to_array().iter().zip(to).all(|(a, b)| (a - b).abs() < 1e-6)
        };
        assert!(near(goal.r_ti * Vector::new(-1.0, 0.0, 0.0), [0.0, 0.0, 1.0]));
        assert!(near(goal.r_ti * Vector::new(0.0, 0.0, 1.0), [1.0, 0.0, 0.0]));
        assert!(near(goal.omega_ti, [0.0, -7.5e3 / 7e6, 0.0]));
    }

    #[test]
    fn an_inertial_aim_needs_no_orbit_and_does_not_turn() {
        let attitude_xyzw = [0.5, -0.5, 0.5, 0.5];
        let goal =
            Aim::new(&AimParameters::Inertial { attitude_xyzw }).unwrap().goal(None).unwrap();
        assert_eq!(goal.omega_ti, Vector::zero());
        assert_eq!(goal.r_ti.attitude_quaternion(), attitude_xyzw);
        assert!(Aim::Nadir.goal(None).is_none());
    }

    #[test]
    fn an_attitude_that_is_none_is_refused() {
        for attitude_xyzw in [[0.0; 4], [f32::NAN, 0.0, 0.0, 1.0]] {
            assert!(Aim::new(&AimParameters::Inertial { attitude_xyzw }).is_err());
        }
    }
}
