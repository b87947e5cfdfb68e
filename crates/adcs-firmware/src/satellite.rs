//! The flight on the board: the real drivers on the real pins, cycle by cycle, for ever.

use adcs_app::FlightApp;
use adcs_hal::driver_board::DriverBoard;
use cortex_m::asm::wfi;

use crate::{
    boot::Boot,
    memory, parameters, peripherals, remembered,
    ticks::{self, SincePowerOn},
    watchdog,
};

/// Health is logged once in so many cycles: once a minute.
const CYCLES_PER_REPORT: u32 = 120;

/// Flies until a reset.
///
/// # Panics
/// If the built-in parameters were refused, which a test excludes.
pub fn fly(mut boot: Boot) -> ! {
    ticks::start(&mut boot.core.SYST, boot.clock.core_hz());
    let parts = peripherals::take(&boot.chip, boot.clock, SincePowerOn::default());
    // No `expect`: printing the refused value would link 20 KB of number formatting.
    let Ok(board) = DriverBoard::new(parameters::BOARD, parts) else {
        panic!("the board as wired is refused")
    };
    let parameters = parameters::flight();
    let Some(state) = remembered::room().map(remembered::power_on) else {
        panic!("the flight has begun before")
    };
    let Ok(mut app) = FlightApp::new(board, &parameters, state) else {
        panic!("the built-in parameters are refused")
    };
    if let Some(findings) = memory::read_findings() {
        app.resume(findings);
    }
    watchdog::start(&boot.chip.IWDG);

    let period_ms = parameters.cycle_us / 1_000;
    let mut due_ms = ticks::milliseconds();
    let mut cycle = 0_u32;
    loop {
        while ticks::milliseconds().wrapping_sub(due_ms) > u32::MAX / 2 {
            wfi();
        }
        due_ms = due_ms.wrapping_add(period_ms);
        let record = app.cycle();
        let noted = record.commissioning.is_some_and(|report| report.ended.is_some());
        if noted || record.committed {
            memory::write_findings(app.findings());
        }
        watchdog::feed(&boot.chip.IWDG);
        if cycle.is_multiple_of(CYCLES_PER_REPORT) {
            defmt::info!("cycle {}: {}", cycle, app.health());
        }
        cycle = cycle.wrapping_add(1);
    }
}
