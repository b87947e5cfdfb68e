//! What stage III has decided, and if it is nothing, why.

use serde::{Deserialize, Serialize};

use crate::control::allocation::Command;
use crate::reading::MissingReason;
use crate::time::Utc;

/// What stage III did, and if nothing, why.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ControlStatus {
    /// No law is selected.
    Off,
    /// The schedule lets the field settle.
    Resting,
    /// The torquers carry the command of this round.
    Acting,
    /// They do, but there is no plan: it is the command of the law that needs none.
    Unplanned,
    /// The rate was missing when it was needed; off until the next round.
    NoRate(MissingReason),
    /// The field was missing when it was needed; off until the next round.
    NoField(MissingReason),
    /// The law gave no finite dipole; off until the next round.
    NoDipole,
    /// No attitude, or no rate with it, was believed when it was needed; off until the next round.
    NoAttitude,
    /// The aim needs an orbit or the Sun, and there was none; off until the next round.
    NoTarget,
    /// The satellite has turned so far that the command would drive it; off until the next round.
    Spent,
}

/// The outcome of stage III, held until the round ends.
#[derive(Debug, Clone, Copy)]
pub struct Decision {
    /// What was done, and if nothing, why.
    pub control: ControlStatus,
    /// What the torquers are asked for.
    pub command: Command,
    /// When it was decided, and for how long it is of use, s.
    pub(super) useful: Option<(Utc, f32)>,
    /// Angle from Body to the target, rad, when it was decided; `None` when no attitude is aimed at.
    pub error_rad: Option<f32>,
}

impl Decision {
    pub(super) fn off(control: ControlStatus) -> Self {
        Self { control, command: Command::off(), useful: None, error_rad: None }
    }

    pub(crate) fn acting(command: Command) -> Self {
        Self { control: ControlStatus::Acting, command, useful: None, error_rad: None }
    }

    /// The command as long as it is of use.
    pub(super) fn still(self, now: Utc) -> Self {
        match self.useful {
            Some((since, useful_s)) if now.seconds_since(since) as f32 >= useful_s => {
                Self { error_rad: self.error_rad, ..Self::off(ControlStatus::Spent) }
            }
            _ => self,
        }
    }
}

impl Default for Decision {
    fn default() -> Self {
        Self::off(ControlStatus::Resting)
    }
}
