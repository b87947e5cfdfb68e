//! Turn between Sun sensors and magnetometer, from the angle between Sun and field.

use super::findings::{Finding, Three};
use super::ladder::{Judged, Seen};
use super::parameters::CommissioningParameters;
use crate::frames::Vector;
use crate::identification::sun::SunAlignment;

/// The sums.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Sun {
    sums: SunAlignment<f32>,
}

impl Sun {
    pub fn see(&mut self, seen: &Seen) {
        let pair = seen.quiet_field().zip(seen.reference_field).zip(seen.sun);
        let Some(((field, reference_field), (sun, reference_sun))) = pair else { return };
        let Some(reference_field) = reference_field.direction() else { return };
        let cosine = reference_field.vector().dot(&reference_sun.vector());
        self.sums.add(sun.vector().to_array(), Vector::to_array(&field), cosine);
    }

    pub fn judged(&self, p: &CommissioningParameters) -> Judged {
        let solution = self.sums.solve().ok()?;
        let found = Three { value: solution.x.into(), sigma: solution.sigma().into() };
        Some((Finding::Sun(found), found.worst_sigma() <= p.sun_sigma_rad))
    }
}
