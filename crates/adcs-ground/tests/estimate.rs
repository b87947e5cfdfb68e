//! `adcs estimate`, from the tables to the exit code.
//!
//! `cargo test -p adcs-ground --test estimate -- --nocapture` prints the errors of the reference run.

mod support;

use std::fs;
use std::path::PathBuf;
use std::process::Output;

use support::{Table, errors_of};

/// The run of the library's tests.
const RUN: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../adcs-core/tests/data/mekf/");

fn adcs(arguments: &[&str], input: &str) -> Output {
    support::adcs("estimate", arguments, input)
}

/// Text in a file of its own.
fn file(name: &str, text: &str) -> PathBuf {
    let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    fs::write(&path, text).expect("a writable folder");
    path
}

fn hamilton(table: &Table, row: usize) -> nalgebra::Quaternion<f64> {
    let [x, y, z, w] = table.quaternion(row, "q");
    nalgebra::Quaternion::new(w, x, y, z)
}

/// The rms of the angle between two tables' attitudes from row `from` on, deg.
fn rms_deg(estimated: &Table, truth: &Table, from: usize) -> f64 {
    let rows = from..truth.rows.len();
    let count = rows.len() as f64;
    let square = |row| {
        let between = hamilton(truth, row).conjugate() * hamilton(estimated, row);
        let angle = 2.0 * between.imag().norm().atan2(between.w.abs());
        angle * angle
    };
    (rows.map(square).sum::<f64>() / count).sqrt().to_degrees()
}

#[test]
fn beside_the_filter_that_knows_the_dynamics_the_reference_run_is_no_worse() {
    // The run's satellite moves as no dynamics would: sinusoids and slews without a torque. The unknown
    // torque has to take that in, or the MEKF to be believed.
    let path = |name: &str| format!("{RUN}{name}");
    let truth = Table::read(&fs::read(path("truth.csv")).unwrap());
    let flown = |filter: &str| {
        let output = adcs(
            &[
                "--measurements",
                &path("measurements.csv"),
                "--references",
                &path("reference_vectors.csv"),
                "--config",
                &path("config.json"),
                "--filter",
                filter,
                "--single",
            ],
            "",
        );
        assert!(output.status.success(), "{}", errors_of(&output));
        Table::read(&output.stdout)
    };
    let (mekf, dynamic) = (flown("mekf"), flown("dynamic"));
    let [mekf_deg, dynamic_deg] = [&mekf, &dynamic].map(|table| rms_deg(table, &truth, 600));
    println!("whole run from 600 s: MEKF {mekf_deg:.3} deg, dynamic {dynamic_deg:.3} deg");
    assert!(dynamic_deg < mekf_deg);
    let sources = 600..dynamic.rows.len();
    let used = sources.clone().filter(|&row| dynamic.text(row, "source") == "dynamic").count();
    assert!(2 * used > sources.len(), "{used} of {}", sources.len());
}

#[test]
fn the_reference_run_comes_out_as_from_the_library_however_it_starts() {
    let path = |name: &str| format!("{RUN}{name}");
    let truth = Table::read(&fs::read(path("truth.csv")).unwrap());
    let config = fs::read_to_string(path("config.json")).unwrap();
    let without_start =
        file("no_start.json", &config.replace("reference_filter_initial_q_xyzw", "elsewhere"));
    let wrong = config.replace("0.7459646112118739", "-0.7459646112118739");
    assert_ne!(wrong, config);
    let wrong_start = file("wrong_start.json", &wrong);
    let starts = [
        (path("config.json"), "field+sun"),
        (without_start.display().to_string(), "two-vectors"),
        (wrong_start.display().to_string(), "none"),
    ];
    for (config, first_source) in &starts {
        for single in [false, true] {
            let (measurements, references) =
                (path("measurements.csv"), path("reference_vectors.csv"));
            let mut arguments = vec!["--measurements", &measurements, "--references", &references];
            arguments.extend(["--config", config]);
            arguments.extend(single.then_some("--single"));
            let output = adcs(&arguments, "");
            assert!(output.status.success(), "{}", errors_of(&output));
            let table = Table::read(&output.stdout);
            assert_eq!(table.rows.len(), truth.rows.len());
            // A wrong start is given away at first, and gone within five seconds.
            if *first_source != "none" {
                assert_eq!(table.text(0, "source"), *first_source);
            }
            assert_eq!(table.text(900, "source"), "field+sun");
            let rms = rms_deg(&table, &truth, 900);
            println!("{config}, single {single}: {rms:.3} deg rms after 900 s");
            assert!(rms <= 3.6);
        }
    }
}

const MEASURED: &str = "t_s,gyro_x_rad_s,gyro_y_rad_s,gyro_z_rad_s,mag_x_nT,mag_y_nT,mag_z_nT,sun_x,sun_y,sun_z,sun_valid,note\n";
const KNOWN: &str =
    "t_s,B_teme_x_nT,B_teme_y_nT,B_teme_z_nT,sun_teme_x,sun_teme_y,sun_teme_z,eclipse\n";
const CONFIG: &str = r#"{"gyro_sigma_rad_s": 0.003, "gyro_bias_rw_rad_s_sqrt_s": 2e-6,
    "sun_sigma_rad_per_transverse_axis": 0.012, "mag_sigma_nT_per_axis": 500}"#;

/// A satellite at rest, Body along TEME, for these rows of measurements and eight seconds of models.
fn at_rest(name: &str, rows: &[&str]) -> Output {
    let known = (0..8).fold(KNOWN.to_owned(), |text, t| {
        text + &format!("{t},30000,0,10000,0,0.6,0.8,{}\n", i32::from(t == 6))
    });
    let references = file(&format!("{name}.references.csv"), &known);
    let config = file(&format!("{name}.json"), CONFIG);
    let measured = MEASURED.to_owned() + &rows.join("\n") + "\n";
    let paths = [references, config].map(|path| path.display().to_string());
    adcs(&["--measurements", "-", "--references", &paths[0], "--config", &paths[1]], &measured)
}

#[test]
fn what_is_missing_is_missing_and_what_is_wrong_is_named_with_its_line() {
    let output = at_rest(
        "rows",
        &[
            "0,0,0,0,30000,0,10000,0,0.6,0.8,1,both",
            "1,0,0,0,,,,0,0.6,0.8,1,sun",
            "2,0,0,0,30000,0,10000,0,0,0,0,field",
            "3,0,0,0,nan,nan,nan,0,0.6,0.8,0,gyro",
            "4,nan,nan,nan,nan,nan,nan,nan,nan,nan,0,held",
            "3.5,0,0,0,30000,0,10000,0,0.6,0.8,1,backwards",
            "5,0,x,0,30000,0,10000,0,0.6,0.8,1,text",
            "6,0,0,0,nan,nan,nan,0,0.6,0.8,1,eclipse",
            "7,0,0,0,30000,0,10000,0,0.6,0.8,2,flag",
            "9,0,0,0,30000,0,10000,0,0.6,0.8,1,no model",
            "100,0,0,0,nan,nan,nan,0,0,0,0,gap",
        ],
    );
    let errors = errors_of(&output);
    assert_eq!(output.status.code(), Some(1), "{errors}");
    let table = Table::read(&output.stdout);
    assert_eq!(
        table.columns,
        vec![
            "t_s",
            "note",
            "q_x",
            "q_y",
            "q_z",
            "q_w",
            "bias_x_rad_s",
            "bias_y_rad_s",
            "bias_z_rad_s",
            "sigma_att_x_rad",
            "sigma_att_y_rad",
            "sigma_att_z_rad",
            "nis_mag",
            "nis_sun",
            "source",
            "error"
        ]
    );
    let sources: Vec<&str> = (0..table.rows.len()).map(|row| table.text(row, "source")).collect();
    let expected = [
        "two-vectors",
        "sun",
        "field",
        "gyro",
        "held-rate",
        "none",
        "none",
        "gyro",
        "none",
        "gyro",
        "none",
    ];
    assert_eq!(sources, expected);
    for (row, source) in sources.iter().enumerate() {
        let has_attitude = table.number(row, "q_w").is_finite();
        assert_eq!(has_attitude, *source != "none", "row {row}");
        assert_eq!(table.number(row, "nis_sun").is_finite(), *source == "sun");
        let is_bad = !table.text(row, "error").is_empty();
        assert_eq!(errors.contains(&format!("line {},", row + 2)), is_bad, "{errors}");
    }
    assert!(errors.contains("line 7, column t_s: '3.5' is not after the '4'"), "{errors}");
    assert!(errors.contains("line 8, column gyro_y_rad_s: 'x' is not a number"), "{errors}");
    assert!(errors.contains("line 10, column sun_valid: '2' is neither 0 nor 1"), "{errors}");
}

#[test]
fn what_cannot_be_a_filter_is_refused_before_anything_is_written() {
    let config = |name: &str, from: &str, to: &str| {
        assert!(CONFIG.contains(from));
        file(name, &CONFIG.replace(from, to)).display().to_string()
    };
    let references = file("refused.references.csv", KNOWN).display().to_string();
    let cases = [
        (config("broken.json", "0.003,", "0.003"), "line 1 column"),
        (config("missing.json", "gyro_sigma_rad_s", "gyro_sigma"), "`gyro_sigma_rad_s`"),
        (config("text.json", "0.003", "\"small\""), "invalid type"),
        (config("degrees.json", "0.012", "0.664"), "sun_noise_rad is 6.64e-1"),
        (config("zero.json", "0.003", "0"), "gyro_noise_rad_s is 0e0"),
        (
            config("start.json", "{", r#"{"reference_filter_initial_q_xyzw": [0, 0, 0, 0],"#),
            "four finite numbers",
        ),
        (
            config(
                "sigma.json",
                "{",
                r#"{"reference_filter_initial_q_xyzw": [0, 0, 0, 1],
                    "reference_filter_P0_attitude_sigma_deg": 1000,"#,
            ),
            "attitude_sigma_rad is 1.7453",
        ),
        ("/nowhere/config.json".to_owned(), "cannot be read"),
        ("-".to_owned(), "only one"),
    ];
    for (config, reason) in &cases {
        let arguments = ["--measurements", "-", "--references", &references, "--config", config];
        let output = adcs(&arguments, MEASURED);
        let errors = errors_of(&output);
        assert_eq!(output.status.code(), Some(2), "{errors}");
        assert!(errors.contains(reason), "{reason}: {errors}");
        assert!(output.stdout.is_empty());
    }
}

#[test]
fn a_table_without_its_columns_and_a_filter_that_is_not_there_are_refused() {
    let config = file("columns.json", CONFIG).display().to_string();
    let references = file("columns.references.csv", KNOWN).display().to_string();
    let arguments = ["--measurements", "-", "--references", &references, "--config", &config];
    let output = adcs(&arguments, "t_s,gyro_x_rad_s\n0,0\n");
    assert_eq!(output.status.code(), Some(2));
    assert!(errors_of(&output).contains("no column gyro_y_rad_s"));

    let wrong = file("columns.wrong.csv", "t_s,B_teme_x_nT\n").display().to_string();
    let arguments = ["--measurements", "-", "--references", &wrong, "--config", &config];
    let output = adcs(&arguments, MEASURED);
    assert_eq!(output.status.code(), Some(2));
    assert!(errors_of(&output).contains("columns.wrong.csv: no column B_teme_y_nT"));

    let output = adcs(&["--filter", "dynamic"], "");
    assert_eq!(output.status.code(), Some(2));
}

#[test]
fn models_that_cannot_be_read_are_named_and_their_instants_have_no_correction() {
    let known = format!("{KNOWN}0,30000,0,10000,0,0.6,0.8,0\n1,30000,0,y,0,0.6,0.8,0\n");
    let references = file("bad.references.csv", &known).display().to_string();
    let config = file("bad.json", CONFIG).display().to_string();
    let rows = "0,0,0,0,30000,0,10000,0,0.6,0.8,1,\n1,0,0,0,30000,0,10000,0,0.6,0.8,1,\n";
    let arguments = ["--measurements", "-", "--references", &references, "--config", &config];
    let output = adcs(&arguments, &(MEASURED.to_owned() + rows));
    assert_eq!(output.status.code(), Some(1));
    assert!(errors_of(&output).contains("line 3, column B_teme_z_nT: 'y' is not a number"));
    let table = Table::read(&output.stdout);
    assert_eq!((table.text(0, "source"), table.text(1, "source")), ("two-vectors", "gyro"));
}
