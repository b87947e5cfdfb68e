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
        let seen = (tracked.torque.norm_squared()
            + tracked.covariance.variance(Block::Torque).sum())
            * third;
        let share = (dt_s / parameters.memory_s).min(T::one());
        let unit: T = convert(TORQUE_UNIT_N_M);
        let square = |sigma: T| (sigma / unit) * (sigma / unit);
        self.variance = (self.variance + (seen - self.variance) * share)
            .min(square(parameters.largest_n_m))
            .max(square(parameters.smallest_n_m));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::attitude::dynamic::block::Blocks;
    use crate::attitude::dynamic::tracked::tests::tracked;
    use nalgebra::{Matrix3, Vector3};
    use rand_core::Rng;
    use rand_pcg::Pcg32;

    /// The filter's own knowledge of the torque after measurements of it, and the torque itself.
    struct World {
        noise: Pcg32,
        torque: Vector3<f64>,
        estimate: Vector3<f64>,
        variance: f64,
    }

    /// Steps of 10 s: the torque changes within minutes.
    const STEP_S: f64 = 10.0;

    impl World {
        fn new() -> Self {
            Self {
                noise: Pcg32::new(5, 0),
                torque: Vector3::zeros(),
                estimate: Vector3::zeros(),
                variance: 1.0,
            }
        }

        /// Mean 0, variance 1: the sum of twelve uniform numbers.
        fn deviates(&mut self) -> Vector3<f64> {
            Vector3::from_fn(|_, _| {
                let uniform = |_| f64::from(self.noise.next_u32()) / 4_294_967_296.0;
                (0..12).map(uniform).sum::<f64>() - 6.0
            })
        }

        /// A Gauss–Markov torque of σ `truth` goes on, is measured with σ `noise`, and estimated by a
        /// scalar filter of each axis that believes in σ `believed`.
        fn step(&mut self, parameters: &TorqueNoise<f64>, truth: f64, noise: f64, believed: f64) {
            let decay = libm::exp(-STEP_S / parameters.correlation_s);
            let rest = 1.0 - decay * decay;
            self.torque = self.torque * decay + self.deviates() * (truth * rest.sqrt());
            let measured = self.torque + self.deviates() * noise;
            self.variance = self.variance * decay * decay + believed * believed * rest;
            let gain = self.variance / (self.variance + noise * noise);
            self.estimate *= decay;
            self.estimate += (measured - self.estimate) * gain;
            self.variance *= 1.0 - gain;
        }
    }

    /// The mean σ that is found over 4e5 s, N·m.
    fn found(parameters: &TorqueNoise<f64>, truth_n_m: f64, noise_n_m: f64) -> f64 {
        let (truth, noise) = (truth_n_m / TORQUE_UNIT_N_M, noise_n_m / TORQUE_UNIT_N_M);
        let mut world = World::new();
        let mut size = TorqueSize::new(parameters);
        let mut tracked = tracked(Blocks { inertia: true, torque: true, ..Blocks::NONE });
        let (mut sum, mut count) = (0.0, 0.0);
        for step in 0..40_000 {
            world.step(parameters, truth, noise, size.sigma());
            tracked.torque = world.estimate;
            let variance = Matrix3::from_diagonal_element(world.variance);
            tracked.covariance.set(Block::Torque, Block::Torque, &variance);
            size.follow(parameters, &tracked, STEP_S);
            if step > 1000 {
                sum += size.sigma() * size.sigma();
                count += 1.0;
            }
        }
        (sum / count).sqrt() * TORQUE_UNIT_N_M
    }

    fn parameters() -> TorqueNoise<f64> {
        TorqueNoise {
            smallest_n_m: 1e-9,
            start_n_m: 8e-8,
            largest_n_m: 2e-5,
            correlation_s: 300.0,
            memory_s: 400.0,
        }
    }

    #[test]
    fn sigma_settles_at_that_of_the_torque_wherever_it_started() {
        // Two thousand independent torques know their σ to 1.6 %.
        const TOLERANCE: f64 = 0.06;
        for truth in [8e-8, 1e-6] {
            for start_n_m in [2e-8, 1e-5] {
                let parameters = TorqueNoise { start_n_m, ..parameters() };
                // Measured as well as ten seconds of a dynamic filter do it, and three times better.
                for noise in [truth, 0.3 * truth] {
                    let found = found(&parameters, truth, noise);
                    assert!((found / truth - 1.0).abs() < TOLERANCE, "{truth} {noise} {found}");
                }
            }
        }
    }

    #[test]
    fn sigma_stays_within_its_limits() {
        let parameters =
            TorqueNoise { smallest_n_m: 2e-8, start_n_m: 5e-8, largest_n_m: 1e-7, ..parameters() };
        assert!((found(&parameters, 1e-12, 1e-8) / 2e-8 - 1.0).abs() < 1e-6);
        assert!((found(&parameters, 1e-5, 1e-8) / 1e-7 - 1.0).abs() < 1e-2);
    }

    #[test]
    fn without_torque_states_sigma_stays_what_it_was_told() {
        let parameters = parameters();
        let mut size = TorqueSize::new(&parameters);
        let mut tracked = tracked(Blocks { inertia: true, ..Blocks::NONE });
        tracked.torque = Vector3::repeat(1e3);
        size.follow(&parameters, &tracked, STEP_S);
        assert_eq!(size.sigma(), TorqueSize::new(&parameters).sigma());
    }

    #[test]
    fn a_step_longer_than_the_memory_takes_the_new_value_and_no_more() {
        let parameters = parameters();
        let mut size = TorqueSize::new(&parameters);
        let mut tracked = tracked(Blocks { inertia: true, torque: true, ..Blocks::NONE });
        tracked.torque = Vector3::repeat(0.5);
        tracked.covariance.set(Block::Torque, Block::Torque, &Matrix3::zeros());
        size.follow(&parameters, &tracked, 1e6);
        assert!((size.sigma() - 0.5).abs() < 1e-15);
    }
}
