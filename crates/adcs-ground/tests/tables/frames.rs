//! `adcs frames` against states with measured UT1, among them the example of AIAA 2006-6753.

use crate::common::{Table, Worst, adcs, data, number};

/// The bars of the project.
const GMST_BAR_RAD: f64 = 1e-11;
const POSITION_BAR_KM: f64 = 1e-6;
const VELOCITY_BAR_KM_S: f64 = 1e-9;
const LONGITUDE_BAR_DEG: f64 = 1e-9;
/// As in the tests of `adcs-core`: one latitude of the reference is itself 1.3e-9 deg off.
const LATITUDE_BAR_DEG: f64 = 2e-9;
/// `utc_iso` is written to the microsecond: 7.3e-11 rad of Earth rotation, half of it by rounding.
const GMST_FROM_UTC_BAR_RAD: f64 = 5e-11;

const POSITION: [&str; 3] = ["teme_x_km", "teme_y_km", "teme_z_km"];
const VELOCITY: [&str; 3] = ["teme_vx_km_s", "teme_vy_km_s", "teme_vz_km_s"];

fn reference() -> Table {
    Table::parse(&data("adcs-core/tests/data/teme_pef_itrf.csv"))
}

/// Time columns, then position and velocity.
fn columns(time: &[&'static str]) -> Vec<&'static str> {
    ["id"].iter().chain(time).chain(&POSITION).chain(&VELOCITY).copied().collect()
}

#[test]
fn states_become_earth_fixed_and_geodetic() {
    let expected = reference();
    let input = expected.with_columns(&columns(&["ut1_jd_fraction", "ut1_jd_day"]));
    let run = adcs(["frames", "-"], input);
    assert_eq!((run.code, run.stderr.as_str()), (Some(0), ""));
    let found = run.table();
    assert_eq!(found.rows.len(), expected.rows.len());
    let mut gmst = Worst::new("GMST-82, rad");
    let mut position = Worst::new("PEF position, km");
    let mut velocity = Worst::new("PEF velocity, km/s");
    let mut latitude = Worst::new("latitude, deg");
    let mut longitude = Worst::new("longitude, deg");
    let mut height = Worst::new("height, km");
    for (found, expected) in found.rows.iter().zip(&expected.rows) {
        let at = format!("row {}", expected["id"]);
        let off = |name: &str, expected_name: &str| {
            (number(found, name) - number(expected, expected_name)).abs()
        };
        gmst.see(off("gmst82_rad", "gmst82_rad"), &at);
        for column in ["pef_x_km", "pef_y_km", "pef_z_km"] {
            position.see(off(column, column), &at);
        }
        for column in ["pef_vx_km_s", "pef_vy_km_s", "pef_vz_km_s"] {
            velocity.see(off(column, column), &at);
        }
        latitude.see(off("geodetic_lat_deg", "pef_geodetic_lat_deg"), &at);
        longitude.see(off("lon_east_deg", "pef_lon_east_deg"), &at);
        height.see(off("height_wgs84_km", "pef_height_wgs84_km"), &at);
    }
    gmst.report(GMST_BAR_RAD);
    position.report(POSITION_BAR_KM);
    velocity.report(VELOCITY_BAR_KM_S);
    latitude.report(LATITUDE_BAR_DEG);
    longitude.report(LONGITUDE_BAR_DEG);
    height.report(POSITION_BAR_KM);
}

#[test]
fn utc_stands_for_ut1_where_nothing_better_is_known() {
    let mut expected = reference();
    expected.rows.retain(|row| row["tag"] == "dut1_zero");
    assert!(expected.rows.len() > 50);
    let run = adcs(["frames", "-"], expected.with_columns(&columns(&["utc_iso"])));
    assert_eq!((run.code, run.stderr.as_str()), (Some(0), ""));
    let mut gmst = Worst::new("GMST-82 from utc_iso, rad");
    for (found, expected) in run.table().rows.iter().zip(&expected.rows) {
        let off = number(found, "gmst82_rad") - number(expected, "gmst82_rad");
        gmst.see(off.abs(), &expected["id"]);
    }
    gmst.report(GMST_FROM_UTC_BAR_RAD);
}

#[test]
fn with_both_times_ut1_is_taken_and_that_is_said() {
    let expected = reference();
    let run = adcs(["frames", "-"], data("adcs-core/tests/data/teme_pef_itrf.csv"));
    assert!(run.stderr.contains("taken from ut1_jd_day"), "{}", run.stderr);
    for (found, expected) in run.table().rows.iter().zip(&expected.rows) {
        let off = number(found, "gmst82_rad") - number(expected, "gmst82_rad");
        assert!(off.abs() <= GMST_BAR_RAD);
        assert_eq!(found["input_gmst82_rad"], expected["gmst82_rad"]);
    }
}

#[test]
fn half_a_julian_date_is_a_missing_column_or_none_at_all() {
    let all = reference();
    let half = adcs(["frames", "-"], all.with_columns(&columns(&["ut1_jd_day"])));
    assert_eq!(half.code, Some(2));
    assert!(half.stderr.contains("no column ut1_jd_fraction"), "{}", half.stderr);
    let with_utc = adcs(["frames", "-"], all.with_columns(&columns(&["ut1_jd_day", "utc_iso"])));
    assert_eq!(with_utc.code, Some(0));
    assert!(with_utc.stderr.contains("taken from utc_iso"), "{}", with_utc.stderr);
}

#[test]
fn what_propagate_writes_is_what_frames_reads() {
    let tle = "1 39770U 14029E   15086.04060623  .00002013  00000-0  25056-3 0  9990\n\
               2 39770  97.8670 184.0112 0011259 108.3774 251.8661 14.83565425 45450\n";
    let span = ["--from", "2015-03-27T02:00:00Z", "--to", "2015-03-27T04:00:00Z", "--step", "600"];
    let states = adcs(["propagate", "--tle", "-"].iter().chain(&span), tle);
    let places = adcs(["frames", "-"], states.stdout);
    assert_eq!((places.code, places.stderr.as_str()), (Some(0), ""));
    for row in &places.table().rows {
        let height_km = number(row, "height_wgs84_km");
        assert!((600.0..660.0).contains(&height_km), "{height_km}");
        assert!(number(row, "geodetic_lat_deg").abs() < 83.0);
    }
}

#[test]
fn positions_without_latitude_and_dates_without_sense_are_bad_rows() {
    let header = columns(&["ut1_jd_day", "ut1_jd_fraction"]).join(",");
    let input = format!(
        "{header}\n0,2453101.5,0.3,0,0,10,1,2,3\n1,2453101.5,1e9,7000,0,0,1,2,3\n\
         2,-1,0,7000,0,0,1,2,3\n3,2453101.5,0.3,1e308,1e308,0,0,0,0\n\
         4,2453101.5,0.3,7000,0,0,1e306,0,0\n5,2453101.5,0.3,7000,0,0,0,7,0\n"
    );
    let run = adcs(["frames", "-"], input);
    assert_eq!(run.code, Some(1));
    for (row, reason) in run.table().rows.iter().zip([
        "column teme_x_km: ",
        "column ut1_jd_day: ",
        "column ut1_jd_day: ",
        "column teme_x_km: ",
        "the result is too large",
        "",
    ]) {
        assert!(row["error"].starts_with(reason), "{}: {}", row["id"], row["error"]);
        assert_eq!(row["gmst82_rad"] == "nan", !reason.is_empty());
    }
}
