//! What a three-axis sensor shows of the truth.

use adcs_core::frames::{Body, Rotation, Vector};
use nalgebra::Matrix3;

use crate::noise::Gaussian;
use crate::scenario::SensorTruth;

/// One sensor with axes `S`, its errors and its noise.
#[derive(Debug, Clone)]
pub struct Sensor<S> {
    alignment: Rotation<S, Body, f64>,
    matrix: Matrix3<f64>,
    bias: Vector<S, f64>,
    noise: f64,
    gaussian: Gaussian,
}

impl<S> Sensor<S> {
    /// The sensor described by `truth`, with its own stream of noise; `None` when its alignment has
    /// no direction.
    pub fn new(truth: &SensorTruth, gaussian: Gaussian) -> Option<Self> {
        let to_body = Rotation::<Body, S, f64>::from_attitude_quaternion(truth.alignment_xyzw)?;
        let [b_x, b_y, b_z] = truth.bias;
        Some(Self {
            alignment: to_body.inverse(),
            matrix: Matrix3::from_fn(|r, c| truth.matrix[r][c]),
            bias: Vector::new(b_x, b_y, b_z),
            noise: truth.noise,
            gaussian,
        })
    }

    /// The true value along the sensor's axes, without any error.
    pub fn exact(&self, truth: Vector<Body, f64>) -> Vector<S, f64> {
        self.alignment * truth
    }

    /// What axis `axis` (0, 1, 2) shows of the true value: one conversion, one draw of noise.
    pub fn shown(&mut self, axis: usize, truth: Vector<Body, f64>) -> f64 {
        let shown = self.matrix * self.exact(truth).xyz + self.bias.xyz;
        // A draw for each conversion, wanted or not, so that the noise of the others stays the same.
        let deviate = self.gaussian.sample();
        shown[axis] + self.noise * deviate
    }
}
