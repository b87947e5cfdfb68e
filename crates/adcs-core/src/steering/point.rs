//! A round of a pointing law: by plan, or by the cross-product law while there is none.

use nalgebra::convert;

use super::deciding::Deciding;
use super::decision::{ControlStatus, Decision};
use super::known::Known;
use super::law::Pointing;
use crate::control::allocation::Saturation;
use crate::control::cross_product::{self, Gravity, PointingError};
use crate::control::feed_forward;
use crate::control::guidance::{Goal, Scene};
use crate::control::periodic::{Motion, PeriodicLaw};
use crate::environment::earth::MU_M3_S2;
use crate::frames::{Eci, Rotation, Vector};
use crate::orbit::OrbitState;
use crate::reading::Reading;

impl Deciding<'_> {
    pub(super) fn point(&mut self, pointing: &Pointing) -> Decision {
        let Pointing { law, periodic, guidance } = pointing;
        let believed = self.known.determination.and_then(|it| it.attitude.zip(it.rate));
        let Some((attitude, rate)) = believed else {
            return Decision::off(ControlStatus::NoAttitude);
        };
        let Known { orbit, sun, .. } = *self.known;
        let Some(goal) = guidance.aim.goal(&Scene { now: self.now, orbit, sun }) else {
            return Decision::off(ControlStatus::NoTarget);
        };
        let error_rad = Some((attitude.r_bi * goal.r_ti.inverse()).angle_rad());
        if let Some(planned) = periodic.as_ref().and_then(|law| self.planned(law, &goal)) {
            return Decision { error_rad, ..planned };
        }
        let field_b = match self.known.field_b {
            Reading::Missing(reason) => {
                return Decision { error_rad, ..Decision::off(ControlStatus::NoField(reason)) };
            }
            Reading::Fresh(field_b) => field_b,
        };
        let asked = match &guidance.slew {
            Some(slew) => slew.towards(self.slew, self.now, attitude.r_bi, &goal),
            None => goal,
        };
        let residual = self.residual;
        let ripple = residual.map_or(Vector::zero(), |it| {
            feed_forward::ripple(it.dipole, field_b, law.inertia_kg_m2(), &self.steering.round)
        });
        let omega_bi = rate.omega_bi - ripple;
        let gravity = orbit.and_then(|orbit| gravity(orbit, attitude.r_bi));
        let error = PointingError::new(attitude.r_bi, omega_bi, &asked);
        let torque = law.desired_torque(&error, omega_bi, gravity.as_ref());
        match cross_product::dipole(torque, field_b) {
            None => Decision { error_rad, ..Decision::off(ControlStatus::NoDipole) },
            Some(wanted) => {
                let fed = residual.map_or(Vector::zero(), |it| it.fed);
                let command = self.allocation.command_beside(fed, wanted, Saturation::ScaleAll);
                let control = match periodic {
                    Some(_) => ControlStatus::Unplanned,
                    None => ControlStatus::Acting,
                };
                Decision { error_rad, control, ..Decision::acting(command) }
            }
        }
    }

    /// The command of the law that plans; `None` without a plan, or without the field's model.
    fn planned(&self, law: &PeriodicLaw, goal: &Goal) -> Option<Decision> {
        let Known { orbit, determination, reference_field, gains, .. } = *self.known;
        let (gains, determination) = (gains?, determination?);
        let (r_bi, rate) = (determination.attitude?.r_bi, determination.rate?);
        let (round, inertia) = (&self.steering.round, law.inertia_kg_m2());
        let r_bt = r_bi * goal.r_ti.inverse();
        let r_tb = r_bt.inverse();
        let field = goal.r_ti * reference_field?;

        let residual = self.residual;
        let ripple = residual.map_or(Vector::zero(), |it| {
            feed_forward::ripple(it.dipole, r_bt * field, inertia, round)
        });
        let error = PointingError::new(r_bi, rate.omega_bi - ripple, goal);
        // What is known to turn the satellite: what stage II found, and on target what its unequal
        // moments make of gravity and of the target's own turn. Where stage II has learned the inertia,
        // its torque is what that leaves.
        let found = determination.dynamic.estimate.as_ref().filter(|it| it.trusted);
        let inertia = found.map_or(inertia, |estimate| &estimate.inertia_kg_m2);
        let found = found.map_or(Vector::zero(), |estimate| r_tb * estimate.torque);
        let omega = goal.omega_ti.xyz;
        let gyroscopic = Vector::from_xyz(-omega.cross(&(inertia * omega)));
        let pulled = orbit.and_then(|orbit| gravity(orbit, goal.r_ti)).map(|it| it.torque(inertia));
        let torque = found + gyroscopic + pulled.unwrap_or(Vector::zero());
        let motion = Motion { attitude: error.attitude.relabel(), rate: r_tb * error.rate, torque };

        let cycle_s = round.on_s + round.off_s;
        let mean = law.dipole(&gains, &motion, field, cycle_s)?;
        let wanted = r_bt * mean * round.inverse_duty();
        let fed = residual.map_or(Vector::zero(), |it| it.fed);
        let command = self.allocation.command_beside(fed, wanted, Saturation::ScaleAll);
        Some(Decision::acting(command))
    }
}

/// Where the Earth is in the axes that `rotation` leads to.
fn gravity<F>(orbit: &OrbitState, rotation: Rotation<F, Eci>) -> Option<Gravity<F>> {
    let up = (rotation * orbit.position.to_f32()).direction()?.vector();
    let r = orbit.position.norm();
    Some(Gravity { up, gradient: convert(3.0 * MU_M3_S2 / (r * r * r)) })
}
