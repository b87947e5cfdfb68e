//! Gyro bias, from a field that turns otherwise than the gyros say.

use super::findings::{Finding, Three};
use super::ladder::{Judged, Seen};
use super::parameters::CommissioningParameters;
use crate::frames::{Eci, Vector};
use crate::identification::Noise;
use crate::identification::gyro::GyroBias;

/// The sums.
#[derive(Debug, Clone, Copy)]
pub(super) struct Gyro {
    sums: GyroBias<f32, 3>,
    last_reference: Option<Vector<Eci>>,
}

impl Gyro {
    pub fn new() -> Option<Self> {
        Some(Self { sums: GyroBias::constant(Noise::default()), last_reference: None })
    }

    pub fn see(&mut self, seen: &Seen) {
        let Some(instant) = &seen.instant else { return };
        let recorded = instant.recorded(seen.quiet_field(), [0.0; 3]);
        self.sums.add(&recorded, 0.0, None);
    }

    pub fn judged(&self, p: &CommissioningParameters) -> Judged {
        let solution = self.sums.solve().ok()?;
        let found = Three { value: solution.x.into(), sigma: solution.sigma().into() };
        Some((Finding::Gyro(found), found.worst_sigma() <= p.gyro_sigma_rad_s))
    }
}
