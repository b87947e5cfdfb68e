//! Shadow entries and exits of a satellite against independent propagation and the JPL Sun.

use adcs_core::environment::crossings::{CrossingKind, Crossings, SHADOW_STEP_S};
use adcs_core::environment::eclipse::{EarthShape, Shadow, shadow_margin_rad};
use adcs_core::environment::sun::ApparentSun;
use adcs_core::orbit::OrbitModel;
use adcs_core::time::{LeapSeconds, Utc};
use serde_json::Value;
use sgp4_lite::Elements;

use crate::table::{Row, Table, Worst};

const CASES: &str = include_str!("../data/eclipse_cases.json");
const EXPECTED: &str = include_str!("../data/eclipse_expected.csv");

/// The bar of the project.
const INSTANT_BAR_S: f64 = 1.0;
/// The Sun by two models: 0.003 deg at 0.024 s for 0.01 deg; the direction of aberration 20 arcsec.
const MODEL_BAR_S: f64 = 0.05;

const SHADOWS: [(&str, Shadow); 3] =
    [("penumbra", Shadow::Penumbra), ("cylinder", Shadow::Cylinder), ("umbra", Shadow::Umbra)];

struct Case {
    id: String,
    orbit: OrbitModel,
    start: Utc,
    duration_s: f64,
}

fn cases() -> Vec<Case> {
    let file: Value = serde_json::from_str(CASES).unwrap();
    let cases = file["cases"].as_array().unwrap().iter().map(|case| {
        let text = |key: &str| case[key].as_str().unwrap();
        let elements = Elements::from_tle(text("tle_line1"), text("tle_line2")).unwrap();
        Case {
            id: text("id").to_owned(),
            orbit: OrbitModel::new(&elements).unwrap(),
            start: Utc::parse(text("start_utc")).unwrap(),
            duration_s: case["duration_s"].as_f64().unwrap(),
        }
    });
    cases.collect()
}

impl Case {
    fn events(&self, shadow: Shadow, shape: EarthShape) -> Vec<(CrossingKind, f64)> {
        let margin = |seconds: f64| {
            let now = self.start.plus_micros((seconds * 1e6) as i64);
            let satellite = self.orbit.state(now)?.position;
            let sun = ApparentSun::at(now.to_tt(&LeapSeconds::BUILT_IN).unwrap());
            Ok::<f64, sgp4_lite::Error>(shadow_margin_rad(
                shadow,
                satellite,
                sun.position_eci_m(),
                shape,
            ))
        };
        let crossings = Crossings::new(margin, self.duration_s, SHADOW_STEP_S).unwrap();
        crossings.map(Result::unwrap).map(|crossing| (crossing.kind, crossing.seconds)).collect()
    }
}

fn expected_kind(row: &Row<'_>) -> CrossingKind {
    match row.text("event") {
        "entry" => CrossingKind::Entry,
        "exit" => CrossingKind::Exit,
        other => panic!("unknown event {other}"),
    }
}

#[test]
fn entries_and_exits_come_when_they_are_expected() {
    let table = Table::parse(EXPECTED);
    let mut instant = Worst::new("shadow entries and exits, s");
    let mut seen = 0;
    for case in cases() {
        for (name, shadow) in SHADOWS {
            let of_this =
                |row: &Row<'_>| row.text("id") == case.id && row.text("shadow_model") == name;
            let rows: Vec<_> = table.rows().filter(of_this).collect();
            let events = case.events(shadow, EarthShape::Sphere);
            assert_eq!(events.len(), rows.len(), "{} {name}", case.id);
            for ((kind, seconds), row) in events.iter().zip(&rows) {
                assert_eq!(*kind, expected_kind(row));
                let at = format!("{} {name} {}", case.id, row.text("utc_iso_nearest_s"));
                instant.see((seconds - row.number("t_after_start_s")).abs(), &at);
                seen += 1;
            }
        }
    }
    assert_eq!(seen, table.rows().count());
    instant.report(MODEL_BAR_S.min(INSTANT_BAR_S));
}

#[test]
fn the_flattening_of_the_earth_shortens_the_eclipse_by_some_seconds() {
    let mut shorter = Worst::new("an entry or exit moved by the Earth's flattening, s");
    for case in cases() {
        for (name, shadow) in SHADOWS {
            let sphere = case.events(shadow, EarthShape::Sphere);
            let ellipsoid = case.events(shadow, EarthShape::Ellipsoid);
            assert_eq!(sphere.len(), ellipsoid.len());
            for ((kind, sphere_s), (_, ellipsoid_s)) in sphere.iter().zip(&ellipsoid) {
                let shorter_s = match kind {
                    CrossingKind::Entry => ellipsoid_s - sphere_s,
                    CrossingKind::Exit => sphere_s - ellipsoid_s,
                };
                assert!(shorter_s > 0.0);
                shorter.see(shorter_s, &format!("{} {name}", case.id));
            }
        }
    }
    // 21.4 km at the poles, through which this orbit's shadow is entered at 2.7 km/s.
    shorter.report(8.0);
}
