//! Is any device wired the wrong way round, or a torquer dead? Found by what they do.
//!
//! With one wrong sign B-dot spins a satellite up, and every reading looks healthy while it does. What
//! gives a wiring away is that three devices must agree with the laws of motion:
//!
//! | law | disagreement means | code |
//! |---|---|---|
//! | Ḃ = −ω × B | gyro or magnetometer | `turning` |
//! | J ω̇ + ω × J ω = (M + P m) × B | torquers, or a reversed magnetometer | `response`, `answer` |
//! | despin takes energy out | something else is wrong | [`Guard`] |
//!
//! [`Guard`] holds them against each other while a loop is closed. [`ActiveCheck`] does it before, with
//! pulses of each torquer, and names the device and its wiring. Derivation and figures: docs/polarity.

mod answer;
mod check;
mod guard;
mod parameters;
mod response;
#[cfg(test)]
mod tests;
mod turning;
mod verdict;

pub use crate::frames::{PermutationError, SignedPermutation};
pub use check::{
    ActiveCheck, CheckInputs, CheckReport, CheckState, CheckStep, LONGEST_CYCLES, LONGEST_ROUNDS,
    Undecided,
};
pub use guard::{Guard, GuardInputs, GuardState, Purpose};
pub use parameters::{PolarityError, PolarityParameters};
pub use verdict::{Evidence, GuardVerdict, Suspect};
