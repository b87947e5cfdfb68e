//! The commands of `adcs`, one a file.

pub mod attitude;
pub mod calibrate;
mod console;
pub mod eclipse;
pub mod estimate;
pub mod field;
mod files;
pub mod fly;
pub mod frames;
pub mod identify;
pub mod mission;
pub mod propagate;
pub mod report;
pub mod study;
pub mod sun;
pub mod tle;
