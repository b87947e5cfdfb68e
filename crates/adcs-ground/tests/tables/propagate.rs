//! `adcs propagate` against the verification set of AIAA 2006-6753 and two synthetic sets.

use std::collections::HashMap;
use std::fs;

use crate::common::{Run, Table, Worst, adcs, data, folder, number};

/// The bars of the project for deep-space orbits; near Earth it is a hundredth of them.
const DEEP_SPACE_BAR_KM: f64 = 1e-4;
const DEEP_SPACE_BAR_KM_S: f64 = 1e-7;
const NEAR_EARTH_BAR_KM: f64 = 1e-6;
const NEAR_EARTH_BAR_KM_S: f64 = 1e-9;

/// What `sgp4-lite/tests/data` has of one set of satellites.
struct Set {
    tle: &'static str,
    expected: &'static str,
    /// Before the names of the state columns.
    prefix: &'static str,
}

const VALLADO: Set =
    Set { tle: "vallado_tle.csv", expected: "vallado_expected.csv", prefix: "python_sgp4_2_27_" };
const LEO: Set = Set { tle: "sample_leo_tle.csv", expected: "sample_leo_expected.csv", prefix: "" };
const DEEP: Set =
    Set { tle: "sample_deep_tle.csv", expected: "sample_deep_expected.csv", prefix: "" };

fn reference(name: &str) -> Table {
    Table::parse(&data(&format!("sgp4-lite/tests/data/{name}")))
}

fn satellites(set: &Set) -> HashMap<String, HashMap<String, String>> {
    reference(set.tle).rows.into_iter().map(|row| (row["id"].clone(), row)).collect()
}

/// The input table for all rows of a set.
fn input(set: &Set) -> Vec<u8> {
    let satellites = satellites(set);
    let mut table = reference(set.expected);
    for row in &mut table.rows {
        let satellite = &satellites[&row["id"]];
        for line in ["line1", "line2"] {
            row.insert(line.to_owned(), satellite[line].clone());
        }
    }
    table.with_columns(&["id", "line1", "line2", "tsince_min"])
}

/// Compares every row; those of satellites in `refused` must have the error code of a wrong TLE.
fn compare(set: &Set, run: &Run, refused: &[&str]) -> (usize, usize) {
    let mut near = [Worst::new("near Earth, km"), Worst::new("near Earth, km/s")];
    let mut deep = [Worst::new("deep space, km"), Worst::new("deep space, km/s")];
    let satellites = satellites(set);
    let (found, expected) = (run.table(), reference(set.expected));
    assert_eq!(found.rows.len(), expected.rows.len());
    let (mut states, mut errors) = (0, 0);
    for (found, expected) in found.rows.iter().zip(&expected.rows) {
        let at = format!("{} at {} min", expected["id"], expected["tsince_min"]);
        assert_eq!(found["id"], expected["id"]);
        assert_eq!(found["tsince_min"], expected["tsince_min"], "inputs are carried as they stand");
        let satellite = &satellites[&expected["id"]];
        let is_refused = satellite.get("satnum").is_some_and(|number| refused.contains(&&**number));
        let code = if is_refused { "11" } else { &expected["sgp4_error_code"] };
        assert_eq!(found["error"], code, "{at}: {}", found["message"]);
        let columns = ["x_teme_km", "y_teme_km", "z_teme_km"];
        let velocity_columns = ["vx_teme_km_s", "vy_teme_km_s", "vz_teme_km_s"];
        if code != "0" {
            errors += 1;
            assert!(!found["message"].is_empty());
            assert!(columns.iter().chain(&velocity_columns).all(|column| found[*column] == "nan"));
            continue;
        }
        states += 1;
        assert!(found["message"].is_empty());
        let off = |columns: [&str; 3]| {
            let square = |column: &str| {
                let expected = number(expected, &format!("{}{column}", set.prefix));
                (number(found, column) - expected).powi(2)
            };
            columns.into_iter().map(square).sum::<f64>().sqrt()
        };
        let is_deep = satellite["method_n_near_d_deep"] == "d";
        let [position, velocity] = if is_deep { &mut deep } else { &mut near };
        position.see(off(columns), &at);
        velocity.see(off(velocity_columns), &at);
    }
    near[0].report(NEAR_EARTH_BAR_KM);
    near[1].report(NEAR_EARTH_BAR_KM_S);
    deep[0].report(DEEP_SPACE_BAR_KM);
    deep[1].report(DEEP_SPACE_BAR_KM_S);
    (states, errors)
}

#[test]
fn the_verification_set_is_reproduced_with_its_error_codes() {
    let run = adcs(["propagate", "-", "--lenient"], input(&VALLADO));
    assert_eq!(compare(&VALLADO, &run, &[]), (666, 8));
    assert_eq!(run.code, Some(1), "rows with an SGP4 error have no result");
    assert!(run.stderr.contains("standard input, line 226: mean eccentricity out of range"));
    assert!(run.stderr.contains("8 of 674 rows have no result"), "{}", run.stderr);
}

#[test]
fn wrong_checksums_cost_their_own_rows_only() {
    let run = adcs(["propagate", "-"], input(&VALLADO));
    let (states, errors) = compare(&VALLADO, &run, &["33333", "33334", "33335"]);
    assert_eq!(states + errors, 674);
    assert_eq!(run.code, Some(1));
    assert!(run.stderr.contains("column line1: TLE line 1, column 69: the checksum"));
}

#[test]
fn the_synthetic_sets_are_reproduced() {
    let run = adcs(["propagate", "-"], input(&LEO));
    assert_eq!((compare(&LEO, &run, &[]), run.code), ((238, 2), Some(1)));
    let run = adcs(["propagate", "-"], input(&DEEP));
    assert_eq!((compare(&DEEP, &run, &[]), run.code), ((180, 0), Some(0)));
    assert_eq!(run.stderr, "");
}

#[test]
fn the_columns_of_the_output_are_the_documented_ones() {
    let run = adcs(["propagate", "-"], input(&DEEP));
    let first = run.stdout.split(|&byte| byte == b'\n').next().unwrap();
    assert_eq!(
        str::from_utf8(first),
        Ok("id,tsince_min,error,x_teme_km,y_teme_km,z_teme_km,vx_teme_km_s,vy_teme_km_s,\
            vz_teme_km_s,message")
    );
}

#[test]
fn the_order_of_rows_and_columns_does_not_matter() {
    // Satellites mixed and times backwards, so that nothing can be resumed.
    let mut table = Table::parse(&input(&DEEP));
    table.rows.reverse();
    table.rows.sort_by_key(|row| row["tsince_min"].len());
    let mixed =
        adcs(["propagate", "-"], table.with_columns(&["tsince_min", "line2", "id", "line1"]));
    let state = |row: &HashMap<String, String>| {
        (row["id"].clone(), row["tsince_min"].clone(), row["x_teme_km"].clone())
    };
    let sorted = |run: &Run| {
        let mut states: Vec<_> = run.table().rows.iter().map(state).collect();
        states.sort();
        states
    };
    assert_eq!(sorted(&mixed), sorted(&adcs(["propagate", "-"], input(&DEEP))));
}

#[test]
fn states_along_one_orbit_are_those_of_the_table() {
    let folder = folder("along_one_orbit");
    let satellites = satellites(&VALLADO);
    let satellite = satellites.values().find(|row| row["satnum"] == "6251").unwrap();
    let file = folder.join("6251.tle");
    fs::write(
        &file,
        format!("DELTA 1 DEB\r\n{}\r\n{}\r\n", satellite["line1"], satellite["line2"]),
    )
    .unwrap();
    let along = adcs(
        [
            "propagate",
            "--tle",
            file.to_str().unwrap(),
            "--from",
            "2006-06-25T20:00:00Z",
            "--to",
            "2006-06-25T20:10:00.5Z",
            "--step",
            "120.25",
        ],
        "",
    );
    assert_eq!((along.code, along.stderr.as_str()), (Some(0), ""));
    let along = along.table();
    let stamps: Vec<_> = along.rows.iter().map(|row| row["utc_iso"].as_str()).collect();
    assert_eq!(stamps.len(), 5);
    assert_eq!(stamps[1], "2006-06-25T20:02:00.250000Z");
    // The epoch is 2006-06-25 and 0.82412014 d = 19:46:43.980096 UTC.
    let minutes = number(&along.rows[1], "tsince_min");
    assert!((minutes - (15.0 + 16.269_904 / 60.0)).abs() < 1e-9, "{minutes}");

    let mut table = String::from("line1,line2,tsince_min\n");
    for row in &along.rows {
        table += &format!("{},{},{}\n", satellite["line1"], satellite["line2"], row["tsince_min"]);
    }
    let by_table = adcs(["propagate", "-"], table).table();
    for (a, b) in along.rows.iter().zip(&by_table.rows) {
        for column in ["error", "x_teme_km", "vz_teme_km_s"] {
            assert_eq!(a[column], b[column]);
        }
    }
}

#[test]
fn an_orbit_that_decays_has_error_rows_from_then_on() {
    let folder = folder("decays");
    let satellites = satellites(&VALLADO);
    let satellite = satellites.values().find(|row| row["satnum"] == "28872").unwrap();
    let file = folder.join("28872.tle");
    fs::write(&file, format!("{}\n{}\n", satellite["line1"], satellite["line2"])).unwrap();
    let span = ["--from", "2005-11-29T00:30:00Z", "--to", "2005-11-29T01:30:00Z", "--step", "300"];
    let run = adcs(["propagate", "--tle", file.to_str().unwrap()].iter().chain(&span), "");
    assert_eq!(run.code, Some(1));
    let codes: Vec<_> = run.table().rows.iter().map(|row| row["error"].clone()).collect();
    assert_eq!(codes.first().map(String::as_str), Some("0"), "{codes:?}");
    assert_eq!(codes.last().map(String::as_str), Some("6"), "{codes:?}");
    assert!(run.stderr.contains("decayed"), "{}", run.stderr);
}
