//! Attitude from vector pairs against independent optima, Markley's cases, degenerate geometry and
//! arbitrary input.
//!
//! `cargo test -p adcs-core --test wahba_reference -- --nocapture` prints the largest difference of
//! each quantity beside its bar. Where the values come from stands in `tests/data/README.md`.

mod degenerate;
mod markley;
mod noise;
mod optimum;
mod problem;
mod properties;
#[path = "../reference/table.rs"]
mod table;

use adcs_core::attitude::Method;

/// The methods that minimise Wahba's loss.
const OPTIMAL: [Method; 3] = [Method::Foam, Method::QMethod, Method::Quest];
