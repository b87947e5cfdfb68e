//! What ends a mode in which torquers are driven: a device that is silent, or a loop that diverges.

use super::growth::Limits;
use super::lasting::Silence;
use super::machine::Seen;
use super::parameters::Needs;
use super::state::ModesState;
use super::{Cause, Flown, Mode, Modes, Sensor};
use crate::schedule::Phase;

impl Modes {
    /// What ends a mode in which torquers are driven.
    pub(super) fn fault(
        &self,
        state: &mut ModesState,
        mode: Mode,
        seen: &Seen<'_>,
    ) -> Option<(Mode, Cause)> {
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

    fn needs(&self, mode: Mode) -> Needs {
        let points = match (mode, &self.experiment) {
            (Mode::Acquire | Mode::Point, _) => true,
            (Mode::Experiment, Some(Flown { law, .. })) => law.points(),
            _ => false,
        };
        let p = self.parameters();
        if points { p.pointing_needs } else { p.despin_needs }
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
}
