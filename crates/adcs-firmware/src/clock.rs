//! Clock set-up that survives a dead crystal.
//!
//! The core starts on the internal 16 MHz oscillator. The 8 MHz crystal and the PLL give 168 MHz
//! if they start; a satellite whose crystal has died must fly on without. Every wait is therefore
//! bounded, and each failure leads back to the internal oscillator, 1 % accurate and ten times
//! slower, and is reported.
//!
//! Sources: reference manual RM0090, §3.5.1 (flash wait states) and §7.2 (clocks); data sheet
//! DS8626, characteristics of the HSE oscillator and of the main PLL.

/// Frequency of the crystal, Hz.
pub const CRYSTAL_HZ: u32 = 8_000_000;
/// Frequency of the internal oscillator, Hz.
pub const INTERNAL_HZ: u32 = 16_000_000;
/// Frequency of the core on crystal and PLL, Hz.
pub const FULL_SPEED_HZ: u32 = 168_000_000;

/// PLL and bus dividers for 168 MHz from 8 MHz.
///
/// The divided crystal is 2 MHz, which RM0090 §7.3.2 recommends against jitter; the oscillator of
/// the PLL runs at 336 MHz.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PllSettings {
    /// Divides the crystal (PLLM).
    pub crystal_divider: u8,
    /// Multiplies the divided crystal (PLLN).
    pub multiplier: u16,
    /// Divides for the core (PLLP).
    pub core_divider: u8,
    /// Divides for USB and random numbers, 48 MHz (PLLQ).
    pub usb_divider: u8,
    /// Divides the core for APB1, at most 42 MHz.
    pub apb1_divider: u8,
    /// Divides the core for APB2, at most 84 MHz.
    pub apb2_divider: u8,
    /// Wait states of the flash at 168 MHz and 2.7 V to 3.6 V (RM0090 table 10).
    pub flash_wait_states: u8,
}

/// The settings this firmware uses.
pub const PLL: PllSettings = PllSettings {
    crystal_divider: 4,
    multiplier: 168,
    core_divider: 2,
    usb_divider: 7,
    apb1_divider: 4,
    apb2_divider: 2,
    flash_wait_states: 5,
};

/// Polls allowed for the crystal. A poll takes 8 cycles of the 16 MHz core or more, so this is
/// 100 ms or more; the data sheet names 2 ms as typical.
pub const CRYSTAL_POLLS: u32 = 200_000;
/// Polls allowed for the PLL: 5 ms or more; the data sheet's maximum is 0.3 ms.
pub const PLL_POLLS: u32 = 10_000;
/// Polls allowed for a flash or multiplexer setting to read back: a few cycles suffice.
pub const SETTING_POLLS: u32 = 1_000;

/// What drives the core.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Source {
    /// The internal 16 MHz oscillator.
    Internal,
    /// The PLL, fed by the crystal.
    Pll,
}

/// Why the core runs on the internal oscillator.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(target_os = "none", derive(defmt::Format))]
#[non_exhaustive]
pub enum Fallback {
    /// The crystal did not start to oscillate.
    CrystalDead,
    /// The PLL did not lock.
    PllNotLocked,
    /// The flash did not accept its wait states: 168 MHz would misread the program.
    FlashRefused,
    /// The multiplexer did not confirm the change to the PLL.
    SwitchNotConfirmed,
}

/// What the clock set-up arrived at.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(target_os = "none", derive(defmt::Format))]
pub enum ClockSource {
    /// Crystal and PLL: 168 MHz, crystal accuracy.
    Crystal168MHz,
    /// The internal oscillator: 16 MHz, 1 %.
    Internal16MHz(Fallback),
}

impl ClockSource {
    /// Frequency of the core, Hz.
    #[must_use]
    pub const fn core_hz(self) -> u32 {
        match self {
            Self::Crystal168MHz => FULL_SPEED_HZ,
            Self::Internal16MHz(_) => INTERNAL_HZ,
        }
    }
}

/// What the set-up needs from RCC, FLASH and PWR. The implementation touches registers; tests use
/// a model whose parts can be broken.
pub trait ClockRegisters {
    /// Starts the crystal oscillator.
    fn start_crystal(&mut self);
    /// The crystal oscillates.
    fn crystal_ready(&self) -> bool;
    /// Writes the PLL's settings and starts it on the crystal.
    fn start_pll(&mut self, settings: &PllSettings);
    /// The PLL has locked.
    fn pll_locked(&self) -> bool;
    /// Sets the wait states of the flash.
    fn set_flash_wait_states(&mut self, wait_states: u8);
    /// Wait states the flash uses.
    fn flash_wait_states(&self) -> u8;
    /// Sets the dividers of the peripheral buses.
    fn set_bus_dividers(&mut self, apb1: u8, apb2: u8);
    /// Asks the multiplexer for a source.
    fn select(&mut self, source: Source);
    /// The source the multiplexer says it uses.
    fn selected(&self) -> Option<Source>;
    /// Stops the PLL and the crystal.
    fn stop_pll_and_crystal(&mut self);
    /// Lets the hardware watch the crystal: if it dies, the core falls back and takes an NMI.
    fn watch_crystal(&mut self);
}

/// Brings the core to 168 MHz, or says why it stays at 16 MHz. Never waits without a bound.
pub fn set_up(registers: &mut impl ClockRegisters) -> ClockSource {
    match try_full_speed(registers) {
        Ok(()) => ClockSource::Crystal168MHz,
        Err(reason) => {
            fall_back(registers);
            ClockSource::Internal16MHz(reason)
        }
    }
}

fn try_full_speed<R: ClockRegisters>(registers: &mut R) -> Result<(), Fallback> {
    registers.start_crystal();
    wait(registers, CRYSTAL_POLLS, R::crystal_ready).ok_or(Fallback::CrystalDead)?;

    registers.start_pll(&PLL);
    wait(registers, PLL_POLLS, R::pll_locked).ok_or(Fallback::PllNotLocked)?;

    // Slower flash and buses first: nothing may be overclocked, not even for an instant.
    registers.set_flash_wait_states(PLL.flash_wait_states);
    wait(registers, SETTING_POLLS, |r| r.flash_wait_states() == PLL.flash_wait_states)
        .ok_or(Fallback::FlashRefused)?;
    registers.set_bus_dividers(PLL.apb1_divider, PLL.apb2_divider);

    registers.select(Source::Pll);
    wait(registers, SETTING_POLLS, |r| r.selected() == Some(Source::Pll))
        .ok_or(Fallback::SwitchNotConfirmed)?;
    registers.watch_crystal();
    Ok(())
}

/// Back to the state after reset, in the order that overclocks nothing.
fn fall_back<R: ClockRegisters>(registers: &mut R) {
    registers.select(Source::Internal);
    // If even this is not confirmed there is nothing else to select; keep the wait states then,
    // since the core may be running fast.
    let internal = wait(registers, SETTING_POLLS, |r| r.selected() == Some(Source::Internal));
    if internal.is_some() {
        registers.stop_pll_and_crystal();
        registers.set_bus_dividers(1, 1);
        registers.set_flash_wait_states(0);
    }
}

fn wait<R>(registers: &R, polls: u32, ready: impl Fn(&R) -> bool) -> Option<()> {
    (0..polls).any(|_| ready(registers)).then_some(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::cell::Cell;

    /// Model of RCC and FLASH with parts that can be broken. Each wait takes a few polls.
    struct Chip {
        crystal_works: bool,
        pll_works: bool,
        flash_works: bool,
        switch_works: bool,
        crystal_on: bool,
        pll: Option<PllSettings>,
        wait_states: u8,
        buses: (u8, u8),
        source: Source,
        watched: bool,
        overclocked: bool,
        polls: Cell<u32>,
    }

    impl Chip {
        fn fine() -> Self {
            Self {
                crystal_works: true,
                pll_works: true,
                flash_works: true,
                switch_works: true,
                crystal_on: false,
                pll: None,
                wait_states: 0,
                buses: (1, 1),
                source: Source::Internal,
                watched: false,
                overclocked: false,
                polls: Cell::new(0),
            }
        }

        fn after_some_polls(&self, state: bool) -> bool {
            self.polls.set(self.polls.get() + 1);
            state && self.polls.get().is_multiple_of(7)
        }

        fn check(&mut self) {
            let fast = self.source == Source::Pll;
            self.overclocked |= fast && (self.wait_states < 5 || self.buses != (4, 2));
        }

        fn is_as_after_reset(&self) -> bool {
            self.source == Source::Internal
                && !self.crystal_on
                && self.pll.is_none()
                && self.wait_states == 0
                && self.buses == (1, 1)
        }
    }

    impl ClockRegisters for Chip {
        fn start_crystal(&mut self) {
            self.crystal_on = true;
        }
        fn crystal_ready(&self) -> bool {
            self.after_some_polls(self.crystal_on && self.crystal_works)
        }
        fn start_pll(&mut self, settings: &PllSettings) {
            self.pll = Some(*settings);
        }
        fn pll_locked(&self) -> bool {
            self.after_some_polls(self.pll.is_some() && self.pll_works)
        }
        fn set_flash_wait_states(&mut self, wait_states: u8) {
            if self.flash_works {
                self.wait_states = wait_states;
            }
            self.check();
        }
        fn flash_wait_states(&self) -> u8 {
            self.wait_states
        }
        fn set_bus_dividers(&mut self, apb1: u8, apb2: u8) {
            self.buses = (apb1, apb2);
            self.check();
        }
        fn select(&mut self, source: Source) {
            if self.switch_works || source == Source::Internal {
                self.source = source;
            }
            self.check();
        }
        fn selected(&self) -> Option<Source> {
            self.after_some_polls(true).then_some(self.source)
        }
        fn stop_pll_and_crystal(&mut self) {
            assert_eq!(self.source, Source::Internal, "the running clock must not be stopped");
            self.crystal_on = false;
            self.pll = None;
        }
        fn watch_crystal(&mut self) {
            self.watched = true;
        }
    }

    #[test]
    fn a_good_crystal_gives_168_mhz_and_is_watched() {
        let mut chip = Chip::fine();
        assert_eq!(set_up(&mut chip), ClockSource::Crystal168MHz);
        assert!(chip.watched && !chip.overclocked);
        assert_eq!(chip.source, Source::Pll);
    }

    #[test]
    fn a_dead_crystal_leaves_the_internal_oscillator() {
        let mut chip = Chip { crystal_works: false, ..Chip::fine() };
        assert_eq!(set_up(&mut chip), ClockSource::Internal16MHz(Fallback::CrystalDead));
        assert!(chip.is_as_after_reset() && !chip.overclocked);
    }

    #[test]
    fn a_pll_that_never_locks_leaves_the_internal_oscillator() {
        let mut chip = Chip { pll_works: false, ..Chip::fine() };
        assert_eq!(set_up(&mut chip), ClockSource::Internal16MHz(Fallback::PllNotLocked));
        assert!(chip.is_as_after_reset() && !chip.overclocked);
    }

    #[test]
    fn a_flash_that_refuses_wait_states_is_not_read_at_168_mhz() {
        let mut chip = Chip { flash_works: false, ..Chip::fine() };
        assert_eq!(set_up(&mut chip), ClockSource::Internal16MHz(Fallback::FlashRefused));
        assert!(chip.is_as_after_reset() && !chip.overclocked);
    }

    #[test]
    fn a_switch_that_is_never_confirmed_leaves_the_internal_oscillator() {
        let mut chip = Chip { switch_works: false, ..Chip::fine() };
        assert_eq!(set_up(&mut chip), ClockSource::Internal16MHz(Fallback::SwitchNotConfirmed));
        assert!(chip.is_as_after_reset() && !chip.overclocked);
    }

    #[test]
    fn waits_end_after_the_polls_they_are_allowed() {
        let mut chip = Chip { crystal_works: false, ..Chip::fine() };
        set_up(&mut chip);
        assert!(chip.polls.get() <= CRYSTAL_POLLS + SETTING_POLLS);
    }

    #[test]
    fn the_dividers_give_the_frequencies_of_the_data_sheet() {
        let oscillator_hz = CRYSTAL_HZ / u32::from(PLL.crystal_divider) * u32::from(PLL.multiplier);
        assert_eq!(oscillator_hz / u32::from(PLL.core_divider), FULL_SPEED_HZ);
        assert_eq!(oscillator_hz / u32::from(PLL.usb_divider), 48_000_000);
        assert_eq!(FULL_SPEED_HZ / u32::from(PLL.apb1_divider), 42_000_000);
        assert_eq!(FULL_SPEED_HZ / u32::from(PLL.apb2_divider), 84_000_000);
    }
}
