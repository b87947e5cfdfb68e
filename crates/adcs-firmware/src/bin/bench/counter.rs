//! Counting instructions.
//!
//! The emulator, told `-icount shift=7`, lets 2⁷ ns pass per instruction, so the 24-bit SysTick
//! timer is an instruction counter. Its ticks are turned into instructions by a loop whose
//! instructions are known; so nothing depends on the frequency the emulator gives the core.

use core::{
    hint::black_box,
    sync::atomic::{AtomicU32, Ordering},
};

use cortex_m::peripheral::{SYST, syst::SystClkSource};
use cortex_m_rt::exception;

/// Ticks until SysTick wraps: its 24 bits.
const WRAP: u32 = 1 << 24;

static WRAPS: AtomicU32 = AtomicU32::new(0);

#[exception]
fn SysTick() {
    WRAPS.store(WRAPS.load(Ordering::Relaxed).wrapping_add(1), Ordering::Relaxed);
}

/// Counts instructions.
pub struct Counter {
    /// Instructions of the calibration loop, and the ticks it took.
    calibration: (u64, u64),
    /// Ticks that a measurement of nothing takes.
    overhead: u64,
}

impl Counter {
    /// Starts SysTick and calibrates.
    pub fn new(timer: &mut SYST) -> Self {
        timer.set_clock_source(SystClkSource::Core);
        timer.set_reload(WRAP - 1);
        timer.clear_current();
        timer.enable_counter();
        timer.enable_interrupt();

        /// `delay(n)` executes n + 1 times two instructions.
        const LOOPS: u32 = 100_000;
        let overhead = ticks_of(|| ());
        let ticks = ticks_of(|| cortex_m::asm::delay(LOOPS - 1)) - overhead;
        Self { calibration: (2 * u64::from(LOOPS), ticks), overhead }
    }

    /// Instructions that `work` takes.
    pub fn count<T>(&self, work: impl FnOnce() -> T) -> u64 {
        self.instructions(ticks_of(work))
    }

    /// This instant, for [`since`](Self::since).
    pub fn now(&self) -> Instant {
        Instant(ticks())
    }

    /// Instructions since `instant`.
    pub fn since(&self, instant: Instant) -> u64 {
        self.instructions(ticks() - instant.0)
    }

    fn instructions(&self, ticks: u64) -> u64 {
        let (instructions, calibration_ticks) = self.calibration;
        let ticks = ticks.saturating_sub(self.overhead);
        (ticks * instructions + calibration_ticks / 2) / calibration_ticks
    }
}

/// A point in the counter's time.
#[derive(Clone, Copy)]
pub struct Instant(u64);

#[inline(never)]
fn ticks_of<T>(work: impl FnOnce() -> T) -> u64 {
    let start = ticks();
    black_box(work());
    ticks() - start
}

/// Ticks since the counter was started.
fn ticks() -> u64 {
    loop {
        let wraps = WRAPS.load(Ordering::Relaxed);
        let elapsed = WRAP - 1 - SYST::get_current();
        // If SysTick wrapped in between, the two do not belong together.
        if WRAPS.load(Ordering::Relaxed) == wraps {
            return u64::from(wraps) * u64::from(WRAP) + u64::from(elapsed);
        }
    }
}
