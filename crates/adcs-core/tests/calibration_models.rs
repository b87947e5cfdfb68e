//! Calibrations beyond scale and bias: cross-axis terms, currents, TWOSTEP, sums, the shift by noise.

use adcs_core::calibration::{
    CalibrationError, CoupledSample, DataSheet, Evidence, Extended, NoiseShift, Parameters, Sample,
    Start, Sums, Unknown, calibrate, calibrate_extended, twostep,
};
use nalgebra::{SVector, Vector3};
use rand_core::{Rng as _, SeedableRng as _};
use rand_pcg::Pcg64Mcg;

const DATA_SHEET: DataSheet<f64> = DataSheet { sensitivity: 50e3, zero: 0.0 };
const START: Start<f64> = Start::DataSheet(DATA_SHEET);
/// Without noise, of a scale and of a cross-axis term, relative; of a bias, nT; a coupling, nT/A.
const NOISE_FREE: f64 = 1e-9;
const NOISE_FREE_NT: f64 = 1e-3;

/// A magnetometer with 8 % from axis to axis, nT/V, nT, and 9,000 nT/A of a panel's current on x.
fn truth() -> Parameters<f64, 12> {
    Parameters(SVector::from([
        47e3, 43e3, 58e3, 5.5e3, -9.9e3, 12.8e3, 0.08, -0.05, 0.03, 9e3, -4e3, 2e3,
    ]))
}

fn first<const N: usize>(x: &Parameters<f64, 12>) -> Parameters<f64, N> {
    Parameters(SVector::from_fn(|i, _| x.0[i]))
}

struct Random(Pcg64Mcg);

impl Random {
    fn new(seed: u64) -> Self {
        Self(Pcg64Mcg::seed_from_u64(seed))
    }

    fn uniform(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// The sum of twelve uniform numbers.
    fn gaussian(&mut self) -> f64 {
        (0..12).map(|_| self.uniform()).sum::<f64>() - 6.0
    }

    /// Readings of a fast tumble: the field comes from all directions. The panel's current is there for
    /// two thirds of the time.
    fn tumble(
        &mut self,
        count: usize,
        x: &Parameters<f64, 12>,
        noise_nt: f64,
    ) -> Vec<CoupledSample<f64, 1>> {
        let inverse = x.matrix().try_inverse().unwrap();
        let sample = |k: usize| {
            let intensity = 33e3 + 13e3 * (k as f64 * 0.021).sin();
            let direction = Vector3::from_fn(|_, _| self.gaussian()).normalize();
            let current = if k % 90 < 60 { 0.6 + 0.3 * self.uniform() } else { 0.0 };
            let field = direction * intensity
                - Vector3::from(x.bias())
                - Vector3::from(x.coupling(0)) * current;
            // Noise of the reading, which is 50,000 nT/V.
            let noise = Vector3::from_fn(|_, _| self.gaussian()) * (noise_nt / 50e3);
            let reading = (inverse * field + noise).into();
            CoupledSample { sample: Sample { reading, intensity }, currents: [current] }
        };
        (0..count).map(sample).collect()
    }
}

fn without_currents(
    samples: &[CoupledSample<f64, 1>],
) -> impl Iterator<Item = CoupledSample<f64, 0>> + Clone {
    samples.iter().map(|coupled| coupled.sample.into())
}

/// No coupling, or no cross-axis terms either.
fn simpler(unknowns: usize) -> Parameters<f64, 12> {
    Parameters(SVector::from_fn(|i, _| if i < unknowns { truth().0[i] } else { 0.0 }))
}

fn assert_near<const N: usize>(found: &Parameters<f64, N>, truth: &Parameters<f64, 12>) {
    for i in 0..N {
        let error = found.0[i] - truth.0[i];
        let bound = match i {
            0..3 => NOISE_FREE * truth.0[i].abs(),
            6..9 => NOISE_FREE,
            _ => NOISE_FREE_NT,
        };
        assert!(error.abs() < bound, "unknown {i}: {error}");
    }
}

#[test]
fn without_noise_every_model_is_recovered_from_the_data_sheet() {
    let nine = Random::new(1).tumble(300, &simpler(9), 0.0);
    let found: Extended<f64, 9> =
        calibrate_extended(without_currents(&nine), &START, NoiseShift::Kept).unwrap();
    assert_near(&found.parameters, &truth());
    assert_eq!(Unknown::CrossAxis(0).to_string(), "the angle between x and y");

    let coupled = Random::new(2).tumble(300, &truth(), 0.0);
    let found: Extended<f64, 12> = calibrate_extended(coupled, &START, NoiseShift::Kept).unwrap();
    assert_near(&found.parameters, &truth());

    let samples = nine.iter().map(|coupled| coupled.sample);
    let found = twostep(samples.clone(), DATA_SHEET).unwrap();
    assert_near(&found.parameters, &truth());

    let mut sums = Sums::new(DATA_SHEET, 35e3).unwrap();
    samples.for_each(|sample| sums.add(sample).unwrap());
    assert_near(&sums.calibration::<9>().unwrap().parameters, &truth());
}

#[test]
fn six_unknowns_are_the_papers_calibration() {
    let samples = Random::new(3).tumble(200, &truth(), 500.0);
    let six: Extended<f64, 6> =
        calibrate_extended(without_currents(&samples), &START, NoiseShift::Kept).unwrap();
    let paper = calibrate(samples.iter().map(|coupled| coupled.sample), &START).unwrap();
    /// Of two descents to one optimum, relative.
    const SAME: f64 = 1e-9;
    let same = |a: f64, b: f64| (a / b - 1.0).abs() < SAME;
    for axis in 0..3 {
        assert!(same(six.parameters.scale()[axis], paper.scale[axis]));
        assert!(same(six.parameters.bias()[axis], paper.bias[axis]));
    }
    assert!(same(six.cost, paper.cost) && same(six.condition, paper.condition));
    let covariances = six.covariance.iter().zip(paper.covariance.iter());
    assert!(covariances.into_iter().all(|(a, b)| same(*a, *b)));
}

#[test]
fn a_zero_that_is_not_zero_moves_the_bias_and_its_covariance_alone() {
    let samples = Random::new(4).tumble(200, &simpler(9), 500.0);
    let raised = without_currents(&samples).map(|CoupledSample { sample, currents }| {
        let reading = sample.reading.map(|volt| volt + 1.65);
        CoupledSample { sample: Sample { reading, ..sample }, currents }
    });
    let start = Start::DataSheet(DataSheet { zero: 1.65, ..DATA_SHEET });
    let at_zero: Extended<f64, 9> =
        calibrate_extended(without_currents(&samples), &START, NoiseShift::Kept).unwrap();
    let raised: Extended<f64, 9> = calibrate_extended(raised, &start, NoiseShift::Kept).unwrap();
    for coupled in &samples {
        let volts = coupled.sample.reading;
        let [a, b] = [(at_zero, volts), (raised, volts.map(|volt| volt + 1.65))]
            .map(|(found, volts)| Vector3::from(found.parameters.field(volts, &[])));
        assert!((a - b).norm() < NOISE_FREE_NT, "{}", (a - b).norm());
    }
    // A bias counted from 1.65 V away is known less.
    assert!(raised.sigma().bias()[0] > 2.0 * at_zero.sigma().bias()[0]);
}

/// Mean of the normalised estimation error squared over many runs; it should be the number of unknowns.
fn nees<const N: usize>(
    runs: u64,
    truth: &Parameters<f64, 12>,
    mut found: impl FnMut(u64) -> (Parameters<f64, N>, nalgebra::SMatrix<f64, N, N>),
) -> f64 {
    let total: f64 = (0..runs)
        .map(|seed| {
            let (parameters, covariance) = found(seed);
            let error = parameters.0 - first::<N>(truth).0;
            // Of units as different as nT/V and one.
            let unit = covariance.diagonal().map(|variance| 1.0 / variance.sqrt());
            let scaled = covariance.component_mul(&(unit * unit.transpose()));
            let error = error.component_mul(&unit);
            error.dot(&(scaled.try_inverse().unwrap() * error))
        })
        .sum();
    total / runs as f64
}

#[test]
fn the_covariances_are_the_scatter_of_the_estimates() {
    /// Three standard errors of a mean of 200 (√(2 N / 200)), and a covariance from 300 samples of noise
    /// that is uncertain itself.
    const RUNS: u64 = 200;
    const OF_NINE: std::ops::Range<f64> = 8.0..10.5;
    const OF_TWELVE: std::ops::Range<f64> = 10.8..13.8;
    // So little noise that its shift is a small part of sigma.
    let nine = |seed| Random::new(seed).tumble(300, &simpler(9), 100.0);
    let mean = nees::<9>(RUNS, &truth(), |seed| {
        let samples = nine(seed);
        let found =
            calibrate_extended(without_currents(&samples), &START, NoiseShift::Kept).unwrap();
        (found.parameters, found.covariance)
    });
    assert!(OF_NINE.contains(&mean), "nine: {mean}");
    let mean = nees::<9>(RUNS, &truth(), |seed| {
        let mut sums = Sums::new(DATA_SHEET, 35e3).unwrap();
        nine(seed).iter().for_each(|coupled| sums.add(coupled.sample).unwrap());
        let found = sums.calibration().unwrap();
        (found.parameters, found.covariance)
    });
    assert!(OF_NINE.contains(&mean), "sums: {mean}");
    let mean = nees::<12>(RUNS, &truth(), |seed| {
        let samples = Random::new(seed).tumble(300, &truth(), 100.0);
        let found = calibrate_extended(samples, &START, NoiseShift::Kept).unwrap();
        (found.parameters, found.covariance)
    });
    assert!(OF_TWELVE.contains(&mean), "coupled: {mean}");
}

#[test]
fn the_shift_by_noise_is_removed() {
    const NOISE_NT: f64 = 1500.0;
    /// The shift is 0.6 % of a scale; 40,000 samples leave 0.02 % of scatter.
    const LEFT: f64 = 1e-3;
    let x = simpler(9);
    let samples = Random::new(5).tumble(40_000, &x, NOISE_NT);
    let off = |shift| -> [f64; 3] {
        let found: Extended<f64, 9> =
            calibrate_extended(without_currents(&samples), &START, shift).unwrap();
        if shift == NoiseShift::Removed {
            // Noise of a reading, V; found from residuals.
            assert!((found.noise * 50e3 / NOISE_NT - 1.0).abs() < 0.02, "{}", found.noise);
        }
        [0, 1, 2].map(|axis| found.parameters.scale()[axis] / x.scale()[axis] - 1.0)
    };
    let (kept, removed) = (off(NoiseShift::Kept), off(NoiseShift::Removed));
    assert!(kept.iter().all(|off| *off < -3.0 * LEFT), "{kept:?}");
    assert!(removed.iter().all(|off| off.abs() < LEFT), "{removed:?}");
}

#[test]
fn the_model_that_made_the_data_is_the_one_that_the_evidence_names() {
    for (seed, unknowns) in (0..20).flat_map(|seed| [6, 9, 12].map(|unknowns| (seed, unknowns))) {
        let samples = Random::new(100 + seed).tumble(200, &simpler(unknowns), 586.0);
        let kept = NoiseShift::Kept;
        let six: Extended<f64, 6> =
            calibrate_extended(without_currents(&samples), &START, kept).unwrap();
        let nine: Extended<f64, 9> =
            calibrate_extended(without_currents(&samples), &START, kept).unwrap();
        let twelve: Extended<f64, 12> =
            calibrate_extended(samples.iter().copied(), &START, kept).unwrap();
        let of = [Evidence::of(&six), Evidence::of(&nine), Evidence::of(&twelve)];
        let chosen =
            of.into_iter().reduce(|best, next| if next.beats(&best) { next } else { best });
        assert_eq!(chosen.unwrap().unknowns, unknowns as u32, "seed {seed}: {of:?}");
    }
}

#[test]
fn sums_in_single_precision_find_what_sigma_allows() {
    /// Of sigma: what f32 takes from a result of 600 readings.
    const OF_SIGMA: f64 = 0.2;
    let samples = Random::new(6).tumble(600, &simpler(9), 586.0);
    let sheet = DataSheet { sensitivity: 50e3_f32, zero: 0.0 };
    let (mut wide, mut single) =
        (Sums::new(DATA_SHEET, 35e3).unwrap(), Sums::new(sheet, 35e3).unwrap());
    for CoupledSample { sample, .. } in &samples {
        wide.add(*sample).unwrap();
        let reading = sample.reading.map(|volt| volt as f32);
        single.add(Sample { reading, intensity: sample.intensity as f32 }).unwrap();
    }
    let (wide, single) = (wide.calibration::<9>().unwrap(), single.calibration::<9>().unwrap());
    for i in 0..9 {
        let error = f64::from(single.parameters.0[i]) - wide.parameters.0[i];
        let sigma = wide.sigma().0[i];
        assert!(error.abs() < OF_SIGMA * sigma, "unknown {i}: {error}, sigma {sigma}");
    }
}

#[test]
fn sums_that_fade_follow_a_sensor_that_changes() {
    let mut sums = Sums::new(DATA_SHEET, 35e3).unwrap();
    let mut feed = |x: &Parameters<f64, 12>, seed| {
        for coupled in Random::new(seed).tumble(1000, x, 100.0) {
            sums.fade(0.99);
            sums.add(coupled.sample).unwrap();
        }
        sums.calibration::<9>().unwrap()
    };
    feed(&simpler(9), 7);
    let mut moved = simpler(9);
    moved.0[3] += 4e3;
    let found = feed(&moved, 8);
    let error = found.parameters.bias()[0] - moved.bias()[0];
    assert!(error.abs() < 5.0 * found.sigma().bias()[0], "{error}");
}

#[test]
fn sums_choose_the_model_by_evidence_and_say_what_is_not_known_of_the_other() {
    for (seed, unknowns) in (0..20).flat_map(|seed| [6, 9].map(|unknowns| (seed, unknowns))) {
        let mut sums = Sums::new(DATA_SHEET, 35e3).unwrap();
        for coupled in Random::new(200 + seed).tumble(200, &simpler(unknowns), 586.0) {
            sums.add(coupled.sample).unwrap();
        }
        let (chosen, nine) = (sums.chosen().unwrap(), sums.calibration::<9>().unwrap());
        assert_eq!(chosen.evidence.unknowns, unknowns as u32, "seed {seed}");
        assert_eq!(chosen.parameters.cross_axis() == [0.0; 3], unknowns == 6);
        assert_eq!(chosen.sigma(), nine.sigma());
    }
    // Nine unknowns are too many for fifteen readings.
    let mut few = Sums::new(DATA_SHEET, 35e3).unwrap();
    for coupled in Random::new(1).tumble(15, &simpler(6), 100.0) {
        few.add(coupled.sample).unwrap();
    }
    let chosen = few.chosen().unwrap();
    assert_eq!((chosen.evidence.unknowns, chosen.evidence.samples), (6, 15));
    assert_eq!(chosen.sigma().cross_axis(), [0.0; 3]);
    assert_eq!(few.calibration::<6>().unwrap().sigma().scale(), chosen.sigma().scale());
}

#[test]
fn a_correction_gives_the_field_behind_the_driver_and_its_sigma_is_that_of_the_zero_field() {
    let driver = DataSheet { sensitivity: 48e3, zero: 1.65 };
    let mut sums = Sums::new(DATA_SHEET, 35e3).unwrap();
    for coupled in Random::new(10).tumble(200, &simpler(9), 300.0) {
        sums.add(coupled.sample).unwrap();
    }
    let found = sums.calibration::<9>().unwrap();
    let (correction, sigma) = found.correction(driver);
    let volts = [1.9, 1.2, 1.7];
    let shown = volts.map(|volt| (volt - driver.zero) * driver.sensitivity);
    let [xy, xz, yz] = correction.cross_axis;
    let shear = nalgebra::Matrix3::new(1.0, xy, xz, xy, 1.0, yz, xz, yz, 1.0);
    let scaled = Vector3::from(shown).component_mul(&Vector3::from(correction.scale));
    let field = shear * scaled - Vector3::from(correction.bias);
    let expected = Vector3::from(found.parameters.field(volts, &[]));
    assert!((field - expected).norm() < NOISE_FREE_NT, "{field} {expected}");
    // What the driver shows as no field is 1.65 V away from where the readings were.
    assert!(sigma.bias[0] > 2.0 * found.sigma().bias()[0]);
    let same = (sigma.scale[1] * driver.sensitivity / found.sigma().scale()[1] - 1.0).abs();
    assert!(same < NOISE_FREE, "{same}");
    let flown = adcs_core::calibration::Correction {
        scale: correction.scale.map(|it| it as f32),
        cross_axis: correction.cross_axis.map(|it| it as f32),
        bias: [1e-6, 2e-6, 3e-6],
    }
    .applied_to(&adcs_core::sensing::TriadParameters {
        alignment_xyzw: [1.0, 0.0, 0.0, 0.0],
        ..Default::default()
    });
    assert_eq!((flown.bias[2], flown.alignment_xyzw[0]), (3e-6, 1.0));
}

#[test]
fn the_covariance_of_sums_that_fade_is_the_scatter_of_their_estimates() {
    const RUNS: u64 = 100;
    /// Three standard errors of a mean of 100, and a covariance from some 200 readings of weight.
    const OF_NINE: std::ops::Range<f64> = 7.7..11.0;
    let mean = nees::<9>(RUNS, &truth(), |seed| {
        let mut sums = Sums::new(DATA_SHEET, 35e3).unwrap();
        for coupled in Random::new(seed).tumble(600, &simpler(9), 300.0) {
            sums.fade(0.99);
            sums.add(coupled.sample).unwrap();
        }
        let found = sums.calibration().unwrap();
        (found.parameters, found.covariance)
    });
    assert!(OF_NINE.contains(&mean), "{mean}");
}

#[test]
fn what_the_data_cannot_support_is_refused_with_the_reason() {
    let samples = Random::new(9).tumble(60, &truth(), 586.0);
    let coupled = |samples: Vec<CoupledSample<f64, 1>>| {
        calibrate_extended::<f64, 1, 12, _>(samples, &START, NoiseShift::Kept).unwrap_err()
    };
    let few = coupled(samples[..23].to_vec());
    assert_eq!(few, CalibrationError::TooFew { found: 23, needed: 24 });
    let constant = samples.iter().map(|it| CoupledSample { currents: [0.5], ..*it }).collect();
    assert_eq!(coupled(constant), CalibrationError::ConstantCurrent { index: 0, found: 0.5 });
    let mut bad = samples.clone();
    bad[4].currents[0] = f64::NAN;
    assert_eq!(coupled(bad), CalibrationError::NotFinite { sample: 4 });

    // All in one plane: what the third axis does is not seen.
    let flat = (0..60).map(|k| {
        let (sin, cos) = (f64::from(k) * 0.4).sin_cos();
        Sample { reading: [0.6 * cos, 0.6 * sin, 1e-6 * f64::from(k % 2)], intensity: 30e3 }
    });
    let refused = twostep(flat.clone(), DATA_SHEET).unwrap_err();
    assert!(matches!(refused, CalibrationError::PoorGeometry { .. }), "{refused}");
    let mut sums = Sums::new(DATA_SHEET, 35e3).unwrap();
    assert_eq!(
        sums.calibration::<6>().unwrap_err(),
        CalibrationError::TooFew { found: 0, needed: 12 }
    );
    flat.for_each(|sample| sums.add(sample).unwrap());
    let refused = sums.calibration::<9>().unwrap_err();
    assert!(matches!(refused, CalibrationError::PoorGeometry { .. }), "{refused}");
    let untold = sums.with_noise(f64::NAN).unwrap_err();
    assert!(matches!(untold, CalibrationError::Noise { .. }), "{untold}");
    let before = sums;
    let nan = Sample { reading: [0.0, f64::NAN, 0.0], intensity: 30e3 };
    assert_eq!(sums.add(nan), Err(CalibrationError::NotFinite { sample: 60 }));
    assert_eq!(sums, before);
}
