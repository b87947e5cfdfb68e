//! `adcs eclipse` against shadows of an independent propagation with the JPL Sun.

use std::collections::HashMap;
use std::fs;
use std::path::PathBuf;

use crate::common::{Run, Table, Worst, adcs, data, folder, number};

/// The bar of the project.
const INSTANT_BAR_S: f64 = 1.0;
/// The table is written to the millisecond, and the two ways of writing an instant are rounded apart.
const WRITTEN_BAR_S: f64 = 0.001;

/// The case of `eclipse_cases.json`, as a TLE file and a span.
struct Case {
    tle: PathBuf,
}

impl Case {
    fn new(test: &str) -> Self {
        let cases: serde_json::Value =
            serde_json::from_slice(&data("adcs-core/tests/data/eclipse_cases.json")).unwrap();
        let case = &cases["cases"][0];
        let text = |key: &str| case[key].as_str().unwrap();
        assert_eq!(text("start_utc"), "2015-03-27T02:00:00Z");
        assert_eq!(case["duration_s"], 21_600);
        let tle = folder(test).join("sprout.tle");
        fs::write(&tle, format!("{}\n{}\n", text("tle_line1"), text("tle_line2"))).unwrap();
        Self { tle }
    }

    fn run(&self, from: &str, to: &str, more: &[&str]) -> Run {
        let tle = self.tle.to_str().unwrap();
        let arguments = ["eclipse", "--tle", tle, "--from", from, "--to", to];
        adcs(arguments.iter().chain(more), "")
    }

    fn six_hours(&self, earth: &str) -> Vec<HashMap<String, String>> {
        let more = ["--earth", earth];
        let run = self.run("2015-03-27T02:00:00Z", "2015-03-27T08:00:00Z", &more);
        assert_eq!((run.code, run.stderr.as_str()), (Some(0), ""));
        let table = run.table();
        assert_eq!(table.header.join(","), "shadow,event,utc_iso,t_after_start_s");
        table.rows
    }
}

#[test]
fn entries_and_exits_over_a_sphere_come_when_expected() {
    let mut expected = Table::parse(&data("adcs-core/tests/data/eclipse_expected.csv"));
    expected.rows.retain(|row| row["shadow_model"] != "cylinder");
    let found = Case::new("eclipse_sphere").six_hours("sphere");
    assert_eq!(found.len(), expected.rows.len());
    let mut worst = Worst::new("shadow, s");
    // Both are in order of time.
    for (found, expected) in found.iter().zip(&expected.rows) {
        assert_eq!(found["shadow"], expected["shadow_model"]);
        assert_eq!(found["event"], expected["event"]);
        let off = number(found, "t_after_start_s") - number(expected, "t_after_start_s");
        worst.see(off.abs(), &expected["utc_iso_nearest_s"]);
    }
    worst.report(INSTANT_BAR_S);
}

#[test]
fn instants_are_written_alike_in_both_columns() {
    for row in Case::new("eclipse_columns").six_hours("ellipsoid") {
        let (hour, rest) = row["utc_iso"].strip_prefix("2015-03-27T").unwrap().split_at(2);
        let (minute, second) = rest[1..].split_once(':').unwrap();
        let second = second.strip_suffix('Z').unwrap();
        assert_eq!(second.len(), "06.575".len());
        let [hour, minute, second]: [f64; 3] = [hour, minute, second].map(|x| x.parse().unwrap());
        let after_s = (hour - 2.0) * 3600.0 + minute * 60.0 + second;
        assert!((after_s - number(&row, "t_after_start_s")).abs() <= WRITTEN_BAR_S);
    }
}

#[test]
fn the_ellipsoid_is_the_default_and_its_shadow_is_shorter() {
    let case = Case::new("eclipse_ellipsoid");
    let sphere = case.six_hours("sphere");
    let ellipsoid = case.six_hours("ellipsoid");
    assert_eq!(sphere.len(), ellipsoid.len());
    for (sphere, ellipsoid) in sphere.iter().zip(&ellipsoid) {
        let later_s = number(ellipsoid, "t_after_start_s") - number(sphere, "t_after_start_s");
        let shorter_s = if sphere["event"] == "entry" { later_s } else { -later_s };
        assert!((0.0..10.0).contains(&shorter_s), "{shorter_s}");
    }
    let default = case.run("2015-03-27T02:00:00Z", "2015-03-27T08:00:00Z", &[]).table().rows;
    assert_eq!(default, ellipsoid);
}

#[test]
fn a_span_that_begins_in_the_umbra_begins_with_an_exit() {
    let case = Case::new("eclipse_within");
    let run = case.run("2015-03-27T02:30:00Z", "2015-03-27T03:00:00Z", &["--earth", "sphere"]);
    let events: Vec<_> =
        run.table().rows.iter().map(|row| (row["shadow"].clone(), row["event"].clone())).collect();
    let event = |shadow: &str, event: &str| (shadow.to_owned(), event.to_owned());
    assert_eq!(events, [event("umbra", "exit"), event("penumbra", "exit")]);
    let moment = case.run("2015-03-27T02:30:00Z", "2015-03-27T02:30:00Z", &[]);
    assert_eq!((moment.code, moment.table().rows.len()), (Some(0), 0));
}

#[test]
fn an_orbit_that_ends_within_the_span_leaves_the_events_before_that() {
    let folder = folder("eclipse_decays");
    let satellites = Table::parse(&data("sgp4-lite/tests/data/vallado_tle.csv"));
    let satellite = satellites.rows.iter().find(|row| row["satnum"] == "29141").unwrap();
    let tle = folder.join("29141.tle");
    fs::write(&tle, format!("{}\n{}\n", satellite["line1"], satellite["line2"])).unwrap();
    let case = Case { tle };
    // The epoch is 2006-06-19T06:25:41 UTC; SGP4 has it decayed 440 min later, at 13:45:41.
    let run = case.run("2006-06-19T06:30:00Z", "2006-06-19T20:00:00Z", &[]);
    assert_eq!(run.code, Some(1));
    assert!(run.stderr.contains("the search ends early: decayed"), "{}", run.stderr);
    let events = run.table().rows;
    assert!(events.len() >= 8, "{}", events.len());
    assert!(events.iter().all(|row| number(row, "t_after_start_s") < 440.0 * 60.0));
}

#[test]
fn spans_that_are_none_are_refused() {
    let case = Case::new("eclipse_spans");
    let backwards = case.run("2015-03-27T02:00:00Z", "2015-03-27T01:59:59Z", &[]);
    assert_eq!(backwards.code, Some(2));
    assert!(backwards.stderr.contains("is before --from"), "{}", backwards.stderr);
    let nonsense = case.run("yesterday", "2015-03-27T01:59:59Z", &[]);
    assert_eq!(nonsense.code, Some(2));
    assert!(nonsense.stderr.contains("not a UTC instant"), "{}", nonsense.stderr);
    let early = case.run("1971-12-31T00:00:00Z", "1972-01-02T00:00:00Z", &[]);
    assert_eq!(early.code, Some(2));
    assert!(early.stderr.contains("before 1972"), "{}", early.stderr);
}
