//! The models beyond the paper's, tried one by one.

use adcs_core::calibration::{
    CalibrationError, CoupledSample, DataSheet, Evidence, Extended, NoiseShift, Parameters, Sample,
    Start, calibrate_extended, twostep,
};
use nalgebra::{RealField, SMatrix, SVector, convert, convert_unchecked};

use super::{Fit, Measured, Request};

/// Steps of the derivative of a calibration by what TWOSTEP finds, in its own units.
const STEP: f64 = 1e-6;

/// Scale and bias (`N` = 6), cross-axis terms (9), and three unknowns for each of `C` currents.
pub(super) fn extended<const C: usize, const N: usize>(
    measured: &[Measured],
    request: &Request<'_>,
) -> Result<Fit, CalibrationError> {
    if request.single {
        least::<f32, C, N>(measured, request)
    } else {
        least::<f64, C, N>(measured, request)
    }
}

/// The best of the starts.
fn least<T: RealField + Copy, const C: usize, const N: usize>(
    measured: &[Measured],
    request: &Request<'_>,
) -> Result<Fit, CalibrationError> {
    let samples = measured.iter().map(|measured| {
        let CoupledSample { sample, currents } = measured.coupled::<C>();
        CoupledSample { sample: narrow(sample), currents: currents.map(convert) }
    });
    let shift = if request.unbiased { NoiseShift::Removed } else { NoiseShift::Kept };
    super::least(request.starts.iter().map(|start| {
        let start = match *start {
            Start::DataSheet(data_sheet) => Start::DataSheet(narrow_sheet(data_sheet)),
            Start::Linear { zero } => Start::Linear { zero: convert(zero) },
        };
        let found: Extended<T, N> = calibrate_extended(samples.clone(), &start, shift)?;
        Ok(Fit {
            unknowns: wide(found.parameters.0.iter()),
            sigma: wide(found.sigma().0.iter()),
            cost: convert_unchecked(found.cost),
            condition: Some(convert_unchecked(found.condition)),
            samples: found.samples,
            iterations: Some(found.iterations),
            evidence: Evidence::of(&found),
        })
    }))
}

/// TWOSTEP, without any start.
pub(super) fn by_twostep(
    measured: &[Measured],
    request: &Request<'_>,
) -> Result<Fit, CalibrationError> {
    let samples = measured.iter().map(|measured| measured.sample);
    let sheet = request.before;
    let found = twostep(samples.clone(), sheet)?;
    let x = found.parameters(sheet);
    // ∂(s, b, c)/∂(b, D) by differences; the columns are of b, then of D.
    let mut slopes = SMatrix::<f64, 9, 9>::zeros();
    for (index, mut slope) in slopes.column_iter_mut().enumerate() {
        let strongest = samples.clone().fold(0.0_f64, |most, it| most.max(it.intensity));
        let step = if index < 3 { STEP * strongest } else { STEP };
        let moved = |by: f64| {
            let mut moved = found;
            match index {
                0..3 => moved.bias[index] += by,
                _ => {
                    let (i, j) = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)][index - 3];
                    moved.distortion[i][j] += by;
                    if i != j {
                        moved.distortion[j][i] += by;
                    }
                }
            }
            moved.parameters(sheet).0
        };
        slope.copy_from(&((moved(step) - moved(-step)) / (2.0 * step)));
    }
    let covariance = slopes * found.covariance * slopes.transpose();
    let errors = samples.clone().map(|sample| squared_error(&x, &sample));
    let (mut cost, mut relative) = (0.0, 0.0);
    for (error, sample) in errors.zip(samples) {
        cost += error * error;
        relative += (error / (2.0 * sample.intensity)).powi(2);
    }
    let rms = (relative / f64::from(found.samples)).sqrt();
    Ok(Fit {
        unknowns: x.0.as_slice().to_vec(),
        sigma: covariance.diagonal().iter().map(|variance| variance.max(0.0).sqrt()).collect(),
        cost,
        condition: None,
        samples: found.samples,
        iterations: None,
        evidence: Evidence { samples: found.samples, unknowns: 9, rms },
    })
}

fn squared_error(x: &Parameters<f64, 9>, sample: &Sample<f64>) -> f64 {
    let field = SVector::from(x.field(sample.reading, &[]));
    field.norm_squared() - sample.intensity.powi(2)
}

fn narrow<T: RealField + Copy>(Sample { reading, intensity }: Sample<f64>) -> Sample<T> {
    Sample { reading: reading.map(convert), intensity: convert(intensity) }
}

fn narrow_sheet<T: RealField + Copy>(sheet: DataSheet<f64>) -> DataSheet<T> {
    DataSheet { sensitivity: convert(sheet.sensitivity), zero: convert(sheet.zero) }
}

fn wide<'a, T: RealField + Copy>(values: impl Iterator<Item = &'a T>) -> Vec<f64> {
    values.map(|&value| convert_unchecked(value)).collect()
}
