//! What is decided before a flight: parameters as they are stored and uplinked, and why they may be
//! refused.

use core::fmt;

use adcs_core::attitude::dynamic::DynamicError;
use adcs_core::attitude::selection::{Estimator, EstimatorParameters, Flies};
use adcs_core::commissioning::{CommissioningError, CommissioningParameters, Ladder, Told};
use adcs_core::control::allocation::{Allocation, AllocationError, TorquerParameters};
use adcs_core::control::b_dot::{BDot, BDotGain, GainError};
use adcs_core::control::bang_bang::{BangBang, BangBangError, BangBangParameters};
use adcs_core::control::cross_product::{CrossProduct, CrossProductError, CrossProductParameters};
use adcs_core::control::feed_forward::{FeedForward, SigmaError};
use adcs_core::control::guidance::{AimError, Guidance, GuidanceParameters};
use adcs_core::control::periodic::{PeriodicError, PeriodicLaw, PeriodicParameters};
use adcs_core::environment::sun_track::SunTrack;
use adcs_core::identification::Noise;
use adcs_core::modes::{Flown, ModeError, ModeParameters, ModeTable, Modes, Polarity};
use adcs_core::orbit::OrbitModel;
use adcs_core::orbit::interpolated::InterpolatedOrbit;
use adcs_core::pipeline::{Configuration, Law, Pointing, RateFrom, Steering, SteeringParameters};
use adcs_core::polarity::{ActiveCheck, Guard, PolarityError, PolarityParameters};
use adcs_core::schedule::{Round, Schedule, ScheduleError, ScheduleParameters};
use adcs_core::sensing::{
    SunFaces, SunFacesError, SunFacesParameters, Triad, TriadError, TriadParameters,
};
use adcs_core::time::LeapSeconds;
use serde::{Deserialize, Serialize};
use sgp4_lite::Elements;

/// The law of stage III and its gain.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum LawParameters {
    /// The torquers stay off.
    Off,
    /// Despin from gyro and magnetometer.
    BDot(BDotGain),
    /// Despin at full dipole, by sign.
    BangBang(BangBangParameters),
    /// An attitude is taken and held by the cross-product law.
    CrossProduct {
        /// Gains and terms.
        law: CrossProductParameters,
        /// Where to point.
        guidance: GuidanceParameters,
    },
    /// The same by the periodic optimal law.
    Periodic {
        /// Weights, horizon and inertia.
        law: PeriodicParameters,
        /// What flies while there is no plan.
        unplanned: CrossProductParameters,
        /// Where to point.
        guidance: GuidanceParameters,
    },
}

/// A law and what surrounds it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct FlownParameters {
    /// The law.
    pub law: LawParameters,
    /// What surrounds it.
    pub steering: SteeringParameters,
}

/// The mode machine: its table, and which law flies in which mode. The law that points is the flight's
/// own ([`FlightParameters::law`]).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ModesParameters {
    /// When to go from mode to mode.
    pub table: ModeParameters,
    /// What detumbles. While the attitude is acquired it flies on, with the rate of stage II and the
    /// feed-forward of the law that points.
    pub despin: FlownParameters,
    /// What flies in an experiment; `None` when there is none.
    pub experiment: Option<FlownParameters>,
    /// What looks after the wiring; `None` to trust it.
    pub polarity: Option<PolarityParameters>,
    /// The commissioning ladder, which needs what looks after the wiring; `None` for its active check alone.
    pub commissioning: Option<CommissioningParameters>,
}

/// Everything that a satellite team configures for its flight.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct FlightParameters {
    /// The cycle period, µs.
    pub cycle_us: u32,
    /// When to rest and when to act.
    pub schedule: ScheduleParameters,
    /// The law of stage III; with modes, that of pointing.
    pub law: LawParameters,
    /// What surrounds the law.
    pub steering: SteeringParameters,
    /// The mode machine; `None` to fly the one law from start to end.
    pub modes: Option<ModesParameters>,
    /// The gyros' correction; rad/s.
    pub gyro: TriadParameters,
    /// The magnetometer's correction; T.
    pub magnetometer: TriadParameters,
    /// The Sun sensors; `None` on a satellite without.
    pub sun_sensors: Option<SunFacesParameters>,
    /// The filters of stage II; `None` to fly without attitude.
    pub attitude: Option<EstimatorParameters>,
    /// The torquers' limit and mounting.
    pub torquers: TorquerParameters,
    /// Mean elements of the orbit; despin flies without them.
    pub elements: Option<Elements>,
}

/// Which parameters are refused, and why.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum ParameterError {
    /// The schedule.
    Schedule(ScheduleError),
    /// The law's gain.
    Gain(GainError),
    /// The bang-bang law's dipole or dead band.
    BangBang(BangBangError),
    /// The cross-product law's gains or inertia.
    CrossProduct(CrossProductError),
    /// The periodic optimal law's weights, horizon or inertia.
    Periodic(PeriodicError),
    /// Where to point, or how to get there.
    Aim(AimError),
    /// The mode machine's table or laws.
    Modes(ModeError),
    /// What looks after the wiring.
    Polarity(PolarityError),
    /// The commissioning ladder.
    Commissioning(CommissioningError),
    /// The accuracy from which on the residual dipole is fed forward.
    FeedForward(SigmaError),
    /// The gyros' correction.
    Gyro(TriadError),
    /// The magnetometer's correction.
    Magnetometer(TriadError),
    /// The Sun sensors.
    SunSensors(SunFacesError),
    /// The filters of stage II.
    Attitude(DynamicError),
    /// The torquers' limit or mounting.
    Torquers(AllocationError),
    /// The orbit's elements.
    Orbit(sgp4_lite::Error),
}

impl fmt::Display for ParameterError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Schedule(error) => write!(f, "schedule: {error}"),
            Self::Gain(error) => write!(f, "law: {error}"),
            Self::BangBang(error) => write!(f, "law: {error}"),
            Self::CrossProduct(error) => write!(f, "law: {error}"),
            Self::Periodic(error) => write!(f, "law: {error}"),
            Self::Aim(error) => write!(f, "law: {error}"),
            Self::Modes(error) => write!(f, "modes: {error}"),
            Self::Polarity(error) => write!(f, "polarity: {error}"),
            Self::Commissioning(error) => write!(f, "commissioning: {error}"),
            Self::FeedForward(error) => write!(f, "law: {error}"),
            Self::Gyro(error) => write!(f, "gyro: {error}"),
            Self::Magnetometer(error) => write!(f, "magnetometer: {error}"),
            Self::SunSensors(error) => write!(f, "Sun sensors: {error}"),
            Self::Attitude(error) => write!(f, "attitude: {error}"),
            Self::Torquers(error) => write!(f, "torquers: {error}"),
            Self::Orbit(error) => write!(f, "orbit: {error}"),
        }
    }
}

impl core::error::Error for ParameterError {}

impl LawParameters {
    /// Accepts the law.
    ///
    /// # Errors
    /// [`ParameterError`] with what is refused of it.
    pub fn accept(&self) -> Result<Law, ParameterError> {
        Ok(match self {
            Self::Off => Law::Off,
            Self::BDot(gain) => Law::BDot(BDot::new(*gain).map_err(ParameterError::Gain)?),
            Self::BangBang(law) => {
                Law::BangBang(BangBang::new(law).map_err(ParameterError::BangBang)?)
            }
            Self::CrossProduct { law, guidance } => Law::Pointing(Pointing {
                law: CrossProduct::new(law).map_err(ParameterError::CrossProduct)?,
                periodic: None,
                guidance: Guidance::new(guidance).map_err(ParameterError::Aim)?,
            }),
            Self::Periodic { law, unplanned, guidance } => Law::Pointing(Pointing {
                law: CrossProduct::new(unplanned).map_err(ParameterError::CrossProduct)?,
                periodic: Some(PeriodicLaw::new(law).map_err(ParameterError::Periodic)?),
                guidance: Guidance::new(guidance).map_err(ParameterError::Aim)?,
            }),
        })
    }
}

impl FlownParameters {
    #[inline(never)]
    /// Accepts the law and what surrounds it.
    ///
    /// # Errors
    /// [`ParameterError`] with what is refused.
    pub fn accept(&self, round: Round) -> Result<Flown, ParameterError> {
        let SteeringParameters { rate, cut_hold, feed_forward_sigma_am2 } = self.steering;
        let feed_forward = feed_forward_sigma_am2.map(FeedForward::new).transpose();
        let feed_forward = feed_forward.map_err(ParameterError::FeedForward)?;
        let steering = Steering { rate, cut_hold, feed_forward, round };
        Ok(Flown { law: self.law.accept()?, steering })
    }
}

impl ModesParameters {
    /// Accepts the mode machine beside the law that points and the filters of stage II.
    ///
    /// # Errors
    /// [`ParameterError`] with what is refused.
    pub fn accept(
        &self,
        pointing: &Flown,
        attitude: Option<&EstimatorParameters>,
        (magnetometer, settle_s): (&TriadParameters, f32),
    ) -> Result<Modes, ParameterError> {
        let despin = self.despin.accept(pointing.steering.round)?;
        let experiment =
            self.experiment.map(|it| it.accept(pointing.steering.round)).transpose()?;
        let has_check = self.polarity.is_some();
        let table = ModeTable::new(&self.table, experiment.is_some(), has_check);
        let table = table.map_err(ParameterError::Modes)?;
        let refusal = match attitude {
            _ if matches!(despin.law, Law::Off) || despin.law.points() => {
                Some(ModeError::NotDespin)
            }
            _ if !pointing.law.points() => Some(ModeError::NotPointing),
            None => Some(ModeError::NoAttitude),
            _ if self.commissioning.is_some() && !has_check => Some(ModeError::NoCheck),
            Some(EstimatorParameters { flies: Flies::Mekf, .. })
                if self.table.dipole_sigma_am2.is_some() =>
            {
                Some(ModeError::NoDipole)
            }
            Some(_) => None,
        };
        if let Some(error) = refusal {
            return Err(ParameterError::Modes(error));
        }
        let acquire = Steering {
            rate: RateFrom::Estimate,
            feed_forward: pointing.steering.feed_forward,
            ..despin.steering
        };
        let polarity = self.polarity.as_ref().map(|parameters| -> Result<_, PolarityError> {
            Ok(Polarity { guard: Guard::new(parameters)?, check: ActiveCheck::new(parameters)? })
        });
        let polarity = polarity.transpose().map_err(ParameterError::Polarity)?;
        let ladder =
            self.commissioning.as_ref().zip(self.polarity).map(|(parameters, polarity)| {
                let told = Told {
                    magnetometer: *magnetometer,
                    inertia_kg_m2: polarity.inertia_kg_m2,
                    noise: Noise {
                        rate_rad_s: polarity.gyro_noise_rad_s,
                        field_t: polarity.field_noise_t,
                        ..Noise::default()
                    },
                    settle_s,
                };
                Ladder::new(parameters, &told)
            });
        let ladder = ladder.transpose().map_err(ParameterError::Commissioning)?;
        Ok(Modes { table, despin, acquire, experiment, polarity, ladder })
    }
}

impl FlightParameters {
    /// Accepts the parameters: what can fail fails here, and not in a cycle.
    ///
    /// # Errors
    /// [`ParameterError`] says which part is refused and why; what was in force should stay so.
    pub fn accept(&self) -> Result<(Schedule, Configuration), ParameterError> {
        let schedule =
            Schedule::new(&self.schedule, self.cycle_us).map_err(ParameterError::Schedule)?;
        let flown = FlownParameters { law: self.law, steering: self.steering };
        let flown = flown.accept(self.schedule.round())?;
        let settle_s = self.schedule.settle_us as f32 * 1e-6;
        let modes = self.modes.map(|modes| {
            modes.accept(&flown, self.attitude.as_ref(), (&self.magnetometer, settle_s))
        });
        let modes = modes.transpose()?;
        let Flown { law, steering } = flown;
        let orbit = match &self.elements {
            Some(elements) => {
                let model = OrbitModel::new(elements).map_err(ParameterError::Orbit)?;
                Some(InterpolatedOrbit::new(model))
            }
            None => None,
        };
        let estimator = self.attitude.as_ref().map(Estimator::new);
        let sun_faces = self.sun_sensors.as_ref().map(SunFaces::new);
        let configuration = Configuration {
            orbit,
            sun: SunTrack::new(LeapSeconds::BUILT_IN),
            gyro: Triad::new(&self.gyro).map_err(ParameterError::Gyro)?,
            magnetometer: Triad::new(&self.magnetometer).map_err(ParameterError::Magnetometer)?,
            sun_faces: sun_faces.transpose().map_err(ParameterError::SunSensors)?,
            estimator: estimator.transpose().map_err(ParameterError::Attitude)?,
            law,
            steering,
            modes,
            allocation: Allocation::new(&self.torquers).map_err(ParameterError::Torquers)?,
        };
        Ok((schedule, configuration))
    }
}
