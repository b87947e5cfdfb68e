//! Switching the torquers off at register level, whatever state the program is in.
//!
//! A torquer left on by a dead program magnetises the satellite, spoils every later field
//! measurement and drains the battery. So this is the first thing a panic or fault handler does;
//! it uses no driver, no lock and no state of the program.

use serde::{Deserialize, Serialize};

/// What the handler needs from the chip. The implementation touches registers; tests use a model.
pub trait TorquerRegisters {
    /// Clocks the timer and the port: without it their registers ignore writes.
    fn enable_clocks(&mut self);
    /// Drives the common sleep pin of the bridges low: all coils float.
    fn sleep_bridges(&mut self);
    /// PWM compare values of the X, Y, Z channels.
    fn duties(&self) -> [u16; 3];
    /// Sets the three compare values to zero, effective at once, and disconnects the channels.
    fn stop_pwm(&mut self);
    /// Makes every torquer pin a plain output at low level.
    fn drive_pins_low(&mut self);
    /// True if every torquer pin is an output and at low level.
    fn pins_are_low(&self) -> bool;
}

/// The torquers' registers before and after they were switched off.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct SwitchedOff {
    /// Compare values found, timer ticks.
    pub duties_before: [u16; 3],
    /// Compare values read back afterwards, timer ticks.
    pub duties_after: [u16; 3],
    /// All torquer pins were read back as outputs at low level.
    pub pins_low: bool,
}

/// Switches the three torquers off and reads back what the registers then say.
pub fn switch_off(registers: &mut impl TorquerRegisters) -> SwitchedOff {
    registers.enable_clocks();
    registers.sleep_bridges();
    let duties_before = registers.duties();
    registers.stop_pwm();
    registers.drive_pins_low();
    SwitchedOff {
        duties_before,
        duties_after: registers.duties(),
        pins_low: registers.pins_are_low(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Models the parts of RCC, TIM3 and port C that matter: writes without a clock are lost.
    #[derive(Default)]
    struct Chip {
        clocked: bool,
        awake: bool,
        compare: [u16; 3],
        pwm_connected: bool,
        low_outputs: bool,
        /// The bridges were awake while the PWM was being dismantled.
        glitch: bool,
    }

    impl TorquerRegisters for Chip {
        fn enable_clocks(&mut self) {
            self.clocked = true;
        }
        fn sleep_bridges(&mut self) {
            self.awake &= !self.clocked;
        }
        fn duties(&self) -> [u16; 3] {
            self.compare
        }
        fn stop_pwm(&mut self) {
            self.glitch |= self.awake;
            if self.clocked {
                self.compare = [0; 3];
                self.pwm_connected = false;
            }
        }
        fn drive_pins_low(&mut self) {
            self.glitch |= self.awake;
            self.low_outputs = self.clocked;
        }
        fn pins_are_low(&self) -> bool {
            self.low_outputs
        }
    }

    #[test]
    fn running_torquers_are_off_afterwards_and_the_bridges_sleep_first() {
        let mut chip =
            Chip { awake: true, compare: [100, 0, 8400], pwm_connected: true, ..Chip::default() };
        let off = switch_off(&mut chip);
        assert_eq!(off.duties_before, [100, 0, 8400]);
        assert_eq!(off.duties_after, [0; 3]);
        assert!(off.pins_low && !chip.awake && !chip.pwm_connected);
        assert!(!chip.glitch, "the bridges must sleep before their inputs change");
    }

    #[test]
    fn switching_off_twice_changes_nothing() {
        let mut chip = Chip { compare: [1, 2, 3], pwm_connected: true, ..Chip::default() };
        switch_off(&mut chip);
        let again = switch_off(&mut chip);
        assert_eq!(again, SwitchedOff { pins_low: true, ..SwitchedOff::default() });
    }
}
