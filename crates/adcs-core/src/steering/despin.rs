//! A round of a despin law: from which rate, and for how long the command is of use.

use super::RateFrom;
use super::deciding::Deciding;
use super::decision::{ControlStatus, Decision};
use crate::control::allocation::{Command, Saturation};
use crate::control::hold;
use crate::frames::{Body, Vector};
use crate::reading::{MissingReason, Reading};

impl Deciding<'_> {
    pub(super) fn despin(
        &self,
        law: impl FnOnce(Vector<Body>, Vector<Body>) -> Option<Vector<Body>>,
    ) -> Decision {
        let (omega_bi, field_b) = match (self.rate(), self.known.field_b) {
            (Reading::Missing(reason), _) => return Decision::off(ControlStatus::NoRate(reason)),
            (_, Reading::Missing(reason)) => return Decision::off(ControlStatus::NoField(reason)),
            (Reading::Fresh(omega_bi), Reading::Fresh(field_b)) => (omega_bi, field_b),
        };
        let Some(wanted) = law(omega_bi, field_b) else {
            return Decision::off(ControlStatus::NoDipole);
        };
        let fed = self.residual.map(|it| it.fed);
        let command = self.clipped(fed, wanted);
        let useful = self.steering.cut_hold.then(|| {
            // What is fed forward stands against M, which turns along: it never grows stale.
            let fed = fed.map_or(Vector::zero(), |fed| self.allocation.command(fed).dipole);
            let share = self.allocation.to_body(command.dipole - fed);
            (self.now, hold::useful_s(share, omega_bi, field_b))
        });
        Decision { useful, ..Decision::acting(command) }
    }

    fn clipped(&self, fed: Option<Vector<Body>>, wanted: Vector<Body>) -> Command {
        match fed {
            Some(fed) => self.allocation.command_beside(fed, wanted, Saturation::ClipAxes),
            None => self.allocation.command(wanted),
        }
    }

    /// The rate that despin works with. From the gyro, and when it is silent what stage II makes of the
    /// dynamics or of the field alone; or always from the field.
    fn rate(&self) -> Reading<Vector<Body>> {
        match self.steering.rate {
            RateFrom::Gyro | RateFrom::Estimate => {
                let believed = self.known.determination.and_then(|it| it.rate);
                let measured = self.known.omega_bi;
                let is_wanted =
                    self.steering.rate == RateFrom::Estimate || measured.missing().is_some();
                match believed.filter(|_| is_wanted) {
                    Some(rate) => Reading::Fresh(rate.omega_bi),
                    None => measured,
                }
            }
            RateFrom::Field => match self.slope.rate() {
                Some(rate) => Reading::Fresh(rate.omega_bi),
                // Too few of them while the torquers rested, unless this one says why it is missing.
                None => Reading::Missing(
                    self.known.field_b.missing().unwrap_or(MissingReason::TorquersOn),
                ),
            },
        }
    }
}
