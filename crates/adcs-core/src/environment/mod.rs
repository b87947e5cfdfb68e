//! What surrounds the satellite: the Earth's turning, the Sun, the field.

pub mod earth;
pub mod field;
pub mod geodetic;
pub mod solar_time;
pub mod sun;
