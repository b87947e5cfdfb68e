//! What the filter says: an estimate with its uncertainty and its origin, or why there is none.

use nalgebra::{Matrix6, RealField};
use serde::{Deserialize, Serialize};

use crate::frames::{Body, Eci, Rotation, Vector};

/// What one cycle made of its inputs.
#[derive(Debug, Clone, Copy)]
pub struct Output<T: RealField + Copy = f32> {
    /// The estimate; nothing when there is none to be believed.
    pub estimate: Option<FilterEstimate<T>>,
    /// The field held against the estimate, when there were both.
    pub field: Option<Innovation<T>>,
    /// The Sun held against the estimate, when there were both.
    pub sun: Option<Innovation<T>>,
    /// What happened besides.
    pub event: Option<Event>,
}

impl<T: RealField + Copy> Output<T> {
    /// No estimate, and nothing held against one.
    pub fn none(event: Option<Event>) -> Self {
        Self { estimate: None, field: None, sun: None, event }
    }
}

/// Attitude, rate and bias, and how well they are known.
#[derive(Debug, Clone, Copy)]
pub struct FilterEstimate<T: RealField + Copy = f32> {
    /// The attitude.
    pub r_bi: Rotation<Body, Eci, T>,
    /// σ of the attitude about each Body axis, rad.
    pub attitude_sigma_rad: Vector<Body, T>,
    /// Rate of Body relative to Eci, its bias removed, rad/s; the last one while the gyro is missing,
    /// nothing when there was none yet.
    pub omega_bi: Option<Vector<Body, T>>,
    /// Gyro bias, rad/s.
    pub gyro_bias: Vector<Body, T>,
    /// σ of the gyro bias, each axis, rad/s.
    pub gyro_bias_sigma_rad_s: Vector<Body, T>,
    /// Covariance of attitude error (rad) and bias error (rad/s), Body.
    pub covariance: Matrix6<T>,
    /// Where it comes from.
    pub source: Source,
    /// False when the innovations of late are larger than the covariance promised, or a sensor keeps
    /// contradicting: σ is then too small.
    pub consistent: bool,
}

/// Where an estimate comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Source {
    /// Field and Sun of this instant alone: the filter starts, or starts again.
    TwoVectors,
    /// Filtered; field and Sun were used in this cycle.
    FieldAndSun,
    /// Filtered; the field was used in this cycle.
    Field,
    /// Filtered; the Sun was used in this cycle.
    Sun,
    /// Carried by the gyro since an earlier cycle.
    Gyro,
    /// Carried by the last rate; the gyro is missing.
    HeldRate,
}

/// One measurement held against the estimate.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Innovation<T> {
    /// Normalised innovation squared; on average the degrees of freedom (field 3, Sun 2) when
    /// sensors and covariance are as promised. The largest number there is when the measurement
    /// cannot be held against the estimate at all.
    pub nis: T,
    /// Whether it passed the gate and was used.
    pub accepted: bool,
}

/// What happened to the estimate besides being filtered.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Event {
    /// There was none; it was found from field and Sun.
    Started,
    /// It had become too uncertain for linear equations; the attitude was found anew, the bias kept.
    Realigned,
    /// Field or Sun contradicted it again and again, but they did not contradict each other; it was
    /// found anew.
    Restarted,
    /// It is withheld: everything that was measured of late contradicts it.
    Withheld,
    /// It was given up; one with the source [`Source::TwoVectors`] has already taken its place.
    Lost(Lost),
}

/// Why the filter gave up its estimate.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Lost {
    /// The time since the last cycle was negative, not a number, or longer than the longest step.
    Time,
    /// The gyro was missing for too long.
    Gyro,
    /// The covariance was none.
    Covariance,
    /// σ of the attitude had grown to half a turn.
    Uncertain,
}
