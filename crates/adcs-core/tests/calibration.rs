//! Magnetometer calibration against optima of independent solvers, random magnetometers, and nonsense.

use adcs_core::calibration::{
    Calibration, CalibrationError, DataSheet, MAX_CONDITION, MIN_SAMPLES, Sample, Start, Sums,
    Unknown, calibrate, norm_error,
};
use nalgebra::{RealField, Vector3, convert};
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
const SINGLE_BIAS_NT: f64 = 0.02;
const SINGLE_CONDITION: f64 = 1e-4;

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
fn errors<T: RealField + Copy>(
    found: &Calibration<T>,
    scale: [f64; 3],
    bias: [f64; 3],
) -> (f64, f64) {
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
        for start in [Start::DataSheet(DATA_SHEET), Start::Linear { zero: 0.0 }] {
            let found = found(&samples, &start);
            let (scale, bias) = errors(&found, optimum.scale, optimum.bias);
            assert!((found.condition / optimum.condition - 1.0).abs() < SCALE, "{}", case.name);
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
fn what_flies_finds_the_same_as_the_ground() {
    let data_sheet = DataSheet { sensitivity: 50e3_f32, zero: 0.0 };
    for case in &CASES {
        let samples = case.samples();
        let ground = found(&samples, &Start::DataSheet(DATA_SHEET));
        for start in [Start::DataSheet(data_sheet), Start::Linear { zero: 0.0 }] {
            let board = calibrate(single(&samples), &start).unwrap();
            let (scale, bias) = errors(&board, ground.scale, ground.bias);
            assert!(scale < SINGLE_SCALE && bias < SINGLE_BIAS_NT, "{}: {scale} {bias}", case.name);
            assert!(
                (f64::from(board.condition) / ground.condition - 1.0).abs() < SINGLE_CONDITION,
                "{}: {}",
                case.name,
                board.condition
            );
        }
    }
}

#[test]
fn a_flight_in_tesla_behind_the_driver_is_the_same_calibration() {
    // What the flight software has: fields in T by the data sheet, and |B| in T.
    let case = &CASES[1];
    let samples = case.samples();
    let tesla = |sample: &Sample<f64>| Sample {
        reading: sample.reading.map(|volt| (volt * DATA_SHEET.sensitivity * 1e-9) as f32),
        intensity: (sample.intensity * 1e-9) as f32,
    };
    let board = calibrate(
        samples.iter().map(tesla),
        &Start::DataSheet(DataSheet { sensitivity: 1.0, zero: 0.0 }),
    )
    .unwrap();
    let ground = found(&samples, &Start::DataSheet(DATA_SHEET));
    let (scale, bias) = ground.correction(DATA_SHEET);
    let (board_scale, board_bias) = board.correction(DataSheet { sensitivity: 1.0, zero: 0.0 });
    for axis in 0..3 {
        let scale = f64::from(board_scale[axis]) / scale[axis] - 1.0;
        let bias_nt = f64::from(board_bias[axis]) * 1e9 - bias[axis];
        assert!(scale.abs() < SINGLE_SCALE && bias_nt.abs() < SINGLE_BIAS_NT, "{scale} {bias_nt}");
    }
}

#[test]
fn the_start_of_the_reference_cases_is_as_wrong_as_they_say() {
    for case in &CASES {
        let samples = case.samples();
        let cost: f64 = samples
            .iter()
            .map(|sample| {
                let squared: f64 = sample.reading.iter().map(|v| (v * 50e3).powi(2)).sum();
                (squared - sample.intensity.powi(2)).powi(2)
            })
            .sum();
        assert!((cost / case.optimum().cost_at_start - 1.0).abs() < COST, "{}", case.name);
        // The paper's fig. 5.2: about ±20,000 nT before.
        let before = norm_error(samples.iter().copied(), [50e3; 3], [0.0; 3]);
        assert!(before.max - before.min > 20e3, "{}: {before:?}", case.name);
    }
}

/// Gaussian enough: the sum of twelve uniform numbers.
fn gaussian(random: &mut Pcg64Mcg) -> f64 {
    (0..12).map(|_| uniform(random, 0.0, 1.0)).sum::<f64>() - 6.0
}

fn uniform(random: &mut Pcg64Mcg, from: f64, to: f64) -> f64 {
    use rand_core::Rng as _;
    from + (to - from) * (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
}

/// Readings of a tumble that is fast against the samples: B = s ∘ V + b comes from all directions, and
/// its strength changes along the orbit.
fn tumble(
    count: usize,
    scale: [f64; 3],
    bias: [f64; 3],
    noise_nt: f64,
    random: &mut Pcg64Mcg,
) -> Vec<Sample<f64>> {
    let sample = |k: usize| {
        let intensity = 33e3 + 13e3 * (k as f64 * 0.021).sin();
        let direction = Vector3::from_fn(|_, _| gaussian(random)).normalize();
        let mut shown = |i: usize| {
            (direction[i] * intensity + noise_nt * gaussian(random) - bias[i]) / scale[i]
        };
        Sample { reading: [shown(0), shown(1), shown(2)], intensity }
    };
    (0..count).map(sample).collect()
}

#[test]
fn the_covariance_is_the_scatter_of_the_estimates() {
    /// Normalised estimation error squared of six unknowns is 6 on average; the mean of 300 scatters
    /// by 0.2, and 200 samples leave the covariance itself uncertain by 10 %.
    const NEES: std::ops::Range<f64> = 5.2..6.8;
    const RUNS: usize = 300;
    let (scale, bias) = ([47e3, 43e3, 58e3], [13.8e3, 10.3e3, -14.5e3]);
    let mut random = Pcg64Mcg::seed_from_u64(6);
    let total: f64 = (0..RUNS)
        .map(|_| {
            // So little noise that its shift of |B|² is a small part of sigma.
            let samples = tumble(200, scale, bias, 100.0, &mut random);
            let found = found(&samples, &Start::DataSheet(DATA_SHEET));
            let error = nalgebra::Vector6::from_fn(|i, _| match i {
                0..3 => found.scale[i] - scale[i],
                _ => found.bias[i - 3] - bias[i - 3],
            });
            error.dot(&(found.covariance.try_inverse().unwrap() * error))
        })
        .sum();
    let nees = total / RUNS as f64;
    assert!(NEES.contains(&nees), "{nees}");
}

#[test]
fn noise_shifts_the_optimum_as_the_documentation_says() {
    // Seen from all directions: s/s_true = 1 − 3.5 σ² Σ I² / Σ I⁴.
    const NOISE_NT: f64 = 1500.0;
    /// Of the shift, relative: three sigma of the mean of three scales from 40,000 samples, and what
    /// σ⁴ adds.
    const OF_SHIFT: f64 = 0.15;
    let samples = tumble(40_000, [50e3; 3], [0.0; 3], NOISE_NT, &mut Pcg64Mcg::seed_from_u64(3));
    let found = found(&samples, &Start::DataSheet(DATA_SHEET));
    let power = |n: i32| samples.iter().map(|sample| sample.intensity.powi(n)).sum::<f64>();
    let expected = -3.5 * NOISE_NT.powi(2) * power(2) / power(4);
    let shift = found.scale.iter().sum::<f64>() / 150e3 - 1.0;
    assert!((shift / expected - 1.0).abs() < OF_SHIFT, "{shift} {expected}");
}

#[test]
fn an_axis_the_other_way_round_looks_right_and_is_not() {
    // Signs cannot be seen: the true scale of y is negative, the result is its mirror image.
    let (scale, bias) = ([47e3, -43e3, 58e3], [3e3, 5e3, -4e3]);
    let samples = tumble(300, scale, bias, 0.0, &mut Pcg64Mcg::seed_from_u64(1));
    let found = found(&samples, &Start::DataSheet(DATA_SHEET));
    let (of_scale, of_bias) = errors(&found, [47e3, 43e3, 58e3], [3e3, -5e3, -4e3]);
    assert!(of_scale < NOISE_FREE_SCALE && of_bias < NOISE_FREE_BIAS_NT);
    assert!(found.norm_error.rms < NOISE_FREE_BIAS_NT);
}

#[test]
fn what_the_data_cannot_support_is_refused_with_the_reason() {
    let start = Start::DataSheet(DATA_SHEET);
    let refused = |samples: &[Sample<f64>]| {
        calibrate(samples.iter().copied(), &start).map(|found| found.condition).unwrap_err()
    };
    let samples = tumble(40, [47e3; 3], [3e3; 3], 500.0, &mut Pcg64Mcg::seed_from_u64(2));

    let few = MIN_SAMPLES as usize - 1;
    assert_eq!(
        refused(&samples[..few]),
        CalibrationError::TooFew { found: few as u32, needed: MIN_SAMPLES }
    );
    assert!(calibrate(samples[..=few].iter().copied(), &start).is_ok());

    let mut bad = samples.clone();
    bad[7].reading[2] = f64::NAN;
    assert_eq!(refused(&bad), CalibrationError::NotFinite { sample: 7 });
    bad[7] = Sample { intensity: 0.0, ..samples[7] };
    assert_eq!(refused(&bad), CalibrationError::Intensity { sample: 7, found: 0.0 });

    let dead = samples.iter().map(|&Sample { reading: [x, y, _], intensity }| Sample {
        reading: [x, y, 0.25],
        intensity,
    });
    let dead: Vec<_> = dead.collect();
    assert_eq!(refused(&dead), CalibrationError::Constant { axis: 2, found: 0.25 });

    // The body holds still in the field: all directions are one.
    let mut random = Pcg64Mcg::seed_from_u64(4);
    let still: Vec<_> = samples
        .iter()
        .map(|&Sample { intensity, .. }| Sample {
            reading: [0.6, 0.0, 0.8].map(|e| (e * intensity + 5.0 * gaussian(&mut random)) / 50e3),
            intensity,
        })
        .collect();
    match refused(&still) {
        CalibrationError::PoorGeometry {
            condition,
            limit,
            weakest: Unknown::Scale(_) | Unknown::Bias(_),
        } => {
            assert!(condition > limit && f64::from(limit) == MAX_CONDITION);
        }
        other => panic!("{other}"),
    }

    for sensitivity in [0.0, -50e3, f64::NAN] {
        let start = Start::DataSheet(DataSheet { sensitivity, zero: 0.0 });
        let error = calibrate(samples.iter().copied(), &start).unwrap_err();
        assert!(matches!(error, CalibrationError::Sensitivity { .. }), "{error}");
    }
}

#[test]
fn an_axis_that_shows_noise_only_is_refused() {
    let mut random = Pcg64Mcg::seed_from_u64(5);
    let mut samples = tumble(200, [50e3; 3], [0.0; 3], 0.0, &mut random);
    for sample in &mut samples {
        sample.reading[1] = 0.3 * gaussian(&mut random);
    }
    let error = calibrate(samples, &Start::DataSheet(DATA_SHEET)).unwrap_err();
    assert!(matches!(error, CalibrationError::NoScale { axis: 1, .. }), "{error}");
}

fn usable<T: RealField + Copy>(found: &Calibration<T>) -> bool {
    let (scale_sigma, bias_sigma) = found.sigma();
    let values = [found.scale, found.bias, scale_sigma, bias_sigma];
    let positive = found.scale.iter().all(|&scale| scale > T::zero());
    positive
        && values.as_flattened().iter().all(nalgebra::ComplexField::is_finite)
        && found.cost.is_finite()
        && found.condition <= convert(MAX_CONDITION)
}

fn any_samples() -> impl Strategy<Value = Vec<[f32; 4]>> {
    let any = prop_oneof![
        any::<f32>(),
        -1.0..1.0_f32,
        Just(0.0),
        Just(f32::MAX),
        Just(f32::MIN_POSITIVE)
    ];
    let tame = prop::array::uniform4(-1.0..1.0_f32);
    prop_oneof![
        prop::collection::vec(prop::array::uniform4(any), 0..40),
        prop::collection::vec(tame, 12..40)
    ]
}

proptest! {
    #[test]
    fn random_magnetometers_are_recovered_from_a_tumble_without_noise(
        factor in prop::array::uniform3(0.6..1.6_f64),
        bias in prop::array::uniform3(-20e3..20e3_f64),
        count in 30_usize..400,
        seed: u64,
    ) {
        let scale = factor.map(|factor| 50e3 * factor);
        let samples = tumble(count, scale, bias, 0.0, &mut Pcg64Mcg::seed_from_u64(seed));
        for start in [Start::DataSheet(DATA_SHEET), Start::Linear { zero: 0.0 }] {
            let found = found(&samples, &start);
            let (of_scale, of_bias) = errors(&found, scale, bias);
            prop_assert!(of_scale < NOISE_FREE_SCALE && of_bias < NOISE_FREE_BIAS_NT, "{found:?}");
        }
    }

    #[test]
    fn the_correction_of_the_flight_software_gives_the_field(
        factor in prop::array::uniform3(0.6..1.6_f64),
        bias in prop::array::uniform3(-20e3..20e3_f64),
        zero in -2.0..2.0_f64,
        seed: u64,
    ) {
        let scale = factor.map(|factor| 50e3 * factor);
        let raw_bias = [0, 1, 2].map(|i| bias[i] - scale[i] * zero);
        let samples = tumble(100, scale, raw_bias, 0.0, &mut Pcg64Mcg::seed_from_u64(seed));
        let data_sheet = DataSheet { sensitivity: 50e3, zero };
        let found = found(&samples, &Start::DataSheet(data_sheet));
        let (scale, bias) = found.correction(data_sheet);
        for sample in &samples {
            let field = [0, 1, 2].map(|i| {
                let driver = data_sheet.sensitivity * (sample.reading[i] - zero);
                scale[i] * driver - bias[i]
            });
            let norm = Vector3::from(field).norm();
            prop_assert!((norm - sample.intensity).abs() < 10.0 * NOISE_FREE_BIAS_NT);
        }
    }

    #[test]
    fn nonsense_gives_a_reason_or_a_finite_result(
        rows in any_samples(),
        sensitivity in prop_oneof![any::<f32>(), Just(1.0)],
        zero in prop_oneof![any::<f32>(), Just(0.0)],
    ) {
        let samples = rows.iter().map(|&[x, y, z, i]| Sample { reading: [x, y, z], intensity: i.abs() });
        for start in [Start::DataSheet(DataSheet { sensitivity, zero }), Start::Linear { zero }] {
            match calibrate(samples.clone(), &start) {
                Ok(found) => prop_assert!(usable(&found), "{found:?}"),
                Err(reason) => prop_assert!(!reason.to_string().is_empty()),
            }
        }
    }
}

/// What the counting image (adcs-firmware, bench) calibrates.
fn readings_of_the_bench() -> impl Iterator<Item = Sample<f32>> + Clone {
    (0..100_u32).map(|k| {
        let [x, y, z] = [k * 7 % 11, k * 5 % 13, k * 3 % 7].map(|step| step as f32);
        let [x, y, z] = [x - 4.5, y - 5.5, z - 3.5].map(|step| step * 6e-6);
        Sample {
            reading: [(x - 1e-5) / 0.9, (y + 8e-6) / 1.1, (z - 5e-6) / 1.2],
            intensity: Vector3::new(x, y, z).norm(),
        }
    })
}

const BENCH_SHEET: DataSheet<f32> = DataSheet { sensitivity: 1.0, zero: 0.0 };

#[test]
fn the_emulated_core_finds_these_bits_from_sums() {
    /// Of f32 against f64: roundings of sums of 100 terms of the fourth degree, and a condition of some ten.
    const SUMS_SCALE: f64 = 1e-5;
    const SUMS_BIAS_NT: f64 = 0.3;
    // The counting image compares.
    const CHOSEN_BITS: [[u32; 3]; 2] =
        [[0x3f666663, 0x3f8ccccf, 0x3f9999a2], [0xb727c5aa, 0x370637c4, 0xb6a7c5cd]];
    let mut sums = Sums::new(BENCH_SHEET, 3e-5).unwrap();
    readings_of_the_bench().for_each(|sample| sums.add(sample).unwrap());
    let chosen = sums.chosen().unwrap();
    let (found, _) = chosen.correction(BENCH_SHEET);
    let bits = [found.scale, found.bias].map(|three| three.map(f32::to_bits));
    assert_eq!(bits, CHOSEN_BITS);
    // And f64, the ground, agrees within what f32 leaves of the sums.
    let mut wide = Sums::new(DataSheet { sensitivity: 1.0, zero: 0.0 }, 3e-5).unwrap();
    for Sample { reading, intensity } in readings_of_the_bench() {
        let reading = reading.map(f64::from);
        wide.add(Sample { reading, intensity: f64::from(intensity) }).unwrap();
    }
    let ground = wide.chosen().unwrap().parameters;
    for (found, ground) in chosen.parameters.0.iter().zip(ground.0.iter()) {
        let error = f64::from(*found) - ground;
        let bound = if ground.abs() > 0.1 { SUMS_SCALE } else { SUMS_BIAS_NT * 1e-9 };
        assert!(error.abs() < bound, "{found}: {error}");
    }
}

#[test]
fn the_emulated_core_finds_these_bits() {
    // The counting image compares.
    const CALIBRATED_BITS: [u32; 6] =
        [0x3f666665, 0x3f8ccccd, 0x3f99999b, 0x3727c5ab, 0xb70637bc, 0x36a7c5ad];
    let samples = readings_of_the_bench();
    let found = calibrate(samples.clone(), &Start::DataSheet(BENCH_SHEET)).unwrap();
    let [s_x, s_y, s_z] = found.scale.map(f32::to_bits);
    let [b_x, b_y, b_z] = found.bias.map(f32::to_bits);
    assert_eq!([s_x, s_y, s_z, b_x, b_y, b_z], CALIBRATED_BITS);
    // And f64, the ground, agrees within some roundings.
    let wide = samples.map(|Sample { reading, intensity }| Sample {
        reading: reading.map(f64::from),
        intensity: f64::from(intensity),
    });
    let ground =
        calibrate(wide, &Start::DataSheet(DataSheet { sensitivity: 1.0, zero: 0.0 })).unwrap();
    let (scale, bias) = errors(&found, ground.scale, ground.bias);
    assert!(scale < SINGLE_SCALE && bias * 1e9 < SINGLE_BIAS_NT, "{scale} {bias}");
}
