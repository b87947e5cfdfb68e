//! A tumbling satellite with torquers, gyros and a magnetometer, in a field that turns along the orbit.
#![allow(dead_code)] // each test uses its part

use nalgebra::{Matrix3, UnitQuaternion, Vector3};
use rand_core::{Rng as _, SeedableRng as _};
use rand_pcg::Pcg64Mcg;

/// SPROUT's assumed tensor, preset A2, kg·m².
pub const INERTIA: [[f64; 3]; 3] =
    [[0.05184, 0.00058, -0.00077], [0.00058, 0.05416, 0.00069], [-0.00077, 0.00069, 0.05978]];
/// The paper's residual dipole, A·m².
pub const RESIDUAL_AM2: [f64; 3] = [-0.3211, -0.2094, -0.0201];
/// Of a sample of each axis, rad/s: the paper's 0.163 deg/s.
pub const GYRO_NOISE: f64 = 0.163 * std::f64::consts::PI / 180.0;
/// Of a sample of each axis, T.
pub const FIELD_NOISE_T: f64 = 586e-9;
/// Of the torquers, A·m².
pub const LIMIT_AM2: f64 = 0.6;
/// Orbital rate at 615 km, rad/s.
const ORBIT_RATE: f64 = 1.08e-3;
/// Field of a dipole at the equator of that orbit, T.
const EQUATOR_T: f64 = 23.5e-6;
/// Of the drag at most, N·m: at 600 km.
const DRAG_N_M: f64 = 1e-8;
/// Of the integration, s. RK4 at 15 deg/s: 1e-9 of a step.
const STEP_S: f64 = 0.25;

pub struct Random(Pcg64Mcg);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(Pcg64Mcg::seed_from_u64(seed))
    }

    /// 0 to 1.
    pub fn uniform(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// The sum of twelve uniform numbers.
    pub fn gaussian(&mut self) -> f64 {
        (0..12).map(|_| self.uniform()).sum::<f64>() - 6.0
    }

    pub fn vector(&mut self, sigma: f64) -> Vector3<f64> {
        Vector3::from_fn(|_, _| sigma * self.gaussian())
    }
}

/// The truth; all in Body but `q`, which turns Body into inertial components.
pub struct Satellite {
    pub inertia: Matrix3<f64>,
    pub residual: Vector3<f64>,
    pub rate: Vector3<f64>,
    pub q: UnitQuaternion<f64>,
    pub seconds: f64,
    /// Gravity gradient, and a torque as of drag that goes round with the orbit.
    pub disturbed: bool,
    phase: f64,
}

impl Satellite {
    /// Somewhere in the orbit, in some attitude, with this rate (rad/s).
    pub fn new(random: &mut Random, rate: Vector3<f64>) -> Self {
        Self {
            inertia: Matrix3::from(INERTIA),
            residual: RESIDUAL_AM2.into(),
            rate,
            q: UnitQuaternion::from_scaled_axis(random.vector(1.5)),
            seconds: 0.0,
            disturbed: false,
            phase: random.uniform() * std::f64::consts::TAU,
        }
    }

    /// Direction from the centre of the Earth, in a polar orbit.
    fn zenith(&self, seconds: f64) -> Vector3<f64> {
        let (sin, cos) = (self.phase + ORBIT_RATE * seconds).sin_cos();
        Vector3::new(cos, 0.17 * sin, 0.985 * sin).normalize()
    }

    /// Torque beside the field's, with this attitude.
    fn disturbance(&self, q: UnitQuaternion<f64>, seconds: f64) -> Vector3<f64> {
        let zenith = q.inverse() * self.zenith(seconds);
        let gradient = 3.0 * ORBIT_RATE.powi(2) * zenith.cross(&(self.inertia * zenith));
        // The flow comes from ahead, a quarter of an orbit later; the centre of pressure is off towards Body X.
        let ahead = q.inverse() * self.zenith(seconds + 0.25 * std::f64::consts::TAU / ORBIT_RATE);
        gradient + Vector3::x().cross(&ahead) * DRAG_N_M
    }

    /// Inertial field of a dipole tilted by 10 degrees.
    pub fn field_inertial(&self, seconds: f64) -> Vector3<f64> {
        let r = self.zenith(seconds);
        let axis = Vector3::new(0.12, -0.12, -0.985).normalize();
        (axis - r * (3.0 * axis.dot(&r))) * -EQUATOR_T
    }

    /// Field in Body.
    pub fn field(&self) -> Vector3<f64> {
        self.q.inverse() * self.field_inertial(self.seconds)
    }

    /// Lets time pass with a dipole of the torquers.
    pub fn advance(&mut self, seconds: f64, dipole: Vector3<f64>) {
        let steps = (seconds / STEP_S).round() as u32;
        let inverse = self.inertia.try_inverse().unwrap();
        for _ in 0..steps {
            let field = self.field_inertial(self.seconds + 0.5 * STEP_S);
            let slope = |rate: Vector3<f64>, q: UnitQuaternion<f64>| {
                let mut torque = (dipole + self.residual).cross(&(q.inverse() * field));
                if self.disturbed {
                    torque += self.disturbance(q, self.seconds);
                }
                inverse * (torque - rate.cross(&(self.inertia * rate)))
            };
            // The attitude of the middle and of the end with the rate of the stage before.
            let turned =
                |rate: Vector3<f64>, dt: f64| self.q * UnitQuaternion::from_scaled_axis(rate * dt);
            let (h, w) = (STEP_S, self.rate);
            let k1 = slope(w, self.q);
            let k2 = slope(w + k1 * (h / 2.0), turned(w + k1 * (h / 4.0), h / 2.0));
            let k3 = slope(w + k2 * (h / 2.0), turned(w + k2 * (h / 4.0), h / 2.0));
            let k4 = slope(w + k3 * h, turned(w + k3 * (h / 2.0), h));
            self.rate = w + (k1 + k2 * 2.0 + k3 * 2.0 + k4) * (h / 6.0);
            self.q = turned((w + self.rate) * 0.5, h);
            self.seconds += h;
        }
    }
}
