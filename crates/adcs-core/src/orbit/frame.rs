//! The frame that travels with the satellite: Z to the Earth's centre, X forwards.

use nalgebra::{Matrix3, Rotation3, UnitQuaternion};

use super::OrbitState;
use crate::frames::{Eci, Orbit, Rotation, Vector};

/// Sine of the least angle between position and velocity for which there is an orbit plane.
const LEAST_SINE: f64 = 1e-6;

/// How the [`Orbit`] axes stand and turn.
#[derive(Debug, Clone, Copy)]
pub struct OrbitFrame {
    /// From inertial to Orbit axes.
    pub r_oi: Rotation<Orbit, Eci, f64>,
    /// Rate of Orbit against Eci, in Orbit axes, rad/s.
    pub omega_oi: Vector<Orbit, f64>,
}

impl OrbitFrame {
    /// The paper's reference frame (its fig. 3.2) of a satellite with this position and velocity.
    ///
    /// With h = r × v: Z = −r/|r|, Y = −h/|h|, X = Y × Z; ω_oi = (0, −|h|/r², 0). That is the rate
    /// of the osculating orbit; the turning of its plane by the Earth's flattening, at most 2e-6
    /// rad/s in low orbit, is left out.
    ///
    /// `None` when there is no orbit plane: r or v is zero or not finite, or they are parallel.
    ///
    /// Source: Markley & Crassidis (2014), §2.6.4 (local-vertical/local-horizontal frame).
    pub fn of(state: &OrbitState) -> Option<Self> {
        let (r, v) = (state.position.xyz, state.velocity.xyz);
        let h = r.cross(&v);
        let (r_norm, v_norm, h_norm) = (r.norm(), v.norm(), h.norm());
        let has_plane = h_norm.is_finite() && h_norm > LEAST_SINE * r_norm * v_norm;
        if !has_plane {
            return None;
        }
        let (z, y) = (-r / r_norm, -h / h_norm);
        let x = y.cross(&z);
        let rows = Matrix3::from_rows(&[x.transpose(), y.transpose(), z.transpose()]);
        let rotation = Rotation3::from_matrix_unchecked(rows);
        Some(Self {
            r_oi: Rotation::from_hamilton(UnitQuaternion::from_rotation_matrix(&rotation)),
            omega_oi: Vector::new(0.0, -h_norm / (r_norm * r_norm), 0.0),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    /// Rounding of a rotation of unit vectors.
    const ROUNDING: f64 = 1e-15;

    fn state(position: [f64; 3], velocity: [f64; 3]) -> OrbitState {
        let [x, y, z] = position;
        let [vx, vy, vz] = velocity;
        OrbitState { position: Vector::new(x, y, z), velocity: Vector::new(vx, vy, vz) }
    }

    #[test]
    fn z_points_to_the_earth_x_forwards_and_y_against_the_orbit_normal() {
        // Over the equator on +x, flying north.
        let frame = OrbitFrame::of(&state([7e6, 0.0, 0.0], [0.0, 0.0, 7.5e3])).unwrap();
        let seen = |x, y, z| (frame.r_oi * Vector::new(x, y, z)).xyz;
        assert!((seen(-1.0, 0.0, 0.0) - Vector3::z()).norm() < ROUNDING, "nadir is Z");
        assert!((seen(0.0, 0.0, 1.0) - Vector3::x()).norm() < ROUNDING, "flight is X");
        // h = x × z = −y, so Y = +y.
        assert!((seen(0.0, 1.0, 0.0) - Vector3::y()).norm() < ROUNDING, "Y is against h");
    }

    #[test]
    fn the_rate_is_that_of_the_axes_themselves() {
        /// Third derivatives of the motion over two steps of 0.1 s.
        const DIFFERENCE_TOLERANCE_RAD_S: f64 = 1e-9;
        const STEP_S: f64 = 0.1;
        const RATE_RAD_S: f64 = 1.08e-3;
        let at = |t: f64| {
            let (s, c) = libm::sincos(RATE_RAD_S * t + 0.4);
            let (r, v) = (7e6, 7e6 * RATE_RAD_S);
            let inclined = |a: f64, b: f64| [a, 0.6 * b, 0.8 * b];
            OrbitFrame::of(&state(inclined(r * c, r * s), inclined(-v * s, v * c))).unwrap()
        };
        let turned = at(STEP_S).r_oi * at(-STEP_S).r_oi.inverse();
        // Hamilton numbers turn components, so the frame turned the other way.
        let omega = turned.hamilton().scaled_axis() * (-0.5 / STEP_S);
        assert!((omega - at(0.0).omega_oi.xyz).norm() < DIFFERENCE_TOLERANCE_RAD_S);
        assert!((at(0.0).omega_oi.xyz.y + RATE_RAD_S).abs() < DIFFERENCE_TOLERANCE_RAD_S);
    }

    #[test]
    fn without_an_orbit_plane_there_is_no_frame() {
        assert!(OrbitFrame::of(&state([7e6, 0.0, 0.0], [0.0; 3])).is_none());
        assert!(OrbitFrame::of(&state([0.0; 3], [0.0, 7e3, 0.0])).is_none());
        assert!(OrbitFrame::of(&state([7e6, 0.0, 0.0], [-3e3, 0.0, 0.0])).is_none());
        assert!(OrbitFrame::of(&state([7e6, f64::NAN, 0.0], [0.0, 7e3, 0.0])).is_none());
        assert!(OrbitFrame::of(&state([1e200, 0.0, 0.0], [0.0, 1e200, 0.0])).is_none());
    }
}
