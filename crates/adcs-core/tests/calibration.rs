//! Magnetometer calibration against optima of independent solvers, random magnetometers, and nonsense.

use adcs_core::calibration::{
    Calibration, CalibrationError, DataSheet, MAX_CONDITION, MIN_SAMPLES, Sample, Start, Unknown,
    calibrate, norm_error,
};
use nalgebra::{RealField, Rotation3, Vector3, convert};
use proptest::prelude::*;
use rand_core::SeedableRng as _;
use rand_pcg::Pcg64Mcg;

/// The data sheet of the reference cases.
const DATA_SHEET: DataSheet<f64> = DataSheet { sensitivity: 50_000.0, zero: 0.0 };

/// Of the cost, relative to the optimum's, which is exact to 30 digits.
const COST: f64 = 1e-9;
/// Of a scale, relative; of a bias, nT: solvers agree to 2e-5 nT.
const SCALE: f64 = 1e-6;
const BIAS_NT: f64 = 0.1;
/// The same without noise, where the optimum is the truth.
const NOISE_FREE_SCALE: f64 = 1e-9;
const NOISE_FREE_BIAS_NT: f64 = 1e-3;
/// Of f32 against f64: some roundings (6e-8) of the field, times the root of the condition.
const SINGLE_SCALE: f64 = 1e-6;
const SINGLE_BIAS_NT: f64 = 0.1;

struct Case {
    name: &'static str,
    samples: &'static str,
}

const CASES: [Case; 5] = [
    Case {
        name: "a_tumbling_noise_free",
        samples: include_str!("data/magcal/magcal_a_tumbling_noise_free.csv"),
    },
    Case {
        name: "b_tumbling_500nT",
        samples: include_str!("data/magcal/magcal_b_tumbling_500nT.csv"),
    },
    Case {
        name: "c_tumbling_500nT_adc10bit",
        samples: include_str!("data/magcal/magcal_c_tumbling_500nT_adc10bit.csv"),
    },
    Case {
        name: "d_nadir_locked_500nT",
        samples: include_str!("data/magcal/magcal_d_nadir_locked_500nT.csv"),
    },
    Case {
        name: "e_few_samples_500nT",
        samples: include_str!("data/magcal/magcal_e_few_samples_500nT.csv"),
    },
];

/// Name, then numbers.
fn rows(text: &str) -> impl Iterator<Item = Vec<&str>> {
    text.lines().skip(1).map(|line| line.split(',').collect())
}

fn value(text: &str) -> f64 {
    text.parse().unwrap()
}

impl Case {
    fn samples(&self) -> Vec<Sample<f64>> {
        let sample = |row: Vec<&str>| Sample {
            reading: [value(row[1]), value(row[2]), value(row[3])],
            intensity: value(row[4]),
        };
        rows(self.samples).map(sample).collect()
    }

    fn optimum(&self) -> Optimum {
        let row = rows(include_str!("data/magcal/magcal_optimum.csv"))
            .find(|row| row[0] == self.name)
            .unwrap();
        let numbers: Vec<f64> = row[1..].iter().map(|text| value(text)).collect();
        Optimum {
            scale: [numbers[0], numbers[1], numbers[2]],
            bias: [numbers[3], numbers[4], numbers[5]],
            cost: numbers[6],
            cost_at_start: numbers[7],
            norm_error_rms: numbers[8],
            condition: numbers[9],
        }
    }
}

struct Optimum {
    scale: [f64; 3],
    bias: [f64; 3],
    cost: f64,
    cost_at_start: f64,
    norm_error_rms: f64,
    condition: f64,
}

fn found(samples: &[Sample<f64>], start: &Start<f64>) -> Calibration<f64> {
    calibrate(samples.iter().copied(), start).unwrap()
}

/// Largest relative error of a scale, and largest error of a bias.
fn errors<T: RealField + Copy>(found: &Calibration<T>, scale: [f64; 3], bias: [f64; 3]) -> (f64, f64) {
    let known = |x: T| nalgebra::convert_unchecked::<T, f64>(x);
    let of_scale = (0..3).map(|i| (known(found.scale[i]) / scale[i] - 1.0).abs());
    let of_bias = (0..3).map(|i| (known(found.bias[i]) - bias[i]).abs());
    (of_scale.fold(0.0, f64::max), of_bias.fold(0.0, f64::max))
}

fn single(samples: &[Sample<f64>]) -> Vec<Sample<f32>> {
    let single = |sample: &Sample<f64>| Sample {
        reading: sample.reading.map(|x| x as f32),
        intensity: sample.intensity as f32,
    };
    samples.iter().map(single).collect()
}

#[test]
fn the_optimum_of_every_reference_case_is_found_from_the_data_sheet_and_from_the_ellipsoid() {
    for case in &CASES {
        let (samples, optimum) = (case.samples(), case.optimum());
        for start in [Start::DataSheet(DATA_SHEET), Start::Linear] {
            let found = found(&samples, &start);
            let (scale, bias) = errors(&found, optimum.scale, optimum.bias);
            println!(
                "{} {start:?}: scale {scale:.1e}, bias {bias:.1e} nT, cost {:.1e}, {} steps, condition {:.2} ({:.2})",
                case.name, found.cost / optimum.cost - 1.0, found.iterations, found.condition, optimum.condition
            );
            if case.name.contains("noise_free") {
                assert!(scale < NOISE_FREE_SCALE && bias < NOISE_FREE_BIAS_NT, "{}", case.name);
            } else {
                assert!(scale < SCALE && bias < BIAS_NT, "{}: {scale} {bias}", case.name);
                assert!(found.cost <= optimum.cost * (1.0 + COST), "{}", case.name);
                let rms = found.norm_error.rms / optimum.norm_error_rms;
                assert!((rms - 1.0).abs() < SCALE, "{}: {rms}", case.name);
            }
        }
    }
}

#[test]
fn f32() {
    for case in &CASES {
        let samples = case.samples();
        let ground = found(&samples, &Start::DataSheet(DATA_SHEET));
        for start in [Start::DataSheet(DataSheet { sensitivity: 50e3_f32, zero: 0.0 }), Start::Linear] {
            let board = calibrate(single(&samples), &start).unwrap();
            let (scale, bias) = errors(&board, ground.scale, ground.bias);
            println!("{} scale {scale:.1e}, bias {bias:.1e} nT {} steps sigma {:?} / {:?}", case.name, board.iterations, board.sigma(), ground.sigma());
        }
    }
}
