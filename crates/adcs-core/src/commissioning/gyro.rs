//! Gyro bias, from a field that turns otherwise than the gyros say.

use super::findings::{Finding, Three};
use super::ladder::{Judged, Seen};
use super::parameters::CommissioningParameters;
use crate::frames::{Eci, Vector};
use crate::identification::Noise;
use crate::identification::gyro::GyroBias;

/// The estimate.
#[derive(Debug, Clone, Copy)]
pub(super) struct Gyro {
    estimate: GyroBias<f32, 3>,
    /// The model's field at the last instant.
    reference: Option<Vector<Eci>>,
}

impl Gyro {
    pub fn new(noise: Noise<f32>) -> Self {
        Self { estimate: GyroBias::constant(noise), reference: None }
    }

    #[inline(never)]
    pub fn see(&mut self, seen: &Seen) {
        let Some(instant) = &seen.instant else { return };
        let before = core::mem::replace(&mut self.reference, seen.reference_field);
        // By day field and Sun give an attitude, which tells how the field itself changes.
        let moved = seen.reference_field.zip(before).map(|(now, before)| now - before);
        let change = seen.attitude().zip(moved).map(|(r_bi, moved)| (r_bi * moved).to_array());
        let recorded = instant.recorded(seen.quiet_field());
        self.estimate.add(&recorded, 0.0, change);
    }

    pub fn judged(&self, p: &CommissioningParameters) -> Judged {
        let solution = self.estimate.solve().ok()?;
        let found = Three { value: solution.x.into(), sigma: solution.sigma().into() };
        Some((Finding::Gyro(found), found.worst_sigma() <= p.gyro_sigma_rad_s))
    }
}
