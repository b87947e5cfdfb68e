//! The linear equations of a body on target in the Orbit frame.
//!
//! ```text
//! ė = ω_e,   δω = ω_e + ω_o × e
//! ω̇_e = J⁻¹ [−δω × J ω_o − ω_o × J δω + δT_gg + m × B] − ω_o × ω_e
//! δT_gg = g (δr × J r + r × J δr),   δr = r × e
//! ```
//!
//! with r the unit vector from the Earth (−Z of Orbit), g = 3μ/r³ and ω_o the rate of the Orbit frame.
//! What does not depend on e or ω_e is left out: it moves the satellite, and decides nothing about
//! stability.

use nalgebra::{Matrix3, Matrix6, SMatrix, Vector3};

/// A body in an orbit.
#[derive(Debug, Clone, Copy)]
pub(super) struct Plant {
    pub(super) inertia: Matrix3<f64>,
    pub(super) inverse: Matrix3<f64>,
}

/// Where the Orbit frame is at an instant.
#[derive(Debug, Clone, Copy)]
pub(super) struct Around {
    /// Flux density, Orbit, T.
    pub(super) field: Vector3<f64>,
    /// Rate of the Orbit frame, Orbit, rad/s.
    pub(super) omega: Vector3<f64>,
    /// 3 μ / r³, 1/s².
    pub(super) gradient: f64,
}

impl Around {
    fn towards(&self, other: &Self, share: f64) -> Self {
        let between = |a: Vector3<f64>, b: Vector3<f64>| a + (b - a) * share;
        Self {
            field: between(self.field, other.field),
            omega: between(self.omega, other.omega),
            gradient: self.gradient + (other.gradient - self.gradient) * share,
        }
    }
}

/// From the Earth to the satellite, Orbit.
pub(super) const UP: Vector3<f64> = Vector3::new(0.0, 0.0, -1.0);

impl Plant {
    /// d(e, ω_e)/dt by (e, ω_e).
    pub(super) fn matrix(&self, around: &Around) -> Matrix6<f64> {
        let Around { omega, gradient, .. } = around;
        let (j, o) = (&self.inertia, omega.cross_matrix());
        let by_rate = self.inverse * ((j * omega).cross_matrix() - o * j);
        let r = UP.cross_matrix();
        let of_gravity = self.inverse * (r * j - (j * UP).cross_matrix()) * r * *gradient;
        let mut a = Matrix6::zeros();
        a.fixed_view_mut::<3, 3>(0, 3).copy_from(&Matrix3::identity());
        a.fixed_view_mut::<3, 3>(3, 0).copy_from(&(by_rate * o + of_gravity));
        a.fixed_view_mut::<3, 3>(3, 3).copy_from(&(by_rate - o));
        a
    }

    /// The state after `span_s`, the surroundings going from one to the other, with the dipole that is
    /// `gain` times the state at the beginning. One column for each state at the beginning.
    pub(super) fn carried(
        &self,
        from: &Around,
        to: &Around,
        gain: &SMatrix<f64, 3, 6>,
        x: &Matrix6<f64>,
        span_s: f64,
    ) -> Matrix6<f64> {
        // The classical rule of Runge and Kutta: within seconds nothing turns by more than 1e-2.
        let dipole = gain * x;
        let slope = |share: f64, x: &Matrix6<f64>| {
            let around = from.towards(to, share);
            let torque = around.field.cross_matrix() * dipole * -1.0;
            let mut slope = self.matrix(&around) * x;
            let mut rate = slope.fixed_view_mut::<3, 6>(3, 0);
            rate += self.inverse * torque;
            slope
        };
        let k1 = slope(0.0, x);
        let k2 = slope(0.5, &(x + k1 * (0.5 * span_s)));
        let k3 = slope(0.5, &(x + k2 * (0.5 * span_s)));
        let k4 = slope(1.0, &(x + k3 * span_s));
        x + (k1 + (k2 + k3) * 2.0 + k4) * (span_s / 6.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RATE: f64 = 1.08e-3;

    fn plant(j: [f64; 3]) -> Plant {
        let inertia = Matrix3::from_diagonal(&Vector3::from(j));
        Plant { inertia, inverse: inertia.try_inverse().unwrap() }
    }

    fn around() -> Around {
        let gradient = 3.0 * RATE * RATE;
        Around {
            field: Vector3::new(2e-5, 1e-6, 3e-5),
            omega: Vector3::new(0.0, -RATE, 0.0),
            gradient,
        }
    }

    #[test]
    fn pitch_swings_as_gravity_says() {
        // J_y ë = −3 n² (J_x − J_z) e for the pitch (Markley & Crassidis (2014), §4.2.4 in principle).
        let a = plant([0.06, 0.055, 0.05]).matrix(&around());
        let expected = -3.0 * RATE * RATE * (0.06 - 0.05) / 0.055;
        assert!((a[(4, 1)] / expected - 1.0).abs() < 1e-12, "{}", a[(4, 1)]);
        assert!(a[(4, 4)].abs() < 1e-18, "nothing brakes it");
    }

    #[test]
    fn a_sphere_feels_neither_gravity_nor_gyroscopic_torque() {
        let a = plant([0.05; 3]).matrix(&around());
        let o = around().omega.cross_matrix();
        assert!(a.fixed_view::<3, 3>(3, 0).norm() < 1e-15);
        assert!((a.fixed_view::<3, 3>(3, 3) + o).norm() < 1e-15);
    }

    #[test]
    fn a_dipole_that_is_held_gives_its_torque_for_as_long() {
        let plant = plant([0.05; 3]);
        let still = Around { omega: Vector3::zeros(), gradient: 0.0, ..around() };
        let mut gain = SMatrix::<f64, 3, 6>::zeros();
        gain[(0, 0)] = 0.1;
        let after = plant.carried(&still, &still, &gain, &Matrix6::identity(), 5.0);
        let torque = Vector3::new(0.1, 0.0, 0.0).cross(&still.field);
        let expected = torque * (5.0 / 0.05);
        let found = after.fixed_view::<3, 1>(3, 0).into_owned();
        assert!((found - expected).norm() < 1e-12 * expected.norm());
    }
}
