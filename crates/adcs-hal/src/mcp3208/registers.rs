//! The three bytes of one MCP3208 conversion, both ways, and what its codes mean.
//!
//! The chip knows bits, not bytes. Five leading zeros put its answer on byte borders (§6.1, figure
//! 6-1):
//!
//! ```text
//! to the chip     0 0 0 0 0 1 S D2 | D1 D0 x  x  x   x   x  x  | x  x  x  x  x  x  x  x
//!                           │ │
//!                       start SGL/DIFF
//! from the chip   z z z z z z z z  | z  z  z  0  B11 B10 B9 B8 | B7 B6 B5 B4 B3 B2 B1 B0
//!                                             └ null bit
//! ```
//! x: the chip does not look; z: high impedance, the line may show anything; S = 1: single-ended.
//! D2 D1 D0 is the channel (§5.0, table 5-2).
//!
//! [`encode_command`] and [`decode_reply`] are the driver's half, [`decode_command`] and
//! [`encode_reply`] the half of whoever plays the chip.
//!
//! Source: Microchip, MCP3204/3208 data sheet, DS21298E (2008).

use core::fmt;

/// Number of codes of a 12-bit converter.
pub const LEVELS: u16 = 4096;

/// First byte: the start bit, after five leading zeros (figure 6-1).
const START: u8 = 0b0000_0100;
/// First byte: SGL/DIFF, single-ended when set (table 5-2).
const SINGLE_ENDED: u8 = 0b0000_0010;
/// First byte: D2, the channel's highest bit.
const D2: u8 = 0b0000_0001;
/// Second byte: D1 and D0 stand in the two highest bits.
const D1_D0_SHIFT: u32 = 6;
/// Second byte of the answer: the null bit, driven low.
const NULL_BIT: u8 = 0b0001_0000;
/// Second byte of the answer: B11 to B8.
const HIGH_NIBBLE: u8 = 0b0000_1111;

/// The bits of the answer during which the chip leaves its output floating (figure 6-1).
pub const HIGH_IMPEDANCE: [u8; 3] = [0xFF, 0b1110_0000, 0x00];

/// One of the eight inputs, CH0 to CH7.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Channel(u8);

impl Channel {
    /// Number of inputs.
    pub const COUNT: u8 = 8;

    /// Input `number`; `None` above 7.
    pub const fn new(number: u8) -> Option<Self> {
        if number < Self::COUNT { Some(Self(number)) } else { None }
    }

    /// 0 to 7.
    pub const fn number(self) -> u8 {
        self.0
    }
}

/// What the converter made of a voltage: 0 to 4095.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Code(u16);

impl Code {
    /// The lowest code: 0 V and everything below.
    pub const MIN: Self = Self(0);
    /// The highest code: one step below the reference and everything above.
    pub const MAX: Self = Self(LEVELS - 1);

    /// `None` above 4095.
    pub const fn new(code: u16) -> Option<Self> {
        if code < LEVELS { Some(Self(code)) } else { None }
    }

    /// 0 to 4095.
    pub const fn get(self) -> u16 {
        self.0
    }

    /// The voltage in the middle of this code's step, V: `code · V_ref / 4096` (equation 4-2).
    pub fn volts(self, reference_v: f32) -> f32 {
        f32::from(self.0) * (reference_v / f32::from(LEVELS))
    }

    /// What an ideal converter makes of `volts`: `4096 · V / V_ref` (equation 4-2) to the nearest
    /// code. At and beyond the rails 000h and FFFh, as §4.1 says; NaN gives 000h.
    ///
    /// The data sheet does not say where within a step a code changes. Nearest (first transition at
    /// half a step) is the ideal curve without offset; the real chip's offset is up to 3 steps
    /// (§1.0) and belongs to calibration.
    pub fn of_volts(volts: f64, reference_v: f64) -> Self {
        let steps = f64::from(LEVELS) * volts / reference_v;
        // `as` saturates at its ends and makes 0 of NaN.
        Self((libm::round(steps) as u16).min(Self::MAX.0))
    }
}

/// The three bytes that ask for a single-ended conversion of `channel`.
pub const fn encode_command(channel: Channel) -> [u8; 3] {
    let d2 = (channel.0 >> 2) & D2;
    [START | SINGLE_ENDED | d2, channel.0 << D1_D0_SHIFT, 0]
}

/// Why three bytes are not the command of figure 6-1.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum CommandError {
    /// The start bit is missing or stands elsewhere, so that the answer would not be on byte
    /// borders.
    Start {
        /// The first byte.
        found: u8,
    },
    /// SGL/DIFF asks for a pseudo-differential pair.
    Differential {
        /// The first byte.
        found: u8,
    },
    /// A bit at which the chip does not look is set: harmless, but no driver of ours sends it.
    DontCare {
        /// The second and the third byte.
        found: [u8; 2],
    },
}

impl fmt::Display for CommandError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Start { found } => write!(f, "the start bit is not at bit 2 of {found:#04x}"),
            Self::Differential { found } => {
                write!(f, "{found:#04x} asks for a differential conversion")
            }
            Self::DontCare { found: [b, c] } => {
                write!(f, "bits without meaning are set in {b:#04x} {c:#04x}")
            }
        }
    }
}

impl core::error::Error for CommandError {}

/// Which channel three bytes ask for. Stricter than the chip: exactly what [`encode_command`] can
/// give.
///
/// # Errors
/// [`CommandError`] with the bytes that depart from figure 6-1.
pub const fn decode_command(command: [u8; 3]) -> Result<Channel, CommandError> {
    let [first, second, third] = command;
    if first & !(SINGLE_ENDED | D2) != START {
        return Err(CommandError::Start { found: first });
    }
    if first & SINGLE_ENDED == 0 {
        return Err(CommandError::Differential { found: first });
    }
    if second << 2 != 0 || third != 0 {
        return Err(CommandError::DontCare { found: [second, third] });
    }
    Ok(Channel((first & D2) << 2 | second >> D1_D0_SHIFT))
}

/// The three bytes with which the chip answers, zeros where it drives nothing
/// ([`HIGH_IMPEDANCE`]).
pub const fn encode_reply(code: Code) -> [u8; 3] {
    let [high, low] = code.0.to_be_bytes();
    [0, high, low]
}

/// The code in three bytes that were read; `None` when the null bit is set, which the chip never
/// does: a floating or stuck line, or a frame out of step.
pub const fn decode_reply(reply: [u8; 3]) -> Option<Code> {
    let [_, middle, low] = reply;
    if middle & NULL_BIT != 0 {
        return None;
    }
    Some(Code(u16::from_be_bytes([middle & HIGH_NIBBLE, low])))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_eight_commands_are_those_of_table_5_2() {
        let expected = [
            [0x06, 0x00],
            [0x06, 0x40],
            [0x06, 0x80],
            [0x06, 0xC0],
            [0x07, 0x00],
            [0x07, 0x40],
            [0x07, 0x80],
            [0x07, 0xC0],
        ];
        for (number, [first, second]) in (0..).zip(expected) {
            let channel = Channel::new(number).unwrap();
            assert_eq!(encode_command(channel), [first, second, 0]);
            assert_eq!(decode_command([first, second, 0]), Ok(channel));
        }
        assert_eq!(Channel::new(8), None);
    }

    #[test]
    fn of_all_commands_exactly_eight_are_accepted() {
        let mut accepted = 0;
        for first in 0..=u8::MAX {
            for second in 0..=u8::MAX {
                for third in [0, 1, 0x80] {
                    accepted += u32::from(decode_command([first, second, third]).is_ok());
                }
            }
        }
        assert_eq!(accepted, 8);
        assert_eq!(decode_command([0x0C, 0, 0]), Err(CommandError::Start { found: 0x0C }));
        assert_eq!(decode_command([0x04, 0, 0]), Err(CommandError::Differential { found: 0x04 }));
        assert_eq!(decode_command([0x06, 1, 2]), Err(CommandError::DontCare { found: [1, 2] }));
    }

    #[test]
    fn every_code_survives_the_answer_whatever_the_floating_bits_show() {
        for raw in 0..LEVELS {
            let code = Code::new(raw).unwrap();
            let [a, b, c] = encode_reply(code);
            assert_eq!(decode_reply([a, b, c]), Some(code));
            let [za, zb, zc] = HIGH_IMPEDANCE;
            assert_eq!(decode_reply([a | za, b | zb, c | zc]), Some(code));
        }
        assert_eq!(Code::new(LEVELS), None);
    }

    #[test]
    fn codes_and_volts_agree_in_the_middle_of_every_step() {
        for raw in 0..LEVELS {
            let code = Code::new(raw).unwrap();
            assert_eq!(Code::of_volts(f64::from(code.volts(3.3)), 3.3), code);
        }
    }

    #[test]
    fn beyond_the_rails_the_code_stays_at_its_end() {
        assert_eq!(Code::of_volts(-1e9, 3.3), Code::MIN);
        assert_eq!(Code::of_volts(f64::NAN, 3.3), Code::MIN);
        assert_eq!(Code::of_volts(3.3 - 3.3 / 4096.0, 3.3), Code::MAX);
        assert_eq!(Code::of_volts(f64::INFINITY, 3.3), Code::MAX);
    }
}
