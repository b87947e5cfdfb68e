//! The registers behind [`crate::clock`] and [`crate::torquers`].

use cortex_m::peripheral::SCB;
use stm32f4::stm32f405::{FLASH, GPIOC, Peripherals, RCC, TIM3};

use crate::{
    clock::{ClockRegisters, PllSettings, Source},
    epitaph::Registers,
    pins,
    torquers::TorquerRegisters,
};

/// The registers of the clock set-up.
#[derive(Debug)]
pub struct Clock<'a> {
    rcc: &'a RCC,
    flash: &'a FLASH,
}

impl<'a> Clock<'a> {
    /// The clock registers of `chip`.
    #[must_use]
    pub fn new(chip: &'a Peripherals) -> Self {
        Self { rcc: &chip.RCC, flash: &chip.FLASH }
    }
}

impl ClockRegisters for Clock<'_> {
    fn start_crystal(&mut self) {
        self.rcc.cr().modify(|_, w| w.hseon().on());
    }

    fn crystal_ready(&self) -> bool {
        self.rcc.cr().read().hserdy().is_ready()
    }

    fn start_pll(&mut self, settings: &PllSettings) {
        self.rcc.pllcfgr().write(|w| {
            // SAFETY: the constants given stay within the ranges of RM0090 §7.3.2, and a host
            // test holds the resulting frequencies against the data sheet.
            unsafe {
                w.pllm().bits(settings.crystal_divider);
                w.plln().bits(settings.multiplier);
                w.pllp().bits(settings.core_divider / 2 - 1);
                w.pllq().bits(settings.usb_divider);
            }
            w.pllsrc().hse()
        });
        self.rcc.cr().modify(|_, w| w.pllon().on());
    }

    fn pll_locked(&self) -> bool {
        self.rcc.cr().read().pllrdy().is_ready()
    }

    fn set_flash_wait_states(&mut self, wait_states: u8) {
        self.flash.acr().modify(|_, w| {
            w.prften().enabled().icen().enabled().dcen().enabled().latency().set(wait_states)
        });
    }

    fn flash_wait_states(&self) -> u8 {
        self.flash.acr().read().latency().bits()
    }

    fn set_bus_dividers(&mut self, apb1: u8, apb2: u8) {
        self.rcc.cfgr().modify(|_, w| {
            match apb1 {
                1 => w.ppre1().div1(),
                2 => w.ppre1().div2(),
                4 => w.ppre1().div4(),
                8 => w.ppre1().div8(),
                _ => w.ppre1().div16(),
            };
            match apb2 {
                1 => w.ppre2().div1(),
                2 => w.ppre2().div2(),
                4 => w.ppre2().div4(),
                8 => w.ppre2().div8(),
                _ => w.ppre2().div16(),
            }
        });
    }

    fn select(&mut self, source: Source) {
        self.rcc.cfgr().modify(|_, w| match source {
            Source::Internal => w.sw().hsi(),
            Source::Pll => w.sw().pll(),
        });
    }

    fn selected(&self) -> Option<Source> {
        let switch = self.rcc.cfgr().read().sws();
        if switch.is_hsi() {
            Some(Source::Internal)
        } else if switch.is_pll() {
            Some(Source::Pll)
        } else {
            None
        }
    }

    fn stop_pll_and_crystal(&mut self) {
        self.rcc.cr().modify(|_, w| w.csson().off().pllon().off().hseon().off());
    }

    fn watch_crystal(&mut self) {
        self.rcc.cr().modify(|_, w| w.csson().on());
    }
}

/// Timer 3 and port C, which drive the torquers.
#[derive(Debug)]
pub struct Torquers<'a> {
    rcc: &'a RCC,
    timer: &'a TIM3,
    port: &'a GPIOC,
}

impl<'a> Torquers<'a> {
    /// The torquers' registers of `chip`.
    #[must_use]
    pub fn new(chip: &'a Peripherals) -> Self {
        Self { rcc: &chip.RCC, timer: &chip.TIM3, port: &chip.GPIOC }
    }

    /// Switches all three torquers on at different duties, as a flight would have left them.
    pub fn switch_on(&mut self) {
        self.enable_clocks();
        self.timer.arr().write(|w| w.arr().set(8399));
        for (axis, duty) in [1_000, 2_000, 3_000].into_iter().enumerate() {
            self.timer.ccr(axis).write(|w| w.ccr().set(duty));
        }
        self.timer.ccer().write(|w| w.cc1e().set_bit().cc2e().set_bit().cc3e().set_bit());
        self.timer.cr1().modify(|_, w| w.cen().enabled());
        for pin in pins::ENABLE {
            self.port.moder().modify(|_, w| w.moder(pin).alternate());
        }
        self.port.bsrr().write(|w| w.bs(pins::AWAKE).set_bit());
        self.port.moder().modify(|_, w| w.moder(pins::AWAKE).output());
    }
}

impl TorquerRegisters for Torquers<'_> {
    fn enable_clocks(&mut self) {
        self.rcc.ahb1enr().modify(|_, w| w.gpiocen().enabled());
        self.rcc.apb1enr().modify(|_, w| w.tim3en().enabled());
        // Errata ES0182 §2.2.13: the first access must come two bus cycles after the enable.
        cortex_m::asm::dsb();
    }

    fn sleep_bridges(&mut self) {
        self.port.bsrr().write(|w| w.br(pins::AWAKE).set_bit());
        self.port.moder().modify(|_, w| w.moder(pins::AWAKE).output());
    }

    fn duties(&self) -> [u16; 3] {
        [0, 1, 2].map(|axis| self.timer.ccr(axis).read().ccr().bits())
    }

    fn stop_pwm(&mut self) {
        for axis in 0..3 {
            self.timer.ccr(axis).write(|w| w.ccr().set(0));
        }
        // The compare registers are preloaded; an update event makes the zeros count now.
        self.timer.egr().write(|w| w.ug().update());
        self.timer.ccer().reset();
        self.timer.cr1().modify(|_, w| w.cen().disabled());
    }

    fn drive_pins_low(&mut self) {
        let pins = || pins::ENABLE.into_iter().chain(pins::PHASE).chain([pins::AWAKE]);
        self.port.bsrr().write(|w| {
            for pin in pins() {
                w.br(pin).set_bit();
            }
            w
        });
        self.port.moder().modify(|_, w| {
            for pin in pins() {
                w.moder(pin).output();
            }
            w
        });
    }

    fn pins_are_low(&self) -> bool {
        let modes = self.port.moder().read();
        let outputs =
            (0..16).filter(|&pin| modes.moder(pin).is_output()).fold(0, |m, p| m | 1 << p);
        let levels = self.port.idr().read().bits() as u16;
        outputs & pins::TORQUER_MASK == pins::TORQUER_MASK && levels & pins::TORQUER_MASK == 0
    }
}

/// The core's fault registers, for an epitaph.
#[must_use]
pub fn fault_registers(program_counter: u32, link_register: u32) -> Registers {
    /// Bits of CFSR that say MMFAR or BFAR holds the failed address (ARMv7-M, §B3.2.15).
    const MMFAR_VALID: u32 = 1 << 7;
    const BFAR_VALID: u32 = 1 << 15;

    // SAFETY: the system control block is always there, and only read here.
    let scb = unsafe { &*SCB::PTR };
    let cfsr = scb.cfsr.read();
    let fault_address = if cfsr & BFAR_VALID != 0 {
        Some(scb.bfar.read())
    } else if cfsr & MMFAR_VALID != 0 {
        Some(scb.mmfar.read())
    } else {
        None
    };
    Registers { program_counter, link_register, cfsr, hfsr: scb.hfsr.read(), fault_address }
}
