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

mod coefficients;
mod error;
mod evaluate;
mod generation;
mod geodetic;
mod lanes;
mod many;
mod orders;
mod real;
mod table;
#[cfg(feature = "uplink")]
mod uplink;
mod year;

pub use coefficients::{Coefficients, HIGHEST_DEGREE, REFERENCE_RADIUS_KM};
pub use error::Error;
pub use evaluate::{MAX_RADIUS_KM, MIN_RADIUS_KM};
pub use generation::{Generation, GenerationError};
pub use geodetic::{GeocentricField, GeocentricPosition, GeodeticField, GeodeticPosition};
pub use real::Real;
#[cfg(feature = "uplink")]
pub use uplink::MAX_ENCODED_BYTES;
pub use year::DecimalYear;
