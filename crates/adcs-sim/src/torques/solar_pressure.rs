//! Sunlight pushes.

use adcs_core::environment::sun::ASTRONOMICAL_UNIT_M;
use adcs_core::frames::{Body, Vector};

use super::Box3;

/// Pressure of sunlight on a black plate at one astronomical unit, N/m²: 1361 W/m² over the speed
/// of light (Kopp & Lean (2011)).
const PRESSURE_AT_1_AU_N_M2: f64 = 4.54e-6;

/// What solar pressure depends on besides the box.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SolarPressure {
    /// 1 for a black surface, 2 for a mirror that faces the Sun.
    pub coefficient: f64,
}

impl SolarPressure {
    /// Solar-pressure torque, Body, N·m, with the vector to the Sun (Body, m) and the lit fraction
    /// of its disc (0 to 1): F = −P C_R A ŝ at the centre of pressure.
    pub fn torque(&self, shape: &Box3, to_sun_b: Vector<Body, f64>, lit: f64) -> Vector<Body, f64> {
        let Some(direction) = to_sun_b.direction() else { return Vector::zero() };
        let distance_au = to_sun_b.norm() / ASTRONOMICAL_UNIT_M;
        let pressure = PRESSURE_AT_1_AU_N_M2 * lit / (distance_au * distance_au);
        let area_m2 = shape.projected_area_m2(direction.vector());
        shape.torque(-direction.vector() * (pressure * self.coefficient * area_m2))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_of_the_papers_size_in_sunlight_and_zero_in_shadow() {
        let pressure = SolarPressure { coefficient: 1.6 };
        let shape =
            Box3 { sides_m: [0.21, 0.283, 0.283], centre_of_pressure: Vector::new(0.0, 0.02, 0.0) };
        let to_sun = Vector::new(ASTRONOMICAL_UNIT_M, 0.0, 0.0);
        let torque = pressure.torque(&shape, to_sun, 1.0).norm();
        // The paper's table 5.1 has 1.0e-8 N·m.
        assert!((0.9e-8..1.4e-8).contains(&torque), "{torque}");
        assert_eq!(pressure.torque(&shape, to_sun, 0.0).norm(), 0.0);
    }
}
