//! The angle by which the Earth has turned.

use super::JulianDate;

/// Greenwich mean sidereal time of 1982, rad, 0 to 2π, at a UT1 date (on board UT1 = UTC is taken,
/// at most 0.9 s or 0.004 deg wrong).
///
/// With T the UT1 centuries since J2000.0 (Aoki et al. (1982); Vallado (2013), eq. (3-47)):
///
/// θ = 67310.54841 s + (876600 h + 8640184.812866 s) T + 0.093104 s T² − 6.2e-6 s T³
///
/// 876,600 h a century is one turn a day, so that term is the day fraction itself and keeps all its
/// digits; with the date in one f64 the angle would be uncertain by 1.5e-9 rad.
pub fn gmst82_rad(ut1: JulianDate) -> f64 {
    const SECONDS_PER_DAY: f64 = 86_400.0;
    let t = ut1.centuries_since_j2000();
    let slow_s = 67_310.548_41 + t * (8_640_184.812_866 + t * (0.093_104 - 6.2e-6 * t));
    // Turns since noon of J2000.0; whole days drop out, each part on its own.
    let days = ut1.day - JulianDate::J2000_DAY;
    let turns = (days - libm::floor(days)) + ut1.fraction + slow_s / SECONDS_PER_DAY;
    (turns - libm::floor(turns)) * core::f64::consts::TAU
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The worked example of AIAA 2006-6753 prints its angle to 1e-10 rad; the value here is the
    /// reference data's own, evaluated in extended precision.
    const TOLERANCE_RAD: f64 = 1e-11;

    #[test]
    fn the_published_example_is_reproduced() {
        let ut1 = JulianDate { day: 2_453_101.5, fraction: 0.327_406_782_952_546_3 };
        assert!((gmst82_rad(ut1) - 5.459_562_586_617_346).abs() < TOLERANCE_RAD);
    }
}
