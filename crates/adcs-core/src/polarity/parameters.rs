//! What the polarity guard is told.

use core::fmt;

use nalgebra::Matrix3;
use serde::{Deserialize, Serialize};

use crate::attitude::dynamic::DynamicParameters;
use crate::parameter::{self, OutOfRange};

/// No calibration leaves less, T.
const LEAST_FIELD_BIAS_T: f32 = 100e-9;

/// The guard's tuning as it is stored and uplinked.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PolarityParameters {
    /// The inertia tensor as well as it is known before flight, Body, kg·m².
    pub inertia_kg_m2: [[f32; 3]; 3],
    /// σ of each moment and product of inertia, in units of the mean moment.
    pub inertia_prior: f32,
    /// σ of the residual dipole, each axis, A·m².
    pub dipole_prior_am2: f32,
    /// σ of one gyro sample, each axis, rad/s.
    pub gyro_noise_rad_s: f32,
    /// σ of the gyro bias, each axis, rad/s.
    pub gyro_bias_rad_s: f32,
    /// σ of one measured field, each axis, T.
    pub field_noise_t: f32,
    /// σ of what the magnetometer shows too much, each axis, T.
    pub field_bias_t: f32,
    /// What is not modelled of the rate's change, each axis, rad/s per √s.
    pub rate_walk_rad_s_per_sqrt_s: f32,
    /// The odds, as a natural logarithm, at which a wiring counts as wrong.
    pub log_odds: f32,
    /// Dipole of the pulses of the active check, A·m².
    pub pulse_am2: f32,
}

impl Default for PolarityParameters {
    /// SPROUT's preset A2 and sensors (docs/paper).
    ///
    /// Rate walk: a torque of 2e-7 N·m that nobody models changes the rate by 3.5e-5 rad/s in a round; drag
    /// and gravity gradient stay below it. Odds: the false alarms that docs/polarity counts.
    fn default() -> Self {
        Self {
            inertia_kg_m2: [
                [0.05184, 0.00058, -0.00077],
                [0.00058, 0.05416, 0.00069],
                [-0.00077, 0.00069, 0.05978],
            ],
            inertia_prior: 0.06,
            dipole_prior_am2: 0.5,
            gyro_noise_rad_s: 2.845e-3,
            gyro_bias_rad_s: 5e-3,
            field_noise_t: 600e-9,
            field_bias_t: LEAST_FIELD_BIAS_T,
            rate_walk_rad_s_per_sqrt_s: 1e-5,
            log_odds: 10.0,
            pulse_am2: 0.6,
        }
    }
}

/// Why parameters are refused; what was in force stays.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum PolarityError {
    /// The inertia tensor is not symmetric, not positive definite, or not finite.
    Inertia,
    /// A number outside its range.
    OutOfRange(OutOfRange),
}

impl fmt::Display for PolarityError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Inertia => {
                write!(f, "the inertia tensor must be symmetric and positive definite")
            }
            Self::OutOfRange(error) => error.fmt(f),
        }
    }
}

impl core::error::Error for PolarityError {}

impl From<OutOfRange> for PolarityError {
    fn from(error: OutOfRange) -> Self {
        Self::OutOfRange(error)
    }
}

impl PolarityParameters {
    /// What the filters of stage II are told of the same satellite, with the torquers' full dipole for
    /// the pulses, A·m².
    ///
    /// A residual dipole that they are told is as large as it is: the guard begins at none, and takes what it
    /// cannot believe to be the magnet's for a wrong wiring.
    pub fn of(told: &DynamicParameters<f32>, pulse_am2: f32) -> Self {
        let field_noise = told.sensors.field_noise;
        let learned = if told.blocks.field_bias { told.field_bias_prior_t } else { 0.0 };
        Self {
            inertia_kg_m2: told.inertia_kg_m2,
            dipole_prior_am2: told.dipole_am2.iter().fold(told.dipole_prior_am2, |prior, told| {
                if told.abs() > prior { told.abs() } else { prior }
            }),
            gyro_noise_rad_s: told.sensors.gyro_noise_rad_s,
            gyro_bias_rad_s: told.sensors.bias_prior_rad_s,
            field_noise_t: field_noise.sensor_t,
            field_bias_t: field_noise.calibration_t.max(learned).max(LEAST_FIELD_BIAS_T),
            pulse_am2,
            ..Self::default()
        }
    }

    /// The tensor, when guard and check can work with all of this.
    pub(super) fn check(&self) -> Result<Matrix3<f32>, PolarityError> {
        let [tensor, _] = parameter::inertia(self.inertia_kg_m2).ok_or(PolarityError::Inertia)?;
        parameter::check(&[
            ("inertia_kg_m2, its mean moment", tensor.trace() / 3.0, 1e-6, 1e4),
            ("inertia_prior", self.inertia_prior, 1e-4, 0.3),
            ("dipole_prior_am2", self.dipole_prior_am2, 1e-4, 100.0),
            ("gyro_noise_rad_s", self.gyro_noise_rad_s, 1e-7, 0.1),
            ("gyro_bias_rad_s", self.gyro_bias_rad_s, 1e-7, 1.0),
            ("field_noise_t", self.field_noise_t, 1e-9, 2e-5),
            ("field_bias_t", self.field_bias_t, 1e-9, 2e-5),
            ("rate_walk_rad_s_per_sqrt_s", self.rate_walk_rad_s_per_sqrt_s, 1e-8, 1e-2),
            ("log_odds", self.log_odds, 3.0, 100.0),
            ("pulse_am2", self.pulse_am2, 1e-4, 100.0),
        ])?;
        Ok(tensor)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(change: impl FnOnce(&mut PolarityParameters)) -> Option<PolarityError> {
        let mut parameters = PolarityParameters::default();
        change(&mut parameters);
        parameters.check().err()
    }

    #[test]
    fn the_default_is_accepted_and_impossible_values_are_refused_by_name() {
        type Field = fn(&mut PolarityParameters) -> &mut f32;
        assert_eq!(refused(|_| ()), None);
        let fields: [(Field, &str); 9] = [
            (|p| &mut p.inertia_prior, "inertia_prior"),
            (|p| &mut p.dipole_prior_am2, "dipole_prior_am2"),
            (|p| &mut p.gyro_noise_rad_s, "gyro_noise_rad_s"),
            (|p| &mut p.gyro_bias_rad_s, "gyro_bias_rad_s"),
            (|p| &mut p.field_noise_t, "field_noise_t"),
            (|p| &mut p.field_bias_t, "field_bias_t"),
            (|p| &mut p.rate_walk_rad_s_per_sqrt_s, "rate_walk_rad_s_per_sqrt_s"),
            (|p| &mut p.log_odds, "log_odds"),
            (|p| &mut p.pulse_am2, "pulse_am2"),
        ];
        for (field, expected) in fields {
            for bad in [f32::NAN, f32::INFINITY, 0.0, -1.0, 1e9] {
                match refused(|p| *field(p) = bad) {
                    Some(PolarityError::OutOfRange(error)) => assert_eq!(error.name, expected),
                    other => panic!("{expected} {bad}: {other:?}"),
                }
            }
        }
    }

    #[test]
    fn a_dipole_that_the_filters_are_told_is_no_surprise_to_the_guard() {
        let unknown = DynamicParameters::<f32>::default();
        let prior =
            |told: &DynamicParameters<f32>| PolarityParameters::of(told, 0.6).dipole_prior_am2;
        assert_eq!(prior(&unknown), unknown.dipole_prior_am2);
        let known = DynamicParameters {
            dipole_am2: [-0.33, -0.21, -0.02],
            dipole_prior_am2: 0.02,
            ..unknown
        };
        assert_eq!(prior(&known), 0.33);
    }

    #[test]
    fn what_is_no_inertia_is_refused() {
        let inertia = Some(PolarityError::Inertia);
        assert_eq!(refused(|p| p.inertia_kg_m2[0][1] = 0.001), inertia, "not symmetric");
        assert_eq!(refused(|p| p.inertia_kg_m2[1][1] = -0.05), inertia);
        assert_eq!(refused(|p| p.inertia_kg_m2[2][2] = f32::NAN), inertia);
    }
}
