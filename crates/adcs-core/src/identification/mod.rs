//! What a record of rates, fields and dipoles says of the satellite itself.
//!
//! | module | finds | from |
//! |---|---|---|
//! | [`torque`] | torque, the paper's eq. (2); residual dipole, its eq. (3) | differences of rates |
//! | [`momentum`] | residual dipole, inertia ratios, torquer gains | the same, integrated |
//! | [`gyro`] | gyro bias and its slope with temperature | what the field's turning contradicts |
//! | [`coupling`] | field of the torquers at the magnetometer | pulses between rests |
//! | [`sun`] | alignment of the Sun sensors to the magnetometer | the angle between Sun and field |
//!
//! All are linear least squares over sums ([`Normal`]): a record is walked through once, nothing of it is
//! kept, and a result comes with its covariance and the condition of its equations, or is refused.
//! A covariance speaks of noise that is new in every row. What is told wrong (the tensor, a bias of the field)
//! is not in it: docs/identification has the sensitivities.

pub mod coupling;
mod error;
mod field_motion;
mod field_track;
pub mod gyro;
mod joint;
mod least_squares;
pub mod momentum;
pub mod sun;
pub mod torque;

use nalgebra::{ComplexField, Matrix3, RealField, Vector3};

use crate::parameter::shown;

pub use error::IdentificationError;
pub use least_squares::{MAX_CONDITION, Normal, Solution};

/// Of the gyro bias at first, rad/s: 1 deg/s.
const PRIOR_BIAS_RAD_S: f64 = 0.0175;
/// What the gyro bias wanders by, rad/s/√s: 0.1 deg/s in half an orbit, as of 10 degrees and 0.01 deg/s per degree.
const BIAS_WALK: f64 = 3.2e-5;

/// What was recorded at an instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Recorded<T> {
    /// Since the instant before, s; zero at the first.
    pub dt_s: T,
    /// By the gyros, Body, rad/s.
    pub rate_rad_s: [T; 3],
    /// Calibrated field, Body, T; `None` where it was not measured, or disturbed.
    pub field_t: Option<[T; 3]>,
    /// Of the torquers from the instant before until now, Body, A·m².
    pub dipole_am2: [T; 3],
}

/// Standard deviations of what the sensors show, each axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Noise<T> {
    /// Of the gyros, rad/s.
    pub rate_rad_s: T,
    /// Of the magnetometer, T.
    pub field_t: T,
    /// What its calibration leaves of its bias, each axis, T.
    pub field_offset_t: T,
}

impl<T: RealField + Copy> Default for Noise<T> {
    /// SPROUT's: 0.163 deg/s by the paper, 586 nT as its 0.586 nT are read (docs/paper.md), and half as much for what
    /// a calibration leaves.
    fn default() -> Self {
        Self {
            rate_rad_s: number(0.163_f64.to_radians()),
            field_t: number(586e-9),
            field_offset_t: number(300e-9),
        }
    }
}

impl<T: RealField + Copy> Recorded<T> {
    fn is_finite(&self) -> bool {
        let given = self.rate_rad_s.iter().chain(&self.dipole_am2).chain([&self.dt_s]);
        let finite = given.chain(self.field_t.iter().flatten()).all(ComplexField::is_finite);
        finite && self.dt_s >= T::zero()
    }
}

/// A tensor and its inverse.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Inertia<T> {
    tensor: Matrix3<T>,
    inverse: Matrix3<T>,
}

impl<T: RealField + Copy> Inertia<T> {
    fn new(rows: [[T; 3]; 3]) -> Result<Self, IdentificationError> {
        // Symmetric: rows are columns.
        let tensor = Matrix3::from(rows);
        let symmetric =
            (tensor - tensor.transpose()).amax() <= tensor.amax() * T::default_epsilon();
        let positive = tensor.cholesky().is_some();
        match tensor.try_inverse() {
            Some(inverse) if symmetric && positive => Ok(Self { tensor, inverse }),
            _ => Err(IdentificationError::Inertia),
        }
    }
}

/// Columns e_x × v, e_y × v, e_z × v: what unit dipoles along the axes do in a field.
fn of_unit_dipoles<T: RealField + Copy>(v: &Vector3<T>) -> Matrix3<T> {
    -v.cross_matrix()
}

fn number<T: RealField>(value: f64) -> T {
    nalgebra::convert(value)
}
