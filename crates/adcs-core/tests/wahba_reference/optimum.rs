//! Against optima computed by singular value decomposition with 50 digits.

use adcs_core::attitude::Method;

use crate::OPTIMAL;
use crate::problem::{angle_rad, attitude, pairs, solve, solve_f32, widened};
use crate::table::{Row, Table, Worst};

const RANDOM: &str = include_str!("../data/wahba_random.csv");
const MARKLEY: &str = include_str!("../data/markley_realisations.csv");

/// f64: 200 roundings, enlarged by the problem's condition, or 1e-10 rad.
fn bar_rad(margin: f64) -> f64 {
    f64::max(1e-10, 200.0 * f64::EPSILON / margin)
}
/// f64, for what these methods do beyond that bar: no problem of the tables is conditioned worse
/// than 1e3 in directions, whatever its weights.
const ANGLE_RAD: f64 = 1e-12;
/// f32, where the margin is at least `F32_MARGIN`.
const F32_ANGLE_RAD: f64 = 2e-4;
const F32_MARGIN: f64 = 0.01;
/// Loss in f64: a residual of rounding alone is 1e-32; otherwise relative, where a residual as small as
/// 1e-8 is known to 1e-8.
const LOSS: f64 = 1e-28;
const LOSS_RELATIVE: f64 = 1e-7;
/// Margin in f64, relative: where two eigenvalues coincide a root keeps half its digits.
const MARGIN_RELATIVE: f64 = 1e-6;

fn for_each_row(mut look: impl FnMut(&Row<'_>, &str)) {
    for (file, text) in [("wahba_random", RANDOM), ("markley_realisations", MARKLEY)] {
        for row in Table::parse(text).rows() {
            assert_eq!(row.text("status"), "unique", "the tables hold unique problems only");
            let at = format!("{file} {} {}", row.text("id"), row.text("tag"));
            look(&row, &at);
        }
    }
}

#[test]
fn every_optimal_method_finds_the_optimum_in_f64() {
    for method in OPTIMAL {
        let mut of_bar = Worst::new("angle over max(1e-10, 200 ε / margin)");
        let mut angle = Worst::new("angle to the optimum, rad");
        let mut loss = Worst::new("loss beyond 1e-28, relative");
        let mut margin = Worst::new("margin, relative");
        println!("{method:?} in f64");
        for_each_row(|row, at| {
            let found = solve(method, &pairs(row)).unwrap_or_else(|no| panic!("{at}: {no}"));
            let expected_margin = row.number("margin_s2_plus_d_s3");
            let error = angle_rad(found.attitude, attitude(row, "q_opt"));
            of_bar.see(error / bar_rad(expected_margin), at);
            angle.see(error, at);
            let expected_loss = row.number("loss");
            let excess = (found.loss - expected_loss).abs() - LOSS;
            loss.see(excess.max(0.0) / expected_loss, at);
            margin.see((found.margin / expected_margin - 1.0).abs(), at);
        });
        of_bar.report(1.0);
        angle.report(ANGLE_RAD);
        loss.report(LOSS_RELATIVE);
        margin.report(MARGIN_RELATIVE);
    }
}

#[test]
fn every_optimal_method_finds_the_optimum_in_f32() {
    for method in OPTIMAL {
        let mut wide = Worst::new("angle to the optimum where the margin is 0.01 or more, rad");
        let mut narrow = Worst::new("angle to the optimum where it is less, rad");
        println!("{method:?} in f32");
        let mut refused = 0;
        for_each_row(|row, at| {
            let expected_margin = row.number("margin_s2_plus_d_s3");
            match solve_f32(method, &pairs(row)) {
                Ok(found) => {
                    let error = angle_rad(widened(found.attitude), attitude(row, "q_opt"));
                    let worst = if expected_margin >= F32_MARGIN { &mut wide } else { &mut narrow };
                    worst.see(error, at);
                }
                Err(no) => {
                    println!("refused: {at}, margin {expected_margin:.1e}: {no}");
                    refused += 1;
                }
            }
        });
        wide.report(F32_ANGLE_RAD);
        narrow.report(F32_ANGLE_RAD);
        assert_eq!(refused, 0, "every problem of the tables can be solved in f32");
    }
}

#[test]
fn triad_is_triad_of_the_first_two_pairs() {
    let mut angle = Worst::new("TRIAD, angle to the reference, rad");
    let mut angle_f32 = Worst::new("TRIAD in f32, angle to the reference, rad");
    for_each_row(|row, at| {
        let expected = attitude(row, "q_triad12");
        let found = solve(Method::Triad, &pairs(row)).unwrap_or_else(|no| panic!("{at}: {no}"));
        angle.see(angle_rad(found.attitude, expected), at);
        let found = solve_f32(Method::Triad, &pairs(row)).unwrap_or_else(|no| panic!("{at}: {no}"));
        angle_f32.see(angle_rad(widened(found.attitude), expected), at);
    });
    angle.report(ANGLE_RAD);
    angle_f32.report(F32_ANGLE_RAD);
}
