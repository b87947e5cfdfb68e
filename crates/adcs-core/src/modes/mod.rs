//! Modes: from separation to pointing by itself, and back to safety.
//!
//! ```text
//!  power on ─► start
//!
//!              despun               trusted
//!  ┌─ Detumble ──────► Acquire ─────────────► Point
//!  │   ▲    ▲  ◄──────    │  ◄───────────────  │
//!  │   │       tumbling   │   attitude lost    │        Off    only by command
//!  │   │ recovered        │                    │        Experiment ─► the mode that is named
//!  │   │                  │                    │
//!  └─► Safe ◄─────────────┴────────────────────┘
//!        a sensor silent, torquers that refuse, divergence, a wrong wiring, a time limit
//! ```
//!
//! | mode | torquers | ends by itself |
//! |---|---|---|
//! | [`Off`](Mode::Off) | off | never |
//! | [`Safe`](Mode::Safe) | off | when the sensors have been speaking for long enough, as often as the retries allow; never when it was commanded |
//! | [`Detumble`](Mode::Detumble) | despin law | when the rate has been low for long enough |
//! | [`Acquire`](Mode::Acquire) | despin law on the rate of stage II, residual dipole fed forward | when attitude and residual dipole are trusted and the rate is low |
//! | [`Point`](Mode::Point) | pointing law | when the satellite tumbles or its attitude is lost |
//! | [`Experiment`](Mode::Experiment) | a law of its own | after its time |
//! | [`Commissioning`](Mode::Commissioning) | off, or pulses of one after the other | when every rung of the [ladder](crate::commissioning) is over |
//!
//! What each of these words means is one table of numbers, [`ModeParameters`]. A condition counts when it
//! has held without a break for its time, and what leads back is further out than what led in. In the
//! order in which they are looked at, per cycle: a command, a sensor that is silent, torquers that refuse,
//! divergence, the wiring, a time limit, and only then the way forward. Every transition has a [`Cause`], and a command held over from
//! the mode before is dropped with it.
//!
//! Time is counted from cycle to cycle and no step counts for more than [`LONGEST_STEP_S`], so that
//! setting the clock ends no mode.
//!
//! | module | has |
//! |---|---|
//! | `parameters` | the table, and why one is refused |
//! | `sight` | what the machine sees in a cycle |
//! | `machine` | one cycle, from what is seen to the mode that flies |
//! | `way` | the way from mode to mode while nothing is wrong |
//! | `fault` | silence and divergence, which end a mode |
//! | `watch` | guard, active check and ladder |
//! | `state` | what is remembered, with `lasting` and `growth` |

mod fault;
mod growth;
mod lasting;
mod machine;
mod parameters;
pub(crate) mod sight;
mod state;
mod watch;
mod way;

use core::fmt;

use serde::{Deserialize, Serialize};

use crate::commissioning::Ladder;
use crate::polarity::{ActiveCheck, Guard, Suspect, Undecided};
use crate::steering::{Law, Steering};

pub use parameters::{ModeError, ModeParameters, ModeTable, Needs};
pub use sight::Sight;
pub use state::{LONGEST_STEP_S, ModesState};

/// What the satellite is at.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Mode {
    /// Torquers off until told otherwise.
    Off,
    /// Torquers off after something went wrong, or by command.
    Safe,
    /// The tumble is damped.
    Detumble,
    /// The rest of the tumble is damped while attitude and residual dipole are found.
    Acquire,
    /// An attitude is taken and held.
    Point,
    /// A law of its own for a time of its own, as in the paper's experiments.
    Experiment,
    /// What is wrong with the devices is found out, before a loop is closed.
    Commissioning,
}

impl Mode {
    /// Whether a law flies in it.
    pub fn drives(self) -> bool {
        !matches!(self, Self::Off | Self::Safe)
    }
}

impl fmt::Display for Mode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Off => "off",
            Self::Safe => "safe",
            Self::Detumble => "detumble",
            Self::Acquire => "acquire",
            Self::Point => "point",
            Self::Experiment => "experiment",
            Self::Commissioning => "commissioning",
        })
    }
}

/// A sensor as a mode needs it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Sensor {
    /// The three gyros together.
    Gyro,
    /// The magnetometer.
    Magnetometer,
    /// The Sun sensors together.
    SunSensors,
}

/// Why a mode was entered.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Cause {
    /// The satellite has been switched on.
    PowerOn,
    /// By command.
    Commanded,
    /// The rate has been low for long enough.
    Despun,
    /// Attitude and residual dipole have been trusted, and the rate low, for long enough.
    Trusted,
    /// The rate has been high for long enough.
    Tumbling,
    /// There has been no attitude for too long.
    AttitudeLost,
    /// A sensor that the mode needs has been silent for too long.
    Silent(Sensor),
    /// The rate has been growing, round after round.
    RateGrows,
    /// The pointing error has been growing, round after round, after it had been small.
    ErrorGrows,
    /// The mode has lasted for longer than it may.
    TooLong,
    /// The pointing error did not become small in the time that it has.
    NotCaptured,
    /// The experiment's time is over.
    Over,
    /// The active check has found everything wired as it should be.
    Checked,
    /// Every rung of the commissioning ladder is over.
    Commissioned,
    /// A reset has interrupted commissioning, which goes on.
    Resumed,
    /// The active check could not tell; the guard goes on watching.
    Unchecked(Undecided),
    /// A device is wired wrongly, or torquers are dead: the guard or the active check says so.
    Miswired(Suspect),
    /// The sensors have been speaking for long enough, and there is a retry left.
    Recovered,
    /// The torquers have refused their commands for too long.
    TorquersRefuse,
}

/// One mode follows another.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Transition {
    /// What was left.
    pub from: Mode,
    /// What was entered.
    pub to: Mode,
    /// Why.
    pub cause: Cause,
}

/// What the mode machine says in one cycle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ModeReport {
    /// What flies in this cycle.
    pub mode: Mode,
    /// How it was entered, in the cycle in which it was.
    pub transition: Option<Transition>,
    /// A command that cannot be followed: there is no law for that mode.
    pub refused: Option<Mode>,
    /// How often the satellite has left the safe mode by itself since it was told something or pointed
    /// well.
    pub retries: u8,
}

/// A law and what surrounds it.
#[derive(Debug, Clone, Copy)]
pub struct Flown {
    /// The law.
    pub law: Law,
    /// What surrounds it.
    pub steering: Steering,
}

/// What looks after the wiring.
#[derive(Debug, Clone, Copy)]
pub struct Polarity {
    /// Watches while a despin loop is closed.
    pub guard: Guard,
    /// Flies in [`Mode::Commissioning`].
    pub check: ActiveCheck,
}

/// The mode machine's accepted configuration. The law of [`Mode::Point`] is the one that flies without
/// modes too.
#[derive(Debug, Clone, Copy)]
pub struct Modes {
    /// When to go from mode to mode.
    pub table: ModeTable,
    /// What flies in [`Mode::Detumble`].
    pub despin: Flown,
    /// How the same law is surrounded in [`Mode::Acquire`].
    pub acquire: Steering,
    /// What flies in [`Mode::Experiment`]; `None` when there is none.
    pub experiment: Option<Flown>,
    /// What looks after the wiring; `None` to trust it.
    pub polarity: Option<Polarity>,
    /// What [`Mode::Commissioning`] does beside the active check; `None` for that alone.
    pub ladder: Option<Ladder>,
}
