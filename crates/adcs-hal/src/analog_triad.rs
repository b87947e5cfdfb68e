//! Three analogue sensor axes behind the converter: codes to SI units by the data sheet's formula.
//!
//! ```text
//! value = (V − V_zero) / S        V = code · V_ref / 4096
//! ```
//!
//! | symbol | code | unit |
//! |---|---|---|
//! | V_zero | [`AnalogTriadConfig::zero_v`] | V |
//! | S | [`AnalogTriadConfig::sensitivity_v_per_si`] | V per T (magnetometer), V per rad/s (gyro) |
//! | V_ref | [`ConverterConfig::reference_v`] | V |
//!
//! SPROUT's magnetometer is a three-axis analogue module, its gyros are three single-axis MEMS
//! units. Both give a voltage that is proportional to what they measure around a middle voltage, so
//! one driver serves both. The part numbers are unknown: [`AnalogTriadConfig::MAGNETOMETER`] and
//! [`AnalogTriadConfig::GYRO`] are assumed and say why.
//!
//! A code at a rail of the converter, or so near that the amplifier before it may have clipped, is
//! no measurement: the true value may be anywhere beyond.

use core::fmt;

use adcs_core::reading::{MissingReason, Reading};
use embedded_hal::spi::SpiDevice;
use serde::{Deserialize, Serialize};

use crate::mcp3208::{Channel, Code, Mcp3208, registers};

/// How the converter is wired; shared by all sensors behind it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ConverterConfig {
    /// The converter's reference voltage, V.
    pub reference_v: f32,
    /// Codes within this distance of 0 or 4095 count as clipped; 0: the two end codes alone.
    pub rail_margin_codes: u16,
}

impl ConverterConfig {
    /// Assumed: the reference is a 3.3 V supply, and amplifiers swing to some 10 mV of their rails
    /// (16 codes are 12.9 mV).
    pub const ASSUMED: Self = Self { reference_v: 3.3, rail_margin_codes: 16 };

    /// The highest code that counts as the lower rail and the lowest that counts as the upper.
    pub(crate) fn rails(self) -> (Code, Code) {
        let margin = self.rail_margin_codes.min(Code::MAX.get());
        let low = Code::new(margin).unwrap_or(Code::MAX);
        let high = Code::new(Code::MAX.get() - margin).unwrap_or(Code::MIN);
        (low, high)
    }
}

/// One analogue sensor of three axes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct AnalogTriadConfig {
    /// The converter's inputs (0 to 7) to which the axes x, y, z are wired.
    pub channels: [u8; 3],
    /// Output voltage for zero, V.
    pub zero_v: f32,
    /// Output voltage for one SI unit: V/T or V/(rad/s).
    pub sensitivity_v_per_si: f32,
}

impl AnalogTriadConfig {
    /// The magnetometer, assumed: 50,000 nT/V (a 3.3 V range then covers ±82,500 nT, the Earth's
    /// field with room for the satellite's own) around the middle of the range.
    pub const MAGNETOMETER: Self =
        Self { channels: [0, 1, 2], zero_v: 1.65, sensitivity_v_per_si: 20_000.0 };

    /// The gyros, assumed: 20 mV/(deg/s), usual for MEMS vibrating gyros of ±80 deg/s, around the
    /// middle of the range.
    pub const GYRO: Self = Self {
        channels: [3, 4, 5],
        zero_v: 1.65,
        // 0.02 V/deg · 180/π deg/rad
        sensitivity_v_per_si: 1.145_915_6,
    };
}

/// Why a configuration cannot be of a real sensor behind this converter.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum ConfigError {
    /// The reference is outside what the MCP3208 takes, 0.25 to 5.5 V (DS21298E §1.0).
    Reference {
        /// What was asked for, V.
        reference_v: f32,
    },
    /// The sensitivity is not a positive number, or so small that a rail is not a number.
    Sensitivity {
        /// What was asked for, V per SI unit.
        sensitivity_v_per_si: f32,
    },
    /// The voltage for zero is not inside the range that the rails leave.
    Zero {
        /// What was asked for, V.
        zero_v: f32,
    },
    /// The converter has no such input.
    Channel {
        /// What was asked for.
        channel: u8,
    },
    /// Two axes are wired to one input.
    ChannelTwice {
        /// Which input.
        channel: u8,
    },
}

impl fmt::Display for ConfigError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Reference { reference_v } => {
                write!(f, "a converter reference of {reference_v} V is outside 0.25 to 5.5 V")
            }
            Self::Sensitivity { sensitivity_v_per_si } => write!(
                f,
                "a sensitivity of {sensitivity_v_per_si} V per SI unit is not positive and finite"
            ),
            Self::Zero { zero_v } => {
                write!(f, "a zero at {zero_v} V is outside what the converter can read")
            }
            Self::Channel { channel } => {
                write!(f, "the converter has no channel {channel}; it has 0 to 7")
            }
            Self::ChannelTwice { channel } => {
                write!(f, "two sensor axes are wired to channel {channel}")
            }
        }
    }
}

impl core::error::Error for ConfigError {}

/// Three inputs of the converter, none twice.
fn distinct([x, y, z]: [u8; 3]) -> Result<[Channel; 3], ConfigError> {
    if x == y || x == z {
        return Err(ConfigError::ChannelTwice { channel: x });
    }
    if y == z {
        return Err(ConfigError::ChannelTwice { channel: y });
    }
    let channel = |channel| Channel::new(channel).ok_or(ConfigError::Channel { channel });
    Ok([channel(x)?, channel(y)?, channel(z)?])
}

/// A three-axis sensor behind the converter, with its configuration checked.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AnalogTriad {
    channels: [Channel; 3],
    reference_v: f32,
    zero_v: f32,
    sensitivity_v_per_si: f32,
    /// Codes strictly between these are measurements.
    rails: (Code, Code),
}

impl AnalogTriad {
    /// Checks the configuration once, so that no reading can fail for its sake.
    ///
    /// # Errors
    /// [`ConfigError`] with the value that cannot be.
    pub fn new(config: AnalogTriadConfig, converter: ConverterConfig) -> Result<Self, ConfigError> {
        let AnalogTriadConfig { channels, zero_v, sensitivity_v_per_si } = config;
        let reference_v = converter.reference_v;
        // Written so that NaN fails.
        if !(0.25..=5.5).contains(&reference_v) {
            return Err(ConfigError::Reference { reference_v });
        }
        let full_scale_si = reference_v / sensitivity_v_per_si;
        if !(full_scale_si > 0.0 && full_scale_si.is_finite()) {
            return Err(ConfigError::Sensitivity { sensitivity_v_per_si });
        }
        let rails @ (low, high) = converter.rails();
        let zero = Code::of_volts(f64::from(zero_v), f64::from(reference_v));
        if !(zero_v.is_finite() && low < zero && zero < high) {
            return Err(ConfigError::Zero { zero_v });
        }
        let channels = distinct(channels)?;
        Ok(Self { channels, reference_v, zero_v, sensitivity_v_per_si, rails })
    }

    /// Converts the three axes, x first, each once. An axis whose conversion fails is
    /// `Missing(Bus)`; the others are still read.
    pub fn read<Spi: SpiDevice>(&self, converter: &mut Mcp3208<Spi>) -> [Reading<f32>; 3] {
        self.channels.map(|channel| match converter.convert(channel) {
            Ok(code) => self.reading(code),
            Err(_) => Reading::Missing(MissingReason::Bus),
        })
    }

    /// What `code` says in SI units; `Missing(OutOfRange)` at or near a rail.
    pub fn reading(&self, code: Code) -> Reading<f32> {
        let (low, high) = self.rails;
        if code <= low || code >= high {
            return Reading::Missing(MissingReason::OutOfRange);
        }
        Reading::Fresh((code.volts(self.reference_v) - self.zero_v) / self.sensitivity_v_per_si)
    }

    /// What one step of the converter is worth, SI units.
    pub fn resolution_si(&self) -> f32 {
        self.reference_v / f32::from(registers::LEVELS) / self.sensitivity_v_per_si
    }

    /// The converter inputs of x, y, z.
    pub fn channels(&self) -> [Channel; 3] {
        self.channels
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::string::ToString;

    fn magnetometer() -> AnalogTriad {
        AnalogTriad::new(AnalogTriadConfig::MAGNETOMETER, ConverterConfig::ASSUMED).unwrap()
    }

    fn refused(
        magnetometer: impl Fn(&mut AnalogTriadConfig),
        converter: impl Fn(&mut ConverterConfig),
    ) -> ConfigError {
        let mut triad_config = AnalogTriadConfig::MAGNETOMETER;
        let mut converter_config = ConverterConfig::ASSUMED;
        magnetometer(&mut triad_config);
        converter(&mut converter_config);
        AnalogTriad::new(triad_config, converter_config).unwrap_err()
    }

    #[test]
    fn the_middle_code_is_zero_and_one_volt_more_is_50_microtesla() {
        // f32 rounding of a value of 50 µT.
        const ROUNDING_T: f32 = 1e-11;
        let field = |raw| magnetometer().reading(Code::new(raw).unwrap()).value().unwrap();
        assert_eq!(field(2048), 0.0);
        // 1241 steps of 3.3/4096 V are 0.99983 V.
        let expected_t = 1241.0 * 3.3 / 4096.0 / 20_000.0;
        assert!((field(2048 + 1241) - expected_t).abs() < ROUNDING_T);
        assert!((field(2048 - 1241) + expected_t).abs() < ROUNDING_T);
    }

    #[test]
    fn the_assumed_gyro_gives_a_degree_per_second_for_20_millivolts() {
        let gyro = AnalogTriad::new(AnalogTriadConfig::GYRO, ConverterConfig::ASSUMED).unwrap();
        // One f32 rounding of the sensitivity.
        const RELATIVE_ROUNDING: f32 = 1e-6;
        let step_deg_s = 3.3_f32 / 4096.0 / 0.02;
        assert!((gyro.resolution_si().to_degrees() / step_deg_s - 1.0).abs() < RELATIVE_ROUNDING);
    }

    #[test]
    fn codes_at_and_near_the_rails_are_missing_and_no_others() {
        let out = Reading::Missing(MissingReason::OutOfRange);
        for raw in 0..4096 {
            let reading = magnetometer().reading(Code::new(raw).unwrap());
            assert_eq!(reading == out, raw <= 16 || raw >= 4079, "code {raw}");
            assert!(reading.value().is_none_or(f32::is_finite));
        }
    }

    #[test]
    fn a_margin_of_zero_still_excludes_the_two_rails() {
        let converter = ConverterConfig { rail_margin_codes: 0, ..ConverterConfig::ASSUMED };
        let triad = AnalogTriad::new(AnalogTriadConfig::MAGNETOMETER, converter).unwrap();
        let present = |raw| triad.reading(Code::new(raw).unwrap()).value().is_some();
        assert!(!present(0) && present(1) && present(4094) && !present(4095));
    }

    #[test]
    fn impossible_configurations_are_refused_with_the_value() {
        for found in [0.0, -1.0, f32::NAN, f32::INFINITY, 1e-39] {
            let error = refused(|m| m.sensitivity_v_per_si = found, |_| ());
            assert!(matches!(error, ConfigError::Sensitivity { .. }), "{found}: {error}");
        }
        for found in [0.0, 3.3, -1.65, f32::NAN, f32::INFINITY] {
            let error = refused(|m| m.zero_v = found, |_| ());
            assert!(matches!(error, ConfigError::Zero { .. }), "{found}: {error}");
        }
        for found in [0.0, -3.3, 6.0, f32::NAN] {
            let error = refused(|_| (), |c| c.reference_v = found);
            assert!(matches!(error, ConfigError::Reference { .. }), "{found}: {error}");
        }
        for found in [2047, 4095, 4096, u16::MAX] {
            let error = refused(|_| (), |c| c.rail_margin_codes = found);
            assert!(matches!(error, ConfigError::Zero { .. }), "{found}: {error}");
        }
        assert_eq!(
            refused(|m| m.channels = [0, 8, 2], |_| ()),
            ConfigError::Channel { channel: 8 }
        );
        for channels in [[4, 4, 2], [4, 2, 4], [2, 4, 4]] {
            let error = refused(|m| m.channels = channels, |_| ());
            assert_eq!(error, ConfigError::ChannelTwice { channel: 4 });
        }
    }

    #[test]
    fn an_error_says_what_is_wrong_in_words() {
        assert_eq!(
            ConfigError::Channel { channel: 9 }.to_string(),
            "the converter has no channel 9; it has 0 to 7"
        );
    }
}
