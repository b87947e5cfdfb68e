//! The commands on tables, as a user runs them, against the reference data of the libraries.
//!
//! `cargo test -p adcs-ground --test tables -- --nocapture` prints the largest difference of each
//! quantity beside its bar. The data are those of the libraries (`crates/*/tests/data`), where it is
//! written where they come from.

mod any_bytes;
mod bad_input;
mod common;
mod eclipse;
mod field;
mod files;
mod frames;
mod omm;
mod propagate;
mod sun;
mod tle;
