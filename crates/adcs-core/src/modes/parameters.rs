//! The table of the mode machine: every condition's number, and why a number is refused.

use core::fmt;

use serde::{Deserialize, Serialize};

use super::Mode;

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

/// A number of [`ModeParameters`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[allow(missing_docs, reason = "each has the name of its field, which says what it is")]
pub enum ModeNumber {
    Despun,
    DespunFor,
    Tumbling,
    TumblingFor,
    DetumbleLimit,
    AttitudeSigma,
    DipoleSigma,
    Slow,
    TrustedFor,
    AcquireLimit,
    LostFor,
    Captured,
    CapturedFor,
    CaptureLimit,
    Experiment,
    SensorGap,
    SunGap,
    ActuatorGap,
    GrowingRounds,
    GrowingFactor,
    Diverged,
    Recovery,
}

impl ModeNumber {
    /// The name of its field.
    pub fn name(self) -> &'static str {
        match self {
            Self::Despun => "despun_rad_s",
            Self::DespunFor => "despun_for_s",
            Self::Tumbling => "tumbling_rad_s",
            Self::TumblingFor => "tumbling_for_s",
            Self::DetumbleLimit => "detumble_limit_s",
            Self::AttitudeSigma => "attitude_sigma_rad",
            Self::DipoleSigma => "dipole_sigma_am2",
            Self::Slow => "slow_rad_s",
            Self::TrustedFor => "trusted_for_s",
            Self::AcquireLimit => "acquire_limit_s",
            Self::LostFor => "lost_for_s",
            Self::Captured => "captured_rad",
            Self::CapturedFor => "captured_for_s",
            Self::CaptureLimit => "capture_limit_s",
            Self::Experiment => "experiment_s",
            Self::SensorGap => "sensor_gap_s",
            Self::SunGap => "sun_gap_s",
            Self::ActuatorGap => "actuator_gap_s",
            Self::GrowingRounds => "growing_rounds",
            Self::GrowingFactor => "growing_factor",
            Self::Diverged => "diverged_rad",
            Self::Recovery => "recovery_s",
        }
    }
}

/// Why a table is refused.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum ModeError {
    /// A number is out of its range, or none.
    OutOfRange {
        /// Which.
        number: ModeNumber,
        /// What was given.
        found: f32,
        /// The least that is taken.
        least: f32,
        /// The most.
        most: f32,
    },
    /// What leads back must be beyond what led in, or the modes alternate.
    NoHysteresis {
        /// What leads in.
        inner: ModeNumber,
        /// What leads back.
        outer: ModeNumber,
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
            Self::OutOfRange { number, found, least, most } => {
                write!(f, "{} = {found} must be from {least} to {most}", number.name())
            }
            Self::NoHysteresis { inner, outer } => {
                write!(f, "{} must be larger than {}", outer.name(), inner.name())
            }
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

/// Fastest rate that a condition may name, rad/s. The rate is a mean over 20 s, which turns a satellite's
/// own nutation at more than a radian in that time into 1/20 rad/s: no number may be near that.
const FASTEST_RAD_S: f32 = 0.04;
/// Shortest and longest times of a condition, s: a cycle or two, and some days.
const TIMES_S: (f32, f32) = (1.0, 1e6);
/// Angles, rad: what filters reach at best, and half a turn.
const ANGLES_RAD: (f32, f32) = (1e-4, core::f32::consts::PI);

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
        for (number, found, (least, most)) in [
            (ModeNumber::Despun, p.despun_rad_s, slow),
            (ModeNumber::DespunFor, p.despun_for_s, TIMES_S),
            (ModeNumber::Tumbling, p.tumbling_rad_s, slow),
            (ModeNumber::TumblingFor, p.tumbling_for_s, TIMES_S),
            (ModeNumber::DetumbleLimit, p.detumble_limit_s, TIMES_S),
            (ModeNumber::AttitudeSigma, p.attitude_sigma_rad, ANGLES_RAD),
            // Where it is not asked for any number stands.
            (ModeNumber::DipoleSigma, p.dipole_sigma_am2.unwrap_or(1.0), (1e-6, 1e3)),
            (ModeNumber::Slow, p.slow_rad_s, slow),
            (ModeNumber::TrustedFor, p.trusted_for_s, TIMES_S),
            (ModeNumber::AcquireLimit, p.acquire_limit_s, TIMES_S),
            (ModeNumber::LostFor, p.lost_for_s, TIMES_S),
            (ModeNumber::Captured, p.captured_rad, ANGLES_RAD),
            (ModeNumber::CapturedFor, p.captured_for_s, TIMES_S),
            (ModeNumber::CaptureLimit, p.capture_limit_s, TIMES_S),
            (ModeNumber::Experiment, p.experiment_s, TIMES_S),
            (ModeNumber::SensorGap, p.sensor_gap_s, TIMES_S),
            (ModeNumber::SunGap, p.sun_gap_s, TIMES_S),
            (ModeNumber::ActuatorGap, p.actuator_gap_s, TIMES_S),
            (ModeNumber::GrowingRounds, f32::from(p.growing_rounds), (2.0, 1e4)),
            (ModeNumber::GrowingFactor, p.growing_factor, (1.0, 100.0)),
            (ModeNumber::Diverged, p.diverged_rad, ANGLES_RAD),
            (ModeNumber::Recovery, p.recovery_s, TIMES_S),
        ] {
            // Nothing contains a NaN.
            if !(least..=most).contains(&found) {
                return Err(ModeError::OutOfRange { number, found, least, most });
            }
        }
        for (inner, is_below, outer) in [
            (ModeNumber::Despun, p.despun_rad_s < p.tumbling_rad_s, ModeNumber::Tumbling),
            (ModeNumber::Slow, p.slow_rad_s < p.tumbling_rad_s, ModeNumber::Tumbling),
            (ModeNumber::Captured, p.captured_rad < p.diverged_rad, ModeNumber::Diverged),
            (
                ModeNumber::CapturedFor,
                p.captured_for_s < p.capture_limit_s,
                ModeNumber::CaptureLimit,
            ),
            (ModeNumber::DespunFor, p.despun_for_s < p.detumble_limit_s, ModeNumber::DetumbleLimit),
            (ModeNumber::TrustedFor, p.trusted_for_s < p.acquire_limit_s, ModeNumber::AcquireLimit),
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
        let set: [(ModeNumber, Set); 21] = [
            (ModeNumber::Despun, |p, x| p.despun_rad_s = x),
            (ModeNumber::DespunFor, |p, x| p.despun_for_s = x),
            (ModeNumber::Tumbling, |p, x| p.tumbling_rad_s = x),
            (ModeNumber::TumblingFor, |p, x| p.tumbling_for_s = x),
            (ModeNumber::DetumbleLimit, |p, x| p.detumble_limit_s = x),
            (ModeNumber::AttitudeSigma, |p, x| p.attitude_sigma_rad = x),
            (ModeNumber::DipoleSigma, |p, x| p.dipole_sigma_am2 = Some(x)),
            (ModeNumber::Slow, |p, x| p.slow_rad_s = x),
            (ModeNumber::TrustedFor, |p, x| p.trusted_for_s = x),
            (ModeNumber::AcquireLimit, |p, x| p.acquire_limit_s = x),
            (ModeNumber::LostFor, |p, x| p.lost_for_s = x),
            (ModeNumber::Captured, |p, x| p.captured_rad = x),
            (ModeNumber::CapturedFor, |p, x| p.captured_for_s = x),
            (ModeNumber::CaptureLimit, |p, x| p.capture_limit_s = x),
            (ModeNumber::Experiment, |p, x| p.experiment_s = x),
            (ModeNumber::SensorGap, |p, x| p.sensor_gap_s = x),
            (ModeNumber::SunGap, |p, x| p.sun_gap_s = x),
            (ModeNumber::ActuatorGap, |p, x| p.actuator_gap_s = x),
            (ModeNumber::GrowingFactor, |p, x| p.growing_factor = x),
            (ModeNumber::Diverged, |p, x| p.diverged_rad = x),
            (ModeNumber::Recovery, |p, x| p.recovery_s = x),
        ];
        for (wanted, set) in set {
            for bad in [0.0, -1.0, f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
                let mut parameters = ModeParameters::default();
                set(&mut parameters, bad);
                match ModeTable::new(&parameters, false, false) {
                    Err(ModeError::OutOfRange { number, .. }) => assert_eq!(number, wanted),
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
            (ModeParameters { tumbling_rad_s: usual.despun_rad_s, ..usual }, ModeNumber::Tumbling),
            (ModeParameters { slow_rad_s: 0.039, ..usual }, ModeNumber::Tumbling),
            (ModeParameters { diverged_rad: 0.2, ..usual }, ModeNumber::Diverged),
            (ModeParameters { acquire_limit_s: 200.0, ..usual }, ModeNumber::AcquireLimit),
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
