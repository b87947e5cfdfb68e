//! Where the Sun stands: the short formula of the Japanese Hydrographic Department.

use crate::frames::{Direction, Eci, Vector};
use crate::time::Tt;

/// The astronomical unit, m (IAU 2012 Resolution B2, exact).
pub const ASTRONOMICAL_UNIT_M: f64 = 149_597_870_700.0;

/// Axes of the true equator and true equinox of date: [`Eci`] turned about z by the equation of the
/// equinoxes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TrueOfDate {}

/// The Sun as it appears from the Earth's centre.
///
/// *Apparent*: aberration and light time are in it, so that it is where a sensor sees it; the
/// satellite's own parallax (0.003 deg in low orbit) is not. The Sun is taken to stand in the
/// ecliptic, which it does within 1.1 arcsec.
///
/// | symbol | code | meaning |
/// |---|---|---|
/// | λ | `longitude_rad` | apparent longitude from the true equinox of date, 0 to 2π |
/// | R | `distance_au` | distance of the centres |
/// | ε | `true_obliquity_rad` | angle of the ecliptic to the true equator |
/// | Δψ | `nutation_in_longitude_rad` | true minus mean equinox, along the ecliptic |
///
/// Against JPL DE421 over 2000–2050: longitude within 0.0022 deg,
/// [`direction_eci`](Self::direction_eci) within 0.0022 deg, distance within 3.5e-5 au.
///
/// Costs 32 sines in software f64, 113,000 instructions on a Cortex-M4F: to be called
/// once in minutes, not in every cycle. The Sun moves by 1 deg a day, so that is enough
/// ([`SunTrack`](super::sun_track::SunTrack)).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ApparentSun {
    /// λ, rad.
    pub longitude_rad: f64,
    /// R, au.
    pub distance_au: f64,
    /// ε, rad.
    pub true_obliquity_rad: f64,
    /// Δψ, rad.
    pub nutation_in_longitude_rad: f64,
}

/// `amplitude · sin(phase + rate T)` or `cos`, T in Julian years.
struct Term {
    amplitude: f64,
    phase_deg: f64,
    rate_deg_per_year: f64,
}

const fn term(amplitude: f64, phase_deg: f64, rate_deg_per_year: f64) -> Term {
    Term { amplitude, phase_deg, rate_deg_per_year }
}

impl Term {
    fn argument_rad(&self, t: f64) -> f64 {
        (self.phase_deg + self.rate_deg_per_year * t).to_radians()
    }

    fn sine(&self, t: f64) -> f64 {
        self.amplitude * libm::sin(self.argument_rad(t))
    }

    fn cosine(&self, t: f64) -> f64 {
        self.amplitude * libm::cos(self.argument_rad(t))
    }
}

/// Julian day number of the formula's origin, 1974-12-31 0h TT.
const ORIGIN_JULIAN_DAY: f64 = 2_442_412.5;
const DAYS_PER_JULIAN_YEAR: f64 = 365.25;
/// Years from J2000.0 to the formula's origin.
const ORIGIN_YEARS_SINCE_J2000: f64 = -9_132.5 / DAYS_PER_JULIAN_YEAR;

/// Mean longitude with the constant part of aberration: degrees, degrees a year.
const MEAN_LONGITUDE_DEG: [f64; 2] = [279.0358, 360.007_69];

/// The equation of the centre, whose amplitude shrinks as the orbit becomes rounder.
const EQUATION_OF_CENTRE: Term = term(1.9159, 356.531, 359.991);
const EQUATION_OF_CENTRE_DEG_PER_YEAR: f64 = -0.000_05;

/// Nutation: of the Moon's node, and of twice the Sun's longitude. Degrees.
const NUTATION: [Term; 2] = [term(-0.0048, 248.64, -19.341), term(-0.0004, 198.1, 720.02)];

/// The other terms of the longitude, degrees: second and third of the equation of the centre, the
/// Moon, Venus, Jupiter, Mars.
const LONGITUDE: [Term; 16] = [
    term(0.0200, 353.06, 719.981),
    term(0.0020, 285.0, 329.64),
    term(0.0018, 334.2, -4452.67),
    term(0.0018, 293.7, -0.20),
    term(0.0015, 242.4, 450.37),
    term(0.0013, 211.1, 225.18),
    term(0.0008, 208.0, 659.29),
    term(0.0007, 53.5, 90.38),
    term(0.0007, 12.1, -30.35),
    term(0.0006, 239.1, 337.18),
    term(0.0005, 10.1, -1.50),
    term(0.0005, 99.1, -22.81),
    term(0.0004, 264.8, 315.56),
    term(0.0004, 233.8, 299.30),
    term(0.0003, 349.6, 1079.97),
    term(0.0003, 241.2, -44.43),
];

/// The common logarithm of the distance in au: constant, and the terms in the cosine.
const LOG10_DISTANCE: f64 = 0.000_030;
const LOG10_DISTANCE_ECCENTRICITY: Term = term(-0.007_261, 356.53, 359.991);
const LOG10_DISTANCE_ECCENTRICITY_PER_YEAR: f64 = 0.000_000_2;
const LOG10_DISTANCE_TERMS: [Term; 4] = [
    term(-0.000_091, 353.1, 719.98),
    term(0.000_013, 205.8, 4452.67),
    term(0.000_007, 62.0, 450.4),
    term(0.000_007, 105.0, 329.6),
];

/// Mean obliquity at J2000.0 and its rate (Lieske et al. (1977), linear part): degrees, degrees a
/// year.
const MEAN_OBLIQUITY_DEG: [f64; 2] = [23.439_291, -0.000_130_042];
/// Nutation in obliquity, with the Moon's node as argument from J2000.0 (IAU 1980, largest term).
const NUTATION_IN_OBLIQUITY: Term = term(0.002_56, 125.04, -19.341);

impl ApparentSun {
    /// The Sun at an instant of Terrestrial Time.
    ///
    /// With T the Julian years from 1974-12-31 0h:
    ///
    /// λ = 279.0358° + 360.00769° T + (1.9159 − 0.00005 T)° sin(356.531° + 359.991° T) +
    /// Σ aᵢ sin(pᵢ + rᵢ T)
    ///
    /// log₁₀ R = (−0.007261 + 0.0000002 T) cos(356.53° + 359.991° T) + 0.000030 +
    /// Σ aᵢ cos(pᵢ + rᵢ T)
    ///
    /// Source: the short formula of the Hydrographic Department (today Japan Coast Guard), appendix
    /// of its almanac for astronomical surveying (天測暦), 1978–1980, argument ET; reprinted by
    /// K. Nagasawa, 天体の位置計算 (1981). Known from public transcriptions of these, checked
    /// against DE421.
    pub fn at(tt: Tt) -> Self {
        let date = tt.julian_date();
        let t = ((date.day - ORIGIN_JULIAN_DAY) + date.fraction) / DAYS_PER_JULIAN_YEAR;
        let nutation_deg: f64 = NUTATION.iter().map(|term| term.sine(t)).sum();
        Self {
            longitude_rad: wrap_0_to_tau(
                (mean_equinox_longitude_deg(t) + nutation_deg).to_radians(),
            ),
            distance_au: distance_au(t),
            true_obliquity_rad: true_obliquity_rad(t),
            nutation_in_longitude_rad: nutation_deg.to_radians(),
        }
    }

    /// The distance in metres.
    pub fn distance_m(&self) -> f64 {
        self.distance_au * ASTRONOMICAL_UNIT_M
    }

    /// The direction to the Sun in axes of the true equator and equinox of date.
    pub fn direction_true_of_date(&self) -> Direction<TrueOfDate, f64> {
        let (sin_longitude, cos_longitude) = libm::sincos(self.longitude_rad);
        let (sin_obliquity, cos_obliquity) = libm::sincos(self.true_obliquity_rad);
        Direction::from_unit(Vector::new(
            cos_longitude,
            sin_longitude * cos_obliquity,
            sin_longitude * sin_obliquity,
        ))
    }

    /// True minus mean equinox along the equator, rad: Δψ cos ε, at most 8.4e-5. The two terms of
    /// the nutation that the formula has give it within 0.5 arcsec.
    pub fn equation_of_equinoxes_rad(&self) -> f64 {
        self.nutation_in_longitude_rad * libm::cos(self.true_obliquity_rad)
    }

    /// The direction to the Sun.
    ///
    /// r_TEME = R₃(Δψ cos ε) r_TOD: [`Eci`] counts from the mean equinox.
    pub fn direction_eci(&self) -> Direction<Eci, f64> {
        let tod = self.direction_true_of_date().vector().xyz;
        let (s, c) = libm::sincos(self.equation_of_equinoxes_rad());
        Direction::from_unit(Vector::new(c * tod.x + s * tod.y, c * tod.y - s * tod.x, tod.z))
    }

    /// The Sun's centre from the Earth's, m.
    pub fn position_eci_m(&self) -> Vector<Eci, f64> {
        self.direction_eci().vector() * self.distance_m()
    }
}

/// Apparent longitude from the mean equinox of date.
fn mean_equinox_longitude_deg(t: f64) -> f64 {
    let [at_origin, per_year] = MEAN_LONGITUDE_DEG;
    let centre_amplitude = EQUATION_OF_CENTRE.amplitude + EQUATION_OF_CENTRE_DEG_PER_YEAR * t;
    let centre = centre_amplitude * libm::sin(EQUATION_OF_CENTRE.argument_rad(t));
    let others: f64 = LONGITUDE.iter().map(|term| term.sine(t)).sum();
    at_origin + per_year * t + centre + others
}

fn distance_au(t: f64) -> f64 {
    let amplitude =
        LOG10_DISTANCE_ECCENTRICITY.amplitude + LOG10_DISTANCE_ECCENTRICITY_PER_YEAR * t;
    let eccentricity = amplitude * libm::cos(LOG10_DISTANCE_ECCENTRICITY.argument_rad(t));
    let others: f64 = LOG10_DISTANCE_TERMS.iter().map(|term| term.cosine(t)).sum();
    libm::exp((eccentricity + LOG10_DISTANCE + others) * core::f64::consts::LN_10)
}

fn true_obliquity_rad(t: f64) -> f64 {
    let years_since_j2000 = t + ORIGIN_YEARS_SINCE_J2000;
    let [at_j2000, per_year] = MEAN_OBLIQUITY_DEG;
    let mean = at_j2000 + per_year * years_since_j2000;
    (mean + NUTATION_IN_OBLIQUITY.cosine(years_since_j2000)).to_radians()
}

fn wrap_0_to_tau(angle_rad: f64) -> f64 {
    use core::f64::consts::TAU;
    angle_rad - TAU * libm::floor(angle_rad / TAU)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::time::{LeapSeconds, Utc};

    fn sun(utc: &str) -> ApparentSun {
        ApparentSun::at(Utc::parse(utc).unwrap().to_tt(&LeapSeconds::BUILT_IN).unwrap())
    }

    #[test]
    fn the_sun_crosses_the_equator_northwards_at_the_equinox_of_march() {
        // 2015-03-20 22:45 UTC, published to the minute: 0.0007 deg; the formula adds 0.0022.
        const LONGITUDE_TOLERANCE_RAD: f64 = 0.003 * core::f64::consts::PI / 180.0;
        let at = sun("2015-03-20T22:45:00Z");
        let from_equinox = libm::remainder(at.longitude_rad, core::f64::consts::TAU);
        assert!(from_equinox.abs() < LONGITUDE_TOLERANCE_RAD, "{from_equinox} rad");
        let before = sun("2015-03-20T21:45:00Z").direction_eci().vector().xyz;
        let after = sun("2015-03-20T23:45:00Z").direction_eci().vector().xyz;
        assert!(before.z < 0.0 && after.z > 0.0);
    }

    #[test]
    fn the_earth_is_nearest_in_january() {
        // Perihelion 2026-01-03, 0.98330 au; aphelion 2026-07-06, 1.01664 au (to five digits).
        const DISTANCE_TOLERANCE_AU: f64 = 5e-5;
        let near = sun("2026-01-03T17:15:00Z").distance_au;
        let far = sun("2026-07-06T17:30:00Z").distance_au;
        assert!((near - 0.983_30).abs() < DISTANCE_TOLERANCE_AU, "{near} au");
        assert!((far - 1.016_64).abs() < DISTANCE_TOLERANCE_AU, "{far} au");
    }

    #[test]
    fn directions_are_of_unit_length_and_differ_by_the_equation_of_the_equinoxes() {
        const ROUNDING: f64 = 1e-15;
        for month in 1..=12_u8 {
            let utc = Utc::from_day(10_000 + 30 * i32::from(month), 0);
            let sun = ApparentSun::at(utc.to_tt(&LeapSeconds::BUILT_IN).unwrap());
            let (tod, eci) = (sun.direction_true_of_date().vector(), sun.direction_eci().vector());
            assert!((tod.norm() - 1.0).abs() < ROUNDING && (eci.norm() - 1.0).abs() < ROUNDING);
            let turned = libm::atan2(tod.xyz.y, tod.xyz.x) - libm::atan2(eci.xyz.y, eci.xyz.x);
            let turned = libm::remainder(turned, core::f64::consts::TAU);
            assert!((turned - sun.equation_of_equinoxes_rad()).abs() < ROUNDING);
        }
    }
}
