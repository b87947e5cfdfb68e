//! `adcs attitude`, from the table to the exit code.

mod support;

use std::process::Output;

use support::Table;

/// The 200 problems with known optima of the library's tests.
const REFERENCE: &str =
    concat!(env!("CARGO_MANIFEST_DIR"), "/../adcs-core/tests/data/wahba_random.csv");
/// Angle to the optimum in f64, rad.
const ANGLE_RAD: f64 = 1e-10;
/// Angle to the optimum in f32, rad.
const SINGLE_ANGLE_RAD: f64 = 2e-4;

fn adcs(arguments: &[&str], input: &str) -> Output {
    support::adcs("attitude", arguments, input)
}

fn angle_rad(p: [f64; 4], q: [f64; 4]) -> f64 {
    let [x, y, z, w] = p;
    let conjugate = nalgebra::Quaternion::new(w, -x, -y, -z);
    let [x, y, z, w] = q;
    let between = conjugate * nalgebra::Quaternion::new(w, x, y, z);
    2.0 * between.imag().norm().atan2(between.w.abs())
}

#[test]
fn every_method_solves_the_reference_problems_in_both_precisions() {
    for method in ["foam", "q-method", "quest", "triad"] {
        for (single, bar_rad) in [(false, ANGLE_RAD), (true, SINGLE_ANGLE_RAD)] {
            let mut arguments = vec![REFERENCE, "--method", method];
            arguments.extend(single.then_some("--single"));
            let output = adcs(&arguments, "");
            assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
            let table = Table::read(&output.stdout);
            assert_eq!(table.rows.len(), 200);
            assert_eq!(table.columns.get(0), Some("id"));
            for row in 0..200 {
                assert_eq!(table.text(row, "status"), "unique");
                let expected = if method == "triad" { "q_triad12" } else { "q_opt" };
                let found = table.quaternion(row, "q");
                let error_rad = angle_rad(found, table.quaternion(row, expected));
                assert!(error_rad < bar_rad, "{method} {single} row {row}: {error_rad}");
                assert!(found[3] >= 0.0);
            }
        }
    }
}

/// Pairs along x and y, unless the row says otherwise.
const HEADER: &str = "id,n_vectors,r1_x,r1_y,r1_z,b1_x,b1_y,b1_z,r2_x,r2_y,r2_z,b2_x,b2_y,b2_z,sigma1_rad,sigma2_rad\n";

#[test]
fn rows_without_an_attitude_say_why_and_the_others_are_solved() {
    let rows = [
        ("good", "2,1,0,0,1,0,0,0,1,0,0,1,0,0.01,0.02", "unique", ""),
        ("one", "1,1,0,0,1,0,0,nan,nan,nan,nan,nan,nan,0.01,nan", "nonunique", "two are needed"),
        ("parallel", "2,1,0,0,1,0,0,-3,0,0,-1,0,0,0.01,0.02", "nonunique", "not unique"),
        ("zero", "2,1,0,0,0,0,0,0,1,0,0,1,0,0.01,0.02", "invalid", "column b1_x: the measured"),
        ("nan", "2,1,0,0,1,0,0,0,nan,0,0,1,0,0.01,0.02", "invalid", "column r2_y: 'nan'"),
        ("sigma", "2,1,0,0,1,0,0,0,1,0,0,1,0,0.01,-0.02", "invalid", "column sigma2_rad"),
        ("three", "3,1,0,0,1,0,0,0,1,0,0,1,0,0.01,0.02", "invalid", "columns for 2"),
        ("count", "1.5,1,0,0,1,0,0,0,1,0,0,1,0,0.01,0.02", "invalid", "no count"),
        ("short", "2,1,0,0", "invalid", "fields"),
        ("last", "2,1,0,0,0,1,0,0,1,0,-1,0,0,0.01,0.02", "unique", ""),
    ];
    let input: String =
        rows.iter().fold(HEADER.to_owned(), |text, (id, row, ..)| text + id + "," + row + "\n");
    for method in ["foam", "q-method", "quest", "triad"] {
        for single in [None, Some("--single")] {
            let arguments: Vec<_> = ["-", "--method", method].into_iter().chain(single).collect();
            let output = adcs(&arguments, &input);
            let errors = String::from_utf8_lossy(&output.stderr).into_owned();
            assert_eq!(output.status.code(), Some(1), "{errors}");
            let table = Table::read(&output.stdout);
            for (at, (id, _, status, reason)) in rows.iter().enumerate() {
                assert_eq!((table.text(at, "id"), table.text(at, "status")), (*id, *status));
                assert!(table.text(at, "error").contains(reason), "{}", table.text(at, "error"));
                let has_attitude = table.quaternion(at, "q").iter().all(|q| q.is_finite());
                assert_eq!(has_attitude, *status == "unique", "{id}");
                // Line 1 is the header.
                let reported = errors.contains(&format!("line {}", at + 2));
                assert_eq!(reported, *status == "invalid", "{id}: {errors}");
            }
            // The last row: yawed by +90 deg, r = x is seen along body y.
            let half = std::f64::consts::FRAC_1_SQRT_2;
            assert!(
                angle_rad(table.quaternion(9, "q"), [0.0, 0.0, -half, half]) < SINGLE_ANGLE_RAD
            );
        }
    }
}

#[test]
fn a_table_without_pairs_is_refused() {
    let output = adcs(&["-", "--method", "foam"], "id,n_vectors\n1,2\n");
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("no column r1_x"));
    assert!(output.stdout.is_empty());
}
