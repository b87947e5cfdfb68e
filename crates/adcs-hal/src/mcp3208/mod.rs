//! MCP3208: converts up to eight voltages, one at a time, to 12-bit codes.
//!
//! Microchip's successive-approximation converter on SPI; here always single-ended. One conversion
//! is one transaction of three bytes, during which the chip samples, converts and answers, so there
//! is no "not ready" state. What the bytes mean is in [`registers`].
//!
//! | signal | requirement (DS21298E) |
//! |---|---|
//! | SPI mode | 0,0 or 1,1 (§6.1); [`MODE`] is 0,0 |
//! | clock | at most 1 MHz at 2.7 V, 2 MHz at 5 V (§1.0) |
//! | clock, lower bound | the sample must be read within 1.2 ms (§6.2): at least 10 kHz |
//! | chip select | high between two conversions (§5.0): `SpiDevice` does so |
//! | reference | 0.25 V to the supply (§1.0) |
//!
//! Source: Microchip, MCP3204/3208 data sheet, DS21298E (2008).

pub mod registers;

use core::fmt;

use embedded_hal::spi::{self, SpiDevice};

pub use registers::{Channel, Code};

/// The SPI mode in which the frame of [`registers`] is read and written (§6.1, figure 6-1).
pub const MODE: spi::Mode = spi::MODE_0;

/// Why a conversion gave no code.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Error<E> {
    /// The bus itself failed.
    Bus(E),
    /// The null bit before the code was not low: nobody drives the line, or the frame slipped.
    Protocol {
        /// What was read.
        reply: [u8; 3],
    },
}

/// What sort of error it is, for code that knows nothing of the bus.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum ErrorKind {
    /// See [`Error::Bus`].
    Bus(spi::ErrorKind),
    /// See [`Error::Protocol`].
    Protocol,
}

impl<E: spi::Error> Error<E> {
    /// The sort of this error.
    pub fn kind(&self) -> ErrorKind {
        match self {
            Self::Bus(error) => ErrorKind::Bus(error.kind()),
            Self::Protocol { .. } => ErrorKind::Protocol,
        }
    }
}

impl<E: spi::Error> fmt::Display for Error<E> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Bus(error) => write!(f, "MCP3208: {}", error.kind()),
            Self::Protocol { reply: [a, b, c] } => write!(
                f,
                "MCP3208 answered {a:#04x} {b:#04x} {c:#04x}: the bit before the code must be low"
            ),
        }
    }
}

impl<E: spi::Error> core::error::Error for Error<E> {}

/// The driver: owns its `SpiDevice` (bus plus chip select).
#[derive(Debug)]
pub struct Mcp3208<Spi> {
    spi: Spi,
}

impl<Spi: SpiDevice> Mcp3208<Spi> {
    /// Takes the bus in [`MODE`]; nothing is sent, the chip needs no set-up.
    pub fn new(spi: Spi) -> Self {
        Self { spi }
    }

    /// Samples the voltage at `channel` against ground and returns its code.
    ///
    /// # Errors
    /// [`Error::Bus`], or [`Error::Protocol`] for an answer that the chip cannot give. A bus that is
    /// all zeros is not told apart here: it reads as code 0, which whoever uses the code takes for a
    /// rail.
    pub fn convert(&mut self, channel: Channel) -> Result<Code, Error<Spi::Error>> {
        // Ones, so that a bus implementation that delivers nothing is refused too.
        let mut reply = [0xFF; 3];
        self.spi.transfer(&mut reply, &registers::encode_command(channel)).map_err(Error::Bus)?;
        registers::decode_reply(reply).ok_or(Error::Protocol { reply })
    }

    /// Gives the bus back.
    pub fn release(self) -> Spi {
        self.spi
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use embedded_hal::spi::ErrorKind as SpiErrorKind;
    use embedded_hal_mock::eh1::spi::{Mock, Transaction};
    use std::string::ToString;

    /// One transaction as figure 6-1 draws it.
    fn frame(command: [u8; 3], reply: [u8; 3]) -> [Transaction<u8>; 3] {
        [
            Transaction::transaction_start(),
            Transaction::transfer(command.to_vec(), reply.to_vec()),
            Transaction::transaction_end(),
        ]
    }

    #[test]
    fn channel_5_is_asked_for_with_the_bytes_of_figure_6_1() {
        // start, SGL, D2 = 1 | D1 = 0, D0 = 1, don't care | don't care
        let spi = Mock::new(&frame([0b0000_0111, 0b0100_0000, 0], [0xFF, 0b1110_1010, 0x5A]));
        let mut converter = Mcp3208::new(spi);
        let code = converter.convert(Channel::new(5).unwrap());
        assert_eq!(code, Ok(Code::new(0xA5A).unwrap()));
        converter.release().done();
    }

    #[test]
    fn a_floating_bus_is_an_error_that_shows_what_was_read() {
        let mut converter = Mcp3208::new(Mock::new(&frame([0x06, 0x00, 0x00], [0xFF; 3])));
        let error = converter.convert(Channel::new(0).unwrap()).unwrap_err();
        assert_eq!(error, Error::Protocol { reply: [0xFF; 3] });
        assert_eq!(error.kind(), ErrorKind::Protocol);
        assert_eq!(
            error.to_string(),
            "MCP3208 answered 0xff 0xff 0xff: the bit before the code must be low"
        );
        converter.release().done();
    }

    #[test]
    fn an_error_of_the_bus_is_handed_on() {
        struct Broken;
        impl spi::ErrorType for Broken {
            type Error = SpiErrorKind;
        }
        impl SpiDevice for Broken {
            fn transaction(
                &mut self,
                _: &mut [spi::Operation<'_, u8>],
            ) -> Result<(), SpiErrorKind> {
                Err(SpiErrorKind::Overrun)
            }
        }
        let error = Mcp3208::new(Broken).convert(Channel::new(0).unwrap()).unwrap_err();
        assert_eq!(error.kind(), ErrorKind::Bus(SpiErrorKind::Overrun));
    }

    #[test]
    fn a_bus_that_delivers_nothing_is_not_taken_for_code_zero() {
        struct Silent;
        impl spi::ErrorType for Silent {
            type Error = core::convert::Infallible;
        }
        impl SpiDevice for Silent {
            fn transaction(&mut self, _: &mut [spi::Operation<'_, u8>]) -> Result<(), Self::Error> {
                Ok(())
            }
        }
        let result = Mcp3208::new(Silent).convert(Channel::new(0).unwrap());
        assert_eq!(result, Err(Error::Protocol { reply: [0xFF; 3] }));
    }
}
