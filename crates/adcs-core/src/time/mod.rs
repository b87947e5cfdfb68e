//! Time: UTC to the microsecond, Julian dates in two parts, Earth rotation.
//!
//! The clock of a flight is [`Utc`], an integer, so that adding cycle after cycle never drifts and
//! is the same on every machine. What needs a real number gets a [`JulianDate`], whose day and
//! fraction are kept apart: one f64 would round to 40 µs. The uniform scales [`Tai`], [`Tt`] and
//! [`Gps`] are reached through the table of [`LeapSeconds`].

mod calendar;
mod julian;
mod leap_seconds;
mod scales;
mod sidereal;
mod utc;

pub use julian::JulianDate;
pub use leap_seconds::{LeapSecond, LeapSeconds, LeapSecondsError};
pub use scales::{Gps, Tai, TimeScaleError, Tt};
pub use sidereal::gmst82_rad;
pub use utc::{CivilDateTime, Utc, UtcError};

/// Microseconds in a second.
pub const MICROS_PER_SECOND: i64 = 1_000_000;
/// Microseconds in a day of 86,400 s.
pub const MICROS_PER_DAY: i64 = 86_400 * MICROS_PER_SECOND;
