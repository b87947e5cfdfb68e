//! Seeded noise on unit vectors.

use nalgebra::{Rotation3, Unit, Vector3};
use rand_core::Rng;
use rand_pcg::Pcg32;

/// Random directions, rotations and normal deviates, the same on every machine.
pub struct Noise {
    generator: Pcg32,
}

impl Noise {
    pub fn new(seed: u64) -> Self {
        Self { generator: Pcg32::new(seed, 0) }
    }

    /// Uniform in 0 to 1, without 0.
    pub fn uniform(&mut self) -> f64 {
        ((self.generator.next_u64() >> 11) + 1) as f64 / (1_u64 << 53) as f64
    }

    /// Uniform in the logarithm.
    pub fn log_uniform(&mut self, from: f64, to: f64) -> f64 {
        from * libm::pow(to / from, self.uniform())
    }

    /// Normal, mean 0 and variance 1 (Box & Muller (1958)).
    pub fn normal(&mut self) -> f64 {
        let radius = libm::sqrt(-2.0 * libm::log(self.uniform()));
        radius * libm::cos(core::f64::consts::TAU * self.uniform())
    }

    pub fn direction(&mut self) -> Vector3<f64> {
        Vector3::from_fn(|_, _| self.normal()).normalize()
    }

    pub fn rotation(&mut self) -> Rotation3<f64> {
        let turn = self.uniform() * core::f64::consts::TAU;
        Rotation3::from_axis_angle(&Unit::new_unchecked(self.direction()), turn)
    }

    /// A unit vector moved by `sigma_rad` about each axis across it.
    pub fn disturbed(&mut self, v: &Vector3<f64>, sigma_rad: f64) -> Vector3<f64> {
        let shift = Vector3::from_fn(|_, _| self.normal() * sigma_rad);
        (v + shift - v * v.dot(&shift)).normalize()
    }
}
