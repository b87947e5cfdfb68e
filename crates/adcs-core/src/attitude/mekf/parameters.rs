//! What the filter is told about its sensors, and what it refuses to be told.

use core::fmt;

use nalgebra::{RealField, convert};
use serde::{Deserialize, Serialize};

use super::gyro::GyroSampling;
use crate::attitude::Method;
use crate::frames::{Body, Vector};
use crate::reading::Reading;

/// The filter's tuning as it is stored and uplinked.
///
/// Noise follows the calibration: a better one is a new set of parameters, and the state stays as it is.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct MekfParameters<T> {
    /// σ of one gyro sample, each axis, rad/s.
    pub gyro_noise_rad_s: T,
    /// What a gyro sample stands for.
    pub gyro_sampling: GyroSampling,
    /// How the gyro bias walks, each axis, rad/s per √s.
    pub bias_walk_rad_s_per_sqrt_s: T,
    /// σ of the gyro bias before anything is known of it, each axis, rad/s.
    pub bias_prior_rad_s: T,
    /// What stands between the measured field and the model's.
    pub field_noise: FieldNoise<T>,
    /// σ of the Sun's direction across the line of sight, each of two axes, rad.
    pub sun_noise_rad: T,
    /// When a measurement contradicts the estimate.
    pub gates: Gates<T>,
    /// How far the filter trusts itself.
    pub limits: Limits<T>,
    /// How attitude is found from field and Sun when the filter has none.
    pub start: Method,
}

/// What stands between the measured field and the model's, σ of each axis, T. The parts add as squares.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct FieldNoise<T> {
    /// The magnetometer's own noise.
    pub sensor_t: T,
    /// What its calibration leaves.
    pub calibration_t: T,
    /// What IGRF and the age of the orbit leave.
    pub model_t: T,
}

/// When a measurement contradicts the estimate.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Gates<T> {
    /// Largest accepted NIS of a field, 3 degrees of freedom.
    pub field_nis: T,
    /// Largest accepted NIS of a Sun, 2 degrees of freedom.
    pub sun_nis: T,
    /// How many contradictions in a row of one sensor put the estimate itself in doubt.
    pub contradictions_in_a_row: u8,
}

/// How far the filter trusts itself.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Limits<T> {
    /// Longest step, s.
    pub step_s: T,
    /// Fastest rate that a gyro reports, each axis, rad/s; faster ones count as missing.
    pub rate_rad_s: T,
    /// Longest time without a gyro, s.
    pub coast_s: T,
    /// How fast the rate may change meanwhile, each axis, rad/s².
    pub coast_acceleration_rad_s2: T,
    /// Largest attitude σ within which the equations count as linear, rad; beyond it the attitude is
    /// found anew as soon as field and Sun are there.
    pub linear_rad: T,
}

impl<T: RealField + Copy> Default for MekfParameters<T> {
    /// SPROUT's sensors as in the paper (docs/paper; the magnetometer's 0.586 nT read as µT), a bias
    /// that walks by 1e-4 deg/s in a second as that of automotive MEMS gyros does, 100 nT of crust and
    /// ring current that IGRF does not know, and nothing left by calibration: that is for the
    /// calibration to say.
    fn default() -> Self {
        let value = convert::<f64, T>;
        let deg = |degrees: f64| value(degrees.to_radians());
        Self {
            gyro_noise_rad_s: deg(0.163),
            gyro_sampling: GyroSampling::Instant,
            bias_walk_rad_s_per_sqrt_s: deg(1e-4),
            bias_prior_rad_s: deg(0.5),
            field_noise: FieldNoise {
                sensor_t: value(586e-9),
                calibration_t: T::zero(),
                model_t: value(100e-9),
            },
            sun_noise_rad: deg(0.664),
            gates: Gates::default(),
            limits: Limits::default(),
            start: Method::Foam,
        }
    }
}

impl<T: RealField> Default for Gates<T> {
    /// A good measurement is refused once in 1e5: χ² quantiles of 3 and 2 degrees of freedom. At one a
    /// second that is once a day, and five in a row never.
    fn default() -> Self {
        Self { field_nis: convert(25.90), sun_nis: convert(23.03), contradictions_in_a_row: 5 }
    }
}

impl<T: RealField> Default for Limits<T> {
    /// Gyro: 300 deg/s, the range of such chips. Coasting: 10 s; a 9 deg/s tumble, with moments of
    /// inertia within 10 % of each other, changes its rate by 2.5e-3 rad/s² at most. Linear: 20 deg,
    /// where sin α is 2 % from α.
    fn default() -> Self {
        Self {
            step_s: convert(10.0),
            rate_rad_s: convert(5.2),
            coast_s: convert(10.0),
            coast_acceleration_rad_s2: convert(2.5e-3),
            linear_rad: convert(0.35),
        }
    }
}

impl<T: RealField + Copy> Limits<T> {
    /// What a gyro shows, unless it is missing or faster than any that a gyro reports.
    pub(in crate::attitude) fn possible_rate(
        &self,
        gyro: Reading<Vector<Body, T>>,
    ) -> Option<Vector<Body, T>> {
        gyro.value().filter(|rate| rate.is_finite() && rate.xyz.amax() <= self.rate_rad_s)
    }
}

impl<T: RealField + Copy> FieldNoise<T> {
    /// All parts together, σ of each axis, T.
    pub fn sigma_t(&self) -> T {
        let Self { sensor_t, calibration_t, model_t } = *self;
        (sensor_t * sensor_t + calibration_t * calibration_t + model_t * model_t).sqrt()
    }
}

/// Which parameter was refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Parameter {
    /// [`MekfParameters::gyro_noise_rad_s`].
    GyroNoise,
    /// [`MekfParameters::bias_walk_rad_s_per_sqrt_s`].
    BiasWalk,
    /// [`MekfParameters::bias_prior_rad_s`].
    BiasPrior,
    /// [`FieldNoise::sensor_t`].
    FieldSensor,
    /// [`FieldNoise::calibration_t`].
    FieldCalibration,
    /// [`FieldNoise::model_t`].
    FieldModel,
    /// [`MekfParameters::sun_noise_rad`].
    SunNoise,
    /// [`Gates::field_nis`].
    FieldGate,
    /// [`Gates::sun_nis`].
    SunGate,
    /// [`Gates::contradictions_in_a_row`].
    Contradictions,
    /// [`Limits::step_s`].
    Step,
    /// [`Limits::rate_rad_s`].
    Rate,
    /// [`Limits::coast_s`].
    Coast,
    /// [`Limits::coast_acceleration_rad_s2`].
    CoastAcceleration,
    /// [`Limits::linear_rad`].
    Linear,
    /// [`GivenStart::attitude_sigma_rad`](super::GivenStart::attitude_sigma_rad).
    StartAttitudeSigma,
    /// [`GivenStart::gyro_bias`](super::GivenStart::gyro_bias), an axis.
    StartBias,
    /// [`GivenStart::gyro_bias_sigma_rad_s`](super::GivenStart::gyro_bias_sigma_rad_s).
    StartBiasSigma,
}

/// A value outside the range in which the filter works; what was in force stays.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct MekfError {
    /// Which.
    pub parameter: Parameter,
    /// What was given, in the parameter's unit.
    pub found: f64,
}

impl fmt::Display for MekfError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Range { name, unit, from, to } = self.parameter.range();
        write!(f, "{name} is {:e}, it must be from {from:e} to {to:e} {unit}", self.found)
    }
}

impl core::error::Error for MekfError {}

/// What a parameter is called and may be.
struct Range {
    name: &'static str,
    unit: &'static str,
    from: f64,
    to: f64,
}

impl Parameter {
    /// The ranges are those of instruments one could fly. The lower ends of the noises keep the
    /// covariance where f32 holds it (docs/filters).
    fn range(self) -> Range {
        let range = |name, unit, from, to| Range { name, unit, from, to };
        match self {
            Self::GyroNoise => range("the gyro's noise", "rad/s", 1e-7, 0.1),
            Self::BiasWalk => range("the walk of the gyro bias", "rad/s per root s", 0.0, 1e-2),
            Self::BiasPrior => range("the prior of the gyro bias", "rad/s", 1e-7, 1.0),
            Self::FieldSensor => range("the magnetometer's noise", "T", 1e-9, 2e-5),
            Self::FieldCalibration => range("what calibration leaves", "T", 0.0, 2e-5),
            Self::FieldModel => range("the field model's noise", "T", 0.0, 2e-5),
            Self::SunNoise => range("the Sun sensor's noise", "rad", 1e-4, 0.35),
            Self::FieldGate => range("the field's gate", "(NIS)", 6.0, 1e6),
            Self::SunGate => range("the Sun's gate", "(NIS)", 4.0, 1e6),
            Self::Contradictions => range("contradictions in a row", "", 1.0, 255.0),
            Self::Step => range("the longest step", "s", 1e-3, 60.0),
            Self::Rate => range("the fastest rate", "rad/s", 1e-3, 100.0),
            Self::Coast => range("the longest time without gyro", "s", 0.0, 600.0),
            Self::CoastAcceleration => {
                range("the acceleration without gyro", "rad/s per s", 0.0, 10.0)
            }
            Self::Linear => range("the limit of linearity", "rad", 1e-2, 1.0),
            Self::StartAttitudeSigma => {
                range("the start's attitude sigma", "rad", 1e-6, core::f64::consts::PI)
            }
            Self::StartBias => range("the start's gyro bias", "rad/s", -1.0, 1.0),
            Self::StartBiasSigma => range("the start's bias sigma", "rad/s", 1e-9, 1.0),
        }
    }

    /// Refuses a value outside the range, NaN too.
    pub(super) fn check<T: RealField + Copy>(self, value: T) -> Result<(), MekfError> {
        let Range { from, to, .. } = self.range();
        let within = value >= convert(from) && value <= convert(to);
        let found = || value.to_subset_unchecked();
        within.then_some(()).ok_or_else(|| MekfError { parameter: self, found: found() })
    }
}

impl<T: RealField + Copy> MekfParameters<T> {
    /// Whether every value is within its range.
    pub(in crate::attitude) fn check(&self) -> Result<(), MekfError> {
        let FieldNoise { sensor_t, calibration_t, model_t } = self.field_noise;
        let Gates { field_nis, sun_nis, contradictions_in_a_row } = self.gates;
        let Limits { step_s, rate_rad_s, coast_s, coast_acceleration_rad_s2, linear_rad } =
            self.limits;
        let values = [
            (Parameter::GyroNoise, self.gyro_noise_rad_s),
            (Parameter::BiasWalk, self.bias_walk_rad_s_per_sqrt_s),
            (Parameter::BiasPrior, self.bias_prior_rad_s),
            (Parameter::FieldSensor, sensor_t),
            (Parameter::FieldCalibration, calibration_t),
            (Parameter::FieldModel, model_t),
            (Parameter::SunNoise, self.sun_noise_rad),
            (Parameter::FieldGate, field_nis),
            (Parameter::SunGate, sun_nis),
            (Parameter::Contradictions, convert(f64::from(contradictions_in_a_row))),
            (Parameter::Step, step_s),
            (Parameter::Rate, rate_rad_s),
            (Parameter::Coast, coast_s),
            (Parameter::CoastAcceleration, coast_acceleration_rad_s2),
            (Parameter::Linear, linear_rad),
        ];
        values.iter().try_for_each(|(parameter, value)| parameter.check(*value))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(change: impl FnOnce(&mut MekfParameters<f32>)) -> Option<Parameter> {
        let mut parameters = MekfParameters::default();
        change(&mut parameters);
        parameters.check().err().map(|error| error.parameter)
    }

    #[test]
    fn the_default_is_accepted_in_both_precisions() {
        assert_eq!(MekfParameters::<f32>::default().check(), Ok(()));
        assert_eq!(MekfParameters::<f64>::default().check(), Ok(()));
    }

    #[test]
    fn impossible_values_are_refused_by_name() {
        for bad in [0.0, -1.0, f32::NAN, f32::INFINITY] {
            assert_eq!(refused(|p| p.gyro_noise_rad_s = bad), Some(Parameter::GyroNoise));
            assert_eq!(refused(|p| p.sun_noise_rad = bad), Some(Parameter::SunNoise));
            assert_eq!(refused(|p| p.field_noise.sensor_t = bad), Some(Parameter::FieldSensor));
            assert_eq!(refused(|p| p.limits.step_s = bad), Some(Parameter::Step));
        }
        // A forgotten factor of 1e9 or 57.
        assert_eq!(refused(|p| p.field_noise.sensor_t = 500.0), Some(Parameter::FieldSensor));
        assert_eq!(refused(|p| p.sun_noise_rad = 0.664), Some(Parameter::SunNoise));
        let none = refused(|p| p.gates.contradictions_in_a_row = 0);
        assert_eq!(none, Some(Parameter::Contradictions));
        // No walk and nothing left by a calibration are possible.
        assert_eq!(refused(|p| p.bias_walk_rad_s_per_sqrt_s = 0.0), None);
        assert_eq!(refused(|p| p.field_noise.calibration_t = 0.0), None);
    }

    #[test]
    fn parts_of_the_fields_noise_add_as_squares() {
        let noise = FieldNoise { sensor_t: 2e-7, calibration_t: 3e-7, model_t: 6e-7_f64 };
        assert!((noise.sigma_t() - 7e-7).abs() < 1e-20);
    }
}
