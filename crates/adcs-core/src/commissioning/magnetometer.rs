//! Scale, bias and cross-axis terms, from the strength of the field while the torquers rest.

use super::findings::{Finding, MagnetometerFound, Three, worst};
use super::ladder::{Judged, Seen};
use super::parameters::CommissioningParameters;
use crate::calibration::{DataSheet, Sample, Sums};

/// Fields in low orbit, T: the unit of the sums.
const STRENGTH_T: f32 = 4e-5;

/// The driver has made T of volts already.
const READINGS_IN_T: DataSheet<f32> = DataSheet { sensitivity: 1.0, zero: 0.0 };

/// The sums.
#[derive(Debug, Clone, Copy)]
pub(super) struct Magnetometer {
    sums: Sums<f32>,
}

impl Magnetometer {
    pub fn new() -> Option<Self> {
        Some(Self { sums: Sums::new(READINGS_IN_T, STRENGTH_T).ok()? })
    }

    pub fn see(&mut self, seen: &Seen) {
        let Some((reading, field)) = seen.reading.zip(seen.reference_field) else { return };
        if seen.rests {
            let sample = Sample { reading: reading.to_array(), intensity: field.norm() };
            // What is refused is left out.
            let _ = self.sums.add(sample);
        }
    }

    /// The model that the readings ask for, and whether it is known well enough.
    pub fn judged(&self, p: &CommissioningParameters) -> Judged {
        let found = self.found()?;
        let MagnetometerFound { scale, cross_axis, bias_t, .. } = &found;
        let sharp = worst(&scale.sigma) <= p.scale_sigma
            && worst(&cross_axis.sigma) <= p.scale_sigma
            && worst(&bias_t.sigma) <= p.bias_sigma_t;
        Some((Finding::Magnetometer(found), sharp))
    }

    fn found(&self) -> Option<MagnetometerFound> {
        let found = self.sums.chosen().ok()?;
        let (value, sigma) = found.correction(READINGS_IN_T);
        let three = |value, sigma| Three { value, sigma };
        Some(MagnetometerFound {
            scale: three(value.scale, sigma.scale),
            cross_axis: three(value.cross_axis, sigma.cross_axis),
            bias_t: three(value.bias, sigma.bias),
            norm_error_t: found.norm_error_rms,
        })
    }
}
