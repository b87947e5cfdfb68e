//! The way from mode to mode while nothing is wrong.

use super::lasting::Silence;
use super::machine::Seen;
use super::parameters::ModeParameters;
use super::state::ModesState;
use super::{Cause, Mode, Modes, Sensor};

/// A sensor need not be read in every cycle to speak, s.
const BETWEEN_READINGS_S: f32 = 2.5;

impl Modes {
    /// The way from mode to mode while nothing is wrong.
    pub(super) fn way(
        &self,
        state: &mut ModesState,
        mode: Mode,
        seen: &Seen<'_>,
    ) -> Option<(Mode, Cause)> {
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
