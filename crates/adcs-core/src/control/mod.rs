//! Stage III: from rates, field and attitude to the dipole of the torquers.

pub mod allocation;
pub mod b_dot;
