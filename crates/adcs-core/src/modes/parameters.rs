//! The table of the mode machine: every condition's number, and why a number is refused.

use core::fmt;

use serde::{Deserialize, Serialize};

use super::Mode;
use crate::parameter::{self, OutOfRange};

/// Which sensors a mode cannot do without, beside the magnetometer, without which none can.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Needs {
    /// The gyros.
    pub gyro: bool,
    /// The Sun sensors.
    pub sun: bool,
}

/// The mode machine as stored and uplinked. `Default` suits a satellite of some kilograms with torquers
/// of some tenths of A·m² in low orbit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ModeParameters {
    /// The mode after power-on.
    pub start: Mode,
    /// Despun: slower than this, rad/s …
    pub despun_rad_s: f32,
    /// … for so long, s.
    pub despun_for_s: f32,
    /// Tumbling: faster than this, rad/s …
    pub tumbling_rad_s: f32,
    /// … for so long, s.
    pub tumbling_for_s: f32,
    /// Longest detumbling, s.
    pub detumble_limit_s: f32,
    /// Trusted: an attitude whose every axis is known so well, rad …
    pub attitude_sigma_rad: f32,
    /// … a residual dipole whose every axis is known so well, A·m² (`None`: not asked for) …
    pub dipole_sigma_am2: Option<f32>,
    /// … and a rate below this, rad/s …
    pub slow_rad_s: f32,
    /// … for so long, s.
    pub trusted_for_s: f32,
    /// Longest acquisition, s.
    pub acquire_limit_s: f32,
    /// Attitude lost: none for so long, s.
    pub lost_for_s: f32,
    /// Captured: nearer to the target than this, rad …
    pub captured_rad: f32,
    /// … for so long, s.
    pub captured_for_s: f32,
    /// Longest pointing without being captured, s.
    pub capture_limit_s: f32,
    /// How long an experiment takes, s.
    pub experiment_s: f32,
    /// The mode after it.
    pub experiment_next: Mode,
    /// Gyros or magnetometer have failed: silent for so long, s.
    pub sensor_gap_s: f32,
    /// The Sun sensors have failed: blind by day, or silent, for so long, s.
    pub sun_gap_s: f32,
    /// The torquers have failed: they refused every command for so long, s.
    pub actuator_gap_s: f32,
    /// What [`Mode::Detumble`] and a despin experiment need.
    pub despin_needs: Needs,
    /// What [`Mode::Acquire`], [`Mode::Point`] and a pointing experiment need.
    pub pointing_needs: Needs,
    /// Divergence: so many rounds up, more than down …
    pub growing_rounds: u16,
    /// … to so many times the start, and beyond tumbling, or beyond …
    pub growing_factor: f32,
    /// … this pointing error, rad, once captured.
    pub diverged_rad: f32,
    /// How long the sensors must speak before the safe mode is left, s.
    pub recovery_s: f32,
    /// How often it is left by itself.
    pub retries: u8,
}

impl Default for ModeParameters {
    fn default() -> Self {
        let deg = f32::to_radians;
        Self {
            start: Mode::Detumble,
            // Uncorrected, a residual dipole of 0.4 A·m² keeps a satellite of 0.05 kg·m² swinging at up
            // to 1 deg/s: despin alone comes no further in reasonable time.
            despun_rad_s: deg(1.0),
            despun_for_s: 120.0,
            tumbling_rad_s: deg(2.0),
            tumbling_for_s: 60.0,
            // Half a day: five times what despin takes from 30 deg/s.
            detumble_limit_s: 43_200.0,
            attitude_sigma_rad: deg(2.0),
            dipole_sigma_am2: Some(0.03),
            slow_rad_s: deg(0.5),
            trusted_for_s: 300.0,
            // Four orbits.
            acquire_limit_s: 23_000.0,
            lost_for_s: 120.0,
            captured_rad: deg(20.0),
            captured_for_s: 600.0,
            // Seven orbits.
            capture_limit_s: 43_200.0,
            // The paper's experiment (its section 5).
            experiment_s: 1_200.0,
            experiment_next: Mode::Safe,
            // Some rounds of the schedule.
            sensor_gap_s: 60.0,
            // Between the cones of two faces a slow satellite sees nothing for minutes.
            sun_gap_s: 600.0,
            actuator_gap_s: 60.0,
            despin_needs: Needs { gyro: true, sun: false },
            pointing_needs: Needs { gyro: true, sun: true },
            // Longer than the quarter of a swing about the field, 90 s, in rounds of 7.5 s.
            growing_rounds: 24,
            growing_factor: 1.5,
            diverged_rad: deg(60.0),
            recovery_s: 300.0,
            retries: 3,
        }
    }
}

/// Why a table is refused.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum ModeError {
    /// A number is out of its range, or none.
    OutOfRange(OutOfRange),
    /// What leads back must be beyond what led in, or the modes alternate.
    NoHysteresis {
        /// What leads in: the name of its field.
        inner: &'static str,
        /// What leads back: the name of its field.
        outer: &'static str,
    },
    /// A mode is named for which there is no law.
    NoExperiment,
    /// An experiment cannot be followed by itself.
    ExperimentNext,
    /// Commissioning is named, and nothing looks after the wiring.
    NoCheck,
    /// Detumbling needs a despin law.
    NotDespin,
    /// Pointing needs a pointing law.
    NotPointing,
    /// Pointing needs stage II.
    NoAttitude,
    /// A residual dipole is only known to the dynamics-aided filter.
    NoDipole,
}

impl fmt::Display for ModeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::OutOfRange(error) => error.fmt(f),
            Self::NoHysteresis { inner, outer } => write!(f, "{outer} must be larger than {inner}"),
            Self::NoExperiment => write!(f, "there is no law for the experiment"),
            Self::ExperimentNext => write!(f, "an experiment cannot be followed by itself"),
            Self::NoCheck => {
                write!(f, "commissioning needs the parameters of the active check")
            }
            Self::NotDespin => write!(f, "the law that detumbles must be a despin law"),
            Self::NotPointing => write!(f, "the law that points must be a pointing law"),
            Self::NoAttitude => write!(f, "pointing needs the filters of stage II"),
            Self::NoDipole => write!(
                f,
                "the residual dipole that is asked for is only known to the dynamics-aided filter"
            ),
        }
    }
}

impl core::error::Error for ModeError {}

impl From<OutOfRange> for ModeError {
    fn from(error: OutOfRange) -> Self {
        Self::OutOfRange(error)
    }
}

/// Fastest rate that a condition may name, rad/s. The rate is a mean over 20 s, which turns a satellite's
/// own nutation at more than a radian in that time into 1/20 rad/s: no number may be near that.
const FASTEST_RAD_S: f64 = 0.04;
/// Shortest and longest times of a condition, s: a cycle or two, and some days.
const TIMES_S: (f64, f64) = (1.0, 1e6);
/// Angles, rad: what filters reach at best, and half a turn.
const ANGLES_RAD: (f64, f64) = (1e-4, core::f64::consts::PI);

/// An accepted table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ModeTable {
    pub(super) parameters: ModeParameters,
}

impl ModeTable {
    /// Accepts the numbers, and that each mode that is named has what it flies.
    ///
    /// # Errors
    /// [`ModeError`] with the first number that is refused.
    pub fn new(
        parameters: &ModeParameters,
        has_experiment: bool,
        has_check: bool,
    ) -> Result<Self, ModeError> {
        let p = parameters;
        let slow = (1e-5, FASTEST_RAD_S);
        let ranges = [
            ("despun_rad_s", p.despun_rad_s, slow),
            ("despun_for_s", p.despun_for_s, TIMES_S),
            ("tumbling_rad_s", p.tumbling_rad_s, slow),
            ("tumbling_for_s", p.tumbling_for_s, TIMES_S),
            ("detumble_limit_s", p.detumble_limit_s, TIMES_S),
            ("attitude_sigma_rad", p.attitude_sigma_rad, ANGLES_RAD),
            // Where it is not asked for any number stands.
            ("dipole_sigma_am2", p.dipole_sigma_am2.unwrap_or(1.0), (1e-6, 1e3)),
            ("slow_rad_s", p.slow_rad_s, slow),
            ("trusted_for_s", p.trusted_for_s, TIMES_S),
            ("acquire_limit_s", p.acquire_limit_s, TIMES_S),
            ("lost_for_s", p.lost_for_s, TIMES_S),
            ("captured_rad", p.captured_rad, ANGLES_RAD),
            ("captured_for_s", p.captured_for_s, TIMES_S),
            ("capture_limit_s", p.capture_limit_s, TIMES_S),
            ("experiment_s", p.experiment_s, TIMES_S),
            ("sensor_gap_s", p.sensor_gap_s, TIMES_S),
            ("sun_gap_s", p.sun_gap_s, TIMES_S),
            ("actuator_gap_s", p.actuator_gap_s, TIMES_S),
            ("growing_rounds", f32::from(p.growing_rounds), (2.0, 1e4)),
            ("growing_factor", p.growing_factor, (1.0, 100.0)),
            ("diverged_rad", p.diverged_rad, ANGLES_RAD),
            ("recovery_s", p.recovery_s, TIMES_S),
        ];
        parameter::check(&ranges.map(|(name, found, (from, to))| (name, found, from, to)))?;
        for (inner, is_below, outer) in [
            ("despun_rad_s", p.despun_rad_s < p.tumbling_rad_s, "tumbling_rad_s"),
            ("slow_rad_s", p.slow_rad_s < p.tumbling_rad_s, "tumbling_rad_s"),
            ("captured_rad", p.captured_rad < p.diverged_rad, "diverged_rad"),
            ("captured_for_s", p.captured_for_s < p.capture_limit_s, "capture_limit_s"),
            ("despun_for_s", p.despun_for_s < p.detumble_limit_s, "detumble_limit_s"),
            ("trusted_for_s", p.trusted_for_s < p.acquire_limit_s, "acquire_limit_s"),
        ] {
            if !is_below {
                return Err(ModeError::NoHysteresis { inner, outer });
            }
        }
        match (p.start, p.experiment_next) {
            (_, Mode::Experiment) => Err(ModeError::ExperimentNext),
            (Mode::Experiment, _) if !has_experiment => Err(ModeError::NoExperiment),
            (Mode::Commissioning, _) | (_, Mode::Commissioning) if !has_check => {
                Err(ModeError::NoCheck)
            }
            _ => Ok(Self { parameters: *parameters }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_usual_table_is_accepted() {
        assert!(ModeTable::new(&ModeParameters::default(), false, false).is_ok());
    }

    #[test]
    fn every_number_that_is_none_is_refused_by_its_name() {
        type Set = fn(&mut ModeParameters, f32);
        let set: [(&str, Set); 21] = [
            ("despun_rad_s", |p, x| p.despun_rad_s = x),
            ("despun_for_s", |p, x| p.despun_for_s = x),
            ("tumbling_rad_s", |p, x| p.tumbling_rad_s = x),
            ("tumbling_for_s", |p, x| p.tumbling_for_s = x),
            ("detumble_limit_s", |p, x| p.detumble_limit_s = x),
            ("attitude_sigma_rad", |p, x| p.attitude_sigma_rad = x),
            ("dipole_sigma_am2", |p, x| p.dipole_sigma_am2 = Some(x)),
            ("slow_rad_s", |p, x| p.slow_rad_s = x),
            ("trusted_for_s", |p, x| p.trusted_for_s = x),
            ("acquire_limit_s", |p, x| p.acquire_limit_s = x),
            ("lost_for_s", |p, x| p.lost_for_s = x),
            ("captured_rad", |p, x| p.captured_rad = x),
            ("captured_for_s", |p, x| p.captured_for_s = x),
            ("capture_limit_s", |p, x| p.capture_limit_s = x),
            ("experiment_s", |p, x| p.experiment_s = x),
            ("sensor_gap_s", |p, x| p.sensor_gap_s = x),
            ("sun_gap_s", |p, x| p.sun_gap_s = x),
            ("actuator_gap_s", |p, x| p.actuator_gap_s = x),
            ("growing_factor", |p, x| p.growing_factor = x),
            ("diverged_rad", |p, x| p.diverged_rad = x),
            ("recovery_s", |p, x| p.recovery_s = x),
        ];
        for (wanted, set) in set {
            for bad in [0.0, -1.0, f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
                let mut parameters = ModeParameters::default();
                set(&mut parameters, bad);
                match ModeTable::new(&parameters, false, false) {
                    Err(ModeError::OutOfRange(error)) => assert_eq!(error.name, wanted),
                    other => panic!("{wanted:?} {bad}: {other:?}"),
                }
            }
        }
        let parameters = ModeParameters { growing_rounds: 1, ..ModeParameters::default() };
        assert!(ModeTable::new(&parameters, false, false).is_err());
    }

    #[test]
    fn modes_that_would_alternate_are_refused() {
        let usual = ModeParameters::default();
        for (parameters, outer) in [
            (ModeParameters { tumbling_rad_s: usual.despun_rad_s, ..usual }, "tumbling_rad_s"),
            (ModeParameters { slow_rad_s: 0.039, ..usual }, "tumbling_rad_s"),
            (ModeParameters { diverged_rad: 0.2, ..usual }, "diverged_rad"),
            (ModeParameters { acquire_limit_s: 200.0, ..usual }, "acquire_limit_s"),
        ] {
            match ModeTable::new(&parameters, false, false) {
                Err(ModeError::NoHysteresis { outer: found, .. }) => assert_eq!(found, outer),
                other => panic!("{outer:?}: {other:?}"),
            }
        }
    }

    #[test]
    fn an_experiment_needs_a_law_and_another_mode_after_it() {
        let start = ModeParameters { start: Mode::Experiment, ..ModeParameters::default() };
        assert_eq!(ModeTable::new(&start, false, false), Err(ModeError::NoExperiment));
        assert!(ModeTable::new(&start, true, false).is_ok());
        let next = ModeParameters { experiment_next: Mode::Experiment, ..start };
        assert_eq!(ModeTable::new(&next, true, false), Err(ModeError::ExperimentNext));
        let check = ModeParameters { start: Mode::Commissioning, ..ModeParameters::default() };
        assert_eq!(ModeTable::new(&check, false, false), Err(ModeError::NoCheck));
        assert!(ModeTable::new(&check, false, true).is_ok());
    }
}
