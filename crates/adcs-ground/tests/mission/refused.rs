//! What is refused in mission files, and how it is said.

use std::fs;

use adcs_ground::mission::{self, Problem};

use proptest::prelude::*;

use super::workshop::{MISSION, SATELLITE, Workshop, missions};

/// Changes one place and gives the only problem, which must stand in the changed line.
fn refused(file: &str, old: &str, new: &str) -> Problem {
    let workshop = Workshop::new();
    workshop.change(file, old, new);
    let problem = workshop.problem();
    assert!(problem.path.ends_with(file), "{problem}");
    let text = fs::read_to_string(workshop.folder.join(file)).unwrap();
    let at = text.find(new).unwrap();
    let first = text[..at].matches('\n').count() + 1;
    let last = first + new.matches('\n').count();
    assert!((first..=last).contains(&problem.line), "lines {first} to {last}: {problem}");
    problem
}

/// The problem is about this key, for this reason, with this advice.
pub fn assert_says(problem: &Problem, key: &str, reason: &str, advice: &str) {
    assert_eq!(problem.key, key, "{problem}");
    assert!(problem.reason.contains(reason), "wanted {reason:?} in: {problem}");
    assert!(problem.advice.contains(advice), "wanted {advice:?} in: {problem}");
}

#[test]
fn unknown_keys_are_refused_with_the_one_that_was_probably_meant() {
    let problem = refused(MISSION, "seed = 20151119", "sede = 20151119");
    assert_says(&problem, "mission.sede", "unknown key", "did you mean seed?");
    let problem = refused(MISSION, "[schedule]", "[scheduel]");
    assert_says(&problem, "scheduel", "unknown key", "did you mean schedule?");
    let problem = refused(MISSION, "seed = 20151119", "colour = 3");
    assert_says(&problem, "mission.colour", "unknown key", "known here: cycle_s, description");
}

#[test]
fn filters_that_cannot_work_are_refused_at_the_key_of_the_number() {
    for (line, key, reason) in [
        ("gyro_noise_deg_s = 9", "gyro_noise_deg_s", "must be from 1e-7 to 1e-1"),
        ("field_noise_nt = 3e4", "field_noise_nt", "must be from 1e-9 to 2e-5"),
        ("residual_dipole_am2 = [0, 200, 0]", "residual_dipole_am2", "must be from -1e2 to 1e2"),
        ("residual_dipole_prior_am2 = 200", "residual_dipole_prior_am2", "from 1e-4 to 1e2"),
        ("inertia_moment_prior = 0.4", "inertia_moment_prior", "from 0e0 to 3e-1"),
        ("unknown_torque_time_s = 0.1", "unknown_torque_time_s", "from 1e0 to 1e6"),
    ] {
        let section = format!("[attitude]\nfilter = \"dynamic\"\n{line}\n[schedule]");
        let problem = refused(MISSION, "[schedule]", &section);
        assert_says(&problem, &format!("attitude.{key}"), reason, "");
    }
    // The end of a range belongs to it.
    let workshop = Workshop::new();
    let section = "[attitude]\nfilter = \"dynamic\"\ninertia_moment_prior = 0.3\n[schedule]";
    workshop.change(MISSION, "[schedule]", section);
    assert!(workshop.load().is_ok());
}

#[test]
fn sun_sensors_that_cannot_be_are_refused_at_their_key() {
    let problem = refused(SATELLITE, "half_cone_deg = 55 ", "half_cone_deg = 60 ");
    assert_says(&problem, "sun_sensors.half_cone_deg", "wider than the diode sees", "");
    let problem = refused(SATELLITE, "dark_v = 0.1 ", "dark_v = 0.01 ");
    assert_says(&problem, "sun_sensors.dark_v", "outside what the converter can read", "");
    let problem = refused(SATELLITE, "albedo = 0.3 ", "albedo = 30 ");
    assert_says(&problem, "sun_sensors.errors.albedo", "must be from 0 (black) to 1 (white)", "");
    let problem = refused(SATELLITE, "full_sun_ua = 80 ", "full_sun_ma = 0.08 ");
    assert_says(
        &problem,
        "sun_sensors.full_sun_ma",
        "given in milliampere, wanted in microampere",
        "write full_sun_ua",
    );
    let faults = "faults = [\"dark\"]\nnoise_deg = 0.664 ";
    let problem = refused(SATELLITE, "noise_deg = 0.664 ", faults);
    assert_says(&problem, "sun_sensors.errors.faults", "expected a list of 6 words", "");
}

#[test]
fn a_wrong_or_missing_unit_is_told_with_the_wanted_one() {
    let problem = refused(SATELLITE, "mass_kg = 7.1 ", "mass_g = 7100 ");
    assert_says(&problem, "satellite.mass_g", "given in gram, wanted in kilogram", "write mass_kg");
    assert_eq!(problem.column, 1);
    let problem = refused(MISSION, "rate_deg_s =", "rate_rad_s =");
    assert_says(
        &problem,
        "start.rate_rad_s",
        "given in radians per second, wanted in degrees per second",
        "write rate_deg_s",
    );
    let problem = refused(MISSION, "on_s = 10", "on = 10");
    assert_says(&problem, "schedule.on", "its unit is missing, wanted in seconds", "write on_s");
    let problem = refused(SATELLITE, "noise_nt = 586 ", "noise_ut = 0.586 ");
    assert_says(
        &problem,
        "magnetometer.errors.noise_ut",
        "given in microtesla, wanted in nanotesla",
        "write noise_nt",
    );
}

#[test]
fn a_number_in_the_wrong_unit_under_the_right_key_is_caught_where_physics_can() {
    // kg·cm² under a key in kg·m².
    let problem = refused(
        SATELLITE,
        "[ 0.05184, 0.00058, -0.00077],\n  [ 0.00058, 0.05416,  0.00069],\n  [-0.00077, 0.00069,  0.05978],",
        "[ 518.4, 5.8, -7.7],\n  [ 5.8, 541.6,  6.9],\n  [-7.7, 6.9,  597.8],",
    );
    assert_says(
        &problem,
        "satellite.inertia_kg_m2",
        "7.1 kg in a box of 0.2 x 0.2 x 0.2 m have at most 0.1420 kg·m²",
        "another unit than kg·m²",
    );
}

#[test]
fn wrong_types_are_refused() {
    let problem = refused(SATELLITE, "mass_kg = 7.1 ", "mass_kg = \"7.1\" ");
    assert_says(&problem, "satellite.mass_kg", "expected a number, found a text", "without quotes");
    let problem = refused(SATELLITE, "drag = true", "drag = 1");
    assert_says(&problem, "torques.drag", "expected true or false, found a number", "");
    let problem =
        refused(MISSION, "rate_deg_s = [3.573, 1.866, 8.175]", "rate_deg_s = [3.573, 1.866]");
    assert_says(&problem, "start.rate_deg_s", "expected a list of 3 numbers, found one of 2", "");
    let problem = refused(MISSION, "rate_deg_s = [3.573, 1.866, 8.175]", "rate_deg_s = 8");
    assert_says(&problem, "start.rate_deg_s", "expected a list of 3 numbers, found a number", "");
    let problem = refused(MISSION, "[3.573, 1.866, 8.175]", "[3.573, \"1.866\", 8.175]");
    assert_says(&problem, "start.rate_deg_s", "expected a number, found a text", "without quotes");
    let problem = refused(MISSION, "seed = 20151119", "seed = 1.5");
    assert_says(&problem, "mission.seed", "must be a whole number from 0", "");
    let problem = refused(MISSION, "readings = \"drivers\"", "readings = \"exactly\"");
    let words = "expected one of \"drivers\", \"exact\", found \"exactly\"";
    assert_says(&problem, "simulation.readings", words, "");
    let problem = refused(
        SATELLITE,
        "switched_off = []                 # any of \"noise\", \"bias\", \"matrix\", \"misalignment\", \"torquer_field\"",
        "switched_off = [\"nois\"]",
    );
    assert_says(&problem, "magnetometer.errors.switched_off", "found \"nois\"", "");
}

#[test]
fn missing_keys_and_sections_are_named() {
    let workshop = Workshop::new();
    workshop.change(MISSION, "on_s = 10\n", "");
    let problem = workshop.problem();
    assert_says(&problem, "schedule.on_s", "is missing (wanted in seconds)", "");
    assert!(problem.to_string().contains("[schedule]"), "{problem}");

    workshop.change(MISSION, "[schedule]\noff_s = 2.5\n", "");
    let problem = workshop.problem();
    assert_says(&problem, "", "the section [schedule] is missing", "");
    assert!(problem.path.ends_with(MISSION));
}

#[test]
fn an_inertia_no_body_can_have_is_refused_with_the_entry_or_the_reason() {
    let key = "satellite.inertia_kg_m2";
    let tensor = |rows: &str| {
        let workshop = Workshop::new();
        workshop.change(
            SATELLITE,
            "[ 0.05184, 0.00058, -0.00077],\n  [ 0.00058, 0.05416,  0.00069],\n  [-0.00077, 0.00069,  0.05978],",
            rows,
        );
        workshop.problem()
    };
    let problem = tensor("[0.02, 0, 0],\n[0, 0.02, 0],\n[0, 0, 0.05],");
    assert_says(&problem, key, "the largest exceeds the sum of the other two", "products");
    let problem = tensor("[0.05, 0, 0],\n[0, -0.05, 0],\n[0, 0, 0.05],");
    assert_says(&problem, key, "-0.05 is impossible: a moment of inertia is positive", "");
    assert!(problem.to_string().contains("[0, -0.05, 0],"), "{problem}");
    let problem = tensor("[0.05, 0.06, 0],\n[0.06, 0.05, 0],\n[0, 0, 0.05],");
    assert_says(&problem, key, "the smallest principal moment is -0.0", "signs of the products");
    let problem = tensor("[0.05, 0.001, 0],\n[0, 0.05, 0],\n[0, 0, 0.05],");
    assert_says(&problem, key, "entry (1,2) differs from entry (2,1)", "symmetric");
    assert!(problem.to_string().contains("[0.05, 0.001, 0],"), "{problem}");
    let problem = tensor("[0.05, 0, 0],\n[0, nan, 0],\n[0, 0, 0.05],");
    assert_says(&problem, key, "NaN is impossible: must be finite, and within 100000", "");
}

#[test]
fn impossible_numbers_are_refused() {
    let cases = [
        (SATELLITE, "mass_kg = 7.1 ", "mass_kg = -7.1 ", "satellite.mass_kg", "must be positive"),
        (
            SATELLITE,
            "mass_kg = 7.1 ",
            "mass_kg = inf ",
            "satellite.mass_kg",
            "inf is impossible: must be positive and at most 10000 kg",
        ),
        (
            SATELLITE,
            "noise_nt = 586 ",
            "noise_nt = -586 ",
            "magnetometer.errors.noise_nt",
            "zero or positive",
        ),
        (
            SATELLITE,
            "noise_deg_s = 0.163 ",
            "noise_deg_s = nan ",
            "gyro.errors.noise_deg_s",
            "NaN is impossible",
        ),
        (
            SATELLITE,
            "max_dipole_am2 = 0.6 ",
            "max_dipole_am2 = 0 ",
            "torquers.max_dipole_am2",
            "must be positive",
        ),
        (SATELLITE, "steps = 4200 ", "steps = 0 ", "torquers.steps", "from 1 to 65535"),
        (SATELLITE, "steps = 4200 ", "steps = 65536 ", "torquers.steps", "from 1 to 65535"),
        (
            SATELLITE,
            "drag_coefficient = 2.2 ",
            "drag_coefficient = 22 ",
            "satellite.drag_coefficient",
            "from 1 to 5",
        ),
        (
            SATELLITE,
            "reflectivity = 1.6 ",
            "reflectivity = 0.6 ",
            "satellite.reflectivity",
            "from 1 (black) to 2 (mirror)",
        ),
        (
            SATELLITE,
            "reference_v = 3.3 ",
            "reference_v = 33 ",
            "converter.reference_v",
            "33 is impossible: must be from 0.25 to 5.5",
        ),
        (
            SATELLITE,
            "sensitivity_nt_per_v = 50_000 ",
            "sensitivity_nt_per_v = 0 ",
            "magnetometer.sensitivity_nt_per_v",
            "must be positive",
        ),
        (
            SATELLITE,
            "channels = [0, 1, 2] ",
            "channels = [0, 1, 8] ",
            "magnetometer.channels",
            "from 0 to 7",
        ),
        (
            SATELLITE,
            "channels = [0, 1, 2] ",
            "channels = [0, 1, 1] ",
            "magnetometer.channels",
            "two sensor axes are wired to channel 1",
        ),
        (
            SATELLITE,
            "channels = [3, 4, 5] ",
            "channels = [3, 4, 2] ",
            "gyro.channels",
            "channel 2 is the magnetometer's",
        ),
        (
            SATELLITE,
            "offset_from_torquers_m = [0.08, 0.08, 0.06] ",
            "offset_from_torquers_m = [0, 0, 0] ",
            "magnetometer.errors.offset_from_torquers_m",
            "not inside the torquers",
        ),
        (
            MISSION,
            "gain_am2_s_per_t = 100_000 ",
            "gain_am2_s_per_t = 0 ",
            "law.gain_am2_s_per_t",
            "must be positive",
        ),
        (
            MISSION,
            "gain_am2_s_per_t = 100_000 ",
            "gain_am2_s_per_t = -1e5 ",
            "law.gain_am2_s_per_t",
            "must be positive",
        ),
        // Too large for the flight software's single precision.
        (
            MISSION,
            "gain_am2_s_per_t = 100_000 ",
            "gain_am2_s_per_t = 1e40 ",
            "law.gain_am2_s_per_t",
            "must be positive and finite",
        ),
        (MISSION, "on_s = 10", "on_s = 0", "schedule.on_s", "duty 0"),
        (MISSION, "off_s = 2.5", "off_s = 0", "schedule.off_s", "never rest"),
        (
            MISSION,
            "on_s = 10",
            "on_s = 10.3",
            "schedule.on_s",
            "not a whole number of cycles of 500000",
        ),
        (MISSION, "off_s = 2.5", "off_s = 2.4", "schedule.off_s", "not a whole number of cycles"),
        (MISSION, "on_s = 10", "on_s = 4295", "schedule.on_s", "from 0 to 4294 s"),
        (MISSION, "on_s = 10", "on_s = -10", "schedule.on_s", "from 0 to 4294 s"),
        (MISSION, "on_s = 10", "on_s = 10.0000001", "schedule.on_s", "finer than a microsecond"),
        (MISSION, "cycle_s = 0.5", "cycle_s = 0", "mission.cycle_s", "from 0.001 to 60 s"),
        (
            MISSION,
            "step_s = 0.1",
            "step_s = 0.3",
            "mission.cycle_s",
            "not a whole number of simulation steps of 0.3 s",
        ),
        (MISSION, "duration_s = 1200", "duration_s = 0", "mission.duration_s", "a flight of 0 s"),
        (
            MISSION,
            "duration_s = 1200",
            "duration_s = 1200.2",
            "mission.duration_s",
            "not a whole number of cycles of 0.5 s",
        ),
        (
            MISSION,
            "duration_s = 1200",
            "duration_s = 1e6",
            "mission.duration_s",
            "2000000 cycles are too many",
        ),
        (
            MISSION,
            "duration_s = 1200",
            "duration_s = 1e300",
            "mission.duration_s",
            "from 0 to 10000000 s",
        ),
        (MISSION, "seed = 20151119", "seed = -1", "mission.seed", "from 0"),
        (
            MISSION,
            "[0.4821, 0.7618, -0.0245, 0.4319]",
            "[0, 0, 0, 0]",
            "start.attitude_xyzw",
            "a zero quaternion",
        ),
        (
            MISSION,
            "[0.4821, 0.7618, -0.0245, 0.4319]",
            "[1, 1, 0, 0]",
            "start.attitude_xyzw",
            "length 1.4142",
        ),
    ];
    for (file, old, new, key, reason) in cases {
        let workshop = Workshop::new();
        workshop.change(file, old, new);
        assert_says(&workshop.problem(), key, reason, "");
    }
}

#[test]
fn a_converter_fault_without_converter_is_refused() {
    let problem = refused(
        MISSION,
        "readings = \"drivers\" ",
        "converter_fault = \"ones\"\nreadings = \"exact\" ",
    );
    assert_says(&problem, "simulation.converter_fault", "no converter", "readings = \"drivers\"");
}

#[test]
fn starts_that_make_no_sense_are_refused() {
    let utc = "2015-11-19T03:31:21.392832Z";
    let problem = refused(MISSION, utc, "2016-11-19T03:31:21.392832Z");
    assert_says(
        &problem,
        "start.utc",
        "366.0 days from the TLE's epoch",
        "give a TLE of that time",
    );
    let problem = refused(MISSION, utc, "\"2015-11-19 03:31:21\"");
    assert_says(&problem, "start.utc", "departs at character 11", "Z for UTC");
    let problem = refused(MISSION, utc, "2015-11-19T03:31:21");
    assert_says(&problem, "start.utc", "departs at character 20", "Z for UTC");
    let problem = refused(MISSION, utc, "\"2015-02-30T03:31:21Z\"");
    assert_says(&problem, "start.utc", "the day 30 does not exist", "");
    let problem = refused(MISSION, "utc = ", "after_tle_epoch_s = 2160\nutc = ");
    assert_says(&problem, "start.after_tle_epoch_s", "excludes utc", "");
}

#[test]
fn every_column_of_a_tle_is_checked_and_pointed_at() {
    let original = fs::read_to_string(missions().join(SATELLITE)).unwrap();
    let lines: Vec<&str> = original
        .lines()
        .filter(|line| line.starts_with("  \"1 ") || line.starts_with("  \"2 "))
        .collect();
    assert_eq!(lines.len(), 2);
    for (number, line) in lines.iter().enumerate() {
        for column in 1..=69 {
            let mut letters: Vec<char> = line.chars().collect();
            // Three characters of indent and quote stand before column 1; a '?' fits nowhere.
            letters[column + 2] = '?';
            let broken: String = letters.into_iter().collect();
            let workshop = Workshop::new();
            workshop.change(SATELLITE, line, &broken);
            let problem = workshop.problem();
            assert_eq!(problem.key, "orbit.tle");
            assert_eq!(problem.column, column + 3, "line {}: {problem}", number + 1);
            assert!(
                problem.reason.contains(&format!("line {}, column {column}:", number + 1)),
                "{problem}"
            );
        }
    }
}

#[test]
fn errors_of_a_tle_as_a_whole_are_refused() {
    let line1 = "1 39770U 14029E   15323.12177538  .00004189  00000-0  50368-3 0  9997";
    let problem = refused(SATELLITE, line1, &line1.replace("9997", "9990"));
    assert_says(
        &problem,
        "orbit.tle",
        "the checksum is 0, but the line sums up to 7",
        "copy it again",
    );
    assert_eq!(problem.column, 69 + 3);
    let problem = refused(SATELLITE, line1, &line1[..68]);
    assert_says(&problem, "orbit.tle", "68 columns instead of 69", "copy both lines whole");
    // 00366 is no day of 2015; the digits' sum stays the same.
    let problem = refused(SATELLITE, line1, &line1.replace("15323.", "15800."));
    assert_says(&problem, "orbit.tle", "has no day 800", "");
    let problem = refused(SATELLITE, "\"2 39770  97.8736", "\"2 39770 197.8735");
    assert_says(&problem, "orbit.tle", "inclination", "");
}

#[test]
fn a_file_that_cannot_be_read_is_named() {
    let error = mission::load("no/such/mission.toml").unwrap_err().to_string();
    assert!(error.starts_with("no/such/mission.toml: cannot be read: "), "{error}");
    let folder = mission::load(missions()).unwrap_err().to_string();
    assert!(folder.contains("cannot be read"), "{folder}");

    let workshop = Workshop::new();
    workshop.write(MISSION, b"title = \"\xff\"");
    let problem = workshop.problem();
    assert_says(&problem, "", "not text in UTF-8 (byte 10)", "save it as UTF-8");
    workshop.write(MISSION, vec![b'#'; (1 << 20) + 1]);
    assert_says(&workshop.problem(), "", "is no mission file: it has 1048577 bytes", "");
}

#[test]
fn a_base_that_cannot_be_read_is_pointed_at() {
    let problem = refused(MISSION, "../satellites/sprout-a2.toml", "../satellites/sprout-b7.toml");
    assert_says(&problem, "base", "cannot be read", "");
    let problem = refused(MISSION, "\"../satellites/sprout-a2.toml\"", "7");
    assert_says(&problem, "base", "expected the path of a file, found a number", "");
    let problem = refused(MISSION, "../satellites/sprout-a2.toml", "despin-calibrated.toml");
    assert_says(&problem, "base", "its own base", "");
}

#[test]
fn what_is_not_toml_is_refused_at_its_place() {
    let problem = refused(MISSION, "seed = 20151119", "seed = = 20151119");
    assert_says(&problem, "", "not TOML", "");
    let workshop = Workshop::new();
    workshop.change(MISSION, "seed = 20151119", "seed = 20151119\nseed = 3");
    assert_says(&workshop.problem(), "", "not TOML", "");
}

#[test]
fn title_and_description_are_not_taken_from_the_base() {
    let workshop = Workshop::new();
    workshop.write("sprout/heir.toml", "base = \"despin-calibrated.toml\"\n[schedule]\non_s = 5\n");
    let error = mission::load(workshop.folder.join("sprout/heir.toml")).unwrap_err();
    let keys: Vec<_> = error.problems.iter().map(|problem| problem.key.as_str()).collect();
    assert_eq!(keys, ["mission.title", "mission.description"]);
    assert!(error.to_string().contains("give this one its own"), "{error}");
}

#[test]
fn all_problems_of_a_file_are_reported_at_once_in_their_order() {
    let workshop = Workshop::new();
    workshop.change(MISSION, "duration_s = 1200", "duration_s = 0");
    workshop.change(MISSION, "on_s = 10", "on_s = 0");
    workshop.change(MISSION, "[3.573, 1.866, 8.175]", "[3.573, nan, 8.175]");
    workshop.change(SATELLITE, "mass_kg = 7.1 ", "mass_g = 7100 ");
    let problems = workshop.load().unwrap_err();
    let keys: Vec<_> = problems.iter().map(|problem| problem.key.as_str()).collect();
    assert_eq!(
        keys,
        ["mission.duration_s", "start.rate_deg_s", "schedule.on_s", "satellite.mass_g"]
    );
}

#[test]
fn slips_of_the_decimal_point_are_refused() {
    let cases = [
        (MISSION, "8.175]", "8175]", "start.rate_deg_s", "within 360 deg/s"),
        (
            SATELLITE,
            "air_density_kg_m3 = 5e-13",
            "air_density_kg_m3 = 5e13",
            "torques.air_density_kg_m3",
            "the air at 150 km",
        ),
        (
            SATELLITE,
            "[-0.3211, -0.2094, -0.0201]",
            "[-3211, -0.2094, -0.0201]",
            "satellite.residual_dipole_am2",
            "within 1000",
        ),
        (
            SATELLITE,
            "noise_nt = 586 ",
            "noise_nt = 586e6 ",
            "magnetometer.errors.noise_nt",
            "at most 1000000 nT",
        ),
    ];
    for (file, old, new, key, reason) in cases {
        assert_says(&refused(file, old, new), key, reason, "");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(500))]
    #[test]
    fn whatever_is_written_into_a_mission_nothing_panics(
        at in 0.0..1.0_f64,
        removed in 0_usize..8,
        written in "[0-9a-z\\-+.,=\\[\\]{}\"'# \n\tµ]{0,8}",
        into_satellite in any::<bool>(),
    ) {
        let workshop = Workshop::new();
        let file = if into_satellite { SATELLITE } else { MISSION };
        let text = fs::read_to_string(missions().join(file)).unwrap();
        let mut letters: Vec<char> = text.chars().collect();
        let start = (at * letters.len() as f64) as usize;
        let end = (start + removed).min(letters.len());
        letters.splice(start..end, written.chars());
        workshop.write(file, letters.into_iter().collect::<String>());
        if let Err(problems) = workshop.load() {
            prop_assert!(!problems.is_empty());
            for problem in problems {
                prop_assert!(!problem.to_string().is_empty());
            }
        }
    }
}
