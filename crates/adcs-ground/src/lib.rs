//! The command `adcs` as a library, so that tests can call what the command calls.

#![forbid(unsafe_code)]

pub mod emulator;
pub mod flight;
pub mod mission;
pub mod report;
