//! The command `adcs` as a library, so that tests can call what the command calls.

#![forbid(unsafe_code)]

pub mod calibration;
pub mod columns;
pub mod emulator;
pub mod ephemeris;
pub mod filter_config;
pub mod flight;
pub mod identification;
pub mod mission;
pub mod omm_file;
pub mod report;
pub mod shadow;
pub mod span;
pub mod study;
pub mod table;
pub mod tle_file;
pub mod tle_report;
