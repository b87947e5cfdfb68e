//! Gravity pulls harder at the near end.

use adcs_core::environment::earth::MU_M3_S2;
use adcs_core::frames::{Body, Vector};

use crate::rigid_body::Inertia;

/// Gravity-gradient torque, Body, N·m: T = 3 μ / r⁵ (r × J r), with the position r in Body, m.
///
/// Source: Markley & Crassidis (2014), eq. (3.155).
pub fn torque(inertia: &Inertia, position_b: Vector<Body, f64>) -> Vector<Body, f64> {
    let r = position_b.norm();
    let r2 = r * r;
    let strength = 3.0 * MU_M3_S2 / (r2 * r2 * r);
    position_b.cross(&inertia.times(position_b)) * strength
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_largest_at_45_deg_and_vanishes_along_an_axis() {
        let inertia =
            Inertia::new([[0.05, 0.0, 0.0], [0.0, 0.055, 0.0], [0.0, 0.0, 0.06]]).unwrap();
        let r_m = 6_993e3;
        assert_eq!(torque(&inertia, Vector::new(r_m, 0.0, 0.0)).norm(), 0.0);
        let half = core::f64::consts::FRAC_1_SQRT_2 * r_m;
        let largest = torque(&inertia, Vector::new(half, 0.0, half)).norm();
        // 1.5 n² ΔJ with n² = μ/r³.
        let expected = 1.5 * MU_M3_S2 / (r_m * r_m * r_m) * 0.01;
        assert!((largest / expected - 1.0).abs() < 1e-12);
    }
}
