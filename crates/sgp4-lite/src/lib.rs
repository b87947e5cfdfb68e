#![doc = include_str!("../README.md")]
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

mod angle;
mod decimal;
#[cfg(feature = "deep-space")]
mod deep_space;
mod drag;
mod elements;
mod epoch;
mod error;
mod gravity;
mod mean_orbit;
mod near_earth;
mod omm;
mod periodic;
mod plausibility;
mod propagator;
mod tle;

#[cfg(feature = "deep-space")]
pub use deep_space::ResonanceState;
pub use elements::{Classification, Element, Elements, InternationalDesignator, WrongDesignator};
pub use epoch::Epoch;
pub use error::Error;
pub use omm::OmmError;
pub use plausibility::{Implausible, PlausibilityLimits, check_plausibility};
pub use propagator::{MinutesSinceEpoch, Propagator, State};
pub use tle::{Expected, TleError, TleText};
