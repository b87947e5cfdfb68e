//! Random vectors of the studies.

use adcs_sim::noise::Gaussian;
use nalgebra::Vector3;

/// Three independent standard normal deviates.
pub fn gaussian(noise: &mut Gaussian) -> Vector3<f64> {
    Vector3::from_fn(|_, _| noise.sample())
}

/// Three independent deviates, uniform within −1 to 1.
pub fn symmetric(noise: &mut Gaussian) -> Vector3<f64> {
    Vector3::from_fn(|_, _| noise.symmetric())
}

/// Uniform within 0 to 1.
pub fn uniform(noise: &mut Gaussian) -> f64 {
    0.5 * (1.0 + noise.symmetric())
}

/// Three signs, each +1 or −1.
pub fn signs(noise: &mut Gaussian) -> Vector3<f64> {
    gaussian(noise).map(f64::signum)
}

/// A first-order Gauss–Markov process on three axes.
#[derive(Debug, Clone, Copy)]
pub struct GaussMarkov {
    /// Its value.
    pub value: Vector3<f64>,
    sigma: f64,
    correlation_s: f64,
}

impl GaussMarkov {
    /// In its steady state.
    pub fn new(sigma: f64, correlation_s: f64, noise: &mut Gaussian) -> Self {
        Self { value: gaussian(noise) * sigma, sigma, correlation_s }
    }

    /// Goes on by `dt_s`.
    pub fn step(&mut self, dt_s: f64, noise: &mut Gaussian) {
        let decay = (-dt_s / self.correlation_s).exp();
        let push = self.sigma * (1.0 - decay * decay).sqrt();
        self.value = self.value * decay + gaussian(noise) * push;
    }
}
