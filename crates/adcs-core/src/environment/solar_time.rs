//! What a sundial would show: local solar time of a place in space and of an orbit.
//!
//! All times are seconds after local midnight, 0 to 86,400: 43,200 when the Sun stands in the
//! meridian.

use core::f64::consts::{PI, TAU};

use super::earth::ecef_from_eci;
use crate::frames::{Direction, Eci, Vector};
use crate::orbit::OrbitState;
use crate::time::Utc;

const SECONDS_PER_DAY: f64 = 86_400.0;
const NOON_S: f64 = SECONDS_PER_DAY / 2.0;

/// Local mean solar time in the meridian of `place`: UTC and the east longitude as a time
/// (UT1 = UTC).
///
/// `None` on the Earth's axis, where all meridians meet.
pub fn mean_solar_time_s(now: Utc, place: Vector<Eci, f64>) -> Option<f64> {
    let place_e = ecef_from_eci(now) * place;
    let longitude_rad = angle_about_z_rad(place_e.to_array())?;
    let universal_s = now.julian_date().fraction * SECONDS_PER_DAY;
    Some(wrap_to_day_s(universal_s + longitude_rad / TAU * SECONDS_PER_DAY))
}

/// Local apparent solar time in the meridian of `place`: noon and the hour angle of the true Sun,
/// up to 16 min from mean time in the course of the year.
///
/// `None` on the Earth's axis.
pub fn apparent_solar_time_s(sun: Direction<Eci, f64>, place: Vector<Eci, f64>) -> Option<f64> {
    let sun_rad = angle_about_z_rad(sun.vector().to_array())?;
    let place_rad = angle_about_z_rad(place.to_array())?;
    Some(wrap_to_day_s(NOON_S + (place_rad - sun_rad) / TAU * SECONDS_PER_DAY))
}

/// Where the osculating orbit crosses the equator southwards: ĥ × ẑ.
///
/// `None` for an orbit in the equator, or without a plane.
pub fn descending_node(state: &OrbitState) -> Option<Direction<Eci, f64>> {
    let h = state.position.cross(&state.velocity).xyz;
    Direction::new(Vector::new(h.y, -h.x, 0.0))
}

/// Mean local time of the descending node (LTDN), by which Sun-synchronous orbits are named.
///
/// `None` for an orbit in the equator, or without a plane.
pub fn local_time_of_descending_node_s(now: Utc, state: &OrbitState) -> Option<f64> {
    mean_solar_time_s(now, descending_node(state)?.vector())
}

/// Angle from x towards y, −π to π; `None` on the axis and for NaN.
fn angle_about_z_rad([x, y, _]: [f64; 3]) -> Option<f64> {
    let angle_rad = libm::atan2(y, x);
    let off_axis = x != 0.0 || y != 0.0;
    (off_axis && (-PI..=PI).contains(&angle_rad)).then_some(angle_rad)
}

fn wrap_to_day_s(seconds: f64) -> f64 {
    let wrapped = seconds - SECONDS_PER_DAY * libm::floor(seconds / SECONDS_PER_DAY);
    // The remainder of a tiny negative number rounds up to the whole day.
    if wrapped < SECONDS_PER_DAY { wrapped } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::environment::earth::EcefState;
    use crate::environment::geodetic::Geodetic;
    use crate::environment::sun::ApparentSun;
    use crate::orbit::OrbitModel;
    use crate::time::LeapSeconds;
    use sgp4_lite::Elements;

    const SECONDS_PER_HOUR: f64 = 3_600.0;

    fn place(now: Utc, latitude_deg: f64, longitude_deg: f64) -> Vector<Eci, f64> {
        let place = Geodetic {
            latitude_rad: latitude_deg.to_radians(),
            longitude_east_rad: longitude_deg.to_radians(),
            height_m: 0.0,
        };
        let still = EcefState { position: place.position(), velocity: Vector::zero() };
        still.to_eci(ecef_from_eci(now)).position
    }

    #[test]
    fn mean_time_in_greenwich_is_utc_and_an_hour_later_for_each_15_degrees_east() {
        /// One microsecond, far below what UT1 − UTC is.
        const TOLERANCE_S: f64 = 1e-6;
        let now = Utc::parse("2026-11-21T22:30:00Z").unwrap();
        for (longitude_deg, hours) in [(0.0, 22.5), (15.0, 23.5), (30.0, 0.5), (-120.0, 14.5)] {
            let time_s = mean_solar_time_s(now, place(now, 40.0, longitude_deg)).unwrap();
            assert!((time_s - hours * SECONDS_PER_HOUR).abs() < TOLERANCE_S, "{longitude_deg}");
        }
    }

    #[test]
    fn the_equation_of_time_is_plus_16_4_min_in_early_november_and_minus_14_2_in_mid_february() {
        /// The values are printed in almanacs to a tenth of a minute.
        const TOLERANCE_S: f64 = 6.0;
        for (utc, minutes) in [("2015-11-03T12:00:00Z", 16.4), ("2015-02-11T12:00:00Z", -14.2)] {
            let now = Utc::parse(utc).unwrap();
            let sun = ApparentSun::at(now.to_tt(&LeapSeconds::BUILT_IN).unwrap()).direction_eci();
            let greenwich = place(now, 51.5, 0.0);
            let apparent_s = apparent_solar_time_s(sun, greenwich).unwrap();
            let difference_s = apparent_s - mean_solar_time_s(now, greenwich).unwrap();
            assert!((difference_s - 60.0 * minutes).abs() < TOLERANCE_S, "{difference_s} s");
        }
    }

    #[test]
    fn sprout_crosses_the_equator_southwards_at_noon() {
        /// The published figures have two decimals; the mean elements they are made from differ
        /// from the osculating ones by up to 0.02 deg of the node.
        const TOLERANCE_H: f64 = 0.0065;
        let ltdn_h = |line1: &str, line2: &str| {
            let model = OrbitModel::new(&Elements::from_tle(line1, line2).unwrap()).unwrap();
            let state = model.state(model.epoch()).unwrap();
            local_time_of_descending_node_s(model.epoch(), &state).unwrap() / SECONDS_PER_HOUR
        };
        let cases = [
            (
                "1 39770U 14029E   15086.04060623  .00002013  00000-0  25056-3 0  9990",
                "2 39770  97.8670 184.0112 0011259 108.3774 251.8661 14.83565425 45450",
                11.99,
            ),
            (
                "1 39770U 14029E   15323.12177538  .00004189  00000-0  50368-3 0  9997",
                "2 39770  97.8736  57.8959 0010514  58.6984 301.5230 14.84437654 80617",
                12.00,
            ),
            (
                "1 39770U 14029E   16353.17081411  .00000713  00000-0  88021-4 0  9997",
                "2 39770  97.8734  88.4127 0008941 193.2274 166.8716 14.85873706139250",
                12.08,
            ),
        ];
        for (line1, line2, expected_h) in cases {
            let found_h = ltdn_h(line1, line2);
            assert!((found_h - expected_h).abs() < TOLERANCE_H, "{found_h} h");
        }
    }

    #[test]
    fn on_the_axis_and_in_the_equator_there_is_no_local_time() {
        let now = Utc::parse("2026-11-21T22:30:00Z").unwrap();
        assert!(mean_solar_time_s(now, Vector::new(0.0, 0.0, 7e6)).is_none());
        assert!(mean_solar_time_s(now, Vector::new(f64::NAN, 0.0, 7e6)).is_none());
        let equatorial = OrbitState {
            position: Vector::new(7e6, 0.0, 0.0),
            velocity: Vector::new(0.0, 7.5e3, 0.0),
        };
        assert!(local_time_of_descending_node_s(now, &equatorial).is_none());
    }
}
