//! What is wrong with a magnetometer, from its own readings and the strength of the model's field.
//!
//! The strength of the field does not depend on the attitude: so the readings of any tumble, each
//! beside |B| of IGRF at its place, tell scale and bias of the three axes. No attitude is needed, and no
//! time: samples may be few, far apart and in any order.
//!
//! ```text
//! readings V, strengths I ─► calibrate ─► Calibration (s, b, covariance) ─► correction ─► TriadParameters
//!                               └─► CalibrationError: what the data cannot support, and why
//! ```
//!
//! [`calibrate`] is the paper's Gauss–Newton method, eqs. (4) and (5), in f32 on board and f64 on the
//! ground. Samples are only ever walked through, so a fixed buffer, or anything that can be walked
//! through again, will do; a pass holds one 6×6 matrix. [`calibrate_extended`] has more unknowns. [`Sums`] keep
//! no sample at all, choose the model, and are free of the shift that noise makes; [`axes`] tells which axis
//! is which.
//!
//! ```
//! use adcs_core::calibration::{DataSheet, Sample, Start, calibrate};
//!
//! // An axis that shows 1.1 V per 50,000 nT, another with 2,000 nT of bias; 30,000 nT all around.
//! let directions = (0..40).map(|k| {
//!     let (a, z) = (2.4 * f64::from(k), f64::from(k) / 20.0 - 0.975);
//!     let across = (1.0 - z * z).sqrt();
//!     [across * a.cos(), across * a.sin(), z]
//! });
//! let samples = directions.map(|[x, y, z]| Sample {
//!     reading: [30e3 * x / 50e3 * 1.1, (30e3 * y - 2e3) / 50e3, 30e3 * z / 50e3],
//!     intensity: 30e3,
//! });
//! let data_sheet = DataSheet { sensitivity: 50e3, zero: 0.0 };
//! let found = calibrate(samples, &Start::DataSheet(data_sheet))?;
//! assert!((found.scale[0] - 50e3 / 1.1).abs() < 1e-4);
//! assert!((found.bias[1] - 2e3).abs() < 1e-4);
//! # Ok::<(), adcs_core::calibration::CalibrationError>(())
//! ```
//!
//! Derivation, pitfalls: docs/calibration.

pub mod axes;
mod descent;
mod error;
mod evidence;
mod extended;
mod gauss_newton;
mod linear;
mod moments;
mod parameters;
mod quadratic;
mod sums;
mod symmetric;
mod twostep;

use nalgebra::{RealField, SMatrix, SVector, convert};

use crate::parameter::shown;

pub use descent::MAX_PASSES;
pub use error::{CalibrationError, Unknown};
pub use evidence::{Evidence, VERY_STRONG};
pub use extended::{CoupledSample, Extended, NoiseShift, calibrate_extended};
pub use gauss_newton::{MAX_CONDITION, MIN_SAMPLES, calibrate};
pub use parameters::{Correction, Parameters};
pub use sums::{Recursive, Sums};
pub(crate) use symmetric::{Spectrum, sigmas};
pub use twostep::twostep;

/// The unknowns: scale of x, y, z, then bias of x, y, z.
pub const UNKNOWNS: usize = 6;

/// One reading of the magnetometer, and how strong the field was there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample<T> {
    /// V: what the sensor shows along its axes, in any unit (V; or T by the data sheet).
    pub reading: [T; 3],
    /// |B_IGRF|: strength of the model's field, in any unit (nT, T).
    pub intensity: T,
}

/// What the data sheet says: B = sensitivity (V − zero), the same for the three axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DataSheet<T> {
    /// Field per reading.
    pub sensitivity: T,
    /// Reading without field.
    pub zero: T,
}

/// Where the search begins.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Start<T> {
    /// From the data sheet, as in the paper.
    DataSheet(DataSheet<T>),
    /// From the ellipsoid that fits the readings best, which is a linear problem: nothing needs to be
    /// known of the sensor but where its readings are counted from.
    Linear {
        /// Reading without field, roughly.
        zero: T,
    },
}

/// The least, the largest and the root mean square of |B| − |B_IGRF|.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NormError<T> {
    /// Least.
    pub min: T,
    /// Largest.
    pub max: T,
    /// Root mean square.
    pub rms: T,
}

/// Scale and bias of a magnetometer, B = s ∘ V + b (the paper's eq. (5)), and how well they are known.
///
/// | symbol | code | unit |
/// |---|---|---|
/// | s | `scale` | field per reading, as the samples have them |
/// | b | `bias` | field |
/// | E | `cost` | field⁴ |
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Calibration<T: RealField + Copy> {
    /// s, positive.
    pub scale: [T; 3],
    /// b, *added* after scaling. The flight software subtracts: see [`correction`](Self::correction).
    pub bias: [T; 3],
    /// Covariance of s_x, s_y, s_z, b_x, b_y, b_z, from the residuals.
    ///
    /// It describes how the result scatters with noise that differs from sample to sample. An error that
    /// lasts (cross-axis coupling, currents nearby, the shift that the noise itself makes in |B|²) is
    /// not in it.
    pub covariance: SMatrix<T, UNKNOWNS, UNKNOWNS>,
    /// E = Σ (|s ∘ V + b|² − |B_IGRF|²)², the paper's eq. (4).
    pub cost: T,
    /// Root mean square of a residual |s ∘ V + b|² − |B_IGRF|², field².
    pub residual_rms: T,
    /// What is left of the norm's error.
    pub norm_error: NormError<T>,
    /// Condition of JᵀJ with its columns scaled to equal length: 1 is best. See [`MAX_CONDITION`].
    pub condition: T,
    /// How many samples there were.
    pub samples: u32,
    /// Steps taken.
    pub iterations: u32,
}

impl<T: RealField + Copy> Calibration<T> {
    /// Standard deviations of the scales and of the biases.
    pub fn sigma(&self) -> ([T; 3], [T; 3]) {
        parted(&sigmas(&self.covariance))
    }

    /// What [`TriadParameters`](crate::sensing::TriadParameters) take, `scale` (no unit) and `bias`
    /// (field), behind a driver that turns readings into field by this data sheet.
    ///
    /// The driver gives x = k (V − V₀), the flight software makes s′ x − b′ of it. So
    /// s′ = s / k, b′ = −(b + s V₀).
    pub fn correction(&self, data_sheet: DataSheet<T>) -> ([T; 3], [T; 3]) {
        let [s_x, s_y, s_z] = self.scale;
        let [b_x, b_y, b_z] = self.bias;
        let DataSheet { sensitivity, zero } = data_sheet;
        (
            self.scale.map(|scale| scale / sensitivity),
            [-(b_x + s_x * zero), -(b_y + s_y * zero), -(b_z + s_z * zero)],
        )
    }
}

/// How far |s ∘ V + b| is from the model; zeros when there is no sample.
pub fn norm_error<T: RealField + Copy>(
    samples: impl IntoIterator<Item = Sample<T>>,
    scale: [T; 3],
    bias: [T; 3],
) -> NormError<T> {
    let mut count = T::zero();
    let mut sum = T::zero();
    let mut range: Option<(T, T)> = None;
    for Sample { reading, intensity } in samples {
        let error = norm(field(reading, scale, bias)) - intensity;
        count += T::one();
        sum += error * error;
        range = Some(range.map_or((error, error), |(min, max)| (min.min(error), max.max(error))));
    }
    match range {
        Some((min, max)) => NormError { min, max, rms: (sum / count).sqrt() },
        None => NormError { min: T::zero(), max: T::zero(), rms: T::zero() },
    }
}

/// s ∘ V + b
fn field<T: RealField + Copy>(
    [v_x, v_y, v_z]: [T; 3],
    [s_x, s_y, s_z]: [T; 3],
    [b_x, b_y, b_z]: [T; 3],
) -> [T; 3] {
    [s_x * v_x + b_x, s_y * v_y + b_y, s_z * v_z + b_z]
}

/// (s, b)
fn joined<T: RealField + Copy>(
    [s_x, s_y, s_z]: [T; 3],
    [b_x, b_y, b_z]: [T; 3],
) -> SVector<T, UNKNOWNS> {
    SVector::from([s_x, s_y, s_z, b_x, b_y, b_z])
}

/// s and b of (s, b).
fn parted<T: RealField + Copy>(x: &SVector<T, UNKNOWNS>) -> ([T; 3], [T; 3]) {
    let [s_x, s_y, s_z, b_x, b_y, b_z] = (*x).into();
    ([s_x, s_y, s_z], [b_x, b_y, b_z])
}

fn norm<T: RealField + Copy>([x, y, z]: [T; 3]) -> T {
    (x * x + y * y + z * z).sqrt()
}

fn number<T: RealField>(value: f64) -> T {
    convert(value)
}
