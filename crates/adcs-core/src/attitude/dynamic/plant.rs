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
