//! What the images for the ADC MPU (STM32F405) have in common.
//!
//! | module | what |
//! |---|---|
//! | [`pins`] | which pin does what |
//! | [`clock`] | 168 MHz, or 16 MHz when the crystal is dead |
//! | [`torquers`] | switching the torquers off at register level |
//! | [`epitaph`] | what a dying image leaves for the next |
//! | [`notebook`] | what commissioning found, kept over a reset |
//! | [`spi`] | the converter's bus, with bounded waits |
//! | [`parameters`] | what the satellite flies with until the ground says otherwise |
//!
//! These are pure and tested on the host. On the chip comes what touches it: `boot`, `peripherals`,
//! `ticks`, `watchdog`, `satellite`; and the modules that hold all `unsafe` of the project:
//! `stm32f405` (registers), `memory` (retained RAM and the stack), `fatal` (panic and fault
//! handlers), and in the emulated image `rehearsal` (dying on purpose).
#![cfg_attr(not(test), no_std)]

pub mod clock;
pub mod epitaph;
pub mod notebook;
pub mod parameters;
pub mod pins;
mod sealed;
pub mod spi;
pub mod torquers;

#[cfg(target_os = "none")]
pub mod boot;
#[cfg(target_os = "none")]
pub mod fatal;
#[cfg(target_os = "none")]
pub mod memory;
#[cfg(all(target_os = "none", not(feature = "emulated")))]
pub mod peripherals;
#[cfg(all(target_os = "none", feature = "emulated"))]
pub mod rehearsal;
#[cfg(target_os = "none")]
pub mod remembered;
#[cfg(all(target_os = "none", not(feature = "emulated")))]
pub mod satellite;
#[cfg(target_os = "none")]
pub mod stm32f405;
#[cfg(all(target_os = "none", not(feature = "emulated")))]
pub mod ticks;
#[cfg(all(target_os = "none", not(feature = "emulated")))]
pub mod watchdog;

#[cfg(all(target_os = "none", feature = "flight", not(feature = "emulated")))]
use defmt_rtt as _;
#[cfg(all(target_os = "none", not(any(feature = "emulated", feature = "flight"))))]
compile_error!(
    "an image needs a way to log: --features emulated (semihosting) or --features flight (RTT)"
);

#[cfg(all(target_os = "none", feature = "emulated"))]
use defmt_semihosting as _;
