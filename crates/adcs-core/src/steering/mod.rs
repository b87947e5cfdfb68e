//! Stage III in the cycle: which law, from which rate, beside which feed-forward, and for how long.
//!
//! | module | has |
//! |---|---|
//! | `law` | the laws that there are, and what the pointing laws need |
//! | `known` | what stages I and II and the sensors say |
//! | `deciding` | one round: the law is asked |
//! | `despin`, `point` | the same for each kind of law |
//! | `residual` | the residual dipole that is fed forward |
//! | `decision` | what comes out, and how long it is of use |
//!
//! A command is decided once a round, at the end of the rest, and held through the action.

mod deciding;
mod decision;
mod despin;
mod known;
mod law;
mod point;
mod residual;

use serde::{Deserialize, Serialize};

use crate::attitude::field_slope::FieldSlope;
use crate::control::allocation::Allocation;
use crate::control::feed_forward::FeedForward;
use crate::control::guidance::SlewState;
use crate::schedule::{Phase, Round};
use crate::time::Utc;

use self::deciding::Deciding;
use self::residual::LastTrusted;

pub use self::decision::{ControlStatus, Decision};
pub use self::known::Known;
pub use self::law::{Law, Pointing};

/// From what the despin laws take the rate.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum RateFrom {
    /// The gyros, and while they are silent what stage II has instead.
    #[default]
    Gyro,
    /// The turning of the field during the rest, without gyros.
    Field,
    /// What stage II believes, and the gyros while it believes nothing.
    Estimate,
}

/// What surrounds every law, as stored and uplinked. `Default` is none of it.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct SteeringParameters {
    /// From what the despin laws take the rate.
    pub rate: RateFrom,
    /// Whether a despin command is switched off when it would begin to drive the spin.
    pub cut_hold: bool,
    /// Largest σ of the residual dipole with which it is fed forward, A·m²; `None` never to do so.
    pub feed_forward_sigma_am2: Option<f32>,
}

/// What surrounds every law.
#[derive(Debug, Clone, Copy)]
pub struct Steering {
    /// From what the despin laws take the rate.
    pub rate: RateFrom,
    /// Whether a despin command is switched off when it would begin to drive the spin.
    pub cut_hold: bool,
    /// The residual dipole's feed-forward.
    pub feed_forward: Option<FeedForward>,
    /// Action and rest.
    pub round: Round,
}

/// What one cycle leaves for the next. `Default` is power-on.
#[derive(Debug, Clone, Copy, Default)]
pub struct SteeringState {
    held: Decision,
    slope: FieldSlope,
    slew: SlewState,
    residual: LastTrusted,
    last: Option<Utc>,
    error_rad: Option<f32>,
}

impl SteeringState {
    /// Drops what was decided by a law that flies no longer: torquers off until the next round.
    pub fn interrupt(&mut self) {
        self.held = Decision::default();
        self.slew = SlewState::default();
        self.error_rad = None;
    }

    /// Angle from Body to the target, rad, as it was last decided upon.
    pub fn error_rad(&self) -> Option<f32> {
        self.error_rad
    }

    /// Stage III of one cycle.
    pub fn cycle(
        &mut self,
        law: &Law,
        steering: &Steering,
        allocation: &Allocation,
        (now, phase): (Utc, Phase),
        known: &Known<'_>,
    ) -> Decision {
        if steering.rate == RateFrom::Field {
            let dt_s = self.last.map_or(0.0, |last| now.seconds_since(last) as f32);
            let settled = matches!(phase, Phase::Settled | Phase::Measuring);
            self.slope.cycle(settled, known.field_b.value(), dt_s);
        }
        self.last = Some(now);
        self.held = match phase {
            Phase::Settling | Phase::Settled => Decision::default(),
            Phase::Measuring => {
                let residual = self.residual.residual(steering, known, now);
                let Self { slope, slew, .. } = self;
                let mut round =
                    Deciding { steering, allocation, known, residual, slope, slew, now };
                let decision = round.decide(law).still(now);
                self.error_rad = decision.error_rad;
                decision
            }
            Phase::Acting => self.held.still(now),
        };
        self.held
    }
}
