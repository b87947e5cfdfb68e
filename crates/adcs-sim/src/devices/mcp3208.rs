//! The MCP3208 from the chip's side of the bus.
//!
//! Stricter than the chip (Microchip, DS21298E): it takes exactly the three-byte frame of §6.1,
//! single-ended, in one transfer, and only while it is powered. The chip itself would take any
//! number of leading zeros, differential pairs, and shorter or longer frames, and answer something.
//! Bits that it leaves floating are read as ones, so that a driver which does not mask them fails.
//!
//! The conversion is ideal ([`Code::of_volts`]); offset, gain error and nonlinearity (up to 3, 5
//! and 2 steps, §1.0) are small beside the sensors' own errors and left out.

use adcs_hal::mcp3208::Code;
use adcs_hal::mcp3208::registers::{self, HIGH_IMPEDANCE};
use embedded_hal::spi::{ErrorType, Operation, SpiDevice};

use super::{Bench, Converter, DeviceError, Plant, SpiFault, Violation};

/// A converter's bus with its chip select.
#[derive(Debug)]
pub struct SimMcp3208<'b, P> {
    bench: &'b Bench<'b, P>,
    converter: Converter,
}

impl<'b, P: Plant> SimMcp3208<'b, P> {
    pub(super) fn new(bench: &'b Bench<'b, P>, converter: Converter) -> Self {
        Self { bench, converter }
    }

    /// What the chip answers to one frame.
    fn answer(&self, command: [u8; 3]) -> Result<[u8; 3], DeviceError> {
        match self.bench.spi_fault.get() {
            Some(SpiFault::Zeros) => return Ok([0x00; 3]),
            Some(SpiFault::Ones) => return Ok([0xFF; 3]),
            Some(SpiFault::Error) => return Err(DeviceError::Injected),
            None => {}
        }
        let channel = registers::decode_command(command)
            .map_err(|error| self.bench.violated(Violation::Command(error)))?;
        let mut plant = self.bench.plant()?;
        if !plant.powered() {
            return Err(self.bench.violated(Violation::Unpowered));
        }
        let volts = plant.pin_volts(self.converter, channel.number());
        let [a, b, c] =
            registers::encode_reply(Code::of_volts(volts, self.bench.config.reference_v));
        let [floating_a, floating_b, floating_c] = HIGH_IMPEDANCE;
        Ok([a | floating_a, b | floating_b, c | floating_c])
    }

    /// One transfer, which must be one frame.
    fn exchange(&self, read: &mut [u8], write: &[u8]) -> Result<(), DeviceError> {
        let (written, wanted) = (write.len(), read.len());
        let (Ok(command), Ok(reply)) = (<[u8; 3]>::try_from(write), <&mut [u8; 3]>::try_from(read))
        else {
            return Err(self.bench.violated(Violation::FrameLength { written, read: wanted }));
        };
        *reply = self.answer(command)?;
        Ok(())
    }
}

impl<P> ErrorType for SimMcp3208<'_, P> {
    type Error = DeviceError;
}

impl<P: Plant> SpiDevice for SimMcp3208<'_, P> {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), DeviceError> {
        match operations {
            [Operation::Transfer(read, write)] => self.exchange(read, write),
            [Operation::TransferInPlace(bytes)] => {
                let (written, read) = (bytes.len(), bytes.len());
                let Ok(bytes) = <&mut [u8; 3]>::try_from(&mut **bytes) else {
                    return Err(self.bench.violated(Violation::FrameLength { written, read }));
                };
                *bytes = self.answer(*bytes)?;
                Ok(())
            }
            [_] => Err(self.bench.violated(Violation::OneWay)),
            pieces => Err(self.bench.violated(Violation::Pieces { found: pieces.len() })),
        }
    }
}
