//! The independent watchdog: a satellite that hangs starts anew.

use stm32f4::stm32f405::IWDG;

/// Counts until the reset. The watchdog's own oscillator gives 17 to 47 kHz (DS8626), divided by
/// 64: the reset comes 1.4 to 3.8 s after the last feeding, which is due twice a second.
const COUNTS: u16 = 1_000;

/// Starts it. It cannot be stopped again.
pub fn start(watchdog: &IWDG) {
    watchdog.kr().write(|w| w.key().start());
    watchdog.kr().write(|w| w.key().unlock());
    watchdog.pr().write(|w| w.pr().divide_by64());
    watchdog.rlr().write(|w| w.rl().set(COUNTS));
    feed(watchdog);
}

/// Says that the satellite is alive.
pub fn feed(watchdog: &IWDG) {
    watchdog.kr().write(|w| w.key().feed());
}
