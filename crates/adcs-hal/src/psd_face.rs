//! One face of the Sun sensors behind the converter: four codes to the photocurrents of a
//! position-sensitive diode.
//!
//! ```text
//! i = (V − V_dark) / R      V = code · V_ref / 4096
//! ```
//!
//! | symbol | code | unit |
//! |---|---|---|
//! | i | the photocurrent at one electrode: X1, X2, Y1, Y2 | A |
//! | V_dark | [`PsdFaceConfig::dark_v`] | V |
//! | R | [`PsdFaceConfig::transimpedance_ohm`] | Ω |
//! | V_ref | [`ConverterConfig::reference_v`] | V |
//!
//! Each electrode of a duo-lateral diode has a transimpedance amplifier. The layer of X gives
//! current and that of Y takes it; the amplifiers of Y invert, so that all four voltages rise with
//! the light. They start above zero volts, at V_dark, so that darkness is told from a dead
//! amplifier. What the four currents say about the light belongs to `adcs_core::sensing`.
//!
//! The circuit is assumed; the satellite's has not been published.

use core::fmt;

use adcs_core::reading::{MissingReason, Reading};
use embedded_hal::spi::SpiDevice;
use serde::{Deserialize, Serialize};

use crate::analog_triad::ConverterConfig;
use crate::mcp3208::{Channel, Code, Mcp3208};

/// Number of faces of a satellite.
pub const FACES: usize = 6;
/// Number of converters behind them.
pub const CONVERTERS: usize = 3;

/// One face as it is wired.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PsdFaceConfig {
    /// Which of the Sun sensors' converters it is wired to, 0 to 2.
    pub converter: u8,
    /// That converter's inputs (0 to 7) for X1, X2, Y1, Y2.
    pub channels: [u8; 4],
    /// Output voltage without light, V.
    pub dark_v: f32,
    /// Volts for one ampere of photocurrent.
    pub transimpedance_ohm: f32,
}

impl PsdFaceConfig {
    /// Assumed: two faces a converter; dark at 0.1 V, which amplifiers reach with room to spare;
    /// 30 kΩ, so that the 80 µA of the full Sun and a third more on one electrode fill 3.3 V.
    pub const SPROUT: [Self; FACES] =
        [first(0), second(0), first(1), second(1), first(2), second(2)];
}

const fn first(converter: u8) -> PsdFaceConfig {
    face(converter, [0, 1, 2, 3])
}

const fn second(converter: u8) -> PsdFaceConfig {
    face(converter, [4, 5, 6, 7])
}

const fn face(converter: u8, channels: [u8; 4]) -> PsdFaceConfig {
    PsdFaceConfig { converter, channels, dark_v: 0.1, transimpedance_ohm: 30e3 }
}

/// Why a configuration cannot be of a real face behind these converters.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum ConfigError {
    /// There is no such converter.
    Converter {
        /// What was asked for.
        converter: u8,
    },
    /// The converter has no such input.
    Channel {
        /// What was asked for.
        channel: u8,
    },
    /// Two electrodes are wired to one input.
    ChannelTwice {
        /// Which input.
        channel: u8,
    },
    /// The voltage without light is not inside the range that the rails leave.
    Dark {
        /// What was asked for, V.
        dark_v: f32,
    },
    /// The transimpedance is not positive and normal.
    Transimpedance {
        /// What was asked for, Ω.
        transimpedance_ohm: f32,
    },
}

impl fmt::Display for ConfigError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Converter { converter } => {
                write!(f, "there is no Sun-sensor converter {converter}; there are 0 to 2")
            }
            Self::Channel { channel } => {
                write!(f, "the converter has no channel {channel}; it has 0 to 7")
            }
            Self::ChannelTwice { channel } => {
                write!(f, "two electrodes are wired to channel {channel}")
            }
            Self::Dark { dark_v } => {
                write!(f, "darkness at {dark_v} V is outside what the converter can read")
            }
            Self::Transimpedance { transimpedance_ohm } => {
                write!(f, "a transimpedance of {transimpedance_ohm} ohm is not positive")
            }
        }
    }
}

impl core::error::Error for ConfigError {}

/// Four inputs of a converter, none twice.
fn distinct(channels: [u8; 4]) -> Result<[Channel; 4], ConfigError> {
    let [a, b, c, d] = channels;
    for (channel, others) in [(a, [b, c, d]), (b, [a, c, d]), (c, [a, b, d])] {
        if others.contains(&channel) {
            return Err(ConfigError::ChannelTwice { channel });
        }
    }
    let channel = |channel| Channel::new(channel).ok_or(ConfigError::Channel { channel });
    Ok([channel(a)?, channel(b)?, channel(c)?, channel(d)?])
}

/// One face behind its converter, with its configuration checked.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PsdFace {
    converter: u8,
    channels: [Channel; 4],
    reference_v: f32,
    dark_v: f32,
    transimpedance_ohm: f32,
    /// Codes strictly between these are measurements.
    rails: (Code, Code),
}

impl PsdFace {
    /// Checks the configuration once, so that no reading can fail for its sake. That of the
    /// converter has been checked by [`AnalogTriad`](crate::analog_triad::AnalogTriad).
    ///
    /// # Errors
    /// [`ConfigError`] with the value that cannot be.
    pub fn new(config: PsdFaceConfig, converter: ConverterConfig) -> Result<Self, ConfigError> {
        let PsdFaceConfig { converter: number, channels, dark_v, transimpedance_ohm } = config;
        if usize::from(number) >= CONVERTERS {
            return Err(ConfigError::Converter { converter: number });
        }
        // `is_normal` refuses NaN, infinity, zero and what would overflow a quotient.
        if !(transimpedance_ohm > 0.0 && transimpedance_ohm.is_normal()) {
            return Err(ConfigError::Transimpedance { transimpedance_ohm });
        }
        let rails @ (low, high) = converter.rails();
        let dark = Code::of_volts(f64::from(dark_v), f64::from(converter.reference_v));
        if !(dark_v.is_finite() && low < dark && dark < high) {
            return Err(ConfigError::Dark { dark_v });
        }
        Ok(Self {
            converter: number,
            channels: distinct(channels)?,
            reference_v: converter.reference_v,
            dark_v,
            transimpedance_ohm,
            rails,
        })
    }

    /// Converts X1, X2, Y1, Y2, each once, and gives the currents, A. Missing, with the first
    /// reason, when one of the four is: three of them tell no direction.
    pub fn read<Spi: SpiDevice>(&self, converter: &mut Mcp3208<Spi>) -> Reading<[f32; 4]> {
        let [x_1, x_2, y_1, y_2] = self.channels.map(|channel| match converter.convert(channel) {
            Ok(code) => self.current_a(code).ok_or(MissingReason::OutOfRange),
            Err(_) => Err(MissingReason::Bus),
        });
        let all = || Ok([x_1?, x_2?, y_1?, y_2?]);
        all().map_or_else(Reading::Missing, Reading::Fresh)
    }

    /// The current that `code` says, A; `None` at or near a rail.
    pub fn current_a(&self, code: Code) -> Option<f32> {
        let (low, high) = self.rails;
        let inside = low < code && code < high;
        inside.then(|| (code.volts(self.reference_v) - self.dark_v) / self.transimpedance_ohm)
    }

    /// Which of the Sun sensors' converters it is wired to, 0 to 2.
    pub fn converter(&self) -> u8 {
        self.converter
    }

    /// That converter's inputs for X1, X2, Y1, Y2.
    pub fn channels(&self) -> [Channel; 4] {
        self.channels
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use crate::mcp3208::registers;
    use embedded_hal_mock::eh1::spi::{Mock, Transaction};
    use std::string::ToString;
    use std::vec::Vec;

    /// One step of the converter: 3.3 V / 4096 / 30 kΩ.
    const STEP_A: f32 = 26.86e-9;

    fn config() -> PsdFaceConfig {
        PsdFaceConfig::SPROUT[3]
    }

    fn face() -> PsdFace {
        PsdFace::new(config(), ConverterConfig::ASSUMED).unwrap()
    }

    fn frames(codes: [u16; 4]) -> Vec<Transaction<u8>> {
        let frame = |(channel, code): (u8, u16)| {
            let command = registers::encode_command(Channel::new(channel).unwrap());
            let reply = registers::encode_reply(Code::new(code).unwrap());
            [
                Transaction::transaction_start(),
                Transaction::transfer(command.to_vec(), reply.to_vec()),
                Transaction::transaction_end(),
            ]
        };
        (4..).zip(codes).flat_map(frame).collect()
    }

    fn read(codes: [u16; 4]) -> Reading<[f32; 4]> {
        let mut converter = Mcp3208::new(Mock::new(&frames(codes)));
        let reading = face().read(&mut converter);
        converter.release().done();
        reading
    }

    #[test]
    fn a_face_reads_its_four_electrodes_in_order() {
        // 0.1 V is code 124.1; 40 µA make 1.2 V more.
        let currents = read([124, 124 + 1489, 124 + 993, 124 + 496]).value().unwrap();
        for (found, expected_ua) in currents.into_iter().zip([0.0, 40.0, 26.7, 13.3]) {
            assert!((found - expected_ua * 1e-6).abs() < 2.0 * STEP_A, "{found} {expected_ua}");
        }
    }

    #[test]
    fn one_clipped_electrode_makes_the_face_missing() {
        for clipped in [0, 16, 4079, 4095] {
            let out = Reading::Missing(MissingReason::OutOfRange);
            assert_eq!(read([1000, 1000, clipped, 1000]), out, "{clipped}");
        }
        assert!(read([17, 17, 4078, 4078]).value().is_some());
    }

    #[test]
    fn a_bus_that_floats_is_missing() {
        let command = |channel| registers::encode_command(Channel::new(channel).unwrap()).to_vec();
        let floating = (4..8).flat_map(|channel| {
            [
                Transaction::transaction_start(),
                Transaction::transfer(command(channel), [0xFF; 3].to_vec()),
                Transaction::transaction_end(),
            ]
        });
        let floating: Vec<_> = floating.collect();
        let mut converter = Mcp3208::new(Mock::new(&floating));
        assert_eq!(face().read(&mut converter), Reading::Missing(MissingReason::Bus));
        converter.release().done();
    }

    #[test]
    fn impossible_configurations_are_refused_with_the_value() {
        let refused = |change: &dyn Fn(&mut PsdFaceConfig)| {
            let mut config = config();
            change(&mut config);
            PsdFace::new(config, ConverterConfig::ASSUMED).unwrap_err()
        };
        assert_eq!(refused(&|c| c.converter = 3), ConfigError::Converter { converter: 3 });
        assert_eq!(refused(&|c| c.channels[2] = 8), ConfigError::Channel { channel: 8 });
        for channels in [[1, 1, 2, 3], [1, 2, 1, 3], [1, 2, 3, 1], [3, 1, 1, 0], [0, 3, 1, 1]] {
            let twice = refused(&|c| c.channels = channels);
            assert_eq!(twice, ConfigError::ChannelTwice { channel: 1 }, "{channels:?}");
        }
        for found in [0.0, -1.0, f32::NAN, f32::INFINITY, 1e-40] {
            let error = refused(&|c| c.transimpedance_ohm = found);
            assert!(matches!(error, ConfigError::Transimpedance { .. }), "{error}");
        }
        for found in [0.0, 0.01, 3.3, f32::NAN] {
            let error = refused(&|c| c.dark_v = found);
            assert!(matches!(error, ConfigError::Dark { .. }), "{error}");
        }
        assert_eq!(
            refused(&|c| c.channels = [7, 0, 0, 1]).to_string(),
            "two electrodes are wired to channel 0"
        );
    }
}
