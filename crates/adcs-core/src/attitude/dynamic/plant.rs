//! How the satellite turns, as the filter believes it: Euler's equations with everything known.
//!
//! J ω̇ = (m + M) × B + T + 3μ/r³ r̂ × J r̂ − ω × J ω,   q̇_bi = −½ ω ⊗ q_bi
//!
//! | symbol | code | meaning |
//! |---|---|---|
//! | J | [`Inertia`] | inertia tensor as estimated, Body, kg·m² |
//! | m + M | [`Torques::dipole`] | the torquers' dipole and the residual one, Body, A·m² |
//! | B | [`Surroundings::field`] | field of the model, Eci, T, turned by the estimated attitude: never the magnetometer's, whose noise would become torque |
//! | T | [`Torques::torque`] | torque of unknown cause, Body, N·m |
//! | r̂, 3μ/r³ | [`Surroundings::up`], [`Surroundings::gradient`] | unit vector from the Earth's centre, Eci; 1/s² |
//!
//! Source: Markley & Crassidis (2014), eqs (3.80), (3.155); sign of q̇ as in `frames`.

use nalgebra::{Matrix3, Quaternion, RealField, Unit, Vector3, convert};

use crate::frames::{Body, Eci, Rotation};

/// An inertia tensor, kg·m², and its inverse.
#[derive(Debug, Clone, Copy)]
pub(super) struct Inertia<T> {
    pub(super) tensor: Matrix3<T>,
    pub(super) inverse: Matrix3<T>,
}

impl<T: RealField + Copy> Inertia<T> {
    /// `None` when no body has this tensor: a principal moment that is not positive.
    pub(super) fn new(tensor: Matrix3<T>) -> Option<Self> {
        tensor.cholesky()?;
        Some(Self { tensor, inverse: tensor.try_inverse()? })
    }
}

/// What surrounds the satellite during a step, Eci.
#[derive(Debug, Clone, Copy)]
pub(super) struct Surroundings<T> {
    /// Mean field over the step, T.
    pub(super) field: Vector3<T>,
    /// From the Earth's centre to the satellite, unit length.
    pub(super) up: Vector3<T>,
    /// 3 μ / r³, 1/s²; zero when the position is not known.
    pub(super) gradient: T,
}

/// What turns the satellite, Body.
#[derive(Debug, Clone, Copy)]
pub(super) struct Torques<T> {
    /// Torquers and residual dipole, A·m².
    pub(super) dipole: Vector3<T>,
    /// How much of each of the shadow's parts is in it, 0 to 1.
    pub(super) shadow: [T; 2],
    /// Of unknown cause, N·m.
    pub(super) torque: Vector3<T>,
}

/// Attitude and rate.
#[derive(Debug, Clone, Copy)]
pub(super) struct Motion<T: RealField + Copy> {
    pub(super) r_bi: Rotation<Body, Eci, T>,
    /// Body, rad/s.
    pub(super) omega: Vector3<T>,
}

/// Everything that accelerates the satellite in one step.
#[derive(Debug, Clone, Copy)]
pub(super) struct Plant<'a, T> {
    pub(super) inertia: &'a Inertia<T>,
    pub(super) surroundings: &'a Surroundings<T>,
    pub(super) torques: &'a Torques<T>,
}

impl<T: RealField + Copy> Motion<T> {
    /// Halfway to a motion that follows within a small part of a turn; to second order in the step.
    pub(super) fn midway(&self, after: &Self) -> Self {
        let sum = self.r_bi.hamilton().into_inner() + after.r_bi.hamilton().into_inner();
        Self {
            r_bi: Rotation::from_hamilton(Unit::new_normalize(sum)),
            omega: (self.omega + after.omega) * convert::<f64, T>(0.5),
        }
    }
}

impl<T: RealField + Copy> Plant<'_, T> {
    /// ω̇ at an attitude (`hamilton` need not be of unit length) and a rate, Body, rad/s².
    pub(super) fn acceleration(&self, hamilton: &Quaternion<T>, omega: &Vector3<T>) -> Vector3<T> {
        let Surroundings { field, up, gradient } = self.surroundings;
        let r_bi = Unit::new_normalize(*hamilton);
        let (field_b, up_b) = (r_bi * field, r_bi * up);
        let Inertia { tensor, inverse } = self.inertia;
        let torque = self.torques.dipole.cross(&field_b)
            + self.torques.torque
            + up_b.cross(&(tensor * up_b)) * *gradient
            - omega.cross(&(tensor * omega));
        inverse * torque
    }

    /// The motion `dt_s` later by the classical fourth-order Runge–Kutta rule.
    pub(super) fn stepped(&self, motion: &Motion<T>, dt_s: T) -> Motion<T> {
        let half: T = convert(0.5);
        let slope = |q: &Quaternion<T>, omega: &Vector3<T>| {
            // q̇ = −½ (0, ω) ⊗ q
            (Quaternion::from_imag(*omega) * q * -half, self.acceleration(q, omega))
        };
        let (q, omega) = (motion.r_bi.hamilton().into_inner(), motion.omega);
        let moved = |(q_dot, omega_dot): &(Quaternion<T>, Vector3<T>), dt: T| {
            (q + *q_dot * dt, omega + omega_dot * dt)
        };
        let k1 = slope(&q, &omega);
        let (q2, omega2) = moved(&k1, dt_s * half);
        let k2 = slope(&q2, &omega2);
        let (q3, omega3) = moved(&k2, dt_s * half);
        let k3 = slope(&q3, &omega3);
        let (q4, omega4) = moved(&k3, dt_s);
        let k4 = slope(&q4, &omega4);
        let (two, sixth): (T, T) = (convert(2.0), convert(1.0 / 6.0));
        let mean = (
            (k1.0 + (k2.0 + k3.0) * two + k4.0) * sixth,
            (k1.1 + (k2.1 + k3.1) * two + k4.1) * sixth,
        );
        let (q, omega) = moved(&mean, dt_s);
        Motion { r_bi: Rotation::from_hamilton(Unit::new_normalize(q)), omega }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::UnitQuaternion;

    const TENSOR: Matrix3<f64> =
        Matrix3::new(0.052, 6e-4, -8e-4, 6e-4, 0.054, 7e-4, -8e-4, 7e-4, 0.060);

    fn nothing_around() -> Surroundings<f64> {
        Surroundings { field: Vector3::zeros(), up: Vector3::zeros(), gradient: 0.0 }
    }

    fn no_torques() -> Torques<f64> {
        Torques { dipole: Vector3::zeros(), shadow: [0.0; 2], torque: Vector3::zeros() }
    }

    fn diagonal() -> Inertia<f64> {
        Inertia::new(Matrix3::from_diagonal(&Vector3::new(0.05, 0.06, 0.08))).unwrap()
    }

    fn at_rest() -> Motion<f64> {
        Motion { r_bi: Rotation::identity(), omega: Vector3::zeros() }
    }

    #[test]
    fn a_free_tumble_keeps_its_energy_and_its_momentum_in_space() {
        // Ten minutes at 9 deg/s. A step of 0.5 s turns by 0.08 rad, a quaternion by half of that, of
        // which Runge-Kutta leaves 0.04⁵ / 120; 1,200 of them, all the same way.
        const ENERGY: f64 = 1e-8;
        const MOMENTUM: f64 = 2e-6;
        let inertia = Inertia::new(TENSOR).unwrap();
        let plant =
            Plant { inertia: &inertia, surroundings: &nothing_around(), torques: &no_torques() };
        let start = Motion {
            r_bi: Rotation::from_hamilton(UnitQuaternion::from_euler_angles(0.3, -0.8, 2.0)),
            omega: Vector3::new(0.06, 0.03, -0.14),
        };
        let energy = |motion: &Motion<f64>| 0.5 * motion.omega.dot(&(TENSOR * motion.omega));
        let momentum =
            |motion: &Motion<f64>| motion.r_bi.inverse().hamilton() * (TENSOR * motion.omega);
        let end = (0..1200).fold(start, |motion, _| plant.stepped(&motion, 0.5));
        assert!((end.omega - start.omega).norm() > 0.01, "it does tumble");
        assert!((energy(&end) / energy(&start) - 1.0).abs() < ENERGY);
        let change = (momentum(&end) - momentum(&start)).norm() / momentum(&start).norm();
        assert!(change < MOMENTUM, "{change}");
    }

    #[test]
    fn a_constant_torque_about_a_principal_axis_turns_by_half_its_acceleration_times_t_squared() {
        let torque = Vector3::z() * 4e-6;
        let torques = Torques { torque, ..no_torques() };
        let inertia = diagonal();
        let plant = Plant { inertia: &inertia, surroundings: &nothing_around(), torques: &torques };
        let end = (0..200).fold(at_rest(), |motion, _| plant.stepped(&motion, 0.5));
        // 5e-5 rad/s² for 100 s; rates are polynomials of time, which the rule integrates exactly.
        assert!((end.omega - Vector3::z() * 5e-3).norm() < 1e-15);
        let turn =
            (end.r_bi.hamilton() * UnitQuaternion::from_scaled_axis(Vector3::z() * 0.25)).angle();
        // 2.5e-3 rad a step at the end, and its fifth power.
        assert!(turn < 1e-12, "{turn}");
    }

    #[test]
    fn the_acceleration_is_that_of_the_textbook_term_by_term() {
        // Rounding of a few products of 1e-3 rad/s².
        const ROUNDING: f64 = 1e-17;
        let inertia = diagonal();
        let [j_x, j_y, j_z] = [0.05, 0.06, 0.08];
        let upright = Quaternion::identity();
        let acceleration = |surroundings: &Surroundings<f64>, torques: &Torques<f64>, omega| {
            Plant { inertia: &inertia, surroundings, torques }.acceleration(&upright, &omega)
        };
        // Euler: J_x ω̇_x = (J_y − J_z) ω_y ω_z and so on.
        let omega = Vector3::new(0.03, -0.05, 0.02);
        let expected = Vector3::new(
            (j_y - j_z) * omega.y * omega.z / j_x,
            (j_z - j_x) * omega.z * omega.x / j_y,
            (j_x - j_y) * omega.x * omega.y / j_z,
        );
        let found = acceleration(&nothing_around(), &no_torques(), omega);
        assert!((found - expected).norm() < ROUNDING);
        // A dipole along x in a field along z: −y, as a compass needle turns.
        let field = Surroundings { field: Vector3::z() * 3e-5, ..nothing_around() };
        let dipole = Torques { dipole: Vector3::x() * 0.5, ..no_torques() };
        let found = acceleration(&field, &dipole, Vector3::zeros());
        assert!((found + Vector3::y() * (1.5e-5 / j_y)).norm() < ROUNDING);
        // Pitched by α: 3μ/2r³ (J_x − J_z) sin 2α about y, which for J_z > J_x turns z away.
        let (alpha, gradient) = (0.4, 3.4e-6);
        let up = Vector3::new(libm::sin(alpha), 0.0, libm::cos(alpha));
        let pitched = Surroundings { up, gradient, ..nothing_around() };
        let found = acceleration(&pitched, &no_torques(), Vector3::zeros());
        let expected = Vector3::y() * (0.5 * gradient * (j_x - j_z) * libm::sin(2.0 * alpha) / j_y);
        assert!((found - expected).norm() < ROUNDING);
    }

    #[test]
    fn field_and_vertical_are_turned_by_the_attitude() {
        // Yawed by 90 deg: inertial y is along Body x.
        let yawed = Rotation::<Body, Eci, f64>::from_attitude_quaternion([0.0, 0.0, 1.0, 1.0]);
        let field = Surroundings { field: Vector3::y() * 3e-5, ..nothing_around() };
        let dipole = Torques { dipole: Vector3::z() * 0.5, ..no_torques() };
        let inertia = diagonal();
        let plant = Plant { inertia: &inertia, surroundings: &field, torques: &dipole };
        let q = yawed.unwrap().hamilton().into_inner();
        let found = plant.acceleration(&q, &Vector3::zeros());
        assert!((found - Vector3::y() * (1.5e-5 / 0.06)).norm() < 1e-17);
    }

    #[test]
    fn what_no_body_can_have_is_no_inertia() {
        assert!(Inertia::new(Matrix3::from_diagonal(&Vector3::new(1.0, -0.1, 1.0_f32))).is_none());
        assert!(Inertia::new(Matrix3::<f32>::zeros()).is_none());
        assert!(Inertia::new(Matrix3::<f32>::identity() * f32::NAN).is_none());
    }
}
