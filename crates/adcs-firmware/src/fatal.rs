//! The last things an image does: torquers off, epitaph, reset.
//!
//! All handlers end in `die`, which uses neither lock nor driver nor log. After the reset the
//! next boot reports the epitaph; the emulated image then exits with an error.

use core::{
    arch::naked_asm,
    panic::PanicInfo,
    sync::atomic::{AtomicBool, Ordering},
};

use cortex_m::peripheral::SCB;
use cortex_m_rt::{ExceptionFrame, exception};
use stm32f4::stm32f405::Peripherals;

use crate::{
    epitaph::{Cause, Epitaph, Message, Registers},
    memory,
    stm32f405::{self, Torquers},
    torquers,
};

/// Set on the first way into `die`. If writing the epitaph fails in turn, the second way only
/// switches the torquers off and resets.
static DYING: AtomicBool = AtomicBool::new(false);

fn die(cause: Cause, registers: Registers, message: impl FnOnce() -> Message) -> ! {
    cortex_m::interrupt::disable();
    // SAFETY: interrupts are off and this function never returns, so whoever had the peripherals
    // does not touch them again.
    let chip = unsafe { Peripherals::steal() };
    let torquers = torquers::switch_off(&mut Torquers::new(&chip));
    if !DYING.swap(true, Ordering::Relaxed) {
        let previous = memory::read_epitaph();
        let epitaph = Epitaph::new(cause, registers, torquers, message(), previous.as_ref());
        memory::write_epitaph(&epitaph);
    }
    SCB::sys_reset()
}

#[panic_handler]
fn panic(info: &PanicInfo<'_>) -> ! {
    die(Cause::Panic, Registers::default(), || match info.location() {
        Some(place) => Message::new(format_args!("at {place}: {}", info.message())),
        None => Message::new(format_args!("{}", info.message())),
    })
}

/// Entry of all faults. If the stack has run off the end of memory, the handler gets the stack
/// from its top again: the program never goes on, and nothing below is needed any more.
///
/// Bus faults are enabled only so that the core can still get here then: its attempt to save
/// registers on an overrun stack is a second fault, which may follow a bus fault but locks the
/// core up if it follows a hard fault (ARMv7-M, §B1.5.14).
///
/// # Safety
/// Called by the core only.
#[unsafe(naked)]
#[unsafe(no_mangle)]
unsafe extern "C" fn HardFault() -> ! {
    naked_asm!(
        "mrs r0, MSP",
        "ldr r1, =_stack_end",
        "cmp r0, r1",
        "bhs 1f",
        "ldr r1, =_stack_start",
        "msr MSP, r1",
        "1: b {fault}",
        fault = sym fault,
    )
}

/// See [`HardFault`].
///
/// # Safety
/// Called by the core only.
#[unsafe(naked)]
#[unsafe(no_mangle)]
unsafe extern "C" fn BusFault() -> ! {
    naked_asm!("b {hard_fault}", hard_fault = sym HardFault)
}

extern "C" fn fault(frame: *const ExceptionFrame) -> ! {
    if memory::is_below_stack(frame.addr()) {
        die(Cause::StackOverflow, stm32f405::fault_registers(0, 0), Message::default);
    }
    // SAFETY: the core has just stored the frame there, and it lies in the stack.
    let frame = unsafe { &*frame };
    die(Cause::Fault, stm32f405::fault_registers(frame.pc(), frame.lr()), Message::default)
}

/// An interrupt nobody expects. The NMI is one: the crystal has died, and the boot after the
/// reset finds that out and flies on with the internal oscillator.
///
/// # Safety
/// Called by the core only; touches no data shared under a critical section.
#[exception]
unsafe fn DefaultHandler(number: i16) -> ! {
    let registers = stm32f405::fault_registers(0, 0);
    die(Cause::Interrupt(number), registers, Message::default)
}
