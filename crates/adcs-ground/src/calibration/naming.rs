//! Which axis of the magnetometer is which, from the history of a flight.

use adcs_core::calibration::axes::{AxesCheck, AxesStep};
use adcs_core::frames::SignedPermutation;
use serde::Serialize;

use super::{Fit, Measured};

/// Tesla in a nanotesla.
const T_PER_NT: f64 = 1e-9;

/// What gyros and torquers say of the axes.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Naming {
    /// The sensor's axes along Body's x, y and z, as `+x +y +z`.
    pub axes: Option<String>,
    /// The same.
    #[serde(skip)]
    pub wiring: Option<SignedPermutation>,
    /// What the record leaves open otherwise.
    pub open: Option<String>,
    /// Whether that is how they are wired.
    pub as_wired: Option<bool>,
    /// How much worse the next naming is, by the gyros.
    pub gyro_ratio: Option<f64>,
    /// Change of energy over the torquers' work: about 1.
    pub torquer_response: Option<f64>,
}

/// Names the axes by what was recorded, calibrated with `fit`; `None` when there are no gyros or no times.
pub(super) fn name(
    measured: &[Measured],
    fit: &Fit,
    has_dipoles: bool,
    inertia_kg_m2: [[f64; 3]; 3],
) -> Option<Naming> {
    let mut check = AxesCheck::new(inertia_kg_m2);
    let mut last = None;
    for one in measured {
        let (t_s, rate) = (one.t_s?, one.gyro_deg_s?);
        let [x, y, z, ..] = one.currents;
        let field = one.settled.then(|| fit.field(one).map(|nt| nt * T_PER_NT));
        check.add(&AxesStep {
            dt_s: last.map_or(0.0, |last| t_s - last),
            rate_rad_s: rate.map(f64::to_radians),
            field_t: field,
            dipole_am2: if has_dipoles { [x, y, z] } else { [0.0; 3] },
        });
        last = Some(t_s);
    }
    last?;
    Some(match check.verdict() {
        Ok(axes) => Naming {
            axes: Some(axes.permutation.to_string()),
            wiring: Some(axes.permutation),
            open: None,
            as_wired: Some(axes.permutation == SignedPermutation::IDENTITY),
            gyro_ratio: Some(axes.gyro_ratio),
            torquer_response: Some(axes.response),
        },
        Err(error) => Naming {
            axes: None,
            wiring: None,
            open: Some(error.to_string()),
            as_wired: None,
            gyro_ratio: check.by_gyros().ok().map(|(_, ratio)| ratio),
            torquer_response: None,
        },
    })
}
