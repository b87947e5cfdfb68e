//! Dying on purpose, with the torquers on: tests see from outside that they are switched off and
//! that the epitaph survives the reset.

use core::{hint::black_box, ptr};

use stm32f4::stm32f405::Peripherals;

use crate::stm32f405::Torquers;

/// No memory answers here (RM0090, memory map).
const NOTHING_THERE: *const u32 = ptr::without_provenance(0xB000_0000);

/// Panics.
pub fn panic() -> ! {
    switch_torquers_on();
    panic!("asked to panic")
}

/// Reads where no memory is.
pub fn fault() -> ! {
    switch_torquers_on();
    // SAFETY: it is not; the fault is what this function is for. The address belongs to nothing,
    // so nothing is disturbed before the core takes the fault.
    let value = unsafe { ptr::read_volatile(NOTHING_THERE) };
    panic!("read {value:#x} from nowhere")
}

/// Calls itself until the stack is used up.
pub fn overflow() -> ! {
    switch_torquers_on();
    panic!("the stack held {} frames", deeper(0))
}

#[expect(unconditional_recursion, reason = "that is the point")]
fn deeper(depth: u32) -> u32 {
    let frame = black_box([depth; 64]);
    deeper(frame[0] + 1) + frame[63]
}

fn switch_torquers_on() {
    // SAFETY: no flight is under way, so no driver owns the torquers.
    let chip = unsafe { Peripherals::steal() };
    Torquers::new(&chip).switch_on();
}
