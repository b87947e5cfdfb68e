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
//! | PA5, PA6, PA7 | SPI1 clock, in, out | all converters |
//! | PA4 | output, low = selected | chip select of the converter behind magnetometer and gyros |
//! | PA1, PA2, PA3 | output, low = selected | chip selects of those behind Sun sensors 0 and 1, 2 and 3, 4 and 5 |
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

/// Clock, in and out of the converters' SPI on port A.
pub const CONVERTER_BUS: [u8; 3] = [5, 6, 7];

/// Chip select of the converter behind magnetometer and gyros, on port A.
pub const CONVERTER_SELECT: u8 = 4;

/// Chip selects of the converters behind the Sun sensors, on port A.
pub const SUN_CONVERTER_SELECTS: [u8; 3] = [1, 2, 3];

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
    fn every_converter_has_a_pin_of_its_own() {
        let selects = mask(&[CONVERTER_SELECT]) | mask(&SUN_CONVERTER_SELECTS);
        assert_eq!(selects.count_ones(), 4);
        assert_eq!(selects & mask(&CONVERTER_BUS), 0);
    }

    #[test]
    fn seven_different_pins_belong_to_the_torquers() {
        assert_eq!(TORQUER_MASK.count_ones(), 7);
    }
}
