//! `adcs tle check`.

use serde_json::Value;

use crate::common::{Run, Table, adcs, data};

const LINE1: &str = "1 39770U 14029E   15086.04060623  .00002013  00000-0  25056-3 0  9990";
const LINE2: &str = "2 39770  97.8670 184.0112 0011259 108.3774 251.8661 14.83565425 45450";

fn check(text: impl Into<Vec<u8>>) -> Run {
    adcs(["tle", "check", "-"], text)
}

fn check_json(text: impl Into<Vec<u8>>) -> (Run, Value) {
    let run = adcs(["tle", "check", "-", "--json"], text);
    let json = serde_json::from_slice(&run.stdout).expect("JSON on standard output");
    (run, json)
}

#[test]
fn the_elements_have_the_values_that_were_written() {
    for name in ["sample_leo_tle.csv", "sample_deep_tle.csv"] {
        for row in &Table::parse(&data(&format!("sgp4-lite/tests/data/{name}"))).rows {
            let (run, json) = check_json(format!("{}\n{}\n", row["line1"], row["line2"]));
            assert_eq!(run.code, Some(0));
            assert_eq!(json["valid"], true);
            for (field, column) in [
                ("norad_id", "satnum"),
                ("mean_motion_dot_over_2_rev_per_day2", "ndot_over2_rev_per_day2"),
                ("mean_motion_ddot_over_6_rev_per_day3", "nddot_over6_rev_per_day3"),
                ("bstar_per_earth_radius", "bstar_per_earth_radius"),
                ("element_set_number", "elset"),
                ("inclination_deg", "inclination_deg"),
                ("raan_deg", "raan_deg"),
                ("eccentricity", "eccentricity"),
                ("argument_of_perigee_deg", "arg_perigee_deg"),
                ("mean_anomaly_deg", "mean_anomaly_deg"),
                ("mean_motion_rev_per_day", "mean_motion_rev_per_day"),
                ("revolution_number", "rev_number"),
            ] {
                let expected: f64 = row[column].parse().unwrap();
                assert_eq!(json[field].as_f64(), Some(expected), "{field} of {}", row["id"]);
            }
        }
    }
}

#[test]
fn every_sound_record_of_the_verification_set_passes_and_no_other() {
    let table = Table::parse(&data("sgp4-lite/tests/data/vallado_tle.csv"));
    for row in &table.rows {
        let sound = row["line1_checksum_ok"] == "1" && row["line2_checksum_ok"] == "1";
        let run = check(format!("{}\r\n{}\r\n", row["line1"], row["line2"]));
        assert_eq!(run.code, Some(if sound { 0 } else { 1 }), "{}: {}", row["satnum"], run.stderr);
    }
}

#[test]
fn a_person_sees_names_values_and_units() {
    let run = check(format!("SPROUT\n{LINE1}\n{LINE2}\n"));
    let text = String::from_utf8(run.stdout).unwrap();
    for expected in
        ["SPROUT", "39770", "14029E", "2015-03-27T00:58:28.378272Z", "97.867 deg", "97.063 min"]
    {
        assert!(text.contains(expected), "{expected} is not in\n{text}");
    }
    assert_eq!(run.stderr, "");
}

#[test]
fn what_is_wrong_is_shown_in_its_column() {
    let run = check(format!("{LINE1}\n{}\n", LINE2.replace("97.8670", "97,8670")));
    assert_eq!(run.code, Some(1));
    assert_eq!(run.stdout, b"");
    assert_eq!(
        run.stderr,
        "standard input: line 2, column 12: expected a decimal point, found ','\n  \
         2 39770  97,8670 184.0112 0011259 108.3774 251.8661 14.83565425 45450\n             ^\n"
    );
    let (run, json) = check_json(format!("{LINE1}\n{}\n", LINE2.replace("97.8670", "98.8670")));
    assert_eq!(run.code, Some(1));
    assert_eq!(json["valid"], false);
    assert_eq!((&json["line"], &json["first_column"]), (&2.into(), &69.into()));
    assert!(json["message"].as_str().unwrap().contains("checksum is 0, but the line sums up to 1"));
}

#[test]
fn an_orbit_without_a_state_is_warned_about() {
    // Satellite 33334 of the verification set, checksum corrected: SGP4 fails at its epoch.
    let table = Table::parse(&data("sgp4-lite/tests/data/vallado_tle.csv"));
    let row = table.rows.iter().find(|row| row["satnum"] == "33334").unwrap();
    let line1 = corrected(&row["line1"]);
    let (run, json) = check_json(format!("{line1}\n{}\n", row["line2"]));
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    assert!(run.stderr.contains("warning: SGP4 has no state at the epoch"), "{}", run.stderr);
    assert!(!json["warnings"].as_array().unwrap().is_empty());
}

#[test]
fn age_and_orbit_are_checked_for_a_time_of_use() {
    // The epoch is 2015-03-27T00:58:28.
    let text = format!("{LINE1}\n{LINE2}\n");
    let at = |now: &str, days: &str| {
        adcs(["tle", "check", "-", "--json", "--now", now, "--max-days", days], text.as_str())
    };
    let fresh = at("2015-03-28T12:58:28.378272Z", "7");
    assert_eq!((fresh.code, fresh.stderr.as_str()), (Some(0), ""));
    let json: Value = serde_json::from_slice(&fresh.stdout).unwrap();
    assert!((json["age_days"].as_f64().unwrap() - 1.5).abs() < 1e-9);
    for (now, days) in [("2015-04-10T00:00:00Z", "7"), ("2015-03-01T00:00:00Z", "7")] {
        let old = at(now, days);
        assert_eq!(old.code, Some(1));
        assert!(old.stderr.contains("not for this use: the epoch is"), "{}", old.stderr);
        let json: Value = serde_json::from_slice(&old.stdout).unwrap();
        assert_eq!(json["valid"], true, "it is written without fault");
        assert!(json["implausible"].as_str().unwrap().contains("days ahead"));
    }
    assert_eq!(at("2015-04-10T00:00:00Z", "15").code, Some(0));
    assert_eq!(at("2015-04-10T00:00:00Z", "nan").code, Some(1));
    // 18 revolutions a day are below the ground: suspicious, and refused for use.
    let low = format!("{LINE1}\n{}\n", corrected(&LINE2.replace("14.83565425", "17.53565425")));
    let run = check(low.as_str());
    assert_eq!(run.code, Some(0));
    assert!(run.stderr.contains("warning: mean motion of 17.5"), "{}", run.stderr);
    let run = adcs(["tle", "check", "-", "--now", "2015-03-27T02:00:00Z"], low);
    assert_eq!(run.code, Some(1));
}

/// The line with its checksum.
fn corrected(line: &str) -> String {
    let value = |c: char| if c == '-' { 1 } else { c.to_digit(10).unwrap_or(0) };
    let sum: u32 = line[..68].chars().map(value).sum();
    format!("{}{}", &line[..68], sum % 10)
}

#[test]
fn files_that_are_no_tle_are_refused() {
    for text in [&b""[..], b"\n\n", b"1 39770U", b"\xFF\xFE\0\0\n\x80", b"a\nb\nc\nd\n"] {
        let run = check(text);
        assert_eq!(run.code, Some(1), "{text:?}");
        assert!(run.stderr.starts_with("standard input: "), "{}", run.stderr);
        let (run, json) = check_json(text);
        assert_eq!((run.code, &json["valid"]), (Some(1), &false.into()));
    }
    let long = check(vec![b'1'; 100_000]);
    assert_eq!(long.code, Some(2));
    assert!(long.stderr.contains("a file with one TLE is wanted"), "{}", long.stderr);
    let missing = adcs(["tle", "check", "/nonexistent/sprout.tle"], "");
    assert_eq!(missing.code, Some(2));
    assert!(
        missing.stderr.contains("/nonexistent/sprout.tle: cannot be read"),
        "{}",
        missing.stderr
    );
}
