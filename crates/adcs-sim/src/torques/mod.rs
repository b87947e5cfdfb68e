//! What turns the satellite besides its own torquers; one torque a file.

pub mod drag;
pub mod gravity_gradient;
pub mod magnetic;
pub mod solar_pressure;

use adcs_core::frames::{Body, Vector};

/// The satellite as a box, for what blows or shines on it: outer sides and where the pressure acts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Box3 {
    /// Length of the sides along Body x, y, z, m.
    pub sides_m: [f64; 3],
    /// Centre of pressure relative to the centre of mass, Body, m.
    pub centre_of_pressure: Vector<Body, f64>,
}

impl Box3 {
    /// The area that a flow along the unit vector `direction` (Body) sees, m²: each pair of faces
    /// counts with the cosine of its normal.
    pub fn projected_area_m2(&self, direction: Vector<Body, f64>) -> f64 {
        let [a, b, c] = self.sides_m;
        let [x, y, z] = direction.to_array();
        b * c * x.abs() + a * c * y.abs() + a * b * z.abs()
    }

    /// The torque of a pressure force (Body, N) at the centre of pressure, Body, N·m.
    fn torque(&self, force: Vector<Body, f64>) -> Vector<Body, f64> {
        self.centre_of_pressure.cross(&force)
    }
}
