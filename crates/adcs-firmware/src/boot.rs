//! The first things every image does.

use cortex_m::peripheral::scb::Exception;
use stm32f4::stm32f405::Peripherals;

use crate::{
    clock::{self, ClockSource},
    epitaph::Epitaph,
    memory,
    stm32f405::{Clock, Torquers},
    torquers,
};

/// What the image starts with.
#[allow(missing_debug_implementations)]
pub struct Boot {
    /// The core's own peripherals.
    pub core: cortex_m::Peripherals,
    /// The chip's peripherals.
    pub chip: Peripherals,
    /// What drives the core.
    pub clock: ClockSource,
    /// What the previous image died of, if it did and no boot has said so yet.
    pub epitaph: Option<Epitaph>,
}

/// Torquers off, faults on, epitaph read, clock up; logs what it finds.
///
/// # Panics
/// When called twice.
#[must_use]
pub fn boot() -> Boot {
    let (Some(mut core), Some(chip)) = (cortex_m::Peripherals::take(), Peripherals::take()) else {
        unreachable!("an image boots once")
    };
    let torquers = torquers::switch_off(&mut Torquers::new(&chip));
    core.SCB.enable(Exception::BusFault);
    let epitaph = memory::take_epitaph();
    let clock = clock::set_up(&mut Clock::new(&chip));

    defmt::info!("adcs-firmware {} runs on {}", env!("CARGO_PKG_VERSION"), clock);
    // The emulator has no port C to read back.
    if !torquers.pins_low && !cfg!(feature = "emulated") {
        defmt::warn!("torquer pins do not read back as low outputs");
    }
    if let Some(epitaph) = &epitaph {
        defmt::error!("the previous image died: {}", defmt::Display2Format(epitaph));
    }
    Boot { core, chip, clock, epitaph }
}
