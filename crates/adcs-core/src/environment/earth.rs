//! How the Earth stands: between inertial and Earth-fixed axes.

use nalgebra::{UnitQuaternion, Vector3};

use crate::frames::{Ecef, Eci, Rotation, Vector};
use crate::orbit::OrbitState;
use crate::time::{JulianDate, Utc, gmst82_rad};

/// Geocentric gravitational constant, m³/s² (IERS Conventions 2010, table 1.1; WGS84 and EGM96 have the
/// same value). SGP4 has one of its own.
pub const MU_M3_S2: f64 = 3.986_004_418e14;

/// Rate of the Earth's rotation against inertial space, about z of both frames, rad/s.
///
/// Source: IERS Conventions (2003), nominal 7.292115146706979e-5, as used with GMST-82 by Vallado
/// (2013), §3.7.
pub const ROTATION_RATE_RAD_S: f64 = 7.292_115_146_706_98e-5;

/// The rotation from TEME to Earth-fixed axes (PEF) at `now`, by Greenwich mean sidereal time about
/// z. UT1 is taken to be UTC (at most 0.9 s or 0.004 deg) and polar motion is ignored (0.0002 deg).
pub fn ecef_from_eci(now: Utc) -> Rotation<Ecef, Eci, f64> {
    ecef_from_eci_at_ut1(now.julian_date())
}

/// The rotation from TEME to Earth-fixed axes (PEF), where UT1 is known.
///
/// r_ecef = R₃(θ) r_eci, θ by [`gmst82_rad`]; Vallado (2013), §3.7.
pub fn ecef_from_eci_at_ut1(ut1: JulianDate) -> Rotation<Ecef, Eci, f64> {
    let theta_rad = gmst82_rad(ut1);
    Rotation::from_hamilton(UnitQuaternion::from_axis_angle(&Vector3::z_axis(), -theta_rad))
}

/// Position and velocity as seen from the turning Earth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EcefState {
    /// Position from the Earth's centre, Ecef, m.
    pub position: Vector<Ecef, f64>,
    /// Velocity against the Earth, Ecef, m/s.
    pub velocity: Vector<Ecef, f64>,
}

impl EcefState {
    /// What is seen from the Earth of an inertial state.
    ///
    /// v_ecef = R v_eci − ω × r_ecef; Vallado (2013), §3.7.
    pub fn from_eci(r_ei: Rotation<Ecef, Eci, f64>, state: &OrbitState) -> Self {
        let position = r_ei * state.position;
        let velocity = r_ei * state.velocity - carried_by_rotation(position);
        Self { position, velocity }
    }

    /// The inertial state.
    ///
    /// v_eci = Rᵀ (v_ecef + ω × r_ecef).
    pub fn to_eci(&self, r_ei: Rotation<Ecef, Eci, f64>) -> OrbitState {
        let r_ie = r_ei.inverse();
        let velocity = self.velocity + carried_by_rotation(self.position);
        OrbitState { position: r_ie * self.position, velocity: r_ie * velocity }
    }
}

/// ω × r: how fast a point fixed to the Earth moves through inertial space, m/s.
fn carried_by_rotation(position: Vector<Ecef, f64>) -> Vector<Ecef, f64> {
    let r = position.xyz;
    Vector::new(-ROTATION_RATE_RAD_S * r.y, ROTATION_RATE_RAD_S * r.x, 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_geostationary_satellite_stands_still_over_the_earth() {
        /// Rounding of a speed of 3 km/s.
        const ROUNDING_M_S: f64 = 1e-11;
        let now = Utc::parse("2026-11-21T12:00:00Z").unwrap();
        let r_ei = ecef_from_eci(now);
        let still =
            EcefState { position: Vector::new(4.2164e7, -1e6, 3e4), velocity: Vector::zero() };
        let inertial = still.to_eci(r_ei);
        let speed = inertial.velocity.norm();
        assert!((speed - ROTATION_RATE_RAD_S * libm::hypot(4.2164e7, 1e6)).abs() < ROUNDING_M_S);
        assert!(inertial.position.dot(&inertial.velocity).abs() < 1.0, "it moves along a circle");
        let back = EcefState::from_eci(r_ei, &inertial);
        assert!((back.position - still.position).norm() < 1e-7);
        assert!(back.velocity.norm() < ROUNDING_M_S);
    }

    #[test]
    fn the_velocity_against_the_earth_is_the_change_of_the_position() {
        /// Rounding of 7000 km over two steps of 0.5 s, and the third derivative of the motion.
        const DIFFERENCE_TOLERANCE_M_S: f64 = 1e-3;
        const STEP_S: f64 = 0.5;
        let now = Utc::parse("2015-03-27T02:00:00Z").unwrap();
        let at = |seconds: f64| {
            let utc = now.plus_micros((seconds * 1e6) as i64);
            let position = Vector::new(7e6 + 300.0 * seconds, 1e6, 5e5 + 7_000.0 * seconds);
            let state = OrbitState { position, velocity: Vector::new(300.0, 0.0, 7_000.0) };
            EcefState::from_eci(ecef_from_eci(utc), &state)
        };
        let difference = (at(STEP_S).position - at(-STEP_S).position) * (0.5 / STEP_S);
        assert!((difference - at(0.0).velocity).norm() < DIFFERENCE_TOLERANCE_M_S);
    }
}
