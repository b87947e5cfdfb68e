//! What is true of the satellite and its surroundings, whatever its software was told.

use adcs_core::polarity::SignedPermutation;
use adcs_sim::noise::Gaussian;
use nalgebra::Vector3;

use super::super::random::{gaussian, symmetric, uniform};
use super::super::sprout::{
    self, BIAS_WALK_RAD_S_PER_SQRT_S, DEG, FIELD_NOISE_T, GYRO_NOISE_RAD_S, RESIDUAL_DIPOLE_AM2,
    SUN_NOISE_RAD,
};
use super::FlawSizes;

/// One set of flights; what is drawn at random differs from seed to seed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Conditions {
    /// Rate at the start.
    pub rate: StartingRate,
    /// Whether flights start in sunlight, or anywhere within two days.
    pub start_in_sunlight: bool,
    /// How the inertia differs from the drawing's.
    pub inertia: sprout::InertiaError,
    /// Residual dipole, Body, A·m².
    pub residual_dipole_am2: [f64; 3],
    /// What it changes by in eclipse.
    pub eclipse_step: DipoleStep,
    /// σ of each torquer's scale error.
    pub torquer_scale_sigma: f64,
    /// Torque that nobody models.
    pub torque: Torque,
    /// The gyro.
    pub gyro: GyroTruth,
    /// Noise of the magnetometer, each axis, T.
    pub magnetometer_noise_t: f64,
    /// Bias of the magnetometer: this on each axis, signs at random, T.
    pub magnetometer_bias_t: f64,
    /// Noise of the direction in which a face sees the Sun, about each axis across it, rad.
    pub sun_noise_rad: f64,
    /// How much of the sunlight the Earth sends back into the Sun sensors.
    pub albedo: f64,
    /// How late the orbit is that flies along, s.
    pub orbit_late_s: f64,
    /// How wrong the field model is that flies along: this on each axis of Eci, signs at random, T.
    pub field_model_error_t: f64,
    /// What nobody has calibrated.
    pub flaws: FlawSizes,
    /// A device that is wired wrongly.
    pub fault: Option<Fault>,
    /// Torquers that obey and do nothing.
    pub dead: [bool; 3],
}

impl Default for Conditions {
    /// The satellite of the drawing with the paper's sensors, at rest, in sunlight. The gyro bias is that
    /// of the independent study behind docs/control.
    fn default() -> Self {
        Self {
            rate: StartingRate::Within([0.0; 3]),
            start_in_sunlight: true,
            inertia: sprout::InertiaError::Signs(0.0),
            residual_dipole_am2: RESIDUAL_DIPOLE_AM2,
            eclipse_step: DipoleStep { share: 0.0, lag_s: [0.0; 2] },
            torquer_scale_sigma: 0.0,
            torque: Torque { constant_n_m: 0.0, random_n_m: 0.0, correlation_s: 300.0 },
            gyro: GyroTruth::default(),
            magnetometer_noise_t: FIELD_NOISE_T,
            magnetometer_bias_t: 0.0,
            sun_noise_rad: SUN_NOISE_RAD,
            albedo: 0.0,
            orbit_late_s: 0.0,
            field_model_error_t: 0.0,
            flaws: FlawSizes::default(),
            fault: None,
            dead: [false; 3],
        }
    }
}

impl Conditions {
    /// How a device is wired.
    pub fn wiring(&self, device: Device) -> SignedPermutation {
        match self.fault {
            Some(fault) if fault.device == device => fault.wiring,
            _ => SignedPermutation::IDENTITY,
        }
    }
}

/// Rate at the start, Body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum StartingRate {
    /// Each axis uniform within ± this, rad/s.
    Within([f64; 3]),
    /// Just this fast about an axis at random, rad/s.
    AnyAxis(f64),
    /// The same, uniform between these, rad/s.
    Between([f64; 2]),
}

impl StartingRate {
    pub(super) fn drawn(self, noise: &mut Gaussian) -> Vector3<f64> {
        match self {
            Self::Within(limits) => symmetric(noise).component_mul(&Vector3::from(limits)),
            Self::AnyAxis(rate) => gaussian(noise).normalize() * rate,
            Self::Between([slow, fast]) => {
                gaussian(noise).normalize() * (slow + (fast - slow) * uniform(noise))
            }
        }
    }
}

/// What the residual dipole changes by in eclipse.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DipoleStep {
    /// Each component by this share of itself, signs at random.
    pub share: f64,
    /// Between which times the thermal lag is uniform, s: the step follows the shadow with a first-order
    /// lag.
    pub lag_s: [f64; 2],
}

/// Torque that nobody models, Body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Torque {
    /// A constant one, direction at random, N·m.
    pub constant_n_m: f64,
    /// σ of each axis of a random one (Gauss–Markov), N·m.
    pub random_n_m: f64,
    /// Its correlation time, s.
    pub correlation_s: f64,
}

/// The gyro.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GyroTruth {
    /// Noise of a sample, each axis, rad/s.
    pub noise_rad_s: f64,
    /// The bias at the start is uniform within ± this, each axis, rad/s.
    pub bias_rad_s: f64,
    /// Walk of the bias, each axis, rad/s per √s.
    pub walk_rad_s_per_sqrt_s: f64,
    /// When there is a sample.
    pub sampling: Sampling,
}

impl Default for GyroTruth {
    /// The paper's noise, once a second.
    fn default() -> Self {
        Self {
            noise_rad_s: GYRO_NOISE_RAD_S,
            bias_rad_s: 0.3 * DEG,
            walk_rad_s_per_sqrt_s: BIAS_WALK_RAD_S_PER_SQRT_S,
            sampling: Sampling::OnceASecond,
        }
    }
}

/// When the gyro has a sample; its noise is that of a sample in either case.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sampling {
    /// Every cycle.
    EveryCycle,
    /// Once a second, counted from the last measuring cycle, at which there always is one.
    OnceASecond,
}

/// What can be wired wrongly.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Device {
    /// The magnetometer.
    Magnetometer,
    /// The gyro.
    Gyro,
    /// The torquers.
    Torquers,
}

impl Device {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Magnetometer, Self::Gyro, Self::Torquers];

    /// What it is called in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Magnetometer => "magnetometer",
            Self::Gyro => "gyro",
            Self::Torquers => "torquers",
        }
    }
}

/// A device whose axes are exchanged or turned round: it shows, or does, P times what it should.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Fault {
    /// Which.
    pub device: Device,
    /// P.
    pub wiring: SignedPermutation,
}
