//! Counts the instructions of stages of the flight software on the emulated core.
//!
//! Prints `instructions STAGE COUNT` and `bytes stack PEAK`; `cargo xtask budget` reads that.
#![cfg_attr(target_os = "none", no_std)]
#![cfg_attr(target_os = "none", no_main)]

#[cfg(all(target_os = "none", feature = "emulated"))]
mod counter;
#[cfg(all(target_os = "none", feature = "emulated"))]
mod ladder;
#[cfg(all(target_os = "none", feature = "emulated"))]
mod scenario;
#[cfg(all(target_os = "none", feature = "emulated"))]
mod stages;

#[cfg(all(target_os = "none", feature = "emulated"))]
#[cortex_m_rt::entry]
fn main() -> ! {
    let mut boot = adcs_firmware::boot::boot();
    stages::run(&counter::Counter::new(&mut boot.core.SYST));
    semihosting::process::exit(0)
}

#[cfg(all(target_os = "none", not(feature = "emulated")))]
compile_error!("the board has nothing to count with: --features emulated");

#[cfg(not(target_os = "none"))]
fn main() {
    println!("Counts instructions on the emulated core: cargo xtask budget");
}
