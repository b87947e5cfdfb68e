//! `adcs field` against an evaluation of IGRF-14 with 40 digits.

use crate::common::{Run, Table, Worst, adcs, data, number};

/// The bars of the project.
const BAR_NT: f64 = 0.01;
const SINGLE_BAR_NT: f64 = 3.0;

const PLACE: [&str; 3] = ["geodetic_lat_deg", "lon_east_deg", "height_above_wgs84_km"];
const COMPONENTS: [&str; 3] = ["B_north_nT", "B_east_nT", "B_down_nT"];

fn reference() -> Table {
    Table::parse(&data("igrf/tests/data/igrf14_field_reference.csv"))
}

fn compare(run: &Run, expected: &Table, what: &'static str, bar_nt: f64) {
    assert_eq!((run.code, run.stderr.as_str()), (Some(0), ""));
    let mut worst = Worst::new(what);
    let found = run.table();
    assert_eq!(found.rows.len(), expected.rows.len());
    for (found, expected) in found.rows.iter().zip(&expected.rows) {
        let at = format!("row {}", expected["id"]);
        for column in COMPONENTS {
            worst.see((number(found, column) - number(expected, column)).abs(), &at);
        }
        let norm = COMPONENTS.map(|column| number(expected, column).powi(2)).iter().sum::<f64>();
        worst.see((number(found, "B_total_nT") - norm.sqrt()).abs(), &at);
        assert_eq!(found["error"], "");
    }
    worst.report(bar_nt);
}

#[test]
fn the_field_agrees_at_all_dates_poles_and_date_line_included() {
    let expected = reference();
    assert!(expected.rows.iter().any(|row| number(row, PLACE[0]).abs() == 90.0));
    assert!(expected.rows.iter().any(|row| number(row, PLACE[1]).abs() == 180.0));
    // In another order than in the documentation, with a column in front that is carried over.
    let input = expected.with_columns(&["id", PLACE[2], PLACE[0], "decimal_year", PLACE[1]]);
    compare(&adcs(["field", "-"], input.as_slice()), &expected, "field, nT", BAR_NT);
    let single = adcs(["field", "-", "--single"], input);
    compare(&single, &expected, "field in f32, nT", SINGLE_BAR_NT);
}

#[test]
fn calendar_dates_serve_as_well_as_decimal_years() {
    let expected = Table::parse(&data("igrf/tests/data/igrf14_calendar_dates.csv"));
    let input = expected.with_columns(&["id", "utc_iso", PLACE[0], PLACE[1], PLACE[2]]);
    compare(&adcs(["field", "-"], input), &expected, "field at calendar dates, nT", BAR_NT);
}

#[test]
fn with_both_dates_the_decimal_year_is_taken_and_that_is_said() {
    let input = "utc_iso,decimal_year,geodetic_lat_deg,lon_east_deg,height_above_wgs84_km\n\
                 1950-01-01T00:00:00Z,2020.5,10,20,500\n";
    let both = adcs(["field", "-"], input);
    assert!(both.stderr.contains("taken from decimal_year"), "{}", both.stderr);
    let only = adcs(["field", "-"], input.replace("utc_iso", "other"));
    assert_eq!(both.table().rows[0]["B_total_nT"], only.table().rows[0]["B_total_nT"]);
}

#[test]
fn the_reference_itself_may_be_the_input() {
    let expected = reference();
    let run = adcs(["field", "-"], data("igrf/tests/data/igrf14_field_reference.csv"));
    compare(&run, &expected, "field, nT", BAR_NT);
    // Its own columns are kept under other names.
    let found = run.table();
    for (found, expected) in found.rows.iter().zip(&expected.rows) {
        assert_eq!(found["input_B_north_nT"], expected["B_north_nT"]);
        assert_eq!(found["tag"], expected["tag"]);
    }
}

#[test]
fn degree_1_is_the_dipole_alone() {
    // IGRF-14 for 2020.0. At latitude 0, longitude 0 and r = 6371.2 km the dipole is -g10 to the
    // north, -h11 to the east, -2 g11 down.
    const EXPECTED_NT: [f64; 3] = [29_403.41, -4_653.35, 2.0 * 1_451.37];
    let run = adcs(
        ["field", "-", "--degree", "1"],
        "decimal_year,geodetic_lat_deg,lon_east_deg,height_above_wgs84_km\n2020,0,0,-6.937\n",
    );
    let row = &run.table().rows[0];
    for (column, expected_nt) in COMPONENTS.iter().zip(EXPECTED_NT) {
        assert!(
            (number(row, column) - expected_nt).abs() <= BAR_NT,
            "{column} is {}",
            row[*column]
        );
    }
    let wrong = adcs(["field", "-", "--degree", "14"], "");
    assert_eq!(wrong.code, Some(2));
    assert!(wrong.stderr.contains("1..=13"), "{}", wrong.stderr);
}

#[test]
fn dates_and_places_without_field_are_bad_rows() {
    let run = adcs(
        ["field", "-"],
        "decimal_year,geodetic_lat_deg,lon_east_deg,height_above_wgs84_km\n\
         1899.9,0,0,0\n2030.1,0,0,0\n2020,90.001,0,0\n2020,0,0,-3000\n2020,0,0,1e300\n2020,0,0,1\n",
    );
    assert_eq!(run.code, Some(1));
    let rows = run.table().rows;
    for (row, reason) in rows.iter().zip([
        "column decimal_year: decimal year 1899.9 is outside",
        "column decimal_year: decimal year 2030.1 is outside",
        "column geodetic_lat_deg: 90.001 is outside -90 to 90",
        "column height_above_wgs84_km: 3378.13",
        "column height_above_wgs84_km: ",
        "",
    ]) {
        assert!(row["error"].starts_with(reason), "{}", row["error"]);
        assert_eq!(row["B_total_nT"] == "nan", !reason.is_empty());
    }
}
