//! What a filter is told about its sensors, from a JSON file.

use std::fmt;
use std::io::Read as _;
use std::path::Path;

use adcs_core::attitude::dynamic::{DynamicError, DynamicParameters};
use adcs_core::attitude::mekf::{FieldNoise, GivenStart, GyroSampling, MekfParameters};
use adcs_core::attitude::selection::{Estimator, EstimatorParameters, EstimatorState, Flies};
use adcs_core::frames::{Rotation, Vector};
use adcs_core::parameter::OutOfRange;
use anyhow::{Context as _, bail};
use nalgebra::{RealField, convert};
use serde::Deserialize;

use crate::table::{name_of, open};

/// More than any such file has.
const MAX_BYTES: u64 = 1 << 20;
/// Tesla in a nanotesla.
const T_PER_NT: f64 = 1e-9;
/// Believed of a given start without its σ: a coarse attitude from two vectors.
const START_SIGMA_DEG: f64 = 5.0;
/// Believed of a gyro bias of which nothing is known.
const BIAS_PRIOR_DEG_S: f64 = 0.5;

/// The keys that are read. Others are passed over: the file may describe more than the filter.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
pub struct FilterConfig {
    gyro_sigma_rad_s: f64,
    gyro_bias_rw_rad_s_sqrt_s: f64,
    sun_sigma_rad_per_transverse_axis: f64,
    #[serde(rename = "mag_sigma_nT_per_axis")]
    mag_sigma_nt_per_axis: f64,
    #[serde(rename = "mag_calibration_sigma_nT_per_axis", default)]
    mag_calibration_sigma_nt_per_axis: f64,
    #[serde(rename = "field_model_sigma_nT_per_axis", default)]
    field_model_sigma_nt_per_axis: f64,
    #[serde(default)]
    gyro_sampling: Sampling,
    reference_filter_initial_q_xyzw: Option<[f64; 4]>,
    #[serde(rename = "reference_filter_P0_attitude_sigma_deg")]
    attitude_sigma_deg: Option<f64>,
    #[serde(rename = "reference_filter_P0_bias_sigma_deg_s")]
    bias_sigma_deg_s: Option<f64>,
    inertia_kg_m2: Option<[[f64; 3]; 3]>,
    residual_dipole_am2: Option<[f64; 3]>,
    unknown_torque_n_m: Option<f64>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Sampling {
    #[default]
    Instant,
    Interval,
}

/// A value that the filter refuses, with the key under which it may stand.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Refused {
    Value(OutOfRange),
    Dynamics(DynamicError),
    StartQuaternion,
}

impl fmt::Display for Refused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Value(error) => error.fmt(f),
            Self::Dynamics(error) => error.fmt(f),
            Self::StartQuaternion => write!(
                f,
                "reference_filter_initial_q_xyzw must be four finite numbers, not all zero"
            ),
        }
    }
}

impl std::error::Error for Refused {}

impl From<OutOfRange> for Refused {
    fn from(error: OutOfRange) -> Self {
        Self::Value(error)
    }
}

impl From<DynamicError> for Refused {
    fn from(error: DynamicError) -> Self {
        Self::Dynamics(error)
    }
}

impl FilterConfig {
    /// Reads a file; `-` is standard input.
    ///
    /// # Errors
    /// When it cannot be read, is not JSON (with line and column), or lacks a key.
    pub fn read(path: &Path) -> anyhow::Result<Self> {
        let name = name_of(path, "standard input");
        let mut bytes = Vec::new();
        open(path)
            .and_then(|(file, _)| file.take(MAX_BYTES + 1).read_to_end(&mut bytes))
            .with_context(|| format!("{name}: cannot be read"))?;
        if bytes.len() as u64 > MAX_BYTES {
            bail!(
                "{name}: longer than {MAX_BYTES} bytes; a file that describes a filter is wanted"
            );
        }
        serde_json::from_slice(&bytes).with_context(|| name.clone())
    }

    /// The filters and the state in which they begin: at the given start, or without estimate.
    ///
    /// # Errors
    /// When a value is none that the filter can work with.
    pub fn filter<T: RealField + Copy>(
        &self,
        flies: Flies,
    ) -> anyhow::Result<(Estimator<T>, EstimatorState<T>)> {
        self.accepted(flies).map_err(Into::into)
    }

    fn accepted<T: RealField + Copy>(
        &self,
        flies: Flies,
    ) -> Result<(Estimator<T>, EstimatorState<T>), Refused> {
        let estimator = Estimator::new(&EstimatorParameters { dynamics: self.dynamics(), flies })?;
        let mut state = EstimatorState::default();
        if let Some(xyzw) = self.reference_filter_initial_q_xyzw {
            let r_bi = Rotation::from_attitude_quaternion(xyzw.map(convert))
                .ok_or(Refused::StartQuaternion)?;
            let attitude_sigma_deg = self.attitude_sigma_deg.unwrap_or(START_SIGMA_DEG);
            let start = GivenStart {
                r_bi,
                attitude_sigma_rad: convert(attitude_sigma_deg.to_radians()),
                gyro_bias: Vector::zero(),
                gyro_bias_sigma_rad_s: convert(self.bias_prior_rad_s()),
            };
            estimator.mekf().begin(&mut state.mekf, &start)?;
        }
        Ok((estimator, state))
    }

    fn bias_prior_rad_s(&self) -> f64 {
        self.bias_sigma_deg_s.unwrap_or(BIAS_PRIOR_DEG_S).to_radians()
    }

    /// Keys that are not there keep the library's values, which are SPROUT's.
    fn dynamics<T: RealField + Copy>(&self) -> DynamicParameters<T> {
        let mut dynamics =
            DynamicParameters { sensors: self.parameters(), ..DynamicParameters::default() };
        if let Some(rows) = self.inertia_kg_m2 {
            dynamics.inertia_kg_m2 = rows.map(|row| row.map(convert));
        }
        if let Some(dipole) = self.residual_dipole_am2 {
            dynamics.dipole_am2 = dipole.map(convert);
        }
        if let Some(sigma) = self.unknown_torque_n_m {
            dynamics.torque.start_n_m = convert(sigma);
        }
        dynamics
    }

    fn parameters<T: RealField + Copy>(&self) -> MekfParameters<T> {
        let tesla = |nanotesla: f64| convert(nanotesla * T_PER_NT);
        MekfParameters {
            gyro_noise_rad_s: convert(self.gyro_sigma_rad_s),
            gyro_sampling: match self.gyro_sampling {
                Sampling::Instant => GyroSampling::Instant,
                Sampling::Interval => GyroSampling::Interval,
            },
            bias_walk_rad_s_per_sqrt_s: convert(self.gyro_bias_rw_rad_s_sqrt_s),
            bias_prior_rad_s: convert(self.bias_prior_rad_s()),
            field_noise: FieldNoise {
                sensor_t: tesla(self.mag_sigma_nt_per_axis),
                calibration_t: tesla(self.mag_calibration_sigma_nt_per_axis),
                model_t: tesla(self.field_model_sigma_nt_per_axis),
            },
            sun_noise_rad: convert(self.sun_sigma_rad_per_transverse_axis),
            ..Default::default()
        }
    }
}
