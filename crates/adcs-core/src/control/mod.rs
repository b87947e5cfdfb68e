//! Stage III: from rates, field and attitude to the dipole of the torquers.

pub mod allocation;
pub mod b_dot;
pub mod bang_bang;
pub mod cross_product;
pub mod feed_forward;
pub mod guidance;
pub mod hold;
pub mod periodic;
