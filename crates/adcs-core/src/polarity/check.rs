//! The active check: pulses of each torquer before a loop is closed.
//!
//! It runs with the schedule of the laws, one pulse a round: +x, −y, +z, −x, +y, −z, … of the torquers'
//! full dipole, while
//!
//! 1. `turning` finds the wiring G of the gyro that explains the fields. What mirrors is
//!    the gyro's, and the check ends.
//! 2. G = 1: `response` finds the torquers' wiring, or which of them do nothing.
//! 3. G another rotation: the gyro shows G ω, or the magnetometer ± G⁻¹ B. Two filters, each with one of
//!    them put right, tell by the response to the pulses which it is.
//!
//! It ends with a name, or that nothing is wrong, as soon as the odds are good enough, and otherwise after
//! [`LONGEST_ROUNDS`] rounds or [`LONGEST_CYCLES`] cycles, whichever is first.

use core::fmt;

use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};

use super::answer::{Answer, ResponseEvidence};
use super::guard::GuardInputs;
use super::parameters::{PolarityError, PolarityParameters};
use super::response::{Response, Seen};
use super::turning::Turning;
use super::verdict::Suspect;
use crate::frames::{Body, SignedPermutation, Vector};
use crate::schedule::Phase;
use crate::time::Utc;

/// Rounds after which it gives up: twenty minutes of the paper's. Pulses of half that length, as of a schedule
/// that points, and slow tumbles take that many.
pub const LONGEST_ROUNDS: u8 = 160;
/// Cycles after which it gives up whatever the phases say: 20 minutes of half seconds.
pub const LONGEST_CYCLES: u16 = 2400;
/// Each torquer has been pulsed once.
const FEWEST_ROUNDS: u8 = 4;
/// Natural logarithm of the odds of the best over the second best at which it counts as known: 1 in 3000.
const KNOWN: f32 = 8.0;
/// And for an accusation by the answer to the pulses: 1 in 160,000. What its filter takes for linear is not at
/// 8 deg/s with a tensor 10 % wrong; at 1 in 3000 it accused 2 of 200 such satellites falsely.
const SURE: f32 = 12.0;
/// And at which another wiring of the gyro is worth starting anew for.
const LIKELIER: f32 = 2.0;

/// What the devices said and did since the last cycle.
pub type CheckInputs = GuardInputs;

/// The check with accepted parameters.
#[derive(Debug, Clone, Copy)]
pub struct ActiveCheck {
    parameters: PolarityParameters,
    inertia: Matrix3<f32>,
}

/// What one cycle leaves for the next. `Default` is the start.
#[derive(Debug, Clone, Copy, Default)]
pub struct CheckState {
    last: Option<Utc>,
    cycles: u16,
    rounds: u8,
    seen_rate: bool,
    seen_field: bool,
    turning: Turning,
    /// The wiring of the gyro that is assumed, by number.
    assumed: Option<SignedPermutation>,
    gyro_put_right: Response,
    magnetometer_put_right: Response,
    report: Option<CheckReport>,
}

/// What is to be done in this cycle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum CheckStep {
    /// The torquers should carry this dipole until the next cycle, Body, A·m².
    Carry(Vector<Body>),
    /// The check is over; the torquers should be off.
    Done(CheckReport),
}

/// What came out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum CheckReport {
    /// Everything is wired as it should be.
    Sound,
    /// A device is wired wrongly, or torquers do nothing.
    Wrong(Suspect),
    /// It cannot be told.
    Undecided(Undecided),
}

/// Why it cannot be told.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Undecided {
    /// The gyro said nothing that could be a rate.
    NoRate,
    /// The magnetometer said nothing that could be a field.
    NoField,
    /// The satellite turns too slowly, or about an axis about which several wirings look alike.
    TooSlow,
    /// Several wirings, or dead torquers, explain the response to the pulses.
    Alike,
}

impl fmt::Display for Undecided {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NoRate => "the gyro was silent",
            Self::NoField => "the magnetometer was silent",
            Self::TooSlow => "the satellite turns too slowly to tell the sensors' axes apart",
            Self::Alike => "several wirings explain the response to the pulses",
        })
    }
}

impl fmt::Display for CheckReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Sound => write!(f, "wired as it should be"),
            Self::Wrong(suspect) => write!(f, "{suspect}"),
            Self::Undecided(why) => write!(f, "undecided: {why}"),
        }
    }
}

impl ActiveCheck {
    /// Accepts parameters.
    ///
    /// # Errors
    /// [`PolarityError`] with the parameter, its value and its range.
    pub fn new(parameters: &PolarityParameters) -> Result<Self, PolarityError> {
        let inertia = parameters.check()?;
        Ok(Self { parameters: *parameters, inertia })
    }

    /// One cycle of the check; the report is repeated until the state is made anew.
    pub fn cycle(&self, state: &mut CheckState, inputs: &CheckInputs) -> CheckStep {
        if let Some(report) = state.report {
            return CheckStep::Done(report);
        }
        self.take_in(state, inputs);
        let round_over = inputs.phase == Phase::Measuring;
        if round_over {
            state.rounds = state.rounds.saturating_add(1);
            state.report = self.decide(state);
        }
        state.cycles = state.cycles.saturating_add(1);
        let late = state.rounds >= LONGEST_ROUNDS || state.cycles >= LONGEST_CYCLES;
        if late && state.report.is_none() {
            state.report = Some(CheckReport::Undecided(self.why_undecided(state)));
        }
        match state.report {
            Some(report) => CheckStep::Done(report),
            None => CheckStep::Carry(self.pulse(state.rounds, inputs.phase)),
        }
    }

    fn take_in(&self, state: &mut CheckState, inputs: &CheckInputs) {
        let p = &self.parameters;
        let dt_s = state.last.map_or(0.0, |last| inputs.now.seconds_since(last) as f32);
        state.last = Some(inputs.now);
        let (gyro, field) = (inputs.rate(), inputs.field());
        state.seen_rate |= gyro.is_some();
        state.seen_field |= field.is_some();
        state.turning.cycle(p, dt_s, gyro, field, inputs.phase == Phase::Measuring, 0.0);
        let wiring = state.assumed.unwrap_or(SignedPermutation::IDENTITY);
        let dipole = inputs.dipole();
        let back = wiring.inverse();
        let seen = Seen { gyro: gyro.map(|rate| back.apply(rate)), field, dipole };
        state.gyro_put_right.cycle(p, &self.inertia, dt_s, &seen);
        if wiring != SignedPermutation::IDENTITY {
            let seen = Seen { gyro, field: field.map(|field| wiring.apply(field)), dipole };
            state.magnetometer_put_right.cycle(p, &self.inertia, dt_s, &seen);
        }
    }

    /// At the end of each rest: what is known by now.
    fn decide(&self, state: &mut CheckState) -> Option<CheckReport> {
        let turning = state.turning.evidence(&self.parameters);
        let assumed = *state.assumed.get_or_insert(SignedPermutation::IDENTITY);
        if turning.best != assumed && turning.lead >= LIKELIER {
            state.assumed = Some(turning.best);
            state.gyro_put_right = Response::default();
            state.magnetometer_put_right = Response::default();
            state.rounds = state.rounds.min(LONGEST_ROUNDS - 1);
            return None;
        }
        if turning.best != assumed || turning.lead < KNOWN {
            return None;
        }
        if !assumed.is_rotation() {
            return Some(CheckReport::Wrong(Suspect::Gyro(assumed)));
        }
        if state.rounds < FEWEST_ROUNDS {
            return None;
        }
        let response = state.gyro_put_right.evidence(false)?;
        if assumed == SignedPermutation::IDENTITY {
            let report = match response.best {
                Answer::Wired(SignedPermutation::IDENTITY) => CheckReport::Sound,
                Answer::Wired(SignedPermutation::REVERSED) => {
                    CheckReport::Wrong(Suspect::ReversedTorquersOrMagnetometer)
                }
                Answer::Wired(wiring) => CheckReport::Wrong(Suspect::Torquers(wiring)),
                Answer::Dead(dead) => CheckReport::Wrong(Suspect::DeadTorquers(dead)),
            };
            let wanted = if report == CheckReport::Sound { KNOWN } else { SURE };
            return (response.lead >= wanted).then_some(report);
        }
        let other = state.magnetometer_put_right.evidence(false)?;
        gyro_or_magnetometer(assumed, &response, &other).map(CheckReport::Wrong)
    }

    fn why_undecided(&self, state: &CheckState) -> Undecided {
        if !state.seen_rate {
            return Undecided::NoRate;
        }
        if !state.seen_field {
            return Undecided::NoField;
        }
        let turning = state.turning.evidence(&self.parameters);
        if turning.lead < KNOWN { Undecided::TooSlow } else { Undecided::Alike }
    }

    /// The pulse of a round: one torquer after the other, with alternating sign.
    pub(crate) fn pulse(&self, round: u8, phase: Phase) -> Vector<Body> {
        let acting = matches!(phase, Phase::Measuring | Phase::Acting);
        let sign = if round.is_multiple_of(2) { 1.0 } else { -1.0 };
        let axis = round % 3;
        let along = |number: u8| if acting && axis == number { sign } else { 0.0 };
        Vector::from_xyz(Vector3::new(along(0), along(1), along(2)) * self.parameters.pulse_am2)
    }
}

/// The one that explains the response best, if it does so clearly.
fn gyro_or_magnetometer(
    wiring: SignedPermutation,
    gyro_put_right: &ResponseEvidence,
    magnetometer_put_right: &ResponseEvidence,
) -> Option<Suspect> {
    let magnetometer = wiring.inverse();
    let mut candidates = [
        (gyro_put_right.right, Suspect::Gyro(wiring)),
        (magnetometer_put_right.right, Suspect::Magnetometer(magnetometer)),
        (magnetometer_put_right.reversed, Suspect::Magnetometer(magnetometer.negated())),
    ];
    candidates.sort_unstable_by(|(a, _), (b, _)| b.total_cmp(a));
    let [(best, suspect), (second, _), _] = candidates;
    (best - second >= SURE).then_some(suspect)
}
