//! The board's buses and pins (see [`crate::pins`]) as embedded-hal sees them.

use core::convert::Infallible;

use adcs_hal::driver_board::Parts;
use embedded_hal::{
    digital::{self, OutputPin},
    pwm::{self, SetDutyCycle},
};
use stm32f4::stm32f405::{GPIOA, GPIOC, Peripherals, SPI1, TIM3};

use crate::{clock::ClockSource, pins, spi};

/// Frequency of the torquers' PWM, Hz: far above what a winding follows, and above hearing.
const PWM_HZ: u32 = 20_000;
/// Polls allowed for one byte on SPI. At 0.5 MHz it takes 16 µs, 2,700 cycles at 168 MHz; a poll
/// takes a handful.
const SPI_POLLS: u32 = 10_000;
/// A converter wants chip select high for 500 ns (DS21298E §1.0, t_CSH): 84 cycles at 168 MHz.
const DESELECTED_CYCLES: u32 = 84;

/// The buses and pins of [`DriverBoard`](adcs_hal::driver_board::DriverBoard).
pub type BoardParts<'a, C> = Parts<spi::Device<Spi<'a>>, Channel<'a>, Pin<'a>, Pin<'a>, C>;

/// Sets the peripherals up, torquers off, and hands them out.
pub fn take<'a, C>(chip: &'a Peripherals, source: ClockSource, clock: C) -> BoardParts<'a, C> {
    chip.RCC.ahb1enr().modify(|_, w| w.gpioaen().enabled().gpiocen().enabled());
    chip.RCC.apb1enr().modify(|_, w| w.tim3en().enabled());
    chip.RCC.apb2enr().modify(|_, w| w.spi1en().enabled());
    set_up_timer(&chip.TIM3, source);
    set_up_torquer_pins(&chip.GPIOC);
    set_up_spi(&chip.SPI1, &chip.GPIOA, source);
    let pin = |number| Pin { port: &chip.GPIOC, number };
    let core_hz = source.core_hz();
    let bus = |select| spi::Device(Spi { bus: &chip.SPI1, port: &chip.GPIOA, select, core_hz });
    Parts {
        spi: bus(pins::CONVERTER_SELECT),
        sun_spi: Some(pins::SUN_CONVERTER_SELECTS.map(bus)),
        enable: [0, 1, 2].map(|channel| Channel { timer: &chip.TIM3, channel }),
        phase: pins::PHASE.map(pin),
        sleep: pin(pins::AWAKE),
        clock,
    }
}

/// TIM3 counts at twice APB1 when that is divided, else at the core's frequency (RM0090 §7.2).
const fn timer_hz(source: ClockSource) -> u32 {
    match source {
        ClockSource::Crystal168MHz => 84_000_000,
        ClockSource::Internal16MHz(_) => source.core_hz(),
    }
}

fn set_up_timer(timer: &TIM3, source: ClockSource) {
    let steps = timer_hz(source) / PWM_HZ;
    timer.arr().write(|w| w.arr().set((steps - 1) as u16));
    timer
        .ccmr1_output()
        .write(|w| w.oc1m().pwm_mode1().oc1pe().enabled().oc2m().pwm_mode1().oc2pe().enabled());
    timer.ccmr2_output().write(|w| w.oc3m().pwm_mode1().oc3pe().enabled());
    timer.ccer().write(|w| w.cc1e().set_bit().cc2e().set_bit().cc3e().set_bit());
    timer.egr().write(|w| w.ug().update());
    timer.cr1().write(|w| w.arpe().enabled().cen().enabled());
}

fn set_up_torquer_pins(port: &GPIOC) {
    // TIM3 is alternate function 2 of PC6 to PC8 (DS8626, table of alternate functions).
    port.afrl().modify(|_, w| w.afrl6().af2().afrl7().af2());
    port.afrh().modify(|_, w| w.afrh8().af2());
    port.moder().modify(|_, w| {
        for pin in pins::ENABLE {
            w.moder(pin).alternate();
        }
        for pin in pins::PHASE.into_iter().chain([pins::AWAKE]) {
            w.moder(pin).output();
        }
        w
    });
}

fn set_up_spi(bus: &SPI1, port: &GPIOA, source: ClockSource) {
    let selects = || pins::SUN_CONVERTER_SELECTS.into_iter().chain([pins::CONVERTER_SELECT]);
    // High before they are outputs, so that no two converters ever answer at once.
    for select in selects() {
        port.bsrr().write(|w| w.bs(select).set_bit());
    }
    // SPI1 is alternate function 5 of PA5 to PA7.
    port.afrl().modify(|_, w| w.afrl5().af5().afrl6().af5().afrl7().af5());
    port.moder().modify(|_, w| {
        for pin in pins::CONVERTER_BUS {
            w.moder(pin).alternate();
        }
        for select in selects() {
            w.moder(select).output();
        }
        w
    });
    // The converters take at most 1 MHz at 2.7 V: 84 MHz / 128 and 16 MHz / 32 stay below.
    bus.cr1().write(|w| {
        match source {
            ClockSource::Crystal168MHz => w.br().div128(),
            ClockSource::Internal16MHz(_) => w.br().div32(),
        };
        w.mstr().master().ssm().enabled().ssi().slave_not_selected();
        w.cpol().idle_low().cpha().first_edge().spe().enabled()
    });
}

/// SPI1 with one converter's chip select.
#[derive(Debug)]
pub struct Spi<'a> {
    bus: &'a SPI1,
    port: &'a GPIOA,
    select: u8,
    core_hz: u32,
}

impl spi::Bus for Spi<'_> {
    fn select(&mut self) {
        self.port.bsrr().write(|w| w.br(self.select).set_bit());
    }

    fn deselect(&mut self) {
        self.port.bsrr().write(|w| w.bs(self.select).set_bit());
        cortex_m::asm::delay(DESELECTED_CYCLES);
    }

    fn exchange(&mut self, byte: u8) -> Option<u8> {
        (0..SPI_POLLS).find(|_| self.bus.sr().read().txe().bit_is_set())?;
        self.bus.dr8().write(|w| w.dr().set(byte));
        (0..SPI_POLLS).find(|_| self.bus.sr().read().rxne().bit_is_set())?;
        Some(self.bus.dr8().read().dr().bits())
    }

    fn delay_ns(&mut self, ns: u32) {
        const NS_PER_S: u64 = 1_000_000_000;
        let cycles = (u64::from(ns) * u64::from(self.core_hz)).div_ceil(NS_PER_S);
        // 2³² ns take less than 2³² cycles below 1 GHz.
        cortex_m::asm::delay(cycles as u32);
    }
}

/// One PWM channel of TIM3.
#[derive(Debug)]
pub struct Channel<'a> {
    timer: &'a TIM3,
    channel: usize,
}

impl pwm::ErrorType for Channel<'_> {
    type Error = Infallible;
}

impl SetDutyCycle for Channel<'_> {
    fn max_duty_cycle(&self) -> u16 {
        // A compare value above the last count keeps the output high throughout.
        self.timer.arr().read().arr().bits().saturating_add(1)
    }

    fn set_duty_cycle(&mut self, duty: u16) -> Result<(), Infallible> {
        self.timer.ccr(self.channel).write(|w| w.ccr().set(duty));
        Ok(())
    }
}

/// An output of port C.
#[derive(Debug)]
pub struct Pin<'a> {
    port: &'a GPIOC,
    number: u8,
}

impl digital::ErrorType for Pin<'_> {
    type Error = Infallible;
}

impl OutputPin for Pin<'_> {
    fn set_low(&mut self) -> Result<(), Infallible> {
        self.port.bsrr().write(|w| w.br(self.number).set_bit());
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        self.port.bsrr().write(|w| w.bs(self.number).set_bit());
        Ok(())
    }
}
