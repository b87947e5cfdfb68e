//! What the filter is told about its sensors, and what it refuses to be told.

use nalgebra::{RealField, convert};
use serde::{Deserialize, Serialize};

use super::gyro::GyroSampling;
use crate::attitude::Method;
use crate::frames::{Body, Vector};
use crate::parameter::{self, OutOfRange};
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

impl<T: RealField + Copy> MekfParameters<T> {
    /// Whether every value is within its range: those of instruments one could fly. The lower ends of the
    /// noises keep the covariance where f32 holds it (docs/filters).
    pub(in crate::attitude) fn check(&self) -> Result<(), OutOfRange> {
        let FieldNoise { sensor_t, calibration_t, model_t } = self.field_noise;
        let Gates { field_nis, sun_nis, contradictions_in_a_row } = self.gates;
        let Limits { step_s, rate_rad_s, coast_s, coast_acceleration_rad_s2, linear_rad } =
            self.limits;
        let contradictions = convert(f64::from(contradictions_in_a_row));
        parameter::check(&[
            ("gyro_noise_rad_s", self.gyro_noise_rad_s, 1e-7, 0.1),
            ("bias_walk_rad_s_per_sqrt_s", self.bias_walk_rad_s_per_sqrt_s, 0.0, 1e-2),
            ("bias_prior_rad_s", self.bias_prior_rad_s, 1e-7, 1.0),
            ("field_noise.sensor_t", sensor_t, 1e-9, 2e-5),
            ("field_noise.calibration_t", calibration_t, 0.0, 2e-5),
            ("field_noise.model_t", model_t, 0.0, 2e-5),
            ("sun_noise_rad", self.sun_noise_rad, 1e-4, 0.35),
            ("gates.field_nis", field_nis, 6.0, 1e6),
            ("gates.sun_nis", sun_nis, 4.0, 1e6),
            ("gates.contradictions_in_a_row", contradictions, 1.0, 255.0),
            ("limits.step_s", step_s, 1e-3, 60.0),
            ("limits.rate_rad_s", rate_rad_s, 1e-3, 100.0),
            ("limits.coast_s", coast_s, 0.0, 600.0),
            ("limits.coast_acceleration_rad_s2", coast_acceleration_rad_s2, 0.0, 10.0),
            ("limits.linear_rad", linear_rad, 1e-2, 1.0),
        ])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(change: impl FnOnce(&mut MekfParameters<f32>)) -> Option<&'static str> {
        let mut parameters = MekfParameters::default();
        change(&mut parameters);
        parameters.check().err().map(|error| error.name)
    }

    #[test]
    fn the_default_is_accepted_in_both_precisions() {
        assert_eq!(MekfParameters::<f32>::default().check(), Ok(()));
        assert_eq!(MekfParameters::<f64>::default().check(), Ok(()));
    }

    #[test]
    fn impossible_values_are_refused_by_name() {
        for bad in [0.0, -1.0, f32::NAN, f32::INFINITY] {
            assert_eq!(refused(|p| p.gyro_noise_rad_s = bad), Some("gyro_noise_rad_s"));
            assert_eq!(refused(|p| p.sun_noise_rad = bad), Some("sun_noise_rad"));
            assert_eq!(refused(|p| p.field_noise.sensor_t = bad), Some("field_noise.sensor_t"));
            assert_eq!(refused(|p| p.limits.step_s = bad), Some("limits.step_s"));
        }
        // A forgotten factor of 1e9 or 57.
        assert_eq!(refused(|p| p.field_noise.sensor_t = 500.0), Some("field_noise.sensor_t"));
        assert_eq!(refused(|p| p.sun_noise_rad = 0.664), Some("sun_noise_rad"));
        let none = refused(|p| p.gates.contradictions_in_a_row = 0);
        assert_eq!(none, Some("gates.contradictions_in_a_row"));
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
