//! Where the satellite should point, and how fast that turns.
//!
//! | aim | Body, on target | ω_ti | needs |
//! |---|---|---|---|
//! | [`nadir`] | along the Orbit axes: Z to the Earth's centre, X forwards | the orbit's own, about −Y | orbit |
//! | [`sun`] | one axis to the Sun, a second one northwards; or spinning about the first | the spin | clock |
//! | [`inertial`] | a fixed attitude | 0 | |
//! | [`site`] | one axis to a place on the ground, a second one against the orbit normal; to nadir while the place is below its horizon | that of the line of sight, Earth's rotation included | orbit, clock |
//!
//! On target Body coincides with [`Target`]. Whatever the aim, [`slew`] can limit the rate at which the
//! satellite is led to it from where it is.

pub mod inertial;
pub mod nadir;
pub mod site;
pub mod slew;
pub mod sun;
mod two_axes;

use core::fmt;

use nalgebra::RealField;
use serde::{Deserialize, Serialize};

use crate::frames::{Direction, Eci, Rotation, Target, Vector};
use crate::orbit::OrbitState;
use crate::time::Utc;

pub use site::{Site, SiteParameters};
pub use slew::{Slew, SlewState};
pub use sun::{SunAim, SunAimParameters};
pub use two_axes::BodyAxesParameters;

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
    /// An axis to the Sun.
    Sun(SunAimParameters),
    /// An axis to a place on the ground.
    Site(SiteParameters),
}

/// Where to point and how fast to turn there, as stored and uplinked.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct GuidanceParameters {
    /// Where to point.
    pub aim: AimParameters,
    /// Largest rate against the target at which the satellite is led there, rad/s; `None` to ask for
    /// the target at once.
    pub slew_rad_s: Option<f32>,
}

/// Why an aim is refused.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum AimError {
    /// The attitude quaternion of an inertial aim is zero or not finite.
    Attitude,
    /// The two axes of Body are zero, not finite, or too near to parallel to settle an attitude.
    Axes,
    /// A spin must be finite and slow enough for the cycle to follow.
    Spin {
        /// What was given, rad/s.
        found: f32,
    },
    /// A latitude must be within ±90 deg.
    Latitude {
        /// What was given, rad.
        found: f64,
    },
    /// A longitude must be within ±180 deg.
    Longitude {
        /// What was given, rad.
        found: f64,
    },
    /// A place on the ground is neither so deep nor so high.
    Height {
        /// What was given, m.
        found: f64,
    },
    /// The least elevation must be from 0 to below 90 deg.
    Elevation {
        /// What was given, rad.
        found: f32,
    },
    /// The slew's rate must be positive and finite.
    Slew {
        /// What was given, rad/s.
        found: f32,
    },
}

impl fmt::Display for AimError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Attitude => write!(f, "the attitude to be held must not be a zero quaternion"),
            Self::Axes => write!(
                f,
                "the two axes of the body must be directions at least {} deg apart",
                two_axes::LEAST_APART_DEG
            ),
            Self::Spin { found } => write!(
                f,
                "the spin {found} rad/s must be within {} rad/s either way",
                sun::FASTEST_SPIN_RAD_S
            ),
            Self::Latitude { found } => {
                write!(f, "the latitude {found} rad must be within a right angle either way")
            }
            Self::Longitude { found } => {
                write!(f, "the longitude {found} rad must be within half a turn either way")
            }
            Self::Height { found } => write!(
                f,
                "the height {found} m must be from {} to {} m",
                site::LOWEST_M,
                site::HIGHEST_M
            ),
            Self::Elevation { found } => {
                write!(f, "the least elevation {found} rad must be from 0 to below a right angle")
            }
            Self::Slew { found } => {
                write!(f, "the slew's rate {found} rad/s must be positive and finite")
            }
        }
    }
}

impl core::error::Error for AimError {}

/// What an aim may need to know.
#[derive(Debug, Clone, Copy)]
pub struct Scene<'a> {
    /// The instant.
    pub now: Utc,
    /// Where the satellite is.
    pub orbit: Option<&'a OrbitState>,
    /// Where the Sun is, from it.
    pub sun: Option<Direction<Eci>>,
}

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
    /// An axis to the Sun.
    Sun(SunAim),
    /// An axis to a place on the ground.
    Site(Site),
}

impl Aim {
    /// Accepts an aim.
    ///
    /// # Errors
    /// [`AimError`] with what is wrong with it.
    pub fn new(parameters: &AimParameters) -> Result<Self, AimError> {
        match parameters {
            AimParameters::Nadir => Ok(Self::Nadir),
            AimParameters::Inertial { attitude_xyzw } => {
                inertial::accept(*attitude_xyzw).map(Self::Inertial)
            }
            AimParameters::Sun(parameters) => SunAim::new(parameters).map(Self::Sun),
            AimParameters::Site(parameters) => Site::new(parameters).map(Self::Site),
        }
    }

    /// The goal now; `None` when the aim needs an orbit or the Sun and there is none, or none that
    /// gives numbers.
    pub fn goal(&self, scene: &Scene<'_>) -> Option<Goal> {
        let goal = match self {
            Self::Nadir => nadir::goal(scene.orbit?),
            Self::Inertial(r_ti) => Some(inertial::goal(*r_ti)),
            Self::Sun(aim) => aim.goal(scene.now, scene.sun?),
            Self::Site(site) => site.goal(scene.now, scene.orbit?),
        };
        goal.filter(|goal| {
            goal.r_ti.hamilton().coords.sum().is_finite() && goal.omega_ti.is_finite()
        })
    }
}

/// An accepted aim and how it is approached.
#[derive(Debug, Clone, Copy)]
pub struct Guidance {
    /// Where to point.
    pub aim: Aim,
    /// The limit of the way there.
    pub slew: Option<Slew>,
}

impl Guidance {
    /// Accepts both.
    ///
    /// # Errors
    /// [`AimError`] with what is wrong.
    pub fn new(parameters: &GuidanceParameters) -> Result<Self, AimError> {
        Ok(Self {
            aim: Aim::new(&parameters.aim)?,
            slew: parameters.slew_rad_s.map(Slew::new).transpose()?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// In an orbit of 615 km, inclined by the angle whose sine is 0.8.
    pub(super) fn in_orbit(seconds: f64) -> OrbitState {
        let (s, c) = libm::sincos(1.0788e-3 * seconds + 0.4);
        let (r, v) = (6.993e6, 7.5446e3);
        OrbitState {
            position: Vector::new(r * c, r * 0.6 * s, r * 0.8 * s),
            velocity: Vector::new(-v * s, v * 0.6 * c, v * 0.8 * c),
        }
    }

    /// The rate of a goal from its attitudes at two instants `2 step_s` apart, Target, rad/s.
    pub(super) fn rate_by_difference(
        at: impl Fn(f64) -> Goal,
        seconds: f64,
        step_s: f64,
    ) -> Vector<Target> {
        let (before, after) = (at(seconds - step_s), at(seconds + step_s));
        let turn = after.r_ti * before.r_ti.inverse();
        // Hamilton numbers turn components, so the frame turned the other way.
        Vector::from_xyz(turn.hamilton().scaled_axis() * (-0.5 / step_s) as f32)
    }

    fn number() -> impl Strategy<Value = f64> {
        prop_oneof![
            4 => -1e7..1e7_f64,
            2 => -2.0..2.0_f64,
            1 => any::<f64>(),
            1 => Just(f64::NAN),
            1 => Just(0.0),
        ]
    }

    proptest! {
        #[test]
        fn a_goal_is_an_attitude_and_a_finite_rate_or_none_at_all(
            r in [number(), number(), number()],
            v in [number(), number(), number()],
            sun in [number(), number(), number()],
            axes in [number(), number(), number(), number(), number(), number()],
            place in [number(), number(), number()],
            spin in number(),
            at in any::<i64>(),
        ) {
            let vector = |[x, y, z]: [f64; 3]| Vector::new(x, y, z);
            let orbit = OrbitState { position: vector(r), velocity: vector(v) };
            let sun = vector(sun).to_f32().direction();
            // Within the years that the clock knows: some centuries either way.
            let now = Utc::from_micros_since_2000(at / 1000);
            let [a, b, c, d, e, f] = axes.map(|x| x as f32);
            let axes = BodyAxesParameters { boresight: [a, b, c], second: [d, e, f] };
            let [latitude_rad, longitude_rad, height_m] = place;
            let site = SiteParameters {
                axes, latitude_rad, longitude_rad, height_m, least_elevation_rad: 0.1
            };
            let anywhere = SiteParameters { axes: BodyAxesParameters::default(), latitude_rad: 0.5,
                longitude_rad: 2.0, height_m: 0.0, ..site };
            let spinning = SunAimParameters { axes, spin_rad_s: spin as f32 };
            let still = SunAimParameters { axes: BodyAxesParameters::default(), spin_rad_s: 0.01 };
            for aim in [
                AimParameters::Nadir,
                AimParameters::Sun(spinning),
                AimParameters::Sun(still),
                AimParameters::Site(site),
                AimParameters::Site(anywhere),
            ] {
                let Ok(aim) = Aim::new(&aim) else { continue };
                let Some(goal) = aim.goal(&Scene { now, orbit: Some(&orbit), sun }) else { continue };
                // Rounding of the square of f32.
                prop_assert!((goal.r_ti.hamilton().norm() - 1.0).abs() < 1e-5, "{aim:?} {goal:?}");
                prop_assert!(goal.omega_ti.is_finite(), "{aim:?} {goal:?}");
            }
        }
    }

    #[test]
    fn what_an_aim_needs_and_lacks_gives_no_goal() {
        let now = Utc::from_micros_since_2000(0);
        let nothing = Scene { now, orbit: None, sun: None };
        let sun = SunAimParameters { axes: BodyAxesParameters::default(), spin_rad_s: 0.0 };
        let site = SiteParameters {
            axes: BodyAxesParameters::default(),
            latitude_rad: 0.6,
            longitude_rad: 2.4,
            height_m: 0.0,
            least_elevation_rad: 0.0,
        };
        for aim in [AimParameters::Nadir, AimParameters::Sun(sun), AimParameters::Site(site)] {
            assert!(Aim::new(&aim).unwrap().goal(&nothing).is_none());
        }
        let held = AimParameters::Inertial { attitude_xyzw: [0.0, 0.0, 0.0, 1.0] };
        assert!(Aim::new(&held).unwrap().goal(&nothing).is_some());
    }
}
