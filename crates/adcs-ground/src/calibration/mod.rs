//! A magnetometer's calibration on the ground: from a table to parameters for the satellite.

mod chart;
mod input;

use std::fmt;

use adcs_core::calibration::{
    Calibration, CalibrationError, DataSheet, MIN_SAMPLES, NormError, Sample, Start, calibrate,
    norm_error,
};
use nalgebra::RealField;
use serde::Serialize;

pub use chart::chart;
pub use input::{Measured, bind};

/// What is asked.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Request<'a> {
    /// Where searches begin, nT/V and V. The solution with the least cost is taken: E has more minima
    /// than one, and a start far away may end in a wrong one.
    pub starts: &'a [Start<f64>],
    /// What the data sheet says: the readings before the calibration.
    pub before: DataSheet<f64>,
    /// What the satellite's driver turns voltages into field by.
    pub driver: DataSheet<f64>,
    /// Whether to compute in f32, as the satellite does.
    pub single: bool,
}

/// The result, as it is written to `OUT.json`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Outcome {
    /// Which errors were sought.
    pub model: &'static str,
    /// s of B = s ∘ V + b.
    pub scale_nt_per_v: [f64; 3],
    /// b.
    pub bias_nt: [f64; 3],
    /// Standard deviation of s.
    pub scale_sigma_nt_per_v: [f64; 3],
    /// Standard deviation of b.
    pub bias_sigma_nt: [f64; 3],
    /// Σ (|B|² − |B_IGRF|²)².
    pub cost_nt4: f64,
    /// How many samples were used.
    pub samples: u32,
    /// Steps of the search.
    pub iterations: u32,
    /// Condition of the scaled normal matrix.
    pub condition: f64,
    /// |B| − |B_IGRF| by the data sheet.
    pub norm_error_before_nt: Range,
    /// The same with s and b.
    pub norm_error_after_nt: Range,
    /// What the flight software takes.
    pub correction: Correction,
}

/// Of |B| − |B_IGRF|, nT.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Range {
    /// Least.
    pub min: f64,
    /// Largest.
    pub max: f64,
    /// Root mean square.
    pub rms: f64,
}

/// Section `[magnetometer.calibration]` of a mission: field = scale · reading − bias.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Correction {
    /// Factor on what the driver gives.
    pub scale: [f64; 3],
    /// Subtracted after it.
    pub bias_nt: [f64; 3],
}

impl From<NormError<f64>> for Range {
    fn from(NormError { min, max, rms }: NormError<f64>) -> Self {
        Self { min, max, rms }
    }
}

/// Calibrates.
///
/// # Errors
/// What the samples do not support, as the first search says it, when none ends well.
pub fn solve(measured: &[Measured], request: &Request<'_>) -> Result<Outcome, CalibrationError> {
    let samples = measured.iter().map(|measured| measured.sample);
    let found = least(request.starts.iter().map(|start| {
        if request.single {
            let samples = samples.clone().map(|Sample { reading, intensity }| Sample {
                reading: reading.map(|volt| volt as f32),
                intensity: intensity as f32,
            });
            let start = match *start {
                Start::DataSheet(data_sheet) => Start::DataSheet(single(data_sheet)),
                Start::Linear { zero } => Start::Linear { zero: zero as f32 },
            };
            Ok(Solved::of(&calibrate(samples, &start)?, single(request.driver), f64::from))
        } else {
            Ok(Solved::of(&calibrate(samples.clone(), start)?, request.driver, |x| x))
        }
    }))?;
    let DataSheet { sensitivity, zero } = request.before;
    let before = norm_error(samples.clone(), [sensitivity; 3], [-sensitivity * zero; 3]);
    Ok(Outcome {
        model: "paper",
        scale_nt_per_v: found.scale,
        bias_nt: found.bias,
        scale_sigma_nt_per_v: found.sigma.0,
        bias_sigma_nt: found.sigma.1,
        cost_nt4: found.cost,
        samples: found.samples,
        iterations: found.iterations,
        condition: found.condition,
        norm_error_before_nt: before.into(),
        norm_error_after_nt: norm_error(samples, found.scale, found.bias).into(),
        correction: Correction { scale: found.correction.0, bias_nt: found.correction.1 },
    })
}

/// The solution with the least cost: the first of those that are equal but for rounding.
fn least(
    searches: impl Iterator<Item = Result<Solved, CalibrationError>>,
) -> Result<Solved, CalibrationError> {
    /// Above what f32 makes of one minimum, far below what parts two.
    const CLEARLY_LESS: f64 = 0.999;
    searches
        .reduce(|best, next| match (&best, &next) {
            (Ok(a), Ok(b)) if b.cost < a.cost * CLEARLY_LESS => next,
            (Err(_), Ok(_)) => next,
            _ => best,
        })
        .unwrap_or(Err(CalibrationError::TooFew { found: 0, needed: MIN_SAMPLES }))
}

fn single(DataSheet { sensitivity, zero }: DataSheet<f64>) -> DataSheet<f32> {
    DataSheet { sensitivity: sensitivity as f32, zero: zero as f32 }
}

/// A calibration in f64, whichever precision it was found in.
struct Solved {
    scale: [f64; 3],
    bias: [f64; 3],
    sigma: ([f64; 3], [f64; 3]),
    correction: ([f64; 3], [f64; 3]),
    cost: f64,
    condition: f64,
    samples: u32,
    iterations: u32,
}

impl Solved {
    fn of<T: RealField + Copy>(
        found: &Calibration<T>,
        driver: DataSheet<T>,
        wide: impl Fn(T) -> f64,
    ) -> Self {
        let all = |(scale, bias): ([T; 3], [T; 3])| (scale.map(&wide), bias.map(&wide));
        Self {
            scale: found.scale.map(&wide),
            bias: found.bias.map(&wide),
            sigma: all(found.sigma()),
            correction: all(found.correction(driver)),
            cost: wide(found.cost),
            condition: wide(found.condition),
            samples: found.samples,
            iterations: found.iterations,
        }
    }
}

impl Correction {
    /// The section as a mission file has it, and as it is uplinked: in single precision.
    pub fn toml(&self) -> String {
        let [s_x, s_y, s_z] = self.scale.map(|scale| scale as f32);
        let [b_x, b_y, b_z] = self.bias_nt.map(|bias| bias as f32);
        format!(
            "[magnetometer.calibration]\n\
             scale = [{s_x:?}, {s_y:?}, {s_z:?}]\n\
             bias_nt = [{b_x:?}, {b_y:?}, {b_z:?}]\n"
        )
    }
}

/// For a person to read.
impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "{} samples, {} iterations, condition {:.1}",
            self.samples, self.iterations, self.condition
        )?;
        writeln!(f, "axis      scale, nT/V                bias, nT")?;
        for (axis, name) in ["x", "y", "z"].iter().enumerate() {
            writeln!(
                f,
                "{name}    {:>10.1} ± {:<8.1}    {:>10.1} ± {:<8.1}",
                self.scale_nt_per_v[axis],
                self.scale_sigma_nt_per_v[axis],
                self.bias_nt[axis],
                self.bias_sigma_nt[axis]
            )?;
        }
        for (when, range) in
            [("before", self.norm_error_before_nt), ("after ", self.norm_error_after_nt)]
        {
            let Range { min, max, rms } = range;
            writeln!(f, "|B| - |IGRF| {when}  {min:+.0} to {max:+.0} nT, rms {rms:.0} nT")?;
        }
        write!(f, "\nFor the mission file:\n\n{}", self.correction.toml())
    }
}
