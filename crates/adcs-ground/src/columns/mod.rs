//! What the commands on tables compute for a row.

pub mod attitude;
pub mod estimate;
pub mod field;
pub mod frames;
pub mod propagate;
pub mod sun;
