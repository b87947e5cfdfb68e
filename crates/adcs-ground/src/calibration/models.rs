//! The models beyond the paper's, tried one by one.

use adcs_core::calibration::{
    CalibrationError, CoupledSample, DataSheet, Evidence, Extended, NoiseShift, Parameters, Sample,
    Start, calibrate_extended, twostep,
};
use nalgebra::{RealField, SVector, convert, convert_unchecked};

use super::{Fit, Measured, Request};

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
    if request.single {
        twostep_in::<f32>(measured, request)
    } else {
        twostep_in::<f64>(measured, request)
    }
}

fn twostep_in<T: RealField + Copy>(
    measured: &[Measured],
    request: &Request<'_>,
) -> Result<Fit, CalibrationError> {
    let samples = measured.iter().map(|measured| measured.sample);
    let found = twostep(samples.clone().map(narrow::<T>), narrow_sheet(request.before))?;
    let unknowns = wide(found.parameters.0.iter());
    let x = Parameters::<f64, 9>(SVector::from_iterator(unknowns.iter().copied()));
    Ok(Fit {
        unknowns,
        sigma: wide(found.sigma().0.iter()),
        cost: samples.map(|sample| squared_error(&x, &sample).powi(2)).sum(),
        condition: Some(convert_unchecked(found.condition)),
        samples: found.evidence.samples,
        iterations: None,
        evidence: found.evidence,
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
