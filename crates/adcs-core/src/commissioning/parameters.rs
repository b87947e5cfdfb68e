//! How long each step may take, how good its result must be, and who commits it.

use core::fmt;

use serde::{Deserialize, Serialize};

use crate::parameter::{self, OutOfRange};

/// How long a step looks, s.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct StepTime {
    /// It looks for so long at least, however good the result seems: what noise cannot show, such as an
    /// axis that has hardly turned yet, takes time.
    pub least_s: f32,
    /// After so long it ends with what it has.
    pub most_s: f32,
}

/// Who decides that what was found flies.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Commit {
    /// The ground, by command. Until then the results are reported and kept.
    ByGround,
    /// The satellite, when the ladder ends: every result that passed its gate.
    WhenPassed,
}

/// The ladder as stored and uplinked.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct CommissioningParameters {
    /// Magnetometer, torquers at rest.
    pub magnetometer: StepTime,
    /// The torquers' field at the magnetometer, by pulses.
    pub coupling: StepTime,
    /// Gyro bias.
    pub gyro: StepTime,
    /// Alignment of the Sun sensors.
    pub sun: StepTime,
    /// Residual dipole and inertia ratios.
    pub momentum: StepTime,
    /// Largest σ of the magnetometer's scales and cross-axis terms, no unit …
    pub scale_sigma: f32,
    /// … and of its biases, T.
    pub bias_sigma_t: f32,
    /// Largest σ of what a torquer adds to an axis, T per A·m².
    pub coupling_sigma_t_per_am2: f32,
    /// Largest σ of the gyro bias, each axis, rad/s.
    pub gyro_sigma_rad_s: f32,
    /// Largest σ of the Sun sensors' turn, about each axis, rad.
    pub sun_sigma_rad: f32,
    /// Largest σ of the residual dipole, each axis, A·m².
    pub dipole_sigma_am2: f32,
    /// Largest σ of moments and products of inertia, in units of the mean moment.
    pub inertia_sigma: f32,
    /// Who commits.
    pub commit: Commit,
}

impl Default for CommissioningParameters {
    /// For SPROUT's sensors in a tumble of 2 to 10 deg/s (docs/commissioning has what they reach).
    fn default() -> Self {
        Self {
            magnetometer: StepTime { least_s: 1_800.0, most_s: 6_000.0 },
            coupling: StepTime { least_s: 300.0, most_s: 900.0 },
            gyro: StepTime { least_s: 600.0, most_s: 6_000.0 },
            sun: StepTime { least_s: 600.0, most_s: 6_000.0 },
            momentum: StepTime { least_s: 1_800.0, most_s: 6_000.0 },
            // 300 nT of the strongest field.
            scale_sigma: 0.006,
            bias_sigma_t: 200e-9,
            // A tenth of what a coil of 1 A·m² adds at 12 cm, 116 µT.
            coupling_sigma_t_per_am2: 5e-6,
            // 0.05 deg/s: a third of a reading's noise.
            gyro_sigma_rad_s: 8.7e-4,
            // 0.3 deg: half of a reading's noise.
            sun_sigma_rad: 5.2e-3,
            // What is enough to feed it forward (docs/modes).
            dipole_sigma_am2: 0.03,
            inertia_sigma: 0.03,
            commit: Commit::ByGround,
        }
    }
}

/// Why parameters are refused; what was in force stays.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum CommissioningError {
    /// A number outside its range.
    OutOfRange(OutOfRange),
}

impl fmt::Display for CommissioningError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self::OutOfRange(error) = self;
        error.fmt(f)
    }
}

impl core::error::Error for CommissioningError {}

impl From<OutOfRange> for CommissioningError {
    fn from(error: OutOfRange) -> Self {
        Self::OutOfRange(error)
    }
}

/// Shortest and longest that a step may look, s: a round, and a day.
const SHORTEST_S: f64 = 1.0;
const LONGEST_S: f64 = 86_400.0;

impl CommissioningParameters {
    pub(super) fn check(&self) -> Result<(), CommissioningError> {
        let times = [
            ("magnetometer", self.magnetometer),
            ("coupling", self.coupling),
            ("gyro", self.gyro),
            ("sun", self.sun),
            ("momentum", self.momentum),
        ];
        let times = times.map(|(name, StepTime { least_s, most_s })| {
            [(name, least_s, SHORTEST_S, LONGEST_S), (name, most_s, f64::from(least_s), LONGEST_S)]
        });
        parameter::check(times.as_flattened())?;
        parameter::check(&[
            ("scale_sigma", self.scale_sigma, 1e-6, 0.5),
            ("bias_sigma_t", self.bias_sigma_t, 1e-10, 1e-4),
            ("coupling_sigma_t_per_am2", self.coupling_sigma_t_per_am2, 1e-10, 1.0),
            ("gyro_sigma_rad_s", self.gyro_sigma_rad_s, 1e-8, 1.0),
            ("sun_sigma_rad", self.sun_sigma_rad, 1e-6, 1.0),
            ("dipole_sigma_am2", self.dipole_sigma_am2, 1e-6, 100.0),
            ("inertia_sigma", self.inertia_sigma, 1e-6, 1.0),
        ])?;
        Ok(())
    }
}
