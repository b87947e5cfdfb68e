//! The thin air pushes.

use adcs_core::frames::{Body, Eci, Vector};

use super::Box3;

/// Rotation rate of the Earth, rad/s (IERS Conventions (2010), table 1.2, rounded).
const EARTH_RATE_RAD_S: f64 = 7.292_115e-5;

/// What drag depends on besides the box.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drag {
    /// Density of the air, kg/m³; between 1e-13 and 2e-12 at 620 km with the Sun's activity.
    pub density_kg_m3: f64,
    /// Drag coefficient, about 2.2 for a box in free molecular flow.
    pub coefficient: f64,
}

/// Velocity relative to air that turns with the Earth, Eci, m/s.
pub fn airspeed(position: Vector<Eci, f64>, velocity: Vector<Eci, f64>) -> Vector<Eci, f64> {
    velocity - Vector::new(0.0, 0.0, EARTH_RATE_RAD_S).cross(&position)
}

impl Drag {
    /// Drag torque, Body, N·m, for the velocity relative to the air (Body, m/s):
    /// F = −½ ρ C_D A |v| v at the centre of pressure.
    pub fn torque(&self, shape: &Box3, airspeed_b: Vector<Body, f64>) -> Vector<Body, f64> {
        let Some(flow) = airspeed_b.direction() else { return Vector::zero() };
        let area_m2 = shape.projected_area_m2(flow.vector());
        let dynamic_pressure = 0.5 * self.density_kg_m3 * airspeed_b.dot(&airspeed_b);
        shape.torque(-flow.vector() * (dynamic_pressure * self.coefficient * area_m2))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_papers_worst_case_needs_everything_stacked() {
        // 2e-12 kg/m³, 5 cm of lever, 0.08 m²: 5e-7 N·m, the row of the paper's table 5.1.
        let drag = Drag { density_kg_m3: 2e-12, coefficient: 2.2 };
        let shape =
            Box3 { sides_m: [0.21, 0.283, 0.283], centre_of_pressure: Vector::new(0.0, 0.05, 0.0) };
        let torque = drag.torque(&shape, Vector::new(7_550.0, 0.0, 0.0)).norm();
        assert!((4.5e-7..5.5e-7).contains(&torque), "{torque}");
    }
}
