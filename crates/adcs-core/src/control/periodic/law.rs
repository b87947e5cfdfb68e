//! From the gains of the moment to a dipole.

use nalgebra::{Matrix3, RealField};

use super::model::Model;
use super::parameters::{PeriodicError, PeriodicParameters};
use super::sweep::Gains;
use crate::frames::{Target, Vector};

/// How far the satellite is from where it should be, in the target's axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Motion<T: RealField + Copy = f32> {
    /// e = 2 q_v, for small angles the rotation vector from target to Body, rad.
    pub attitude: Vector<Target, T>,
    /// Rate of Body relative to the target, rad/s.
    pub rate: Vector<Target, T>,
    /// Torque that is known, N·m.
    pub torque: Vector<Target, T>,
}

/// The law with accepted parameters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PeriodicLaw<T = f32> {
    pub(super) model: Model<T>,
    pub(super) step_s: T,
    pub(super) horizon_s: T,
    inertia: Matrix3<T>,
}

impl<T: RealField + Copy> PeriodicLaw<T> {
    /// Accepts parameters.
    ///
    /// # Errors
    /// [`PeriodicError`] with the parameter, its value and its range.
    pub fn new(parameters: &PeriodicParameters<T>) -> Result<Self, PeriodicError> {
        let [inertia, inverse_inertia] = parameters.check()?;
        let model = Model {
            attitude: parameters.attitude_weight_rad,
            rate: parameters.rate_weight_rad_s,
            dipole: parameters.dipole_weight_am2,
            inverse_inertia,
        };
        let PeriodicParameters { step_s, horizon_s, .. } = *parameters;
        Ok(Self { model, step_s, horizon_s, inertia })
    }

    /// Step of the sweep, s.
    pub fn step_s(&self) -> T {
        self.step_s
    }

    /// J, Body, kg·m².
    pub fn inertia_kg_m2(&self) -> &Matrix3<T> {
        &self.inertia
    }

    /// m: the mean dipole over a round of `round_s`, in the target's axes, A·m², not yet limited. `field`
    /// is that of the model. `None` when something is not finite.
    pub fn dipole(
        &self,
        gains: &Gains<T>,
        motion: &Motion<T>,
        field: Vector<Target, T>,
        round_s: T,
    ) -> Option<Vector<Target, T>> {
        let Model { attitude, rate, dipole, .. } = self.model;
        let v = self.model.influence(field);
        let slope = gains.attitude * (motion.attitude.xyz / attitude)
            + gains.rate * (motion.rate.xyz / rate)
            + gains.torque * motion.torque.xyz;
        let effort = Matrix3::identity() + v.tr_mul(&(gains.rate * v)) * round_s;
        let wanted = effort.try_inverse()? * v.tr_mul(&slope) * -dipole;
        let wanted = Vector::from_xyz(wanted);
        wanted.is_finite().then_some(wanted)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    fn law() -> PeriodicLaw<f64> {
        PeriodicLaw::new(&PeriodicParameters::default()).unwrap()
    }

    /// What a stiff sweep gives about: a quarter of an hour of rate.
    fn gains() -> Gains<f64> {
        let one = Matrix3::identity();
        Gains { attitude: one * 300.0, rate: one * 2000.0, torque: one * 3e9 }
    }

    fn motion(attitude: [f64; 3], rate: [f64; 3], torque: [f64; 3]) -> Motion<f64> {
        let of = |v| Vector::from_xyz(Vector3::from(v));
        Motion { attitude: of(attitude), rate: of(rate), torque: of(torque) }
    }

    const FIELD: [f64; 3] = [2e-5, -1e-5, 3e-5];

    fn torque(motion: &Motion<f64>) -> Vector3<f64> {
        let field = Vector::from_xyz(Vector3::from(FIELD));
        let dipole = law().dipole(&gains(), motion, field, 7.5).unwrap();
        dipole.xyz.cross(&field.xyz)
    }

    #[test]
    fn it_pushes_back_and_brakes_across_the_field_and_against_a_known_torque() {
        // Across the field.
        let across = Vector3::from(FIELD).cross(&Vector3::x()).normalize();
        let push = |v: Vector3<f64>| [v.x, v.y, v.z];
        let off = torque(&motion(push(across * 0.1), [0.0; 3], [0.0; 3]));
        assert!(off.dot(&across) < 0.0);
        let turning = torque(&motion([0.0; 3], push(across * 1e-3), [0.0; 3]));
        assert!(turning.dot(&across) < 0.0);
        let pushed = torque(&motion([0.0; 3], [0.0; 3], push(across * 1e-7)));
        assert!(pushed.dot(&across) < 0.0);
    }

    #[test]
    fn on_target_it_does_nothing() {
        assert_eq!(torque(&motion([0.0; 3], [0.0; 3], [0.0; 3])), Vector3::zeros());
    }

    #[test]
    fn what_is_not_finite_gives_no_dipole() {
        let field = Vector::from_xyz(Vector3::from(FIELD));
        for bad in [f64::NAN, f64::INFINITY, 1e308] {
            let motion = motion([bad, 0.0, 0.0], [0.0, bad, 0.0], [0.0; 3]);
            assert_eq!(law().dipole(&gains(), &motion, field, 7.5), None);
        }
        let motion = motion([0.1, 0.0, 0.0], [0.0; 3], [0.0; 3]);
        let nowhere = Vector::new(f64::NAN, 0.0, 0.0);
        assert_eq!(law().dipole(&gains(), &motion, nowhere, 7.5), None);
        let none = law().dipole(&gains(), &motion, Vector::zero(), 7.5).unwrap();
        assert_eq!(none, Vector::zero(), "no field, no dipole");
    }
}
