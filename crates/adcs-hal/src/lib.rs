//! Drivers for a small satellite's ADCS on embedded-hal 1.0, and the Board trait.
//!
//! ```text
//! flight application ── board::Board ─┬─ driver_board::DriverBoard ─┬─ analog_triad ── mcp3208 ── SPI
//!                                     │                             ├─ psd_face ───── mcp3208 ── SPI
//!                                     │                             └─ drv8838 ────────── PWM, pins
//!                                     └─ fault::FaultInjector<any Board>
//! ```
//!
//! | module | what |
//! |---|---|
//! | [`board`] | the world as the flight application sees it |
//! | [`driver_board`] | that world made of the drivers below |
//! | [`analog_triad`] | magnetometer module and gyros: volts to SI by the data sheet's formula |
//! | [`psd_face`] | Sun sensors: volts to the four photocurrents of a face |
//! | [`mcp3208`] | the converter that reads their volts |
//! | [`drv8838`] | the H-bridges that feed the torquers |
//! | [`fault`] | a board that fails by a script |
//!
//! Each chip has one module with its bits or its truth table
//! ([`mcp3208::registers`], [`drv8838::logic`]), read in one direction by the driver and in the
//! other by the simulator's model of the chip, so that the two cannot disagree in private.
//! Drivers return SI numbers along the sensors' own axes; alignment, bias and scale belong to
//! `adcs_core::sensing`.
#![no_std]
#![forbid(unsafe_code)]
#![cfg_attr(
    not(test),
    deny(
        clippy::unwrap_used,
        clippy::expect_used,
        clippy::panic,
        clippy::indexing_slicing,
        clippy::unreachable
    )
)]

pub mod analog_triad;
pub mod board;
pub mod driver_board;
pub mod drv8838;
pub mod fault;
pub mod mcp3208;
pub mod psd_face;
