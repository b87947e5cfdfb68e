//! What must be known of a board before its drivers can be built.

use core::fmt;

use serde::{Deserialize, Serialize};

use crate::analog_triad::{self, AnalogTriadConfig, ConverterConfig};
use crate::psd_face::{self, FACES, PsdFaceConfig};

/// Everything about the board that is a number.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct DriverBoardConfig {
    /// The converters and their surroundings, all alike.
    pub converter: ConverterConfig,
    /// The magnetometer, in T.
    pub magnetometer: AnalogTriadConfig,
    /// The gyros, in rad/s.
    pub gyro: AnalogTriadConfig,
    /// The Sun sensors; `None` on a board without.
    pub sun: Option<[PsdFaceConfig; FACES]>,
    /// The dipole of each torquer at full duty, A·m².
    pub max_dipole_am2: [f32; 3],
}

impl DriverBoardConfig {
    /// SPROUT: torquers of ±0.6 A·m² as published; converter and sensors assumed (see their own
    /// constants).
    pub const SPROUT: Self = Self {
        converter: ConverterConfig::ASSUMED,
        magnetometer: AnalogTriadConfig::MAGNETOMETER,
        gyro: AnalogTriadConfig::GYRO,
        sun: Some(PsdFaceConfig::SPROUT),
        max_dipole_am2: [0.6; 3],
    };
}

/// Why a board cannot be built.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum ConfigError {
    /// The magnetometer's configuration.
    Magnetometer(analog_triad::ConfigError),
    /// The gyros' configuration.
    Gyro(analog_triad::ConfigError),
    /// Magnetometer and gyros share an input of the converter.
    ChannelShared {
        /// Which input.
        channel: u8,
    },
    /// A Sun sensor's configuration.
    SunFace {
        /// Which one, 0 to 5.
        face: u8,
        /// What is wrong with it.
        error: psd_face::ConfigError,
    },
    /// Two Sun sensors share an input of one converter.
    SunChannelShared {
        /// The second of them.
        face: u8,
        /// Which input.
        channel: u8,
    },
    /// Sun sensors are configured, but their converters' buses are not among the parts.
    NoSunConverters,
    /// A torquer's full dipole is not a positive, normal number.
    MaxDipole {
        /// Which torquer.
        axis: u8,
        /// What was asked for, A·m².
        max_dipole_am2: f32,
    },
    /// The timer behind a torquer has no steps: its maximal duty is 0.
    NoSteps {
        /// Which torquer.
        axis: u8,
    },
}

impl fmt::Display for ConfigError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Magnetometer(error) => write!(f, "magnetometer: {error}"),
            Self::Gyro(error) => write!(f, "gyro: {error}"),
            Self::ChannelShared { channel } => {
                write!(f, "magnetometer and gyro are both wired to channel {channel}")
            }
            Self::SunFace { face, error } => write!(f, "Sun sensor {face}: {error}"),
            Self::SunChannelShared { face, channel } => {
                write!(f, "Sun sensor {face} is wired to channel {channel}, which is taken")
            }
            Self::NoSunConverters => write!(f, "Sun sensors are configured without converters"),
            Self::MaxDipole { axis, max_dipole_am2 } => {
                write!(f, "torquer {axis}: a full dipole of {max_dipole_am2} A m2 is not positive")
            }
            Self::NoSteps { axis } => {
                write!(f, "torquer {axis}: its timer has a maximal duty of 0")
            }
        }
    }
}

impl core::error::Error for ConfigError {}
