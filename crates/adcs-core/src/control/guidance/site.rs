//! Ground target tracking: one axis of Body to a place on the Earth, a second one against the orbit
//! normal; to nadir while the place is below its horizon.
//!
//! ```text
//! ρ = r_site − r,  ρ̇ = ω_⊕ × r_site − v,  below the horizon ρ = −r, ρ̇ = −v
//! t₁ = ρ/|ρ|,  ṫ₁ = (ρ̇ − t₁ (t₁·ρ̇)) / |ρ|,  t₂ ∥ t₁ × y,  t₃ = t₁ × t₂
//! ω_ti = t₁ × ṫ₁ + t₁ (ṫ₁ × y)·t₃ / |t₁ × y|
//! ```
//!
//! | symbol | code | meaning |
//! |---|---|---|
//! | r, v | `orbit` | position and velocity of the satellite, Eci, m, m/s |
//! | ρ | `sight` | line of sight, m |
//! | y | `against_normal` | Y of the Orbit axes |
//! | ω_⊕ | `ROTATION_RATE_RAD_S` | rate of the Earth, rad/s |
//!
//! The first term of ω_ti carries t₁; the second, along t₁, keeps y in the plane of t₁ and t₃: it follows
//! from ṫ₂·t₃ = ω_ti·t₁. The turning of the orbit plane, at most 2e-6 rad/s, is left out, as at nadir.
//!
//! Above the horizon of a place the line of sight is at most 65 deg off nadir (615 km), so it is never
//! near the orbit normal. With the default axes (z, y) a place right below gives the Orbit frame: looking
//! away from the place and back again is a turn about two axes of less than that, and a
//! [slew](super::slew) makes it gentle.

use serde::{Deserialize, Serialize};

use super::two_axes::{BodyAxes, BodyAxesParameters};
use super::{AimError, Goal};
use crate::environment::earth::ROTATION_RATE_RAD_S;
use crate::environment::geodetic::Geodetic;
use crate::frames::{Ecef, Eci, Vector};
use crate::orbit::OrbitState;
use crate::time::{Utc, gmst82_rad};

/// Places on the ground are higher than this, m: the deepest shore is at −430 m, ellipsoid and geoid are
/// 110 m apart at most.
pub(super) const LOWEST_M: f64 = -1_000.0;
/// And lower than this, m: the highest mountain, rounded up.
pub(super) const HIGHEST_M: f64 = 10_000.0;

/// A place on the ground as stored and uplinked.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SiteParameters {
    /// The axis to the place, and the one that is brought against the orbit normal.
    pub axes: BodyAxesParameters,
    /// Geodetic latitude, positive north, rad.
    pub latitude_rad: f64,
    /// Longitude, positive east, rad.
    pub longitude_rad: f64,
    /// Height above the WGS84 ellipsoid, m.
    pub height_m: f64,
    /// Elevation of the satellite over the place's horizon from which on it is tracked, rad.
    pub least_elevation_rad: f32,
}

/// An accepted place on the ground.
#[derive(Debug, Clone, Copy)]
pub struct Site {
    axes: BodyAxes,
    position: Vector<Ecef, f64>,
    /// The ellipsoid's normal there, unit.
    up: Vector<Ecef>,
    sine_of_least_elevation: f32,
}

impl Site {
    /// Accepts it.
    ///
    /// # Errors
    /// [`AimError`] with what is on no map.
    pub fn new(parameters: &SiteParameters) -> Result<Self, AimError> {
        use core::f64::consts::{FRAC_PI_2, PI};
        let SiteParameters { axes, latitude_rad, longitude_rad, height_m, least_elevation_rad } =
            *parameters;
        let axes = BodyAxes::new(&axes)?;
        // All comparisons are false for a NaN.
        let is_elevation = (0.0..core::f32::consts::FRAC_PI_2).contains(&least_elevation_rad);
        match () {
            () if !(-FRAC_PI_2..=FRAC_PI_2).contains(&latitude_rad) => {
                Err(AimError::Latitude { found: latitude_rad })
            }
            () if !(-PI..=PI).contains(&longitude_rad) => {
                Err(AimError::Longitude { found: longitude_rad })
            }
            () if !(LOWEST_M..=HIGHEST_M).contains(&height_m) => {
                Err(AimError::Height { found: height_m })
            }
            () if !is_elevation => Err(AimError::Elevation { found: least_elevation_rad }),
            () => {
                let place = |height_m| Geodetic {
                    latitude_rad,
                    longitude_east_rad: longitude_rad,
                    height_m,
                };
                let position = place(height_m).position();
                let above = place(height_m + 1.0).position();
                Ok(Self {
                    axes,
                    position,
                    up: (above - position).to_f32(),
                    sine_of_least_elevation: libm::sinf(least_elevation_rad),
                })
            }
        }
    }

    /// The goal from there. `None` when position and velocity span no orbit plane.
    pub fn goal(&self, now: Utc, orbit: &OrbitState) -> Option<Goal> {
        let (sight, drift) = self.line_of_sight(now, orbit);
        let (r, v) = (orbit.position.to_f32(), orbit.velocity.to_f32());
        let against_normal = v.cross(&r).direction()?;
        let drift = drift.xyz * (1.0 / sight.norm());
        let aligned = self.axes.towards(sight.direction()?, against_normal)?;
        let (t1, t3) = (aligned.eci.column(0).into_owned(), aligned.eci.column(2).into_owned());
        let t1_dot = drift - t1 * t1.dot(&drift);
        let about = t1_dot.cross(&against_normal.vector().xyz).dot(&t3) / aligned.sine;
        let omega: Vector<Eci> = Vector::from_xyz(t1.cross(&t1_dot) + t1 * about);
        Some(Goal { r_ti: aligned.r_ti, omega_ti: aligned.r_ti * omega })
    }

    /// ρ and ρ̇, Eci, m and m/s. The place is turned into Eci in f64; from the difference on f32 is
    /// precise to some centimetres.
    fn line_of_sight(&self, now: Utc, orbit: &OrbitState) -> (Vector<Eci>, Vector<Eci>) {
        let (s, c) = libm::sincos(gmst82_rad(now.julian_date()));
        let [x, y, z] = self.position.to_array();
        let site: Vector<Eci, f64> = Vector::new(c * x - s * y, s * x + c * y, z);
        let sight = (site - orbit.position).to_f32();
        let (s, c) = (s as f32, c as f32);
        let [x, y, z] = self.up.to_array();
        let up: Vector<Eci> = Vector::new(c * x - s * y, s * x + c * y, z);
        if -up.dot(&sight) >= self.sine_of_least_elevation * sight.norm() {
            let site = site.to_f32().xyz;
            let carried: Vector<Eci> = Vector::new(-site.y, site.x, 0.0);
            let rate = ROTATION_RATE_RAD_S as f32;
            (sight, carried * rate - orbit.velocity.to_f32())
        } else {
            (-orbit.position.to_f32(), -orbit.velocity.to_f32())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::nadir;
    use super::super::tests::{in_orbit, rate_by_difference};
    use super::*;
    use crate::environment::earth::ecef_from_eci;

    fn start() -> Utc {
        Utc::parse("2015-11-19T03:31:21Z").unwrap()
    }

    fn at(seconds: f64) -> Utc {
        start().plus_micros((seconds * 1e6) as i64)
    }

    fn parameters(seconds: f64, aside_rad: f64) -> SiteParameters {
        // The place below the satellite at that time, or a little aside.
        let below = ecef_from_eci(at(seconds)) * in_orbit(seconds).position;
        let below = Geodetic::from_position(below).unwrap();
        SiteParameters {
            axes: BodyAxesParameters::default(),
            latitude_rad: below.latitude_rad + aside_rad,
            longitude_rad: below.longitude_east_rad,
            height_m: 0.0,
            least_elevation_rad: 0.1,
        }
    }

    #[test]
    fn the_place_stays_in_the_boresight_and_the_rate_is_that_of_the_attitude() {
        /// Rounding of an attitude in f32 over two steps of 2 s, and the third derivative of the motion:
        /// at 615 km the line of sight turns at up to 0.0123 rad/s within 57 s.
        const DIFFERENCE_TOLERANCE_RAD_S: f32 = 1e-5;
        let site = Site::new(&parameters(600.0, 0.03)).unwrap();
        let goal = |s: f64| site.goal(at(s), &in_orbit(s)).unwrap();
        let mut fastest = 0.0_f32;
        for k in -9..=9 {
            let seconds = 600.0 + 20.0 * f64::from(k);
            let place = ecef_from_eci(at(seconds)).inverse() * site.position;
            let sight = (place - in_orbit(seconds).position).to_f32().direction().unwrap();
            let seen = goal(seconds).r_ti * sight.vector();
            // Rounding of f32.
            assert!((seen - Vector::new(0.0, 0.0, 1.0)).norm() < 1e-5);
            let off = rate_by_difference(goal, seconds, 2.0) - goal(seconds).omega_ti;
            assert!(off.norm() < DIFFERENCE_TOLERANCE_RAD_S, "{seconds} {off:?}");
            fastest = fastest.max(goal(seconds).omega_ti.norm());
        }
        assert!(fastest > 0.01, "{fastest}: it passed nearly overhead");
    }

    #[test]
    fn below_the_horizon_it_looks_to_nadir_as_the_orbit_frame_does() {
        let site = Site::new(&parameters(600.0, 0.0)).unwrap();
        let orbit = in_orbit(3_000.0);
        let (goal, nadir) = (site.goal(at(3_000.0), &orbit).unwrap(), nadir::goal(&orbit).unwrap());
        // Rounding of f32.
        assert!((goal.r_ti * nadir.r_ti.inverse()).angle_rad() < 1e-3);
        assert!((goal.omega_ti - nadir.omega_ti).norm() < 1e-8);
        // Right above the place it is nearly the same attitude: down is down.
        let above = in_orbit(600.0);
        let (goal, nadir) = (site.goal(at(600.0), &above).unwrap(), nadir::goal(&above).unwrap());
        let apart = (goal.r_ti * nadir.r_ti.inverse()).angle_rad();
        // Geodetic down is up to 0.2 deg from the Earth's centre, seen from ten times nearer.
        assert!(apart < 0.04, "{apart}");
        assert!((goal.omega_ti - nadir.omega_ti).norm() > 0.01, "but it turns with the place");
    }

    #[test]
    fn places_that_are_on_no_map_are_refused() {
        let good = parameters(0.0, 0.0);
        assert!(Site::new(&good).is_ok());
        for bad in [2.0, -2.0, f64::NAN] {
            let site = Site::new(&SiteParameters { latitude_rad: bad, ..good });
            assert!(matches!(site, Err(AimError::Latitude { .. })));
        }
        for bad in [4.0, -4.0, f64::INFINITY] {
            let site = Site::new(&SiteParameters { longitude_rad: bad, ..good });
            assert!(matches!(site, Err(AimError::Longitude { .. })));
        }
        for bad in [1e5, -2e3, f64::NAN] {
            let site = Site::new(&SiteParameters { height_m: bad, ..good });
            assert!(matches!(site, Err(AimError::Height { .. })));
        }
        for bad in [-0.1, 1.6, f32::NAN] {
            let site = Site::new(&SiteParameters { least_elevation_rad: bad, ..good });
            assert!(matches!(site, Err(AimError::Elevation { .. })));
        }
    }
}
