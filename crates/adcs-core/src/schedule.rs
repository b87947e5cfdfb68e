//! Measure, then act: torquers spoil the magnetometer, so the two take turns.
//!
//! ```text
//! t = 0     settle    off       off + on
//! ├─ settling ┼─ settled ●─ acting ──┼─ settling ┼─ settled ●─ acting ── …
//!             │          └ measured at the last instant of rest, held through the acting
//!             └ from here on the field is the Earth's, and the filters may use it
//! ```
//!
//! The paper's experiments rest 2.5 s and act 10 s or 5 s. When within the rest they measured is not
//! said; the last instant leaves the field and the low-pass filter the longest time to settle.
//! A command held while the satellite turns grows stale by ω · t_on.

use core::cmp::Ordering;
use core::fmt;

use serde::{Deserialize, Serialize};

/// Durations of rest and action as stored and uplinked.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct ScheduleParameters {
    /// How long the torquers act, µs (paper: 10 s or 5 s).
    pub on_us: u32,
    /// How long they rest before the next measurement, µs (paper: 2.5 s).
    pub off_us: u32,
    /// How long within the rest the field takes to settle, µs; at most `off_us`: then only the last
    /// instant of the rest measures.
    pub settle_us: u32,
}

/// Action and rest of one round, as the laws count them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Round {
    /// How long the torquers act, s.
    pub on_s: f32,
    /// How long they rest, s.
    pub off_s: f32,
}

impl Round {
    /// The whole round over its action; infinite when there is none.
    pub fn inverse_duty(&self) -> f32 {
        (self.on_s + self.off_s) / self.on_s
    }
}

impl ScheduleParameters {
    /// Action and rest in seconds.
    pub fn round(&self) -> Round {
        let seconds = |us: u32| us as f32 * 1e-6;
        Round { on_s: seconds(self.on_us), off_s: seconds(self.off_us) }
    }
}

/// Why a schedule is refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum ScheduleError {
    /// The cycle period is zero.
    NoCycle,
    /// The torquers would never act: the duty is zero.
    NeverActs,
    /// The torquers would never rest, so the field could never be measured.
    NeverRests,
    /// The field would settle later than the rest ends.
    NeverSettles {
        /// The time to settle, µs.
        settle_us: u32,
        /// The rest, µs.
        off_us: u32,
    },
    /// A duration is not a whole number of cycles.
    NotWholeCycles {
        /// The duration, µs.
        found_us: u32,
        /// The cycle period, µs.
        cycle_us: u32,
    },
}

impl fmt::Display for ScheduleError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoCycle => write!(f, "the cycle period must not be zero"),
            Self::NeverActs => write!(f, "the torquers would never act (on-time 0, duty 0)"),
            Self::NeverRests => {
                write!(
                    f,
                    "the torquers would never rest (off-time 0), so nothing could be measured"
                )
            }
            Self::NeverSettles { settle_us, off_us } => {
                write!(
                    f,
                    "the field would settle after {settle_us} µs, but the rest ends after {off_us} µs"
                )
            }
            Self::NotWholeCycles { found_us, cycle_us } => {
                write!(f, "{found_us} µs is not a whole number of cycles of {cycle_us} µs")
            }
        }
    }
}

impl core::error::Error for ScheduleError {}

/// What a cycle is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Phase {
    /// The torquers rest and the field settles.
    Settling,
    /// The field has settled: measure, compute, switch the torquers on.
    Measuring,
    /// The torquers hold the command that was measured for.
    Acting,
    /// The torquers rest and the field has settled: the filters measure.
    Settled,
}

/// The accepted schedule, in whole cycles.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Schedule {
    on_cycles: u32,
    off_cycles: u32,
    settle_cycles: u32,
}

impl Schedule {
    /// Accepts durations that are whole numbers of cycles of `cycle_us`.
    ///
    /// # Errors
    /// [`ScheduleError`]; a duty of 0 or 1 is refused.
    pub fn new(parameters: &ScheduleParameters, cycle_us: u32) -> Result<Self, ScheduleError> {
        let cycles = |found_us: u32| match (
            found_us.checked_div(cycle_us),
            found_us.checked_rem(cycle_us),
        ) {
            (Some(count), Some(0)) => Ok(count),
            (Some(_), _) => Err(ScheduleError::NotWholeCycles { found_us, cycle_us }),
            (None, _) => Err(ScheduleError::NoCycle),
        };
        let ScheduleParameters { on_us, off_us, settle_us } = *parameters;
        let (on_cycles, off_cycles) = (cycles(on_us)?, cycles(off_us)?);
        let settle_cycles = cycles(settle_us)?;
        match (on_cycles, off_cycles) {
            (0, _) => Err(ScheduleError::NeverActs),
            (_, 0) => Err(ScheduleError::NeverRests),
            _ if settle_us > off_us => Err(ScheduleError::NeverSettles { settle_us, off_us }),
            _ => Ok(Self { on_cycles, off_cycles, settle_cycles }),
        }
    }

    /// What the cycle `index` cycles after the start is for. The first is the first of a rest; the
    /// measuring cycle is the one at whose instant the rest ends and the action begins.
    pub fn phase(&self, index: u32) -> Phase {
        let within = index % self.on_cycles.saturating_add(self.off_cycles).max(1);
        match within.cmp(&self.off_cycles) {
            Ordering::Less if within < self.settle_cycles => Phase::Settling,
            Ordering::Less => Phase::Settled,
            Ordering::Equal => Phase::Measuring,
            Ordering::Greater => Phase::Acting,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HALF_SECOND_US: u32 = 500_000;

    fn paper() -> Schedule {
        let parameters =
            ScheduleParameters { on_us: 10_000_000, off_us: 2_500_000, settle_us: 2_500_000 };
        Schedule::new(&parameters, HALF_SECOND_US).unwrap()
    }

    #[test]
    fn the_papers_round_rests_five_half_seconds_and_acts_twenty() {
        let schedule = paper();
        for round in 0..4 {
            let start = round * 25;
            assert!((0..5).all(|k| schedule.phase(start + k) == Phase::Settling));
            assert_eq!(schedule.phase(start + 5), Phase::Measuring);
            assert!((6..25).all(|k| schedule.phase(start + k) == Phase::Acting));
        }
    }

    #[test]
    fn between_settling_and_the_last_instant_the_field_may_be_used() {
        let parameters =
            ScheduleParameters { on_us: 10_000_000, off_us: 2_500_000, settle_us: 1_000_000 };
        let schedule = Schedule::new(&parameters, HALF_SECOND_US).unwrap();
        for round in [0, 25] {
            assert!((0..2).all(|k| schedule.phase(round + k) == Phase::Settling));
            assert!((2..5).all(|k| schedule.phase(round + k) == Phase::Settled));
            assert_eq!(schedule.phase(round + 5), Phase::Measuring);
        }
        let late = ScheduleParameters { settle_us: 3_000_000, ..parameters };
        assert_eq!(
            Schedule::new(&late, HALF_SECOND_US),
            Err(ScheduleError::NeverSettles { settle_us: 3_000_000, off_us: 2_500_000 })
        );
    }

    #[test]
    fn schedules_that_never_act_or_never_rest_are_refused() {
        let new = |on_us, off_us, cycle_us| {
            Schedule::new(&ScheduleParameters { on_us, off_us, settle_us: off_us }, cycle_us)
        };
        assert_eq!(new(0, 500_000, 500_000), Err(ScheduleError::NeverActs));
        assert_eq!(new(500_000, 0, 500_000), Err(ScheduleError::NeverRests));
        assert_eq!(new(500_000, 500_000, 0), Err(ScheduleError::NoCycle));
        assert_eq!(
            new(750_000, 500_000, 500_000),
            Err(ScheduleError::NotWholeCycles { found_us: 750_000, cycle_us: 500_000 })
        );
    }
}
