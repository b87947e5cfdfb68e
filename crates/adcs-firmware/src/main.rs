//! The image. On the chip it flies; under an emulator it takes its orders from the command line
//! (`commands`); on the host it prints what it is.
#![cfg_attr(target_os = "none", no_std)]
#![cfg_attr(target_os = "none", no_main)]

#[cfg(all(target_os = "none", feature = "emulated"))]
mod commands;
#[cfg(all(target_os = "none", feature = "emulated"))]
mod flight;
#[cfg(all(target_os = "none", feature = "emulated"))]
mod host;

#[cfg(all(target_os = "none", feature = "emulated"))]
#[cortex_m_rt::entry]
fn main() -> ! {
    commands::run(&adcs_firmware::boot::boot())
}

#[cfg(all(target_os = "none", not(feature = "emulated")))]
#[cortex_m_rt::entry]
fn main() -> ! {
    adcs_firmware::satellite::fly(adcs_firmware::boot::boot())
}

#[cfg(not(target_os = "none"))]
fn main() {
    use adcs_firmware::{clock, epitaph, parameters, pins};
    println!("adcs-firmware {}: an image for the STM32F405.", env!("CARGO_PKG_VERSION"));
    println!("Build and fly it with `cargo xtask fly`. Memory (memory.x):\n");
    print!("{}", include_str!("../../../memory.x"));
    println!("\nClock: {:?}, else {} Hz", clock::PLL, clock::INTERNAL_HZ);
    println!(
        "Torquer pins on port C: enable {:?}, phase {:?}, awake {}",
        pins::ENABLE,
        pins::PHASE,
        pins::AWAKE
    );
    println!("Parameters after power-on: {:#?}", parameters::flight());
    println!("Epitaph: {} bytes, message up to {}", epitaph::REGION_BYTES, epitaph::MESSAGE_BYTES);
}
