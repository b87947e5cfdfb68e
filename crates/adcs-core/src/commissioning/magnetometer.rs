//! Scale, bias and cross-axis terms, from the strength of the field while the torquers rest.

use super::findings::{Finding, MagnetometerFound, Three, worst};
use super::ladder::{Judged, Seen};
use super::parameters::CommissioningParameters;
use crate::calibration::{DataSheet, Sample, Sums};

/// Fields in low orbit, T: the unit of the sums.
const STRENGTH_T: f32 = 4e-5;

/// The driver has made T of volts already.
const READINGS_IN_T: DataSheet<f32> = DataSheet { sensitivity: 1.0, zero: 0.0 };

/// Readings that do not turn enough multiply what is no noise, such as a field model 60 nT wrong, as
/// much as noise; σ knows of noise alone. Of 60 tumbles of half an hour 59 have a condition below this and
/// are then wrong by 130 nT at most; one of 990 was wrong by 3200 nT (docs/commissioning).
const MOST_CONDITION: f32 = 300.0;

/// The sums.
#[derive(Debug, Clone, Copy)]
pub(super) struct Magnetometer {
    sums: Sums<f32>,
}

impl Magnetometer {
    pub fn new() -> Option<Self> {
        Some(Self { sums: Sums::new(READINGS_IN_T, STRENGTH_T).ok()? })
    }

    #[inline(never)]
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
        let (found, condition) = self.found()?;
        let MagnetometerFound { scale, cross_axis, bias_t, .. } = &found;
        let sharp = condition <= MOST_CONDITION
            && worst(&scale.sigma) <= p.scale_sigma
            && worst(&cross_axis.sigma) <= p.scale_sigma
            && worst(&bias_t.sigma) <= p.bias_sigma_t;
        Some((Finding::Magnetometer(found), sharp))
    }

    fn found(&self) -> Option<(MagnetometerFound, f32)> {
        let found = self.sums.chosen().ok()?;
        let (value, sigma) = found.correction(READINGS_IN_T);
        let three = |value, sigma| Three { value, sigma };
        let condition = found.condition;
        let found = MagnetometerFound {
            scale: three(value.scale, sigma.scale),
            cross_axis: three(value.cross_axis, sigma.cross_axis),
            bias_t: three(value.bias, sigma.bias),
            norm_error_t: found.norm_error_rms,
        };
        Some((found, condition))
    }
}
