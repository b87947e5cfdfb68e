//! What looks after the wiring: the guard while a loop is closed, and in commissioning the active check or
//! the ladder.

use super::sight::Sight;
use super::state::ModesState;
use super::{Cause, Flown, Mode, Modes, Polarity};
use crate::commissioning::{Ended, LadderReport, LadderState, Outcome, Rung, Shortfall};
use crate::polarity::{
    CheckReport, CheckState, CheckStep, GuardState, GuardVerdict, Purpose, Suspect, Undecided,
};

/// What looks after the wiring: one of them at a time.
#[derive(Debug, Clone, Copy)]
#[allow(
    clippy::large_enum_variant,
    reason = "there is one, in static memory, and no heap to box into"
)]
pub(super) enum Watch {
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

impl Modes {
    /// What the guard says. It listens whenever no loop is closed, and watches while one is.
    pub(super) fn wiring(
        &self,
        state: &mut ModesState,
        mode: Mode,
        sight: &Sight,
    ) -> Option<(Mode, Cause)> {
        let Polarity { guard, .. } = self.polarity.as_ref()?;
        let Watch::Guard(watch) = &mut state.watch else { return None };
        let purpose = match (mode, &self.experiment) {
            (Mode::Point, _) => Purpose::Point,
            (Mode::Experiment, Some(Flown { law, .. })) if law.points() => Purpose::Point,
            (Mode::Acquire, _) => Purpose::Acquire,
            _ => Purpose::Despin,
        };
        match guard.cycle(watch, &sight.witnessed.devices, purpose) {
            GuardVerdict::Stop { suspect, .. } if mode.drives() => {
                Some((Mode::Safe, Cause::Miswired(suspect)))
            }
            _ => None,
        }
    }

    /// One cycle of commissioning.
    pub(super) fn commission(
        &self,
        state: &mut ModesState,
        sight: &Sight,
    ) -> Option<(Mode, Cause)> {
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
