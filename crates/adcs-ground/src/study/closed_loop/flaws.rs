//! What is wrong with the sensors when nobody has calibrated them.

use adcs_sim::noise::Gaussian;
use nalgebra::{Matrix3, Vector3};

use super::super::random::{gaussian, symmetric, uniform};

/// How large flaws can be; each is drawn for each flight. `Default` is none.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct FlawSizes {
    /// The magnetometer's scales are uniform within 1 ± this.
    pub scale: f64,
    /// Its cross-axis terms within ± this.
    pub cross_axis: f64,
    /// Its biases within ± this, T.
    pub bias_t: f64,
    /// Between which distances the torquers are from it, in any direction, m; `None` keeps their field away.
    pub torquers_at_m: Option<[f64; 2]>,
    /// The Sun sensors are turned by ± this about each axis, rad.
    pub sun_turn_rad: f64,
    /// The residual dipole is uniform within ± this on each axis, A·m²; zero leaves it as it is told.
    pub residual_dipole_am2: f64,
}

/// Those of one flight.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Flaws {
    /// s of the correction B = C (s ∘ shown) − b.
    pub scale: Vector3<f64>,
    /// c_xy, c_xz, c_yz.
    pub cross_axis: Vector3<f64>,
    /// b, T.
    pub bias_t: Vector3<f64>,
    /// What torquers add to the field, Body, T per A·m².
    pub coupling: Matrix3<f64>,
    /// By what the Sun sensors' directions must be turned, Body, rad.
    pub sun_turn: Vector3<f64>,
    /// The residual dipole, Body, A·m²; `None` for that of the conditions.
    pub residual_dipole: Option<Vector3<f64>>,
}

impl FlawSizes {
    pub(super) fn drawn(&self, noise: &mut Gaussian) -> Flaws {
        let scale = Vector3::repeat(1.0) + symmetric(noise) * self.scale;
        let cross_axis = symmetric(noise) * self.cross_axis;
        let bias_t = symmetric(noise) * self.bias_t;
        let sun_turn = symmetric(noise) * self.sun_turn_rad;
        let dipole = symmetric(noise) * self.residual_dipole_am2;
        let direction = gaussian(noise).normalize();
        let share = uniform(noise);
        let coupling = self.torquers_at_m.map_or(Matrix3::zeros(), |[near, far]| {
            let distance = near + (far - near) * share;
            // μ₀/4π (3 r rᵀ − 1) / |r|³
            let outer = direction * direction.transpose() * 3.0 - Matrix3::identity();
            outer * (1e-7 / distance.powi(3))
        });
        let residual_dipole = (self.residual_dipole_am2 > 0.0).then_some(dipole);
        Flaws { scale, cross_axis, bias_t, coupling, sun_turn, residual_dipole }
    }
}

impl Flaws {
    /// What the magnetometer shows of a field.
    pub(super) fn shown(&self, field: Vector3<f64>) -> Vector3<f64> {
        let [xy, xz, yz] = self.cross_axis.into();
        let c = Matrix3::new(1.0, xy, xz, xy, 1.0, yz, xz, yz, 1.0);
        // C is near the identity.
        let scaled = c.try_inverse().unwrap_or_else(Matrix3::identity) * (field + self.bias_t);
        scaled.component_div(&self.scale)
    }
}
