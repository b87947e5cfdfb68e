//! What surrounds the satellite: the Earth's turning and shape, the Sun and the Earth's shadow, the
//! field.

pub mod crossings;
pub mod earth;
pub mod eclipse;
pub mod field;
pub mod geodetic;
pub mod solar_time;
pub mod sun;
pub mod sun_track;
pub mod sunlight;
