//! How the Earth stands: from inertial to Earth-fixed axes.

use nalgebra::{UnitQuaternion, Vector3};

use crate::frames::{Ecef, Eci, Rotation};
use crate::time::{Utc, gmst82_rad};

/// The rotation from TEME to Earth-fixed axes (PEF) at `now`, by Greenwich mean sidereal time about
/// z. UT1 is taken to be UTC (at most 0.9 s or 0.004 deg) and polar motion is ignored (0.0002 deg).
///
/// r_ecef = R₃(θ) r_eci; Vallado (2013), §3.7.
pub fn ecef_from_eci(now: Utc) -> Rotation<Ecef, Eci, f64> {
    let theta_rad = gmst82_rad(now.julian_date());
    Rotation::from_hamilton(UnitQuaternion::from_axis_angle(&Vector3::z_axis(), -theta_rad))
}
