//! The mathematics of a small satellite's attitude determination and control: no bus, no pin, no
//! clock.
//!
//! ```text
//!            stage I                     stage II              stage III
//! time ─► orbit ─► reference vectors ─► attitude ─► mode ─► dipole ─► torquers
//!                  measured vectors ──────▲          ▲
//!                       └────────────────────────────┘  B-dot needs no attitude
//! ```
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

pub mod attitude;
pub mod calibration;
pub mod commissioning;
pub mod control;
mod determination;
pub mod environment;
pub mod frames;
pub mod identification;
pub mod modes;
mod nodes;
pub mod orbit;
pub mod parameter;
pub mod pipeline;
pub mod planning;
pub mod polarity;
pub mod reading;
mod rolled;
pub mod schedule;
pub mod sensing;
pub mod steering;
pub mod time;
