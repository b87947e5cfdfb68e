//! The filter's states, three at a time, and which of them fly.

use serde::{Deserialize, Serialize};

/// One triple of states.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub(crate) enum Block {
    /// θ: attitude error, Body, rad: A = (I − [θ×]) Â.
    Attitude,
    /// ω: rate of Body relative to Eci, Body, rad/s.
    Rate,
    /// β: gyro bias, Body, rad/s.
    Bias,
    /// M: residual dipole, Body, A·m².
    Dipole,
    /// Moments of inertia: what J_xx, J_yy, J_zz differ by from the given tensor, in units of its
    /// mean moment.
    Moments,
    /// Products of inertia: the same of J_xy, J_xz, J_yz.
    Products,
    /// T: torque of which nobody knows the cause, Body, in units of [`TORQUE_UNIT_N_M`].
    Torque,
    /// S: what the residual dipole changes by in the shadow, Body, A·m²: the part that comes and goes
    /// soon,
    ShadowSoon,
    /// and the part that comes and goes late.
    ShadowLate,
    /// b: what the magnetometer shows too much, Body, in units of [`FIELD_UNIT_T`].
    FieldBias,
}

/// Triples of states.
pub(crate) const COUNT: usize = 10;

/// Unit of the torque states, N·m, so that they are of order one in the covariance.
pub(crate) const TORQUE_UNIT_N_M: f64 = 1e-6;

/// Unit of the states of the magnetometer's bias, T: likewise.
pub(crate) const FIELD_UNIT_T: f64 = 1e-6;

impl Block {
    /// All, in the order of the covariance.
    pub(crate) const ALL: [Self; COUNT] = [
        Self::Attitude,
        Self::Rate,
        Self::Bias,
        Self::Dipole,
        Self::Moments,
        Self::Products,
        Self::Torque,
        Self::ShadowSoon,
        Self::ShadowLate,
        Self::FieldBias,
    ];
}

/// Which states fly besides attitude, rate, gyro bias and residual dipole.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Blocks {
    /// The six parameters of the inertia tensor. Without them the given tensor is believed, which a
    /// tumble of degrees per second forgives by about 1 %.
    pub inertia: bool,
    /// A slowly varying torque of unknown cause.
    pub torque: bool,
    /// A residual dipole that is another one in the shadow, where the panels carry no current; learned
    /// from one eclipse to the next. Without it the dipole is allowed to jump at the shadow's edge.
    pub shadow: bool,
    /// What the magnetometer shows too much, constant in Body.
    pub field_bias: bool,
}

impl Blocks {
    /// Attitude, rate, gyro bias and residual dipole alone.
    pub const NONE: Self = Self { inertia: false, torque: false, shadow: false, field_bias: false };

    /// Everything.
    pub const ALL: Self = Self { inertia: true, torque: true, shadow: true, field_bias: true };

    /// Which triples fly, in the order of the covariance.
    pub(crate) fn flying(&self) -> [bool; COUNT] {
        Block::ALL.map(|block| match block {
            Block::Attitude | Block::Rate | Block::Bias | Block::Dipole => true,
            Block::Moments | Block::Products => self.inertia,
            Block::Torque => self.torque,
            Block::ShadowSoon | Block::ShadowLate => self.shadow,
            Block::FieldBias => self.field_bias,
        })
    }
}
