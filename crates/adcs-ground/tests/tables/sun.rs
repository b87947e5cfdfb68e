//! `adcs sun` against the JPL ephemeris DE421.

use std::collections::HashMap;

use crate::common::{Table, Worst, adcs, data, number};

/// The bars of the project.
const DIRECTION_BAR_DEG: f64 = 0.004;
const DISTANCE_BAR_AU: f64 = 5e-5;

fn vector(row: &HashMap<String, String>, columns: [&str; 3]) -> [f64; 3] {
    columns.map(|column| number(row, column))
}

fn angle_deg(a: [f64; 3], b: [f64; 3]) -> f64 {
    let half = a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt() / 2.0;
    2.0 * half.asin().to_degrees()
}

#[test]
fn direction_and_distance_agree_with_the_ephemeris() {
    let expected = Table::parse(&data("adcs-core/tests/data/sun_apparent_reference.csv"));
    let run = adcs(["sun", "-"], expected.with_columns(&["id", "utc_iso"]));
    assert_eq!((run.code, run.stderr.as_str()), (Some(0), ""));
    let found = run.table();
    assert_eq!(
        found.header.join(","),
        "id,utc_iso,sun_tod_x,sun_tod_y,sun_tod_z,sun_teme_x,sun_teme_y,sun_teme_z,distance_au,error"
    );
    assert_eq!(found.rows.len(), expected.rows.len());
    let mut tod = Worst::new("Sun, true of date, deg");
    let mut teme = Worst::new("Sun, TEME, deg");
    let mut distance = Worst::new("Sun, distance, au");
    for (found, expected) in found.rows.iter().zip(&expected.rows) {
        let at = &expected["utc_iso"];
        assert_eq!(&found["utc_iso"], at);
        let off = |columns| angle_deg(vector(found, columns), vector(expected, columns));
        tod.see(off(["sun_tod_x", "sun_tod_y", "sun_tod_z"]), at);
        teme.see(off(["sun_teme_x", "sun_teme_y", "sun_teme_z"]), at);
        distance.see((number(found, "distance_au") - number(expected, "distance_au")).abs(), at);
    }
    tod.report(DIRECTION_BAR_DEG);
    teme.report(DIRECTION_BAR_DEG);
    distance.report(DISTANCE_BAR_AU);
}
