//! Scale, bias and cross-axis terms, from the strength of the field while the torquers rest.

use super::findings::{Finding, MagnetometerFound, Three, worst};
use super::ladder::{Judged, Seen};
use super::parameters::CommissioningParameters;
use crate::calibration::{DataSheet, Evidence, Recursive, Sums};

/// Fields in low orbit, T: the unit of the sums.
const STRENGTH_T: f32 = 4e-5;

/// The sums.
#[derive(Debug, Clone, Copy)]
pub(super) struct Magnetometer {
    sums: Sums<f32>,
}

impl Magnetometer {
    pub fn new() -> Option<Self> {
        // Readings are in T already.
        let data_sheet = DataSheet { sensitivity: 1.0, zero: 0.0 };
        Some(Self { sums: Sums::new(data_sheet, STRENGTH_T).ok()? })
    }

    pub fn see(&mut self, seen: &Seen) {
        let Some((reading, field)) = seen.reading.zip(seen.reference_field) else { return };
        if seen.rests {
            let sample = crate::calibration::Sample {
                reading: reading.to_array(),
                intensity: field.norm(),
            };
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
        let six = self.sums.calibration::<6>().ok();
        let nine = self.sums.calibration::<9>().ok();
        let evidence = |unknowns, rms: f32| Evidence {
            samples: self.sums.samples(),
            unknowns,
            rms: f64::from(rms),
        };
        match (six, nine) {
            (Some(six), Some(nine)) => {
                let asked = evidence(9, nine.norm_error_rms).beats(&evidence(6, six.norm_error_rms));
                Some(if asked { found(&nine) } else { found(&six) })
            }
            (six, nine) => nine.as_ref().map(found).or(six.as_ref().map(found)),
        }
    }
}

fn found<const N: usize>(of: &Recursive<f32, N>) -> MagnetometerFound {
    let (x, sigma) = (&of.parameters, of.sigma());
    MagnetometerFound {
        scale: Three { value: x.scale(), sigma: sigma.scale() },
        cross_axis: Three { value: x.cross_axis(), sigma: sigma.cross_axis() },
        // Added there, subtracted here.
        bias_t: Three { value: x.bias().map(|b| -b), sigma: sigma.bias() },
        norm_error_t: of.norm_error_rms,
    }
}
