//! The pieces of RAM that the linker script sets aside: those that outlive a reset, and the stack.

use core::ptr;

use adcs_core::commissioning::Findings;

use crate::epitaph::{Epitaph, REGION_BYTES};
use crate::notebook;

// Addresses set in `memory.x`. Only the addresses mean something, nothing lives in the symbols.
unsafe extern "C" {
    static mut _epitaph_start: [u8; REGION_BYTES];
    static mut _notebook_start: [u8; notebook::REGION_BYTES];
    static _stack_start: u32;
    static _stack_end: u32;
}

/// The record in retained memory, if a previous image left one.
#[must_use]
pub fn read_epitaph() -> Option<Epitaph> {
    // SAFETY: `memory.x` reserves REGION_BYTES readable bytes at this symbol, any bit pattern is
    // a valid [u8], and volatile keeps the compiler from assuming they are still as it knew them.
    let region = unsafe { ptr::read_volatile(&raw const _epitaph_start) };
    Epitaph::decode(&region)
}

/// Writes `epitaph` where the next image finds it.
pub fn write_epitaph(epitaph: &Epitaph) {
    let mut region = [0; REGION_BYTES];
    epitaph.encode(&mut region);
    // SAFETY: `memory.x` reserves REGION_BYTES writable bytes at this symbol, which nothing else
    // uses; there is one core, and both users (boot, dying handler) run to their end.
    unsafe { ptr::write_volatile(&raw mut _epitaph_start, region) };
}

/// Takes the record that no boot has reported yet, and marks it as reported.
#[must_use]
pub fn take_epitaph() -> Option<Epitaph> {
    let epitaph = read_epitaph().filter(|epitaph| !epitaph.reported)?;
    let mut reported = epitaph.clone();
    reported.reported = true;
    write_epitaph(&reported);
    Some(epitaph)
}

/// What commissioning had found before a reset.
#[must_use]
pub fn read_findings() -> Option<Findings> {
    // SAFETY: `memory.x` reserves REGION_BYTES readable bytes at this symbol, any bit pattern is
    // a valid [u8], and volatile keeps the compiler from assuming they are still as it knew them.
    let region = unsafe { ptr::read_volatile(&raw const _notebook_start) };
    notebook::decode(&region)
}

/// Writes what commissioning found where the next image finds it.
pub fn write_findings(findings: &Findings) {
    let Some(region) = notebook::encode(findings) else { return };
    // SAFETY: `memory.x` reserves REGION_BYTES writable bytes at this symbol, which nothing else
    // uses; there is one core, and one user. A reset in the middle leaves a CRC that is wrong.
    unsafe { ptr::write_volatile(&raw mut _notebook_start, region) };
}

/// Bytes of stack this image has, and the most it has used since boot.
///
/// Start-up code paints the stack; what has lost its paint has been used.
#[must_use]
pub fn stack_use() -> StackUse {
    let bottom = &raw const _stack_end;
    let top = &raw const _stack_start;
    let words = (top.addr() - bottom.addr()) / size_of::<u32>();
    let painted = (0..words)
        .take_while(|&word| {
            // SAFETY: bottom..top is the stack in RAM (`memory.x`), aligned to words; reads are
            // volatile because the words in use belong to the callers of this function.
            let value = unsafe { ptr::read_volatile(bottom.add(word)) };
            value == cortex_m_rt::STACK_PAINT_VALUE
        })
        .count();
    StackUse {
        peak_bytes: (words - painted) * size_of::<u32>(),
        size_bytes: words * size_of::<u32>(),
    }
}

/// True if `address` lies below the stack, where no memory is.
#[must_use]
pub fn is_below_stack(address: usize) -> bool {
    address < (&raw const _stack_end).addr()
}

/// Use of the stack.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StackUse {
    /// The most that has been used, bytes.
    pub peak_bytes: usize,
    /// Its size, bytes.
    pub size_bytes: usize,
}
