//! IGRF-14 geomagnetic field for microcontrollers.
#![no_std]
#![forbid(unsafe_code)]
#![allow(missing_docs)]

mod coefficients;
mod error;
mod evaluate;
mod geodetic;
mod real;
mod table;
mod year;

pub use coefficients::{Coefficients, HIGHEST_DEGREE, REFERENCE_RADIUS_KM};
pub use error::Error;
pub use evaluate::{MAX_RADIUS_KM, MIN_RADIUS_KM};
pub use geodetic::{GeocentricField, GeocentricPosition, GeodeticField, GeodeticPosition};
pub use real::Real;
pub use year::DecimalYear;
