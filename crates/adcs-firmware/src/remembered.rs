//! Where what the cycles remember lies.
//!
//! It is a quarter of the RAM. Made on the stack and moved, it would take that much there for as long as the
//! flight lasts; so it is made where it stays.

use core::mem::MaybeUninit;

use adcs_core::pipeline::State;
use cortex_m::singleton;

/// The memory, once; `None` after that.
pub fn room() -> Option<&'static mut MaybeUninit<State>> {
    singleton!(: MaybeUninit<State> = MaybeUninit::uninit())
}

/// The state of power-on. In a function of its own: what the compiler needs beside the room for making it is
/// off the stack when the flight begins.
#[inline(never)]
pub fn power_on(room: &mut MaybeUninit<State>) -> &mut State {
    room.write(State::default())
}
