//! Markley's twelve cases, many draws of noise each.

use nalgebra::Matrix3;

use crate::OPTIMAL;
use crate::noise::Noise;
use crate::problem::{Pair, angle_rad, attitude, solve};
use crate::table::{Row, Table};

const CASES: &str = include_str!("../data/markley_cases.csv");
const EXPECTED: &str = include_str!("../data/markley_expected_errors.csv");

const DRAWS: u32 = 10_000;
/// Relative. The rms of 10,000 draws itself scatters by 0.7 % at most (error along one axis: √(1/2N)).
const RMS: f64 = 0.05;
/// Relative, on the mean of the loss: with one degree of freedom it scatters by √(2/N) = 1.4 %.
const MEAN_LOSS: f64 = 0.06;
/// Relative, on the mean predicted variance beside the errors' mean square.
const CONSISTENCY: f64 = 0.05;

/// Cases in which errors are of the order of a radian: linear theory does not hold, and the expected
/// values are those of 20,000 draws.
const BEYOND_LINEAR: [f64; 2] = [8.0, 9.0];

fn draw(case: &Row<'_>, noise: &mut Noise) -> Vec<Pair> {
    let a: Matrix3<f64> = attitude(case, "q_true").matrix();
    (1..=case.number("n_vectors") as u32)
        .map(|i| {
            let columns = ["x", "y", "z"].map(|axis| format!("r{i}_{axis}"));
            let reference = case.vector(columns.each_ref().map(String::as_str));
            let sigma_rad = case.number(&format!("sigma{i}_rad"));
            Pair { body: noise.disturbed(&(a * reference), sigma_rad), reference, sigma_rad }
        })
        .collect()
}

#[test]
fn errors_loss_and_covariance_are_those_expected_in_markleys_cases() {
    let (cases, expected) = (Table::parse(CASES), Table::parse(EXPECTED));
    println!(
        "case  expected rms, rad  measured / expected: rms, χ²/2; predicted / measured variance"
    );
    for (case, expected) in cases.rows().zip(expected.rows()) {
        let number = case.number("case");
        assert_eq!(number, expected.number("case"));
        let linear = !BEYOND_LINEAR.contains(&number);
        let column = if linear {
            "predicted_rms_total_rad_quest_covariance"
        } else {
            "montecarlo_rms_total_rad"
        };
        let expected_rms = expected.number(column);
        let expected_loss = if linear {
            expected.number("degrees_of_freedom_2n_minus_3") / 2.0
        } else {
            expected.number("montecarlo_mean_weighted_loss_half_sum_chi2")
        };
        let truth = attitude(&case, "q_true");

        let mut noise = Noise::new(1993 + number as u64);
        let (mut square, mut variance, mut loss) = (0.0, 0.0, 0.0);
        for _ in 0..DRAWS {
            let pairs = draw(&case, &mut noise);
            let information: f64 = pairs.iter().map(|pair| pair.sigma_rad.powi(-2)).sum();
            // The methods agree, draw by draw, elsewhere: they take turns here.
            let method = OPTIMAL[noise.uniform().mul_add(-3.0, 3.0) as usize % 3];
            let found = solve(method, &pairs).expect("the cases are unique");
            square += angle_rad(found.attitude, truth).powi(2) / f64::from(DRAWS);
            variance += found.covariance_rad2.trace() / f64::from(DRAWS);
            loss += found.loss * information / f64::from(DRAWS);
        }
        let (rms, loss) = (square.sqrt() / expected_rms, loss / expected_loss);
        let consistency = variance / square;
        println!("{number:4}  {expected_rms:.4e}  {rms:.4}  {loss:.4}  {consistency:.4}");
        assert!((rms - 1.0).abs() < RMS, "case {number}: rms {rms} of the expected");
        assert!((loss - 1.0).abs() < MEAN_LOSS, "case {number}: loss {loss} of the expected");
        let consistent = (consistency - 1.0).abs() < CONSISTENCY;
        assert!(consistent || !linear, "case {number}: variance {consistency} of the errors'");
    }
}
