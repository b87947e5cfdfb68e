//! Time on board: milliseconds counted by SysTick.

use core::sync::atomic::{AtomicU32, Ordering};

use adcs_core::time::Utc;
use adcs_hal::driver_board::Clock;
use cortex_m::peripheral::{SYST, syst::SystClkSource};
use cortex_m_rt::exception;

static MILLISECONDS: AtomicU32 = AtomicU32::new(0);

const MICROS_PER_MILLI: i64 = 1_000;

#[exception]
fn SysTick() {
    // Nobody else writes, so loading and storing is as good as adding.
    MILLISECONDS.store(milliseconds().wrapping_add(1), Ordering::Relaxed);
}

/// Milliseconds since [`start`]; wraps after 49 days.
pub fn milliseconds() -> u32 {
    MILLISECONDS.load(Ordering::Relaxed)
}

/// Starts the millisecond tick of a core that runs at `core_hz`.
pub fn start(timer: &mut SYST, core_hz: u32) {
    timer.set_clock_source(SystClkSource::Core);
    timer.set_reload(core_hz / 1_000 - 1);
    timer.clear_current();
    timer.enable_interrupt();
    timer.enable_counter();
}

/// The satellite's clock. It stands at 2000-01-01 at power-on: nothing on this board keeps the time
/// without power, and nothing that despins needs it.
#[derive(Debug, Default)]
pub struct SincePowerOn {
    micros: i64,
    seen_ms: u32,
}

impl Clock for SincePowerOn {
    fn now(&mut self) -> Utc {
        let now_ms = milliseconds();
        let elapsed_ms = now_ms.wrapping_sub(self.seen_ms);
        self.seen_ms = now_ms;
        self.micros += i64::from(elapsed_ms) * MICROS_PER_MILLI;
        Utc::from_micros_since_2000(self.micros)
    }
}
