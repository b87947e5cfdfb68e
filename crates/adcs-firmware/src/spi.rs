//! A converter's chip select and the converters' common SPI bus as an embedded-hal `SpiDevice`.
//!
//! Every wait is bounded: a bus whose clock stands still gives an error, not a hanging satellite.

use embedded_hal::spi::{self, ErrorKind, Operation, SpiDevice};

/// What the device needs from the chip's SPI. The implementation touches registers; tests use a
/// model.
pub trait Bus {
    /// Drives chip select low.
    fn select(&mut self);
    /// Drives chip select high and keeps it there as long as the converter asks for.
    fn deselect(&mut self);
    /// Sends one byte and gives the one that came in meanwhile; `None` when the bus stands still.
    fn exchange(&mut self, byte: u8) -> Option<u8>;
    /// Waits.
    fn delay_ns(&mut self, ns: u32);
}

/// One device of a bus. Several may share it: one processor, one transaction after the other.
#[derive(Debug)]
pub struct Device<B>(pub B);

/// The bus stood still in the middle of a byte.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Timeout;

impl spi::Error for Timeout {
    fn kind(&self) -> ErrorKind {
        ErrorKind::Other
    }
}

impl<B> spi::ErrorType for Device<B> {
    type Error = Timeout;
}

impl<B: Bus> SpiDevice for Device<B> {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), Timeout> {
        self.0.select();
        let result = operations.iter_mut().try_for_each(|operation| self.perform(operation));
        self.0.deselect();
        result
    }
}

impl<B: Bus> Device<B> {
    fn perform(&mut self, operation: &mut Operation<'_, u8>) -> Result<(), Timeout> {
        match operation {
            Operation::Read(words) => words.iter_mut().try_for_each(|word| {
                *word = self.exchange(0)?;
                Ok(())
            }),
            Operation::Write(words) => {
                words.iter().try_for_each(|&word| self.exchange(word).map(|_| ()))
            }
            Operation::Transfer(read, write) => {
                let length = read.len().max(write.len());
                (0..length).try_for_each(|position| {
                    let word = self.exchange(write.get(position).copied().unwrap_or(0))?;
                    if let Some(slot) = read.get_mut(position) {
                        *slot = word;
                    }
                    Ok(())
                })
            }
            Operation::TransferInPlace(words) => words.iter_mut().try_for_each(|word| {
                *word = self.exchange(*word)?;
                Ok(())
            }),
            Operation::DelayNs(ns) => {
                self.0.delay_ns(*ns);
                Ok(())
            }
        }
    }

    fn exchange(&mut self, byte: u8) -> Result<u8, Timeout> {
        self.0.exchange(byte).ok_or(Timeout)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Answers each byte with its complement, until it stands still.
    #[derive(Default)]
    struct Wires {
        seen: Vec<u8>,
        selected: bool,
        selections: u32,
        stands_still_after: Option<usize>,
        waited_ns: u32,
    }

    impl Bus for Wires {
        fn select(&mut self) {
            self.selected = true;
            self.selections += 1;
        }
        fn deselect(&mut self) {
            self.selected = false;
        }
        fn exchange(&mut self, byte: u8) -> Option<u8> {
            assert!(self.selected, "a byte must not leave while the chip is not selected");
            self.seen.push(byte);
            (Some(self.seen.len()) <= self.stands_still_after.or(Some(usize::MAX))).then_some(!byte)
        }
        fn delay_ns(&mut self, ns: u32) {
            self.waited_ns += ns;
        }
    }

    #[test]
    fn one_transaction_is_one_selection_whatever_it_holds() {
        let mut device = Device(Wires::default());
        let (mut read, mut short, mut in_place) = ([0; 2], [0; 1], [7]);
        device
            .transaction(&mut [
                Operation::Write(&[1, 2]),
                Operation::DelayNs(50),
                Operation::Read(&mut read),
                Operation::Transfer(&mut short, &[3, 4]),
                Operation::TransferInPlace(&mut in_place),
            ])
            .unwrap();
        assert_eq!(device.0.seen, [1, 2, 0, 0, 3, 4, 7]);
        assert_eq!((read, short, in_place), ([0xFF; 2], [!3], [!7]));
        assert_eq!((device.0.selections, device.0.selected, device.0.waited_ns), (1, false, 50));
    }

    #[test]
    fn a_bus_that_stands_still_is_an_error_and_the_chip_is_released() {
        let mut device = Device(Wires { stands_still_after: Some(1), ..Wires::default() });
        assert_eq!(device.transfer_in_place(&mut [1, 2, 3]), Err(Timeout));
        assert_eq!(device.0.seen.len(), 2, "no byte after the one that failed");
        assert!(!device.0.selected);
    }
}
