//! Dipoles in a field: the torquers, the satellite's own remanence, and what a torquer does to the
//! magnetometer next to it.

use adcs_core::frames::{Body, Vector};

/// Torque of a dipole (Body, A·m²) in a field (Body, T), N·m: T = m × B.
pub fn torque(dipole_am2: Vector<Body, f64>, field_t: Vector<Body, f64>) -> Vector<Body, f64> {
    dipole_am2.cross(&field_t)
}

/// Field of a dipole (Body, A·m²) at `offset` from it (Body, m), T:
/// B = μ₀/4π (3 r̂ (m · r̂) − m) / r³. Zero at the dipole itself.
///
/// Source: Jackson (1999), eq. (5.56), outside the source.
pub fn dipole_field_t(
    dipole_am2: Vector<Body, f64>,
    offset: Vector<Body, f64>,
) -> Vector<Body, f64> {
    /// μ₀/4π, T·m/A.
    const MU0_OVER_4PI: f64 = 1e-7;
    let Some(direction) = offset.direction() else { return Vector::zero() };
    let r_hat = direction.vector();
    let r = offset.norm();
    (r_hat * (3.0 * dipole_am2.dot(&r_hat)) - dipole_am2) * (MU0_OVER_4PI / (r * r * r))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_full_torquer_makes_120_microtesla_on_its_axis_10_cm_away() {
        let field = dipole_field_t(Vector::new(0.6, 0.0, 0.0), Vector::new(0.1, 0.0, 0.0));
        assert!((field.xyz.x - 120e-6).abs() < 1e-12);
        let beside = dipole_field_t(Vector::new(0.6, 0.0, 0.0), Vector::new(0.0, 0.1, 0.0));
        assert!((beside.xyz.x + 60e-6).abs() < 1e-12);
    }
}
