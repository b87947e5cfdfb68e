//! Is any device wired the wrong way round? Wrong signs and exchanged axes, found by what they do.

mod permutation;

pub use permutation::SignedPermutation;
