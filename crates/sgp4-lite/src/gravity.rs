//! The WGS72 gravity model, which SGP4 elements are fitted with.
//!
//! Source: Hoots & Roehrich, Spacetrack Report No. 3 (1980); values of Vallado et al.,
//! AIAA 2006-6753, `getgravconst` for WGS72.

use core::f64::consts::TAU;

/// Equatorial radius of the Earth, km. SGP4's unit of length.
pub(crate) const EARTH_RADIUS_KM: f64 = 6378.135;

/// Square root of the gravitational parameter, k_e = 60 s √(μ / R³), in Earth radii^1.5 per minute,
/// with μ = 398600.8 km³/s² and R = 6378.135 km.
pub(crate) const KE: f64 = 0.074_366_916_133_173_42;

/// Second zonal harmonic.
pub(crate) const J2: f64 = 0.001_082_616;
/// Third zonal harmonic.
pub(crate) const J3: f64 = -0.000_002_538_81;
/// Fourth zonal harmonic.
pub(crate) const J4: f64 = -0.000_001_655_97;
/// J₃ / J₂, the strength of the long-period terms.
pub(crate) const J3_OVER_J2: f64 = J3 / J2;

/// Minutes in a day.
pub(crate) const MINUTES_PER_DAY: f64 = 1440.0;
/// Radians per minute in one revolution per day.
pub(crate) const RAD_PER_MIN_PER_REV_PER_DAY: f64 = TAU / MINUTES_PER_DAY;

/// x^(2/3), for Kepler's third law.
pub(crate) fn two_thirds_power(x: f64) -> f64 {
    let root = libm::cbrt(x);
    root * root
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ke_follows_from_the_gravitational_parameter() {
        let radius_cubed = EARTH_RADIUS_KM * EARTH_RADIUS_KM * EARTH_RADIUS_KM;
        assert_eq!(KE, 60.0 / libm::sqrt(radius_cubed / 398_600.8));
    }
}
