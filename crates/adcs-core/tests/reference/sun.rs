//! The Sun against the JPL ephemeris DE421, 2000 to 2050 (see `tests/data/README.md`).

use crate::table::{Table, Worst};
use adcs_core::environment::sun::ApparentSun;
use adcs_core::time::{LeapSeconds, Utc};
use nalgebra::Vector3;

const REFERENCE: &str = include_str!("../data/sun_apparent_reference.csv");

/// The bars of the project for this formula; its own worst error over 2000–2050 is 0.0021 deg.
const LONGITUDE_BAR_DEG: f64 = 0.0025;
const TRUE_OF_DATE_BAR_DEG: f64 = 0.0025;
const TEME_BAR_DEG: f64 = 0.004;
const DISTANCE_BAR_AU: f64 = 5e-5;

fn angle_deg(a: &Vector3<f64>, b: &Vector3<f64>) -> f64 {
    libm::atan2(a.cross(b).norm(), a.dot(b)).to_degrees()
}

#[test]
fn the_sun_stands_where_the_ephemeris_has_it() {
    let mut longitude = Worst::new("Sun longitude, deg");
    let mut true_of_date = Worst::new("Sun direction, true of date, deg");
    let mut teme = Worst::new("Sun direction, TEME, deg");
    let mut distance = Worst::new("Sun distance, au");
    for row in Table::parse(REFERENCE).rows() {
        let at = row.text("utc_iso");
        let utc = Utc::parse(at).unwrap();
        let sun = ApparentSun::at(utc.to_tt(&LeapSeconds::BUILT_IN).unwrap());

        let reference_tod = row.vector(["sun_tod_x", "sun_tod_y", "sun_tod_z"]);
        let (sin, cos) = libm::sincos(sun.true_obliquity_rad);
        let along_ecliptic = reference_tod.y * cos + reference_tod.z * sin;
        let reference_longitude = libm::atan2(along_ecliptic, reference_tod.x);
        let error =
            libm::remainder(sun.longitude_rad - reference_longitude, core::f64::consts::TAU);
        longitude.see(error.abs().to_degrees(), at);

        let tod = sun.direction_true_of_date().vector().xyz;
        true_of_date.see(angle_deg(&tod, &reference_tod), at);
        let reference_teme = row.vector(["sun_teme_x", "sun_teme_y", "sun_teme_z"]);
        teme.see(angle_deg(&sun.direction_eci().vector().xyz, &reference_teme), at);
        distance.see((sun.distance_au - row.number("distance_au")).abs(), at);
    }
    longitude.report(LONGITUDE_BAR_DEG);
    true_of_date.report(TRUE_OF_DATE_BAR_DEG);
    teme.report(TEME_BAR_DEG);
    distance.report(DISTANCE_BAR_AU);
}
