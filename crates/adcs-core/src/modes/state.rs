//! What the mode machine remembers from cycle to cycle.

use super::growth::Growth;
use super::lasting::{Held, Silence};
use super::sight::Sight;
use super::watch::Watch;
use super::{Cause, Mode, Sensor, Transition};
use crate::commissioning::{Findings, LadderReport, LadderState};
use crate::frames::{Body, Vector};
use crate::polarity::CheckState;
use crate::time::Utc;

/// No step from cycle to cycle counts for more, s: the longest cycle period there is.
pub const LONGEST_STEP_S: f32 = 60.0;

/// Time constant of the mean that rates are compared in, s: of 0.163 deg/s of gyro noise twice a second
/// it leaves 0.02 deg/s. A satellite that turns faster than 1/20 rad/s in its own axes still shows that
/// much (`FASTEST_RAD_S`).
const MEAN_S: f32 = 20.0;

/// What is remembered of the mode that flies, and forgotten with it.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct InMode {
    pub for_s: f32,
    pub despun: Held,
    pub tumbling: Held,
    pub trusted: Held,
    pub lost: Held,
    pub captured: Held,
    pub recovered: Held,
    pub was_captured: bool,
    pub was_commanded: bool,
    /// The sensor whose silence led here.
    pub missed: Option<Sensor>,
    pub rate: Growth,
    pub error: Growth,
}

/// What one cycle leaves for the next. `Default` is power-on.
#[derive(Debug, Clone, Copy, Default)]
pub struct ModesState {
    pub(super) mode: Option<Mode>,
    last: Option<Utc>,
    mean_rate: Option<Vector<Body>>,
    pub(super) gyro: Silence,
    pub(super) magnetometer: Silence,
    pub(super) sun: Silence,
    pub(super) torquers: Silence,
    pub(super) retries: u8,
    pub(super) here: InMode,
    pub(super) watch: Watch,
    /// What commissioning has found.
    pub(super) findings: Findings,
    /// Whether a climb that a reset interrupted goes on.
    pub(super) resumes: bool,
    /// What commissioning wants to be carried, Body, A·m².
    pub(super) pulse: Option<Vector<Body>>,
    /// What it says in this cycle.
    pub(super) climbed: Option<LadderReport>,
}

impl ModesState {
    /// The time since the last cycle, s; a clock that was set counts for little or nothing.
    pub(super) fn elapsed_s(&mut self, now: Utc) -> f32 {
        let dt_s = self.last.map_or(0.0, |last| now.seconds_since(last) as f32);
        self.last = Some(now);
        dt_s.clamp(0.0, LONGEST_STEP_S)
    }

    /// Takes in what the sensors say; the length of the mean rate, rad/s, while there is a rate.
    pub(super) fn observe(&mut self, sight: &Sight, dt_s: f32) -> Option<f32> {
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

    pub(super) fn enter(
        &mut self,
        from: Mode,
        (to, cause): (Mode, Cause),
        has_ladder: bool,
    ) -> Transition {
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
