//! The mode machine itself: from what is seen to the mode that flies.

use super::growth::{Growth, Limits};
use super::parameters::{ModeParameters, Needs};
use super::sight::Sight;
use super::{Cause, Flown, Mode, ModeReport, Modes, Polarity, Sensor, Transition};
use crate::commissioning::{Ended, Findings, LadderReport, LadderState, Outcome, Rung, Shortfall};
use crate::frames::{Body, Vector};
use crate::polarity::{
    Aim, CheckReport, CheckState, CheckStep, GuardState, GuardVerdict, Suspect, Undecided,
};
use crate::schedule::Phase;
use crate::steering::{Law, Steering};
use crate::time::Utc;

/// No step from cycle to cycle counts for more, s: the longest cycle period there is.
pub const LONGEST_STEP_S: f32 = 60.0;

/// Time constant of the mean that rates are compared in, s: of 0.163 deg/s of gyro noise twice a second
/// it leaves 0.02 deg/s. A satellite that turns faster than 1/20 rad/s in its own axes still shows that
/// much (`FASTEST_RAD_S`).
const MEAN_S: f32 = 20.0;

/// A sensor need not be read in every cycle to speak, s.
const BETWEEN_READINGS_S: f32 = 2.5;

/// For how long something has been so without a break, s.
#[derive(Debug, Clone, Copy, Default)]
struct Held(f32);

impl Held {
    /// Whether it has now been so for `for_s`.
    fn step(&mut self, dt_s: f32, is_so: bool, for_s: f32) -> bool {
        self.0 = if is_so { self.0 + dt_s } else { 0.0 };
        is_so && self.0 >= for_s
    }
}

/// For how long a sensor has been silent, or the torquers have refused, s.
#[derive(Debug, Clone, Copy, Default)]
struct Silence {
    is_silent: bool,
    for_s: f32,
}

impl Silence {
    /// Takes in whether it speaks; `None` leaves the last word standing.
    fn step(&mut self, dt_s: f32, speaks: Option<bool>) {
        self.is_silent = speaks.map_or(self.is_silent, |speaks| !speaks);
        self.for_s = if self.is_silent { self.for_s + dt_s } else { 0.0 };
    }
}

/// What is remembered of the mode that flies, and forgotten with it.
#[derive(Debug, Clone, Copy, Default)]
struct InMode {
    for_s: f32,
    despun: Held,
    tumbling: Held,
    trusted: Held,
    lost: Held,
    captured: Held,
    recovered: Held,
    was_captured: bool,
    was_commanded: bool,
    /// The sensor whose silence led here.
    missed: Option<Sensor>,
    rate: Growth,
    error: Growth,
}

/// What one cycle leaves for the next. `Default` is power-on.
#[derive(Debug, Clone, Copy, Default)]
pub struct ModesState {
    mode: Option<Mode>,
    last: Option<Utc>,
    mean_rate: Option<Vector<Body>>,
    gyro: Silence,
    magnetometer: Silence,
    sun: Silence,
    torquers: Silence,
    retries: u8,
    here: InMode,
    watch: Watch,
    /// What commissioning has found.
    findings: Findings,
    /// Whether a climb that a reset interrupted goes on.
    resumes: bool,
    /// What commissioning wants to be carried, Body, A·m².
    pulse: Option<Vector<Body>>,
    /// What it says in this cycle.
    climbed: Option<LadderReport>,
}

/// What looks after the wiring: one of them at a time.
#[derive(Debug, Clone, Copy)]
#[allow(
    clippy::large_enum_variant,
    reason = "there is one, in static memory, and no heap to box into"
)]
enum Watch {
    Guard(GuardState),
    /// The active check alone, where there is no ladder.
    Check(CheckState),
    Ladder(LadderState),
}

impl Default for Watch {
    fn default() -> Self {
        Self::Guard(GuardState::default())
    }
}

impl ModesState {
    /// The time since the last cycle, s; a clock that was set counts for little or nothing.
    fn elapsed_s(&mut self, now: Utc) -> f32 {
        let dt_s = self.last.map_or(0.0, |last| now.seconds_since(last) as f32);
        self.last = Some(now);
        dt_s.clamp(0.0, LONGEST_STEP_S)
    }

    /// Takes in what the sensors say; the length of the mean rate, rad/s, while there is a rate.
    fn observe(&mut self, sight: &Sight, dt_s: f32) -> Option<f32> {
        self.gyro.step(dt_s, Some(sight.gyro_speaks));
        self.magnetometer.step(dt_s, sight.magnetometer_speaks);
        self.sun.step(dt_s, Some(sight.sun_speaks));
        self.torquers.step(dt_s, Some(sight.torquers_obey));
        let rate = sight.rate?;
        let mean = self.mean_rate.map_or(rate, |mean| mean + (rate - mean) * weight(dt_s));
        self.mean_rate = Some(mean);
        Some(mean.norm())
    }

    /// The pulse that commissioning wants to be carried, Body, A·m²; `None` outside
    /// [`Mode::Commissioning`].
    pub(crate) fn pulse(&self) -> Option<Vector<Body>> {
        self.pulse
    }

    /// What the commissioning ladder says in this cycle.
    pub(crate) fn climbed(&self) -> Option<LadderReport> {
        self.climbed
    }

    /// What commissioning has found so far.
    pub fn findings(&self) -> &Findings {
        &self.findings
    }

    pub(crate) fn note_commit(&mut self) {
        self.findings.committed = true;
    }

    /// Before the first cycle: what was found before a reset. A climb that was interrupted goes on.
    pub fn resume(&mut self, findings: Findings) {
        let begun = findings.outcomes.iter().any(Option::is_some);
        self.resumes = begun && findings.next().is_some();
        self.findings = findings;
    }

    fn enter(&mut self, from: Mode, (to, cause): (Mode, Cause), has_ladder: bool) -> Transition {
        match cause {
            Cause::Recovered => self.retries = self.retries.saturating_add(1),
            Cause::Commanded => self.retries = 0,
            _ => {}
        }
        self.mode = Some(to);
        let missed = match cause {
            Cause::Silent(sensor) => Some(sensor),
            _ => None,
        };
        // No waiting cures a wrong wiring.
        let was_commanded = matches!(cause, Cause::Commanded | Cause::Miswired(_));
        if to == Mode::Commissioning {
            if cause != Cause::Resumed {
                self.findings.retry();
            }
            self.watch = match has_ladder {
                true => Watch::Ladder(LadderState::resumed(self.findings)),
                false => Watch::Check(CheckState::default()),
            };
        } else if was_commanded || from == Mode::Commissioning {
            self.watch = Watch::default();
        }
        self.pulse = None;
        self.here = InMode { was_commanded, missed, ..InMode::default() };
        Transition { from, to, cause }
    }
}

/// Weight of a new sample in a mean over [`MEAN_S`].
fn weight(dt_s: f32) -> f32 {
    (dt_s * (1.0 / MEAN_S)).min(1.0)
}

impl Modes {
    /// One cycle of the mode machine.
    pub fn cycle(&self, state: &mut ModesState, sight: &Sight) -> ModeReport {
        let dt_s = state.elapsed_s(sight.now);
        let rate_rad_s = state.observe(sight, dt_s);
        let is_refused = |mode: &Mode| match mode {
            Mode::Experiment => self.experiment.is_none(),
            Mode::Commissioning => self.polarity.is_none(),
            _ => false,
        };
        let refused = sight.commanded.filter(is_refused);
        let commanded = sight.commanded.filter(|mode| !is_refused(mode));

        state.climbed = None;
        let (mode, next) = match state.mode {
            None if state.resumes && self.ladder.is_some() => {
                (Mode::Off, Some((Mode::Commissioning, Cause::Resumed)))
            }
            None => (Mode::Off, Some((self.parameters().start, Cause::PowerOn))),
            Some(mode) => {
                state.here.for_s += dt_s;
                let seen = Seen { sight, rate_rad_s, dt_s };
                // All of them are looked at in every cycle: each counts its own time.
                let wiring = self.wiring(state, mode, sight);
                let fault = self.fault(state, mode, &seen).or(wiring);
                let way = self.way(state, mode, &seen);
                (mode, fault.or(way))
            }
        };
        let next = commanded.map(|mode| (mode, Cause::Commanded)).or(next);
        let transition = next.map(|next| state.enter(mode, next, self.ladder.is_some()));
        let mode = transition.map_or(mode, |transition| transition.to);
        ModeReport { mode, transition, refused, retries: state.retries }
    }

    /// What flies in a mode, `pointing` being what flies in [`Mode::Point`].
    pub fn flown<'a>(
        &'a self,
        mode: Mode,
        pointing: (&'a Law, &'a Steering),
    ) -> (&'a Law, &'a Steering) {
        match (mode, &self.experiment) {
            (Mode::Detumble, _) => (&self.despin.law, &self.despin.steering),
            (Mode::Acquire, _) => (&self.despin.law, &self.acquire),
            (Mode::Point, _) => pointing,
            (Mode::Experiment, Some(Flown { law, steering })) => (law, steering),
            (Mode::Off | Mode::Safe | Mode::Experiment | Mode::Commissioning, _) => {
                (&Law::Off, pointing.1)
            }
        }
    }

    fn parameters(&self) -> &ModeParameters {
        &self.table.parameters
    }

    fn needs(&self, mode: Mode) -> Needs {
        let points = match (mode, &self.experiment) {
            (Mode::Acquire | Mode::Point, _) => true,
            (Mode::Experiment, Some(Flown { law, .. })) => law.points(),
            _ => false,
        };
        let p = self.parameters();
        if points { p.pointing_needs } else { p.despin_needs }
    }

    /// What ends a mode in which torquers are driven.
    fn fault(&self, state: &mut ModesState, mode: Mode, seen: &Seen<'_>) -> Option<(Mode, Cause)> {
        if !mode.drives() {
            return None;
        }
        let (p, needs) = (self.parameters(), self.needs(mode));
        let grows = self.grows(state, mode, seen);
        let silent = |silence: &Silence, gap_s: f32| silence.for_s >= gap_s;
        let cause = if silent(&state.magnetometer, p.sensor_gap_s) {
            Cause::Silent(Sensor::Magnetometer)
        } else if needs.gyro && silent(&state.gyro, p.sensor_gap_s) {
            Cause::Silent(Sensor::Gyro)
        } else if needs.sun && silent(&state.sun, p.sun_gap_s) {
            Cause::Silent(Sensor::SunSensors)
        } else if silent(&state.torquers, p.actuator_gap_s) {
            Cause::TorquersRefuse
        } else {
            grows?
        };
        Some((Mode::Safe, cause))
    }

    /// What the guard says. It listens whenever no loop is closed, and watches while one is.
    fn wiring(&self, state: &mut ModesState, mode: Mode, sight: &Sight) -> Option<(Mode, Cause)> {
        let Polarity { guard, .. } = self.polarity.as_ref()?;
        let Watch::Guard(watch) = &mut state.watch else { return None };
        let aim = match (mode, &self.experiment) {
            (Mode::Point, _) => Aim::Point,
            (Mode::Experiment, Some(Flown { law, .. })) if law.points() => Aim::Point,
            (Mode::Acquire, _) => Aim::Acquire,
            _ => Aim::Despin,
        };
        match guard.cycle(watch, &sight.witnessed.devices, aim) {
            GuardVerdict::Stop { suspect, .. } if mode.drives() => {
                Some((Mode::Safe, Cause::Miswired(suspect)))
            }
            _ => None,
        }
    }

    /// One cycle of commissioning.
    fn commission(&self, state: &mut ModesState, sight: &Sight) -> Option<(Mode, Cause)> {
        let Polarity { check, .. } = self.polarity.as_ref()?;
        match (&mut state.watch, &self.ladder) {
            (Watch::Ladder(watch), Some(ladder)) => {
                let step = ladder.cycle(check, watch, &sight.witnessed);
                state.findings = *watch.findings();
                (state.pulse, state.climbed) = (Some(step.pulse), Some(step.report));
                let LadderReport { rung, ended } = step.report;
                let trouble = ended.as_ref().and_then(trouble);
                trouble.or(rung.is_none().then_some((Mode::Detumble, Cause::Commissioned)))
            }
            (Watch::Check(watch), _) => match check.cycle(watch, &sight.witnessed.devices) {
                CheckStep::Carry(pulse) => {
                    state.pulse = Some(pulse);
                    None
                }
                CheckStep::Done(CheckReport::Sound) => Some((Mode::Detumble, Cause::Checked)),
                CheckStep::Done(CheckReport::Wrong(suspect)) => Some(miswired(suspect)),
                CheckStep::Done(CheckReport::Undecided(why)) => Some(unchecked(why)),
            },
            (Watch::Guard(_) | Watch::Ladder(_), _) => None,
        }
    }

    /// Whether what should shrink grows.
    fn grows(&self, state: &mut ModesState, mode: Mode, seen: &Seen<'_>) -> Option<Cause> {
        // The pulses of the active check turn the satellite as they like.
        if seen.sight.phase != Phase::Measuring || mode == Mode::Commissioning {
            return None;
        }
        let (p, here) = (self.parameters(), &mut state.here);
        let limits = |floor| Limits { rounds: p.growing_rounds, factor: p.growing_factor, floor };
        let rate = seen.rate_rad_s;
        if rate.is_some_and(|rate| here.rate.diverges(rate, &limits(p.tumbling_rad_s))) {
            return Some(Cause::RateGrows);
        }
        let error = seen.sight.pointing_error_rad.filter(|_| mode == Mode::Point);
        let grows = error.is_some_and(|error| here.error.diverges(error, &limits(p.diverged_rad)));
        (grows && here.was_captured).then_some(Cause::ErrorGrows)
    }

    /// The way from mode to mode while nothing is wrong.
    fn way(&self, state: &mut ModesState, mode: Mode, seen: &Seen<'_>) -> Option<(Mode, Cause)> {
        let (p, dt_s) = (self.parameters(), seen.dt_s);
        let sun_is_silent = p.pointing_needs.sun && state.sun.for_s >= p.sun_gap_s;
        let missed = state.here.missed;
        let needed = |sensor, needs| needs || missed == Some(sensor);
        let speaks = |silence: &Silence| silence.for_s <= BETWEEN_READINGS_S;
        let speaking = speaks(&state.magnetometer)
            && state.torquers.for_s == 0.0
            && (speaks(&state.gyro) || !needed(Sensor::Gyro, p.despin_needs.gyro))
            && (speaks(&state.sun) || !needed(Sensor::SunSensors, p.despin_needs.sun));
        let here = &mut state.here;
        let below = |limit: f32| seen.rate_rad_s.is_some_and(|rate| rate < limit);
        let fast = seen.rate_rad_s.is_some_and(|rate| rate > p.tumbling_rad_s);
        let tumbling = here.tumbling.step(dt_s, fast, p.tumbling_for_s);
        match mode {
            Mode::Off => None,
            Mode::Commissioning => self.commission(state, seen.sight),
            Mode::Safe => {
                let recovered = here.recovered.step(dt_s, speaking, p.recovery_s);
                let may = !here.was_commanded && state.retries < p.retries;
                (recovered && may).then_some((Mode::Detumble, Cause::Recovered))
            }
            Mode::Detumble => {
                let despun = here.despun.step(dt_s, below(p.despun_rad_s), p.despun_for_s);
                match (despun, sun_is_silent) {
                    (true, true) => Some((Mode::Safe, Cause::Silent(Sensor::SunSensors))),
                    (true, false) => Some((Mode::Acquire, Cause::Despun)),
                    (false, _) => too_long(here.for_s, p.detumble_limit_s),
                }
            }
            Mode::Acquire => {
                let trusted = seen.trusts(p) && below(p.slow_rad_s);
                if tumbling {
                    Some((Mode::Detumble, Cause::Tumbling))
                } else if here.trusted.step(dt_s, trusted, p.trusted_for_s) {
                    Some((Mode::Point, Cause::Trusted))
                } else {
                    too_long(here.for_s, p.acquire_limit_s)
                }
            }
            Mode::Point => {
                let near = seen.sight.pointing_error_rad.is_some_and(|e| e < p.captured_rad);
                if here.captured.step(dt_s, near, p.captured_for_s) {
                    here.was_captured = true;
                    state.retries = 0;
                }
                let is_lost = seen.sight.attitude_sigma_rad.is_none() || seen.sight.rate.is_none();
                let lost = here.lost.step(dt_s, is_lost, p.lost_for_s);
                if tumbling {
                    Some((Mode::Detumble, Cause::Tumbling))
                } else if lost {
                    Some((Mode::Acquire, Cause::AttitudeLost))
                } else if !here.was_captured && here.for_s >= p.capture_limit_s {
                    Some((Mode::Safe, Cause::NotCaptured))
                } else {
                    None
                }
            }
            Mode::Experiment => {
                (here.for_s >= p.experiment_s).then_some((p.experiment_next, Cause::Over))
            }
        }
    }
}

/// Past its limit a mode ends in safety.
fn too_long(for_s: f32, limit_s: f32) -> Option<(Mode, Cause)> {
    (for_s >= limit_s).then_some((Mode::Safe, Cause::TooLong))
}

/// One cycle, and what was made of it.
struct Seen<'a> {
    sight: &'a Sight,
    /// Length of the mean rate.
    rate_rad_s: Option<f32>,
    dt_s: f32,
}

impl Seen<'_> {
    /// Whether attitude and residual dipole are known well enough to point.
    fn trusts(&self, p: &ModeParameters) -> bool {
        let sight = self.sight;
        let attitude = sight.attitude_sigma_rad.is_some_and(|sigma| sigma <= p.attitude_sigma_rad);
        let dipole = match p.dipole_sigma_am2 {
            Some(wanted) => sight.dipole_sigma_am2.is_some_and(|sigma| sigma <= wanted),
            None => true,
        };
        sight.filtered && attitude && dipole
    }
}

/// What a rung ended with that ends commissioning.
fn trouble(ended: &Ended) -> Option<(Mode, Cause)> {
    match (ended.rung, ended.outcome) {
        (Rung::Polarity, Outcome::Failed(Shortfall::Miswired(suspect))) => Some(miswired(suspect)),
        (Rung::Polarity, Outcome::Failed(Shortfall::Undecided(why))) => {
            // One that turns too slowly goes on: the other rungs have gates of their own.
            Some(unchecked(why)).filter(|(mode, _)| *mode == Mode::Safe)
        }
        _ => None,
    }
}

fn miswired(suspect: Suspect) -> (Mode, Cause) {
    (Mode::Safe, Cause::Miswired(suspect))
}

fn unchecked(why: Undecided) -> (Mode, Cause) {
    let is_silent = matches!(why, Undecided::NoRate | Undecided::NoField);
    (if is_silent { Mode::Safe } else { Mode::Detumble }, Cause::Unchecked(why))
}
