//! One round's decision: by what law, and what the torquers can do of it.

use super::Steering;
use super::decision::{ControlStatus, Decision};
use super::known::Known;
use super::law::Law;
use super::residual::Residual;
use crate::attitude::field_slope::FieldSlope;
use crate::control::allocation::Allocation;
use crate::control::guidance::SlewState;
use crate::time::Utc;

/// One round's decision in the making.
pub(super) struct Deciding<'a> {
    pub steering: &'a Steering,
    pub allocation: &'a Allocation,
    pub known: &'a Known<'a>,
    pub residual: Option<Residual>,
    pub slope: &'a FieldSlope,
    pub slew: &'a mut SlewState,
    pub now: Utc,
}

impl Deciding<'_> {
    /// The law's dipole, brought within what the torquers can do. Whatever is missing switches them off
    /// for the round.
    pub fn decide(&mut self, law: &Law) -> Decision {
        match law {
            Law::Off => Decision::off(ControlStatus::Off),
            Law::BDot(law) => self.despin(|omega_bi, field_b| law.dipole(omega_bi, field_b)),
            Law::BangBang(law) => self.despin(|omega_bi, field_b| {
                let along = |v| self.allocation.to_torquers(v);
                let dipole = law.dipole(along(omega_bi), along(field_b))?;
                Some(self.allocation.to_body(dipole))
            }),
            Law::Pointing(pointing) => self.point(pointing),
        }
    }
}
