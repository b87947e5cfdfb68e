//! How the satellite really turns: Euler's equations and the attitude, in f64.
//!
//! | symbol | code | meaning |
//! |---|---|---|
//! | J | `Inertia` | inertia tensor about the centre of mass, Body, kg·m² |
//! | ω | `omega_bi` | rate of Body relative to Eci, Body, rad/s |
//! | q | `attitude` | Hamilton quaternion with v_eci = q ⊗ v_body ⊗ q* |
//! | T | torque | sum of all torques, Body, N·m |
//!
//! J ω̇ = T − ω × J ω,   q̇ = ½ q ⊗ (ω, 0)
//!
//! Source: Markley & Crassidis (2014), eqs (3.80) and (2.88), the latter for the conjugate.

use core::fmt;

use adcs_core::frames::{Body, Eci, Rotation, Vector};
use nalgebra::{Matrix3, Quaternion, Unit, Vector3};

/// Why a matrix is not the inertia tensor of any body.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum InertiaError {
    /// An entry is not finite.
    NotFinite,
    /// The tensor is not symmetric.
    NotSymmetric {
        /// Row of the entry that differs from its mirror image, 0 to 2.
        row: u8,
        /// Its column.
        column: u8,
    },
    /// A principal moment is zero or negative.
    NotPositive {
        /// The smallest principal moment, kg·m².
        smallest_kg_m2: f64,
    },
    /// One principal moment is larger than the sum of the other two.
    Triangle {
        /// The principal moments in rising order, kg·m².
        principal_kg_m2: [f64; 3],
    },
}

impl fmt::Display for InertiaError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotFinite => write!(f, "an entry is not a finite number"),
            Self::NotSymmetric { row, column } => {
                let (row, column) = (row + 1, column + 1);
                write!(f, "entry ({row},{column}) differs from entry ({column},{row})")
            }
            Self::NotPositive { smallest_kg_m2 } => {
                write!(f, "the smallest principal moment is {smallest_kg_m2} kg·m², not positive")
            }
            Self::Triangle { principal_kg_m2: [a, b, c] } => write!(
                f,
                "no body has the principal moments {a}, {b}, {c} kg·m²: the largest exceeds the sum \
                 of the other two"
            ),
        }
    }
}

impl core::error::Error for InertiaError {}

/// An inertia tensor that some body can have, and its inverse.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Inertia {
    tensor: Matrix3<f64>,
    inverse: Matrix3<f64>,
}

impl Inertia {
    /// Accepts the tensor `[[xx, xy, xz], [yx, yy, yz], [zx, zy, zz]]`, kg·m² (the entries of the
    /// tensor as they stand: products of inertia enter with their negative sign).
    ///
    /// # Errors
    /// [`InertiaError`] when it is not symmetric, not positive, or breaks the triangle inequality.
    pub fn new(rows: [[f64; 3]; 3]) -> Result<Self, InertiaError> {
        let tensor = Matrix3::from_fn(|r, c| rows[r][c]);
        if !tensor.iter().all(|entry| entry.is_finite()) {
            return Err(InertiaError::NotFinite);
        }
        for (row, column) in [(0, 1), (0, 2), (1, 2)] {
            if tensor[(row, column)] != tensor[(column, row)] {
                return Err(InertiaError::NotSymmetric { row: row as u8, column: column as u8 });
            }
        }
        let mut principal: [f64; 3] = tensor.symmetric_eigenvalues().into();
        principal.sort_unstable_by(f64::total_cmp);
        let [smallest, middle, largest] = principal;
        if smallest <= 0.0 {
            return Err(InertiaError::NotPositive { smallest_kg_m2: smallest });
        }
        // A flat plate stands at equality; leave room for the rounding of the eigenvalues.
        if largest > (smallest + middle) * (1.0 + 1e-12) {
            return Err(InertiaError::Triangle { principal_kg_m2: principal });
        }
        let inverse =
            tensor.try_inverse().ok_or(InertiaError::NotPositive { smallest_kg_m2: smallest })?;
        Ok(Self { tensor, inverse })
    }

    /// The tensor, kg·m².
    pub fn matrix(&self) -> Matrix3<f64> {
        self.tensor
    }

    /// J v.
    pub fn times(&self, v: Vector<Body, f64>) -> Vector<Body, f64> {
        Vector::from_xyz(self.tensor * v.xyz)
    }

    /// The kinetic energy of turning at ω, J (joule): ½ ω · J ω.
    pub fn kinetic_energy_j(&self, omega_bi: Vector<Body, f64>) -> f64 {
        0.5 * omega_bi.dot(&self.times(omega_bi))
    }
}

/// Attitude and rate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Motion {
    attitude: Quaternion<f64>,
    /// Rate of Body relative to Eci, Body, rad/s.
    pub omega_bi: Vector<Body, f64>,
}

impl Motion {
    /// Starts with attitude and rate.
    pub fn new(r_bi: Rotation<Body, Eci, f64>, omega_bi: Vector<Body, f64>) -> Self {
        Self { attitude: r_bi.hamilton().conjugate().into_inner(), omega_bi }
    }

    /// The attitude: `v_b = r_bi * v_i`.
    pub fn r_bi(&self) -> Rotation<Body, Eci, f64> {
        Rotation::from_hamilton(Unit::new_normalize(self.attitude).conjugate())
    }

    fn derivative(&self, inertia: &Inertia, torque: Vector<Body, f64>) -> Derivative {
        let omega = self.omega_bi;
        let momentum = inertia.times(omega);
        Derivative {
            // q̇ = ½ q ⊗ (ω, 0)
            attitude: self.attitude * Quaternion::from_imag(omega.xyz) * 0.5,
            // ω̇ = J⁻¹ (T − ω × J ω)
            omega: inertia.inverse * (torque - omega.cross(&momentum)).xyz,
        }
    }

    fn moved(&self, slope: &Derivative, dt_s: f64) -> Self {
        Self {
            attitude: self.attitude + slope.attitude * dt_s,
            omega_bi: Vector::from_xyz(self.omega_bi.xyz + slope.omega * dt_s),
        }
    }

    /// The motion `dt_s` seconds later by the classical fourth-order Runge–Kutta rule.
    ///
    /// `torque(stage, motion)` is the torque (Body, N·m) at the start ([`Stage::Start`]), the
    /// middle or the end of the step, with the motion assumed there.
    #[must_use]
    pub fn stepped(
        &self,
        inertia: &Inertia,
        dt_s: f64,
        mut torque: impl FnMut(Stage, &Self) -> Vector<Body, f64>,
    ) -> Self {
        let k1 = self.derivative(inertia, torque(Stage::Start, self));
        let at_2 = self.moved(&k1, dt_s / 2.0);
        let k2 = at_2.derivative(inertia, torque(Stage::Middle, &at_2));
        let at_3 = self.moved(&k2, dt_s / 2.0);
        let k3 = at_3.derivative(inertia, torque(Stage::Middle, &at_3));
        let at_4 = self.moved(&k3, dt_s);
        let k4 = at_4.derivative(inertia, torque(Stage::End, &at_4));
        let slope = Derivative {
            attitude: (k1.attitude + (k2.attitude + k3.attitude) * 2.0 + k4.attitude) / 6.0,
            omega: (k1.omega + (k2.omega + k3.omega) * 2.0 + k4.omega) / 6.0,
        };
        let mut next = self.moved(&slope, dt_s);
        next.attitude = Unit::new_normalize(next.attitude).into_inner();
        next
    }
}

/// Where within a step a torque is asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stage {
    /// At its start.
    Start,
    /// Half way.
    Middle,
    /// At its end.
    End,
}

struct Derivative {
    attitude: Quaternion<f64>,
    omega: Vector3<f64>,
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;

    /// SPROUT's assumed tensor, preset A2.
    const A2: [[f64; 3]; 3] =
        [[0.05184, 0.00058, -0.00077], [0.00058, 0.05416, 0.00069], [-0.00077, 0.00069, 0.05978]];
    const STEP_S: f64 = 0.1;

    fn tumble() -> Motion {
        Motion::new(Rotation::identity(), Vector::new(0.06, 0.03, 0.14))
    }

    #[test]
    fn a_free_tumble_keeps_energy_and_inertial_momentum_for_an_hour() {
        // RK4 at 0.1 s and 9 deg/s: the local error is (0.16 · 0.1)^5/120 per step.
        const RELATIVE: f64 = 1e-9;
        let inertia = Inertia::new(A2).unwrap();
        let start = tumble();
        let mut motion = start;
        for _ in 0..36_000 {
            motion = motion.stepped(&inertia, STEP_S, |_, _| Vector::zero());
        }
        let energy = inertia.kinetic_energy_j(start.omega_bi);
        assert!((inertia.kinetic_energy_j(motion.omega_bi) / energy - 1.0).abs() < RELATIVE);
        let momentum = |m: &Motion| m.r_bi().inverse() * inertia.times(m.omega_bi);
        let drift = momentum(&motion) - momentum(&start);
        assert!(drift.norm() < 100.0 * RELATIVE * momentum(&start).norm(), "{drift:?}");
    }

    #[test]
    fn a_constant_torque_about_a_principal_axis_gives_the_textbook_spin() {
        let inertia = Inertia::new([[0.05, 0.0, 0.0], [0.0, 0.06, 0.0], [0.0, 0.0, 0.07]]).unwrap();
        let mut motion = Motion::new(Rotation::identity(), Vector::zero());
        for _ in 0..1000 {
            motion = motion.stepped(&inertia, STEP_S, |_, _| Vector::new(0.0, 0.0, 7e-5));
        }
        // ω = T t / J = 0.1 rad/s, angle = ½ T t² / J = 5 rad.
        assert!((motion.omega_bi.xyz.z - 0.1).abs() < 1e-12);
        let expected: Rotation<Body, Eci, f64> =
            Rotation::from_attitude_quaternion([0.0, 0.0, libm::sin(2.5), libm::cos(2.5)]).unwrap();
        assert!((motion.r_bi() * expected.inverse()).angle_rad() < 1e-9);
    }

    #[test]
    fn impossible_tensors_are_refused_and_said_why() {
        let diagonal = |a, b, c| Inertia::new([[a, 0.0, 0.0], [0.0, b, 0.0], [0.0, 0.0, c]]);
        assert!(matches!(diagonal(0.05, -0.05, 0.05), Err(InertiaError::NotPositive { .. })));
        assert!(matches!(diagonal(0.02, 0.02, 0.05), Err(InertiaError::Triangle { .. })));
        assert!(matches!(diagonal(0.02, f64::NAN, 0.05), Err(InertiaError::NotFinite)));
        let mut skewed = A2;
        skewed[0][2] = 0.001;
        assert_eq!(Inertia::new(skewed), Err(InertiaError::NotSymmetric { row: 0, column: 2 }));
    }
}
