//! What is refused in mission files, and how it is said.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};

use adcs_core::control::b_dot::BDotGain;
use adcs_ground::mission::{self, Mission, Problem};
use adcs_sim::scenario::{Readings, SensorTruth};

const MISSION: &str = "sprout/despin-calibrated.toml";
const SATELLITE: &str = "satellites/sprout-a2.toml";

fn missions() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../missions")
}

/// A copy of a mission and its satellite, to be changed.
struct Workshop {
    folder: PathBuf,
}

impl Workshop {
    fn new() -> Self {
        static NEXT: AtomicU32 = AtomicU32::new(0);
        let number = NEXT.fetch_add(1, Ordering::Relaxed);
        let name = format!("mission-{}-{number}", std::process::id());
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
        for file in [MISSION, SATELLITE] {
            let path = folder.join(file);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::copy(missions().join(file), path).unwrap();
        }
        Self { folder }
    }

    /// Replaces the one place of `file` that reads `old`.
    fn change(&self, file: &str, old: &str, new: &str) {
        let path = self.folder.join(file);
        let text = fs::read_to_string(&path).unwrap();
        assert_eq!(text.matches(old).count(), 1, "{old:?} in {file}");
        fs::write(path, text.replace(old, new)).unwrap();
    }

    fn write(&self, file: &str, text: impl AsRef<[u8]>) {
        fs::write(self.folder.join(file), text).unwrap();
    }

    fn load(&self) -> Result<Mission, Vec<Problem>> {
        mission::load(self.folder.join(MISSION)).map_err(|error| error.problems)
    }

    /// The only problem; there must be one.
    fn problem(&self) -> Problem {
        let problems = self.load().expect_err("the mission was accepted");
        assert_eq!(problems.len(), 1, "{problems:#?}");
        problems.into_iter().next().unwrap()
    }
}

impl Drop for Workshop {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.folder);
    }
}

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

fn assert_says(problem: &Problem, key: &str, reason: &str, advice: &str) {
    assert_eq!(problem.key, key, "{problem}");
    assert!(problem.reason.contains(reason), "wanted {reason:?} in: {problem}");
    assert!(problem.advice.contains(advice), "wanted {advice:?} in: {problem}");
}

#[test]
fn every_mission_of_the_repository_loads() {
    let mut loaded = 0;
    for folder in ["sprout", "reference"] {
        for entry in fs::read_dir(missions().join(folder)).unwrap() {
            let path = entry.unwrap().path();
            match mission::load(&path) {
                Ok(mission) => assert_eq!(Some(mission.name.as_ref()), path.file_stem()),
                Err(error) => panic!("{error}"),
            }
            loaded += 1;
        }
    }
    assert!(loaded >= 14, "only {loaded} missions");
}

#[test]
fn persons_units_become_si() {
    let mission = mission::load(missions().join(MISSION)).unwrap();
    let scenario = mission.scenario;
    assert_eq!(mission.name, "despin-calibrated");
    assert_eq!((scenario.cycles, scenario.flight.cycle_us), (2400, 500_000));
    assert_eq!(scenario.flight.schedule.on_us, 10_000_000);
    assert_eq!(scenario.flight.schedule.off_us, 2_500_000);
    assert_eq!(scenario.world.start.to_string(), "2015-11-19T03:31:21.392832Z");
    assert_eq!(scenario.world.omega_bi_rad_s, [3.573, 1.866, 8.175].map(f64::to_radians));
    assert_eq!(scenario.world.magnetometer.noise, 586e-9);
    assert_eq!(scenario.world.gyro.noise, 0.163_f64.to_radians());
    // 50,000 nT/V and 20 mV/(deg/s), as the drivers' own presets have them.
    assert_eq!(scenario.board, adcs_hal::driver_board::DriverBoardConfig::SPROUT);
    assert_eq!(scenario.readings, Readings::Drivers);
}

#[test]
fn a_start_is_a_date_or_a_time_after_the_epoch() {
    let workshop = Workshop::new();
    let by_date = workshop.load().unwrap().scenario;
    workshop.change(MISSION, "utc = 2015-11-19T03:31:21.392832Z ", "after_tle_epoch_s = 2160 ");
    assert_eq!(workshop.load().unwrap().scenario, by_date);
    let quoted = Workshop::new();
    quoted.change(MISSION, "2015-11-19T03:31:21.392832Z", "\"2015-11-19T03:31:21.392832Z\"");
    assert_eq!(quoted.load().unwrap().scenario, by_date);
}

#[test]
fn the_normalised_law_and_none_have_their_own_keys() {
    let workshop = Workshop::new();
    workshop.change(
        MISSION,
        "kind = \"b-dot\"                        # m = k (ω × B)\ngain_am2_s_per_t = 100_000 ",
        "kind = \"b-dot-normalised\"\ngain_n_m_s = 1e-4 ",
    );
    let law = workshop.load().unwrap().scenario.flight.law;
    let gain = BDotGain::Normalised { gain_n_m_s: 1e-4 };
    assert_eq!(law, adcs_app::LawParameters::BDot(gain));
    let workshop = Workshop::new();
    workshop.change(MISSION, "kind = \"b-dot\" ", "kind = \"none\" ");
    let problem = workshop.problem();
    assert_says(&problem, "law.gain_am2_s_per_t", "no meaning with this kind", "remove it");
}

#[test]
fn each_error_of_a_sensor_is_switched_off_alone() {
    let workshop = Workshop::new();
    workshop.change(
        SATELLITE,
        "noise_nt = 586 ",
        "matrix = [[1.1, 0, 0], [0, 1, 0], [0, 0, 1]]\nmisalignment_deg = [0, 0, 90]\nnoise_nt = 586 ",
    );
    workshop.change(SATELLITE, "bias_nt = [0, 0, 0]\noffset", "bias_nt = [100, 200, 300]\noffset");
    let with = |off: &str| {
        workshop.write(
            "sprout/some-off.toml",
            format!(
                "base = \"despin-calibrated.toml\"\n[mission]\ntitle = \"t\"\ndescription = \"d\"\n\
                 [magnetometer.errors]\nswitched_off = [{off}]\n"
            ),
        );
        mission::load(workshop.folder.join("sprout/some-off.toml")).unwrap().scenario.world
    };
    let all = with("");
    assert_eq!(all.magnetometer.bias, [100.0 / 1e9, 200.0 / 1e9, 300.0 / 1e9]);
    assert_eq!(all.magnetometer.matrix[0][0], 1.1);
    assert!(all.magnetometer.noise > 0.0 && all.magnetometer_offset_m.is_some());
    // Sensor axes turned by +90 deg about z: what the sensor calls x is Body y.
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let [x, y, z, w] = all.magnetometer.alignment_xyzw;
    assert!(x.abs() + y.abs() + (z.abs() - half).abs() + (w - half).abs() < 1e-15);
    let axes: adcs_core::frames::Rotation<
        adcs_core::frames::Body,
        adcs_core::frames::MagnetometerAxes,
        f64,
    > = adcs_core::frames::Rotation::from_attitude_quaternion(all.magnetometer.alignment_xyzw)
        .unwrap();
    let x_in_body = axes * adcs_core::frames::Vector::new(1.0, 0.0, 0.0);
    assert!((x_in_body.xyz.y - 1.0).abs() < 1e-15, "{x_in_body:?}");

    let perfect = SensorTruth::PERFECT;
    let without = |off: &str| (with(off).magnetometer, with(off).magnetometer_offset_m);
    let (m, offset) = (all.magnetometer, all.magnetometer_offset_m);
    assert_eq!(without("\"noise\""), (SensorTruth { noise: 0.0, ..m }, offset));
    assert_eq!(without("\"bias\""), (SensorTruth { bias: [0.0; 3], ..m }, offset));
    assert_eq!(without("\"matrix\""), (SensorTruth { matrix: perfect.matrix, ..m }, offset));
    let straight = SensorTruth { alignment_xyzw: perfect.alignment_xyzw, ..m };
    assert_eq!(without("\"misalignment\""), (straight, offset));
    assert_eq!(without("\"torquer_field\""), (m, None));
    let every = "\"noise\", \"bias\", \"matrix\", \"misalignment\", \"torquer_field\"";
    assert_eq!(without(every), (perfect, None));
}

#[test]
fn torquers_may_be_weaker_reversed_and_turned_than_the_flight_software_knows() {
    let workshop = Workshop::new();
    let nominal = workshop.load().unwrap().scenario;
    workshop.change(
        SATELLITE,
        "steps = 4200 ",
        "errors = { scale = [1.0, -1.0, 0.5], misalignment_deg = [0, 0, 90] }\nsteps = 4200 ",
    );
    let scenario = workshop.load().unwrap().scenario;
    assert_eq!(scenario.world.torquer_full_dipole_am2, [0.6, -0.6, 0.3]);
    assert_ne!(scenario.world.torquer_alignment_xyzw, nominal.world.torquer_alignment_xyzw);
    assert_eq!((scenario.flight, scenario.board), (nominal.flight, nominal.board));
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
    assert_says(&problem, key, "NaN is impossible: must be finite", "");
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
            "must be positive and finite",
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
fn a_mission_overrides_its_base_key_by_key() {
    let mission = mission::load(missions().join("sprout/despin-on5.toml")).unwrap();
    let schedule = mission.scenario.flight.schedule;
    assert_eq!((schedule.on_us, schedule.off_us), (5_000_000, 2_500_000));
    assert_eq!(mission.files.len(), 3);
    let none = mission::load(missions().join("sprout/no-control.toml")).unwrap();
    // The gain that the base gives has no meaning any more, and is no problem.
    assert_eq!(none.scenario.flight.law, adcs_app::LawParameters::Off);
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
fn the_readme_lists_every_key() {
    let readme = fs::read_to_string(missions().join("README.md")).unwrap();
    let sections = [
        "mission",
        "satellite",
        "torques",
        "orbit",
        "start",
        "law",
        "schedule",
        "torquers",
        "torquers.errors",
        "converter",
        "magnetometer",
        "magnetometer.calibration",
        "magnetometer.errors",
        "gyro",
        "gyro.calibration",
        "gyro.errors",
        "simulation",
    ];
    let mut keys = 0;
    for section in sections {
        assert!(readme.contains(&format!("`[{section}]`")), "[{section}]");
        let workshop = Workshop::new();
        workshop.write(
            "sprout/odd.toml",
            format!(
                "base = \"despin-calibrated.toml\"\nmission.title = \"t\"\n\
                 mission.description = \"d\"\n{section}.odd_one_out = 1\n"
            ),
        );
        let error = mission::load(workshop.folder.join("sprout/odd.toml")).unwrap_err();
        let advice = &error.problems[0].advice;
        let known = advice.strip_prefix("known here: ").unwrap_or_else(|| panic!("{error}"));
        for key in known.split(", ") {
            let is_section = sections.contains(&format!("{section}.{key}").as_str());
            assert!(is_section || readme.contains(&format!("`{key}`")), "{section}.{key}");
            keys += 1;
        }
    }
    assert!(keys > 60, "only {keys} keys");
}

#[test]
fn the_readmes_own_mission_flies() {
    let readme = fs::read_to_string(missions().join("README.md")).unwrap();
    let (_, example) = readme.split_once("```toml\n").unwrap();
    let (example, _) = example.split_once("```").unwrap();
    let workshop = Workshop::new();
    workshop.write("mine.toml", example);
    let mission = mission::load(workshop.folder.join("mine.toml")).unwrap();
    let gain = BDotGain::Plain { gain_am2_s_per_t: 5e4 };
    assert_eq!(mission.scenario.flight.law, adcs_app::LawParameters::BDot(gain));
    assert_eq!(mission.name, "mine");
}
