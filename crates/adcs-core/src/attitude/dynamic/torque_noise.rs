//! How large the torque of unknown cause is: the filter's own noise, found from its own estimates.
//!
//! For a Gauss–Markov torque of σ², an estimate T̂ of it with covariance P satisfies E[T̂²] + P = σ²: what
//! is known and what is not add up to what there is. So σ² is set to the running mean of T̂² + P. Were σ
//! too small, T̂² would come out larger than σ² − P, and σ grows until both sides agree; likewise the other
//! way. (It is one step of the EM algorithm for the variance a cycle: Dempster, Laird & Rubin (1977),
//! J. R. Stat. Soc. B 39, 1–38, with the filtered moments for the smoothed ones.)

use nalgebra::{RealField, convert};

use super::block::{Block, TORQUE_UNIT_N_M};
use super::parameters::TorqueNoise;
use super::tracked::Tracked;

/// The running σ² of each axis.
#[derive(Debug, Clone, Copy)]
pub(super) struct TorqueSize<T> {
    /// In [`TORQUE_UNIT_N_M`], squared.
    variance: T,
}

impl<T: RealField + Copy> TorqueSize<T> {
    pub(super) fn new(parameters: &TorqueNoise<T>) -> Self {
        let sigma = parameters.start_n_m / convert(TORQUE_UNIT_N_M);
        Self { variance: sigma * sigma }
    }

    /// σ of each axis, [`TORQUE_UNIT_N_M`].
    pub(super) fn sigma(&self) -> T {
        self.variance.sqrt()
    }

    /// Takes in what the filter thinks of the torque after `dt_s`.
    pub(super) fn follow(&mut self, parameters: &TorqueNoise<T>, tracked: &Tracked<T>, dt_s: T) {
        if !tracked.blocks.torque {
            return;
        }
        let third: T = convert(1.0 / 3.0);
        let seen =
            (tracked.torque.norm_squared() + tracked.covariance.variance(Block::Torque).sum()) * third;
        let share = (dt_s / parameters.memory_s).min(T::one());
        let unit: T = convert(TORQUE_UNIT_N_M);
        let square = |sigma: T| (sigma / unit) * (sigma / unit);
        self.variance = (self.variance + (seen - self.variance) * share)
            .clamp(square(parameters.smallest_n_m), square(parameters.largest_n_m));
    }
}
