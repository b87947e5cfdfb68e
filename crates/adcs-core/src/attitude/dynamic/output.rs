//! What the dynamics-aided filter says.

use nalgebra::{Matrix3, RealField, Vector3, convert};
use serde::{Deserialize, Serialize};

use super::block::{Block, TORQUE_UNIT_N_M};
use super::tracked::Tracked;
use crate::attitude::mekf::Innovation;
use crate::frames::{Body, Eci, Rotation, Vector};

/// What one cycle made of its inputs.
#[derive(Debug, Clone, Copy)]
pub struct DynamicOutput<T: RealField + Copy = f32> {
    /// The estimate, when there is one.
    pub estimate: Option<DynamicEstimate<T>>,
    /// The gyro held against the estimate.
    pub gyro: Option<Innovation<T>>,
    /// The field held against the estimate.
    pub field: Option<Innovation<T>>,
    /// The Sun held against the estimate.
    pub sun: Option<Innovation<T>>,
    /// What happened besides.
    pub event: Option<DynamicEvent>,
}

/// What happened to the estimate besides being filtered.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum DynamicEvent {
    /// It was taken over from the MEKF.
    Started,
    /// Time, field model or torquers gave nothing to go on with, or a number was none; when there is
    /// an estimate, it has already been taken over anew.
    Lost,
    /// The sensors, or the MEKF, contradicted it for too long: it is given up, and will start again.
    Contradicted,
}

/// Everything the filter knows, and how well.
#[derive(Debug, Clone, Copy)]
pub struct DynamicEstimate<T: RealField + Copy = f32> {
    /// The attitude.
    pub r_bi: Rotation<Body, Eci, T>,
    /// Covariance of the attitude error, Body, rad².
    pub attitude_covariance: Matrix3<T>,
    /// Rate of Body relative to Eci, rad/s.
    pub omega_bi: Vector<Body, T>,
    /// Covariance of the rate, Body, (rad/s)².
    pub rate_covariance: Matrix3<T>,
    /// Gyro bias, rad/s.
    pub gyro_bias: Vector<Body, T>,
    /// σ of the gyro bias, each axis, rad/s.
    pub gyro_bias_sigma_rad_s: Vector<Body, T>,
    /// Residual dipole as it is now, in sunlight or shadow, A·m².
    pub residual_dipole: Vector<Body, T>,
    /// σ of the residual dipole, each axis, A·m².
    pub residual_dipole_sigma_am2: Vector<Body, T>,
    /// Inertia tensor, Body, kg·m².
    pub inertia_kg_m2: Matrix3<T>,
    /// Torque of unknown cause, N·m.
    pub torque: Vector<Body, T>,
    /// How large that torque is believed to be, σ of each axis, N·m.
    pub torque_sigma_n_m: T,
    /// Whether its innovations, and the MEKF, bear the estimate out.
    pub trusted: bool,
    /// Whether the gyro has been contradicting the dynamics, which field and Sun bear out.
    pub gyro_doubtful: bool,
}

impl<T: RealField + Copy> DynamicEstimate<T> {
    pub(super) fn new(
        tracked: &Tracked<T>,
        torque_sigma: T,
        trusted: bool,
        gyro_doubtful: bool,
    ) -> Self {
        let unit: T = convert(TORQUE_UNIT_N_M);
        let p = &tracked.covariance;
        let root = |variance: Vector3<T>| -> Vector<Body, T> {
            Vector::from_xyz(variance.map(|v| v.max(T::zero()).sqrt()))
        };
        let sigma = |block: Block| root(p.variance(block));
        Self {
            r_bi: tracked.motion.r_bi,
            attitude_covariance: p.block(Block::Attitude, Block::Attitude),
            omega_bi: Vector::from_xyz(tracked.motion.omega),
            rate_covariance: p.block(Block::Rate, Block::Rate),
            gyro_bias: Vector::from_xyz(tracked.bias),
            gyro_bias_sigma_rad_s: sigma(Block::Bias),
            residual_dipole: Vector::from_xyz(tracked.residual_dipole()),
            residual_dipole_sigma_am2: root(tracked.residual_dipole_variance()),
            inertia_kg_m2: tracked.inertia.tensor,
            torque: Vector::from_xyz(tracked.torque * unit),
            torque_sigma_n_m: torque_sigma * unit,
            trusted,
            gyro_doubtful,
        }
    }
}

impl<T: RealField + Copy> DynamicOutput<T> {
    /// No estimate, and nothing held against one.
    pub fn none(event: Option<DynamicEvent>) -> Self {
        Self { estimate: None, gyro: None, field: None, sun: None, event }
    }
}
