//! The flight application: one object that flies on the host, on the emulated core and on the
//! board.
//!
//! [`FlightApp`] owns a [`Board`](adcs_hal::board::Board) and an accepted configuration. Each call
//! of [`FlightApp::cycle`] is one cycle: read the clock and the sensors, think
//! (`adcs_core::pipeline`), drive the torquers, and put everything that was read, thought and done
//! into one record. What is swapped between the worlds is the bus underneath the board, nothing here.
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

mod commit;
pub mod flight;
pub mod parameters;

pub use flight::{FlightApp, Health};
pub use parameters::{
    FlightParameters, FlownParameters, LawParameters, ModesParameters, ParameterError,
};
