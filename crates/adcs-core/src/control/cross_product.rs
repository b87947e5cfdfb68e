//! The cross-product law: an attitude held with magnets alone.
//!
//! ```text
//! e   = 2 q_v                                   error, Body, rad for small angles
//! u   = −K_p e − K_d ω_e [+ ω × J ω − T_gg]     torque that is wanted, Body
//! m   = (B × u) / |B|²                          dipole
//! m × B = u − b̂ (b̂ · u)                         torque that comes out: u across the field
//! ```
//!
//! | symbol | code | meaning |
//! |---|---|---|
//! | q_v | | vector part of the attitude quaternion of Body against the target, q_w ≥ 0 |
//! | e, ω_e | [`PointingError`] | error of attitude and of rate, Body |
//! | K_p, K_d | [`CrossProductParameters`] | gains, N·m/rad and N·m·s |
//! | J | `inertia_kg_m2` | inertia tensor, Body, kg·m² |
//! | T_gg | [`Gravity`] | gravity-gradient torque 3μ/r³ r̂ × J r̂, Body |
//! | B | `field` | flux density, Body, T |
//!
//! The turn from target to Body leaves its own axis where it is, so q_v has the same components in
//! both frames; with scalar gains it does not matter either in which frame u is composed.
//!
//! | case | what happens |
//! |---|---|
//! | no field, or something not finite | no dipole; the torquers stay off |
//! | u along the field | the dipole vanishes: there is nothing a magnet can do at that instant |
//! | 180 deg off | \|e\| is 2, its largest; e vanishes nowhere but on target, so no wrong attitude is at rest. At exactly 180 deg both ways round are equally long and the sign of q_w takes one |
//!
//! **Gains.** Across the field the loop is a spring with √(K_p / J). Along the field it has no torque
//! at all and waits until the field has turned, so it must be slower than the field turns, twice a
//! revolution: a high gain pins two axes and the third, the angle φ about the field, runs away,
//! φ̈ + (K_d/K_p) |ḃ|² φ̇ − |ḃ|² φ = 0. For SPROUT (0.055 kg·m², 615 km) that happens between 2e-7 and
//! 3e-7 N·m/rad.
//!
//! Source: Markley & Crassidis (2014), §7.5.1 (m = B × u / |B|²) and eq. (7.7) (quaternion feedback).

use core::fmt;

use nalgebra::{Matrix3, RealField, convert};
use serde::{Deserialize, Serialize};

use super::guidance::Goal;
use crate::frames::{Body, Eci, Rotation, Vector};
use crate::parameter;

/// Fields weaker than this are no geomagnetic field anywhere in low orbit, T.
const WEAKEST_FIELD_T: f64 = 1e-6;

/// The law as stored and uplinked.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct CrossProductParameters<T = f32> {
    /// K_p, N·m/rad.
    pub stiffness_n_m_per_rad: T,
    /// K_d, N·m·s.
    pub damping_n_m_s: T,
    /// J, Body, kg·m²: for the terms below, and for the rate's ripple under feed-forward.
    pub inertia_kg_m2: [[T; 3]; 3],
    /// Adds ω × J ω, which cancels the gyroscopic torque.
    pub gyroscopic: bool,
    /// Subtracts the gravity-gradient torque.
    pub gravity_gradient: bool,
}

/// Why the law is refused.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum CrossProductError<T = f32> {
    /// K_p must be positive (a negative one turns away from the target) and finite.
    Stiffness {
        /// What was given, N·m/rad.
        found: T,
    },
    /// K_d must be positive (a negative one spins the satellite up) and finite.
    Damping {
        /// What was given, N·m·s.
        found: T,
    },
    /// No body has this inertia tensor: not symmetric, or a principal moment is not positive.
    Inertia,
}

impl<T: fmt::Display> fmt::Display for CrossProductError<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Stiffness { found } => {
                write!(f, "the stiffness {found} N·m/rad must be positive and finite")
            }
            Self::Damping { found } => {
                write!(f, "the damping {found} N·m·s must be positive and finite")
            }
            Self::Inertia => {
                write!(f, "the inertia tensor must be symmetric with positive principal moments")
            }
        }
    }
}

impl<T: fmt::Debug + fmt::Display> core::error::Error for CrossProductError<T> {}

/// How far the satellite is from where it should be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PointingError<T: RealField + Copy = f32> {
    /// e = 2 q_v, Body; for small angles the rotation vector from target to Body, rad.
    pub attitude: Vector<Body, T>,
    /// ω_e = ω_bi − R_bt ω_ti: rate of Body relative to the target, Body, rad/s.
    pub rate: Vector<Body, T>,
}

impl<T: RealField + Copy> PointingError<T> {
    /// The error of an attitude and a rate (Body relative to Eci, Body, rad/s) against the goal.
    pub fn new(r_bi: Rotation<Body, Eci, T>, omega_bi: Vector<Body, T>, goal: &Goal<T>) -> Self {
        let r_bt = r_bi * goal.r_ti.inverse();
        let [x, y, z, _] = r_bt.attitude_quaternion();
        let two: T = convert(2.0);
        Self { attitude: Vector::new(x, y, z) * two, rate: omega_bi - r_bt * goal.omega_ti }
    }
}

/// Where the Earth's centre is, as far as the gravity gradient is concerned, in the axes F.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gravity<F = Body, T: RealField + Copy = f32> {
    /// Unit vector from the Earth's centre to the satellite.
    pub up: Vector<F, T>,
    /// 3 μ / r³, 1/s².
    pub gradient: T,
}

impl<F, T: RealField + Copy> Gravity<F, T> {
    /// T_gg of a body with this tensor in the same axes, N·m.
    pub fn torque(&self, inertia_kg_m2: &Matrix3<T>) -> Vector<F, T> {
        let up = &self.up.xyz;
        Vector::from_xyz(up.cross(&(inertia_kg_m2 * up)) * self.gradient)
    }
}

/// The law with accepted parameters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CrossProduct<T = f32> {
    stiffness: T,
    damping: T,
    inertia: Matrix3<T>,
    gyroscopic: bool,
    gravity_gradient: bool,
}

impl<T: RealField + Copy> CrossProduct<T> {
    /// Accepts gains and inertia.
    ///
    /// # Errors
    /// [`CrossProductError`] with the value.
    pub fn new(parameters: &CrossProductParameters<T>) -> Result<Self, CrossProductError<T>> {
        let positive = |x: T| x.is_finite() && x > T::zero();
        let (stiffness, damping) = (parameters.stiffness_n_m_per_rad, parameters.damping_n_m_s);
        if !positive(stiffness) {
            return Err(CrossProductError::Stiffness { found: stiffness });
        }
        if !positive(damping) {
            return Err(CrossProductError::Damping { found: damping });
        }
        let [inertia, _] =
            parameter::inertia(parameters.inertia_kg_m2).ok_or(CrossProductError::Inertia)?;
        Ok(Self {
            stiffness,
            damping,
            inertia,
            gyroscopic: parameters.gyroscopic,
            gravity_gradient: parameters.gravity_gradient,
        })
    }

    /// J, Body, kg·m².
    pub fn inertia_kg_m2(&self) -> &Matrix3<T> {
        &self.inertia
    }

    /// u: the torque that is wanted, Body, N·m. `omega_bi` is the rate against Eci; without `gravity`
    /// its torque is not subtracted.
    pub fn desired_torque(
        &self,
        error: &PointingError<T>,
        omega_bi: Vector<Body, T>,
        gravity: Option<&Gravity<Body, T>>,
    ) -> Vector<Body, T> {
        let mut torque = -(error.attitude.xyz * self.stiffness + error.rate.xyz * self.damping);
        if self.gyroscopic {
            torque += omega_bi.xyz.cross(&(self.inertia * omega_bi.xyz));
        }
        if let Some(gravity) = gravity.filter(|_| self.gravity_gradient) {
            torque -= gravity.torque(&self.inertia).xyz;
        }
        Vector::from_xyz(torque)
    }
}

/// The smallest dipole that gives the part of a torque (Body, N·m) across the field (Body, T):
/// m = (B × u) / |B|², Body, A·m², not yet limited. `None` when there is no field or something is not
/// finite.
pub fn dipole<T: RealField + Copy>(
    torque: Vector<Body, T>,
    field: Vector<Body, T>,
) -> Option<Vector<Body, T>> {
    let norm = field.norm();
    // In this order a strong field does not overflow, and a weak one is none.
    let strong = norm.is_finite() && norm >= convert(WEAKEST_FIELD_T);
    let along = strong.then(|| field * (T::one() / norm))?;
    let dipole = along.cross(&torque) * (T::one() / norm);
    dipole.is_finite().then_some(dipole)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frames::Target;
    use nalgebra::{UnitQuaternion, Vector3};
    use proptest::prelude::*;

    const INERTIA: [[f64; 3]; 3] =
        [[0.05184, 0.00058, -0.00077], [0.00058, 0.05416, 0.00069], [-0.00077, 0.00069, 0.05978]];
    const PARAMETERS: CrossProductParameters<f64> = CrossProductParameters {
        stiffness_n_m_per_rad: 2e-7,
        damping_n_m_s: 3e-4,
        inertia_kg_m2: INERTIA,
        gyroscopic: false,
        gravity_gradient: false,
    };

    fn goal() -> Goal<f64> {
        Goal { r_ti: Rotation::identity(), omega_ti: Vector::zero() }
    }

    /// The attitude after a turn of the body by this rotation vector from the target.
    fn turned(by: Vector3<f64>) -> Rotation<Body, Eci, f64> {
        Rotation::from_hamilton(UnitQuaternion::from_scaled_axis(-by))
    }

    fn component() -> impl Strategy<Value = f64> {
        -1.0..1.0_f64
    }

    proptest! {
        #[test]
        fn the_torque_that_comes_out_is_the_wanted_one_across_the_field(
            u in [component(), component(), component()],
            b in [component(), component(), component()],
        ) {
            let (u, b) = (Vector3::from(u) * 1e-6, Vector3::from(b) * 5e-5);
            prop_assume!(b.norm() > 1e-6);
            let m = dipole(Vector::from_xyz(u), Vector::from_xyz(b)).unwrap().xyz;
            let across = u - b * (b.dot(&u) / b.norm_squared());
            // Rounding of two cross products.
            prop_assert!((m.cross(&b) - across).norm() < 1e-21);
            prop_assert!(m.dot(&b).abs() < 1e-21, "no dipole is wasted along the field");
        }

        #[test]
        fn damping_alone_never_adds_energy(
            omega in [component(), component(), component()],
            b in [component(), component(), component()],
        ) {
            let (omega, b) = (Vector3::from(omega) * 0.1, Vector3::from(b) * 5e-5);
            prop_assume!(b.norm() > 1e-6);
            let law = CrossProduct::new(&PARAMETERS).unwrap();
            let error = PointingError { attitude: Vector::zero(), rate: Vector::from_xyz(omega) };
            let u = law.desired_torque(&error, Vector::from_xyz(omega), None);
            let torque = dipole(u, Vector::from_xyz(b)).unwrap().xyz.cross(&b);
            // Rounding of 3e-4 · 0.01.
            prop_assert!(omega.dot(&torque) <= 1e-21);
        }

        #[test]
        fn f32_agrees_with_its_f64_twin(
            turn in [component(), component(), component()],
            omega in [component(), component(), component()],
            b in [component(), component(), component()],
        ) {
            let [turn, omega, b] = [turn, omega, b].map(Vector3::from);
            let (omega, b) = (omega * 0.02, b * 5e-5);
            prop_assume!(b.norm() > 1e-6);
            let law = CrossProduct::new(&PARAMETERS).unwrap();
            let error = PointingError::new(turned(turn), Vector::from_xyz(omega), &goal());
            let double =
                dipole(law.desired_torque(&error, Vector::from_xyz(omega), None), Vector::from_xyz(b));
            let law = CrossProduct::<f32>::new(&CrossProductParameters {
                stiffness_n_m_per_rad: 2e-7,
                damping_n_m_s: 3e-4,
                inertia_kg_m2: INERTIA.map(|row| row.map(|x| x as f32)),
                gyroscopic: false,
                gravity_gradient: false,
            }).unwrap();
            let r_bi = Rotation::from_hamilton(turned(turn).hamilton().cast::<f32>());
            let goal = Goal { r_ti: Rotation::identity(), omega_ti: Vector::zero() };
            let omega: Vector<Body, f64> = Vector::from_xyz(omega);
            let error = PointingError::new(r_bi, omega.to_f32(), &goal);
            let b: Vector<Body, f64> = Vector::from_xyz(b);
            let single =
                dipole(law.desired_torque(&error, omega.to_f32(), None), b.to_f32()).unwrap();
            let scale = (2e-7 * 2.0 + 3e-4 * omega.norm()) / b.norm();
            // A few roundings of 6e-8.
            prop_assert!((single.to_f64() - double.unwrap()).norm() < 1e-6 * scale);
        }
    }

    #[test]
    fn the_error_is_the_turn_from_target_to_body_and_the_torque_turns_back() {
        let by = Vector3::new(0.01, -0.02, 0.005);
        let error = PointingError::new(turned(by), Vector::zero(), &goal());
        // 2 sin(θ/2) against θ: θ³ / 24.
        assert!((error.attitude.xyz - by).norm() < 1e-6);
        let u =
            CrossProduct::new(&PARAMETERS).unwrap().desired_torque(&error, Vector::zero(), None);
        assert!(u.xyz.dot(&by) < 0.0);
    }

    #[test]
    fn a_body_that_turns_with_its_target_has_no_error() {
        let r_ti: Rotation<Target, Eci, f64> =
            Rotation::from_hamilton(UnitQuaternion::from_euler_angles(0.4, -1.0, 2.0));
        let omega_ti = Vector::new(0.0, -1.08e-3, 0.0);
        let goal = Goal { r_ti, omega_ti };
        let r_bt: Rotation<Body, Target, f64> =
            Rotation::from_hamilton(UnitQuaternion::from_euler_angles(0.3, 0.2, 0.1));
        let error = PointingError::new(r_bt * r_ti, r_bt * omega_ti, &goal);
        assert!(error.rate.norm() < 1e-18);
        assert!(error.attitude.norm() > 0.1);
    }

    #[test]
    fn at_180_deg_the_error_is_at_its_largest_and_near_it_the_shorter_way_is_taken() {
        let off = |angle: f64| {
            let r_bi = turned(Vector3::z() * angle);
            PointingError::new(r_bi, Vector::zero(), &goal()).attitude.xyz
        };
        assert!((off(core::f64::consts::PI).norm() - 2.0).abs() < 1e-12);
        assert!(off(3.0).z > 1.9, "back by 3 rad");
        assert!(off(3.3).z < -1.9, "on by 2.98 rad");
    }

    #[test]
    fn the_gyroscopic_and_the_gravity_term_cancel_those_of_eulers_equations() {
        let law = CrossProduct::new(&CrossProductParameters {
            gyroscopic: true,
            gravity_gradient: true,
            ..PARAMETERS
        })
        .unwrap();
        let (omega, up) = (Vector3::new(0.03, -0.05, 0.02), Vector3::new(0.6, 0.0, 0.8));
        let gravity = Gravity { up: Vector::from_xyz(up), gradient: 3.5e-6 };
        let none = PointingError { attitude: Vector::zero(), rate: Vector::zero() };
        let u = law.desired_torque(&none, Vector::from_xyz(omega), Some(&gravity)).xyz;
        let j = Matrix3::from(INERTIA);
        let euler = -omega.cross(&(j * omega)) + up.cross(&(j * up)) * 3.5e-6;
        assert!((u + euler).norm() < 1e-18);
        let without = law.desired_torque(&none, Vector::zero(), None);
        assert_eq!(without, Vector::zero(), "no position, no gravity term");
    }

    #[test]
    fn without_a_field_there_is_no_dipole_and_along_it_none_is_spent() {
        let u = Vector::<Body>::new(1e-6, 0.0, 0.0);
        for bad in [0.0, 1e-7, f32::NAN, f32::INFINITY] {
            assert!(dipole(u, Vector::new(bad, 0.0, 0.0)).is_none());
        }
        assert!(dipole(Vector::new(f32::NAN, 0.0, 0.0), Vector::new(3e-5, 0.0, 0.0)).is_none());
        assert_eq!(dipole(u, Vector::new(3e-5, 0.0, 0.0)), Some(Vector::zero()));
    }

    #[test]
    fn gains_and_tensors_that_make_no_loop_are_refused() {
        for bad in [0.0, -1e-7, f64::NAN, f64::INFINITY] {
            let stiff = CrossProductParameters { stiffness_n_m_per_rad: bad, ..PARAMETERS };
            assert!(CrossProduct::new(&stiff).is_err());
            assert!(
                CrossProduct::new(&CrossProductParameters { damping_n_m_s: bad, ..PARAMETERS })
                    .is_err()
            );
        }
        let mut lopsided = INERTIA;
        lopsided[0][1] = 0.001;
        for inertia_kg_m2 in [[[0.0; 3]; 3], lopsided, [[f64::NAN; 3]; 3]] {
            let law = CrossProduct::new(&CrossProductParameters { inertia_kg_m2, ..PARAMETERS });
            assert_eq!(law, Err(CrossProductError::Inertia));
        }
    }
}
