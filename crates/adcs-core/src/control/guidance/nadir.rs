//! Nadir: Body along the Orbit axes, the paper's reference frame (its fig. 3.2).

use super::Goal;
use crate::frames::Rotation;
use crate::orbit::OrbitState;
use crate::orbit::frame::OrbitFrame;

/// Z to the Earth's centre, X forwards, turning once an orbit about −Y ([`OrbitFrame`]).
///
/// `None` when position and velocity span no orbit plane.
pub fn goal(orbit: &OrbitState) -> Option<Goal> {
    OrbitFrame::of(orbit).map(|frame| Goal {
        r_ti: Rotation::from_hamilton(frame.r_oi.hamilton().cast()),
        omega_ti: frame.omega_oi.to_f32().relabel(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frames::{Target, Vector};

    #[test]
    fn z_is_down_x_forwards_and_the_frame_turns_once_an_orbit() {
        let over_the_equator = OrbitState {
            position: Vector::new(7e6, 0.0, 0.0),
            velocity: Vector::new(0.0, 0.0, 7.5e3),
        };
        let goal = goal(&over_the_equator).unwrap();
        // Rounding of f32.
        let near = |v: Vector<Target>, to: [f32; 3]| {
            v.to_array().iter().zip(to).all(|(a, b)| (a - b).abs() < 1e-6)
        };
        assert!(near(goal.r_ti * Vector::new(-1.0, 0.0, 0.0), [0.0, 0.0, 1.0]));
        assert!(near(goal.r_ti * Vector::new(0.0, 0.0, 1.0), [1.0, 0.0, 0.0]));
        assert!(near(goal.omega_ti, [0.0, -7.5e3 / 7e6, 0.0]));
    }
}
