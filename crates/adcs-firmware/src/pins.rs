//! Which pin does what on the ADC board.
//!
//! The flight wiring is not published; this is the pinout the firmware assumes (docs chapter
//! "The board"). Another board changes this file,
//! `stm32f405.rs` and `peripherals.rs`, and nothing else.
//!
//! | pin | function | to |
//! |---|---|---|
//! | PC6, PC7, PC8 | TIM3 channels 1, 2, 3 | bridge enable (PWM) of the X, Y, Z torquer |
//! | PC0, PC1, PC2 | output | bridge phase (direction) of the X, Y, Z torquer |
//! | PC9 | output, high = awake | sleep input common to the three bridges |
//! | PA5, PA6, PA7 | SPI1 clock, in, out | the converter behind the magnetometer and the gyros |
//! | PA4 | output, low = selected | that converter's chip select |
//! | PH0, PH1 | oscillator | 8 MHz crystal |
//! | PA13, PA14 | SWD | debugger, RTT |
//!
//! All seven torquer pins are on port C, so one register write drives them all low.

/// Bridge enable (PWM) pins of the X, Y, Z torquers on port C.
pub const ENABLE: [u8; 3] = [6, 7, 8];

/// Bridge phase (direction) pins of the X, Y, Z torquers on port C.
pub const PHASE: [u8; 3] = [0, 1, 2];

/// Sleep pin common to the three bridges on port C: low puts all outputs to high impedance.
pub const AWAKE: u8 = 9;

/// Clock, in and out of the converter's SPI on port A.
pub const CONVERTER_BUS: [u8; 3] = [5, 6, 7];

/// The converter's chip select on port A.
pub const CONVERTER_SELECT: u8 = 4;

/// Port C pins of the torquers as a bit mask.
pub const TORQUER_MASK: u16 = mask(&ENABLE) | mask(&PHASE) | mask(&[AWAKE]);

const fn mask(pins: &[u8]) -> u16 {
    let mut mask = 0;
    let mut rest = pins;
    while let [pin, tail @ ..] = rest {
        mask |= 1 << *pin;
        rest = tail;
    }
    mask
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seven_different_pins_belong_to_the_torquers() {
        assert_eq!(TORQUER_MASK.count_ones(), 7);
    }
}
