//! What a dying image leaves for the next one.
//!
//! A panic or fault handler can trust nothing: not the stack far below, not a driver, not a log.
//! It writes one [`Epitaph`] into a part of RAM that a reset leaves alone (`memory.x`) and resets.
//! The next boot finds it, logs it, and says it to the ground. RAM holds noise after power-on, so
//! the record carries a magic number and a CRC.

use core::fmt::{self, Write};

use serde::{Deserialize, Serialize};

use crate::sealed;
use crate::torquers::SwitchedOff;

/// Bytes of the region in RAM that holds the record.
pub const REGION_BYTES: usize = 256;

/// Bytes of a message that are kept. With it the longest record still fits the region.
pub const MESSAGE_BYTES: usize = 160;

/// Says "an epitaph of this layout". Change the last digit when the layout changes.
const MAGIC: [u8; 4] = *b"EPI1";

/// What ended the image.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Cause {
    /// The program gave up: a bug.
    Panic,
    /// The core could not go on: bad address, bad instruction, failing bus.
    Fault,
    /// An access ran off the end of the stack.
    StackOverflow,
    /// An interrupt nobody handles. −14 is the NMI: the crystal has died.
    Interrupt(i16),
}

/// Registers of the core at the time of death.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Registers {
    /// Program counter of the offending instruction; 0 when unknown.
    pub program_counter: u32,
    /// Link register: who called; 0 when unknown.
    pub link_register: u32,
    /// Configurable fault status register.
    pub cfsr: u32,
    /// Hard fault status register.
    pub hfsr: u32,
    /// Address of the failed access, if the core recorded one.
    pub fault_address: Option<u32>,
}

/// The record.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Epitaph {
    magic: [u8; 4],
    /// What ended the image.
    pub cause: Cause,
    /// How many images ended like this since power-on, this one included.
    pub count: u16,
    /// The core's registers.
    pub registers: Registers,
    /// The torquers' registers before and after they were switched off.
    pub torquers: SwitchedOff,
    /// A later boot has already reported this record.
    pub reported: bool,
    /// For a panic: where and why.
    pub message: Message,
}

impl Epitaph {
    /// A new record. `previous` is what the region held before.
    #[must_use]
    pub fn new(
        cause: Cause,
        registers: Registers,
        torquers: SwitchedOff,
        message: Message,
        previous: Option<&Self>,
    ) -> Self {
        let count = previous.map_or(0, |epitaph| epitaph.count).saturating_add(1);
        Self { magic: MAGIC, cause, count, registers, torquers, reported: false, message }
    }

    /// Writes the record into `region`. False if it does not fit, which the layout excludes.
    pub fn encode(&self, region: &mut [u8; REGION_BYTES]) -> bool {
        sealed::seal(self, region).is_some()
    }

    /// The record in `region`; `None` when there is none, as after power-on.
    #[must_use]
    pub fn decode(region: &[u8; REGION_BYTES]) -> Option<Self> {
        let epitaph: Self = sealed::open(region)?;
        (epitaph.magic == MAGIC).then_some(epitaph)
    }
}

impl fmt::Display for Epitaph {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.cause {
            Cause::Panic => write!(f, "panic {}", self.message)?,
            Cause::Fault => write!(f, "fault{}", FaultStatus(self.registers.cfsr))?,
            Cause::StackOverflow => f.write_str("stack overflow")?,
            Cause::Interrupt(number) => write!(f, "unhandled interrupt {number}")?,
        }
        let Registers { program_counter, link_register, cfsr, hfsr, fault_address } =
            self.registers;
        write!(f, "; death {} since power-on", self.count)?;
        write!(f, "; pc {program_counter:#010x} lr {link_register:#010x}")?;
        write!(f, " cfsr {cfsr:#010x} hfsr {hfsr:#010x}")?;
        if let Some(address) = fault_address {
            write!(f, " address {address:#010x}")?;
        }
        let SwitchedOff { duties_before, duties_after, pins_low } = self.torquers;
        write!(f, "; torquer duties {duties_before:?} -> {duties_after:?}")?;
        write!(f, ", pins {}", if pins_low { "low" } else { "not confirmed low" })
    }
}

/// The causes a CFSR value names (ARMv7-M architecture reference manual, §B3.2.15).
struct FaultStatus(u32);

impl fmt::Display for FaultStatus {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        const NAMES: [(u32, &str); 14] = [
            (1 << 0, "instruction access violation"),
            (1 << 1, "data access violation"),
            (1 << 3, "memory fault while returning"),
            (1 << 4, "memory fault while stacking"),
            (1 << 8, "instruction bus error"),
            (1 << 9, "precise data bus error"),
            (1 << 10, "imprecise data bus error"),
            (1 << 11, "bus error while returning"),
            (1 << 12, "bus error while stacking"),
            (1 << 16, "undefined instruction"),
            (1 << 17, "invalid state"),
            (1 << 18, "invalid return"),
            (1 << 24, "unaligned access"),
            (1 << 25, "division by zero"),
        ];
        let named = NAMES.iter().filter(|(bit, _)| self.0 & bit != 0);
        for (position, (_, name)) in named.enumerate() {
            write!(f, "{} {name}", if position == 0 { ":" } else { "," })?;
        }
        Ok(())
    }
}

/// A text that keeps its beginning when it gets too long.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Message(heapless::String<MESSAGE_BYTES>);

impl Message {
    /// `text`, cut after [`MESSAGE_BYTES`].
    #[must_use]
    pub fn new(text: fmt::Arguments<'_>) -> Self {
        let mut message = Self::default();
        // An error only says that `text` was cut, or broke off by itself: keep what came.
        let _ = message.write_fmt(text);
        message
    }
}

impl fmt::Display for Message {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl Write for Message {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        text.chars().try_for_each(|c| self.0.push(c).map_err(|_| fmt::Error))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn panic_epitaph() -> Epitaph {
        Epitaph::new(
            Cause::Panic,
            Registers { fault_address: Some(u32::MAX), cfsr: u32::MAX, ..Registers::default() },
            SwitchedOff { duties_before: [u16::MAX; 3], duties_after: [0; 3], pins_low: true },
            Message::new(format_args!("at src/main.rs:7:5: index out of bounds")),
            None,
        )
    }

    #[test]
    fn what_was_written_is_found_again() {
        let mut region = [0xA5; REGION_BYTES];
        assert!(panic_epitaph().encode(&mut region));
        assert_eq!(Epitaph::decode(&region), Some(panic_epitaph()));
    }

    #[test]
    fn noise_after_power_on_is_no_epitaph() {
        for noise in [[0; REGION_BYTES], [0xFF; REGION_BYTES], [0xA5; REGION_BYTES]] {
            assert_eq!(Epitaph::decode(&noise), None);
        }
    }

    #[test]
    fn no_single_wrong_bit_goes_unnoticed() {
        let mut region = [0; REGION_BYTES];
        let used = sealed::seal(&panic_epitaph(), &mut region).unwrap();
        for bit in 0..used * 8 {
            let mut damaged = region;
            damaged[bit / 8] ^= 1 << (bit % 8);
            assert_eq!(Epitaph::decode(&damaged), None, "bit {bit}");
        }
    }

    #[test]
    fn a_message_too_long_is_cut_at_a_character_and_the_record_still_fits() {
        let long = "°".repeat(MESSAGE_BYTES);
        let mut epitaph = panic_epitaph();
        epitaph.message = Message::new(format_args!("{long}"));
        epitaph.count = u16::MAX;
        epitaph.cause = Cause::Interrupt(i16::MIN);
        assert_eq!(epitaph.message.0.len(), MESSAGE_BYTES);
        assert!(epitaph.encode(&mut [0; REGION_BYTES]));
    }

    #[test]
    fn deaths_are_counted_and_the_count_does_not_wrap() {
        let mut epitaph = panic_epitaph();
        assert_eq!(epitaph.count, 1);
        epitaph.count = u16::MAX;
        let next = Epitaph::new(
            Cause::Fault,
            Registers::default(),
            SwitchedOff::default(),
            Message::default(),
            Some(&epitaph),
        );
        assert_eq!(next.count, u16::MAX);
    }

    #[test]
    fn the_text_names_the_fault_and_the_torquers() {
        let registers =
            Registers { cfsr: 1 << 9, fault_address: Some(0xDEAD_BEEF), ..Registers::default() };
        let torquers =
            SwitchedOff { duties_before: [1, 2, 3], duties_after: [0; 3], pins_low: true };
        let text =
            Epitaph::new(Cause::Fault, registers, torquers, Message::default(), None).to_string();
        assert!(
            text.starts_with("fault: precise data bus error; death 1 since power-on"),
            "{text}"
        );
        assert!(text.contains("address 0xdeadbeef"), "{text}");
        assert!(text.ends_with("torquer duties [1, 2, 3] -> [0, 0, 0], pins low"), "{text}");
    }
}
