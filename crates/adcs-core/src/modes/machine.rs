//! The mode machine itself: from what is seen to the mode that flies.

use super::parameters::ModeParameters;
use super::sight::Sight;
use super::state::ModesState;
use super::{Cause, Flown, Mode, ModeReport, Modes};
use crate::steering::{Law, Steering};

/// One cycle, and what was made of it.
pub(super) struct Seen<'a> {
    pub sight: &'a Sight,
    /// Length of the mean rate.
    pub rate_rad_s: Option<f32>,
    pub dt_s: f32,
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

    pub(super) fn parameters(&self) -> &ModeParameters {
        &self.table.parameters
    }
}
