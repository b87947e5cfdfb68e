//! Seeded random numbers that are the same on every machine.
//!
//! The generator is PCG (crate `rand_pcg`), integer arithmetic only. The normal deviate is ours,
//! over `libm`: the ready-made ones call the platform's logarithm, whose last bit differs between
//! hosts. Each source of noise has its own stream, so that switching one off does not shift the
//! others.

use rand_core::Rng;
use rand_pcg::Pcg32;

/// Independent standard normal deviates.
#[derive(Debug, Clone)]
pub struct Gaussian {
    generator: Pcg32,
    spare: Option<f64>,
}

impl Gaussian {
    /// The stream numbered `stream` of the flight's `seed`.
    pub fn new(seed: u64, stream: u64) -> Self {
        Self { generator: Pcg32::new(seed, stream), spare: None }
    }

    /// Uniform in −1 to 1, 53 bits.
    pub fn symmetric(&mut self) -> f64 {
        const SCALE: f64 = 1.0 / (1_u64 << 52) as f64;
        (self.generator.next_u64() >> 11) as f64 * SCALE - 1.0
    }

    /// The next deviate, mean 0 and variance 1.
    ///
    /// Marsaglia's polar method (Marsaglia & Bray (1964)): a point in the unit disc gives two. A
    /// point misses the disc with probability 0.21; after 64 misses (1e-43) zero is returned, so
    /// that the loop is bounded.
    pub fn sample(&mut self) -> f64 {
        if let Some(spare) = self.spare.take() {
            return spare;
        }
        for _ in 0..64 {
            let (u, v) = (self.symmetric(), self.symmetric());
            let s = u * u + v * v;
            if s > 0.0 && s < 1.0 {
                let factor = libm::sqrt(-2.0 * libm::log(s) / s);
                self.spare = Some(v * factor);
                return u * factor;
            }
        }
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DRAWS: u32 = 100_000;
    /// Four standard errors of a mean (1/√N) of 1e5 draws.
    const MEAN_TOLERANCE: f64 = 0.0127;
    /// Four standard errors of a variance (√(2/N)).
    const VARIANCE_TOLERANCE: f64 = 0.0179;

    fn moments(mut gaussian: Gaussian) -> [f64; 4] {
        let mut sums = [0.0; 4];
        for _ in 0..DRAWS {
            let x = gaussian.sample();
            for (sum, power) in sums.iter_mut().zip([x, x * x, x * x * x, x * x * x * x]) {
                *sum += power / f64::from(DRAWS);
            }
        }
        sums
    }

    #[test]
    fn deviates_are_normal_to_the_fourth_moment() {
        let [mean, variance, skewness, kurtosis] = moments(Gaussian::new(20_140_524, 1));
        assert!(mean.abs() < MEAN_TOLERANCE);
        assert!((variance - 1.0).abs() < VARIANCE_TOLERANCE);
        // Standard errors √(15/N) and √(96/N), four times.
        assert!(skewness.abs() < 0.049);
        assert!((kurtosis - 3.0).abs() < 0.124);
    }

    #[test]
    fn streams_of_one_seed_differ_and_repeat() {
        let first = |stream| Gaussian::new(7, stream).sample();
        assert_ne!(first(1), first(2));
        assert_eq!(first(1), first(1));
    }
}
