//! Time, frames and environment against independent reference values.
//!
//! `cargo test -p adcs-core --test reference -- --nocapture` prints the largest difference of each
//! quantity beside its bar. Where the values come from stands in `tests/data/README.md`.

mod eclipse;
mod frames;
mod sun;
mod table;
mod time_scales;
