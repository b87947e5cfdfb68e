//! What a record says of the satellite: against a simulated one whose properties are known.

mod tumble_support;

use adcs_core::identification::gyro::GyroBias;
use adcs_core::identification::momentum::MomentumFit;
use adcs_core::identification::sun::SunAlignment;
use adcs_core::identification::torque::{DipoleByDifferences, central_torque, torque_noise};
use adcs_core::identification::{IdentificationError, Noise, Recorded, Solution};
use nalgebra::{Matrix3, Rotation3, SMatrix, Vector3};
use tumble_support::{
    FIELD_NOISE_T, GYRO_NOISE, INERTIA, LIMIT_AM2, RESIDUAL_AM2, Random, Satellite,
};

fn told_noise() -> Noise<f64> {
    Noise { rate_rad_s: GYRO_NOISE, field_t: FIELD_NOISE_T, field_offset_t: 300e-9 }
}

/// What is wrong with a record.
#[derive(Clone, Copy)]
struct Errors {
    gyro_noise: f64,
    gyro_bias: [f64; 3],
    /// Of the gyros, rad/s per degree; the temperature swings by 10 degrees.
    gyro_slope: [f64; 3],
    field_bias: [f64; 3],
    /// Of a dipole that the torquers are told.
    gains: Matrix3<f64>,
}

const NOISE: Errors = Errors {
    gyro_noise: GYRO_NOISE,
    gyro_bias: [0.0; 3],
    gyro_slope: [0.0; 3],
    field_bias: [0.0; 3],
    gains: Matrix3::new(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0),
};

/// Temperature at an instant, °C.
fn temperature_c(seconds: f64) -> f64 {
    20.0 + 10.0 * (seconds * std::f64::consts::TAU / 900.0).sin()
}

/// 1200 s at 1 Hz of a tumble of 4 deg/s or so; with `torquers`, full dipoles of random signs 5 s on,
/// 3 s off, the field not measured while they are on.
fn tumble(seed: u64, torquers: bool, errors: Errors, mut record: impl FnMut(f64, &Recorded<f64>)) {
    let mut random = Random::new(seed);
    let rate = random.vector(2.5_f64.to_radians());
    let mut satellite = Satellite::new(&mut random, rate);
    let mut told = Vector3::zeros();
    for second in 0..=1200 {
        let warm = temperature_c(f64::from(second)) - 20.0;
        let bias = Vector3::from(errors.gyro_bias) + Vector3::from(errors.gyro_slope) * warm;
        let rate = satellite.rate + bias + random.vector(errors.gyro_noise);
        let field =
            satellite.field() + Vector3::from(errors.field_bias) + random.vector(FIELD_NOISE_T);
        record(
            f64::from(second),
            &Recorded {
                dt_s: if second == 0 { 0.0 } else { 1.0 },
                rate_rad_s: rate.into(),
                field_t: (told == Vector3::zeros()).then_some(field.into()),
                dipole_am2: told.into(),
            },
        );
        told = match second % 8 {
            2 if torquers => {
                Vector3::from_fn(|_, _| if random.uniform() < 0.5 { -LIMIT_AM2 } else { LIMIT_AM2 })
            }
            7 => Vector3::zeros(),
            _ => told,
        };
        satellite.advance(1.0, errors.gains * told);
    }
}

fn dipole(seed: u64, torquers: bool, errors: Errors, told: [[f64; 3]; 3]) -> Solution<f64, 3> {
    let mut fit = MomentumFit::dipole(told, told_noise()).unwrap();
    tumble(seed, torquers, errors, |_, recorded| fit.add(recorded));
    fit.solve().unwrap()
}

/// Largest error of an axis, A m².
fn off(found: &Vector3<f64>) -> f64 {
    (found - Vector3::from(RESIDUAL_AM2)).amax()
}

#[test]
fn the_papers_residual_dipole_is_found_within_0_03_by_momentum_and_nearly_by_differences() {
    /// The bar, A m², for every axis of 40 records.
    const BAR_AM2: f64 = 0.03;
    /// What most of them reach: root mean square.
    const RMS_AM2: f64 = 0.005;
    let (mut momentum, mut differences, mut squares) = (0.0_f64, 0.0_f64, 0.0);
    for seed in 0..20 {
        for torquers in [false, true] {
            let found = dipole(seed, torquers, NOISE, INERTIA);
            momentum = momentum.max(off(&found.x));
            squares += (found.x - Vector3::from(RESIDUAL_AM2)).norm_squared() / (3.0 * 40.0);
            // What the residuals are: the gyros' noise.
            assert!((found.residual_rms / GYRO_NOISE - 1.0).abs() < 0.1, "{}", found.residual_rms);
        }
        let mut fit = DipoleByDifferences::new(INERTIA).unwrap();
        tumble(seed, false, NOISE, |_, recorded| fit.add(recorded));
        differences = differences.max(off(&fit.solve().unwrap().x));
    }
    let rms = squares.sqrt();
    println!(
        "error in A m²: momentum {rms:.4} rms, {momentum:.4} at most; differences {differences:.4} at most"
    );
    assert!(momentum < BAR_AM2 && rms < RMS_AM2, "{momentum} {rms}");
    assert!(differences < 2.0 * BAR_AM2, "{differences}");
}

/// Mean normalised error squared over many records; it should be the number of unknowns.
fn nees<const N: usize>(found: impl Iterator<Item = (Solution<f64, N>, [f64; N])>) -> f64 {
    let (mut total, mut runs) = (0.0, 0.0);
    for (solution, truth) in found {
        let error = solution.x - nalgebra::SVector::from(truth);
        let scale = solution.sigma().map(|sigma| 1.0 / sigma);
        let scaled: SMatrix<f64, N, N> =
            solution.covariance.component_mul(&(scale * scale.transpose()));
        let error = error.component_mul(&scale);
        total += error.dot(&(scaled.try_inverse().unwrap() * error));
        runs += 1.0;
    }
    total / runs
}

#[test]
fn the_covariance_of_the_dipole_is_its_scatter() {
    /// Of three unknowns over 60 records, three standard errors (√(2·3/60)); and less for what is allowed for
    /// and does not act here, torques and drifts.
    const OF_THREE: std::ops::Range<f64> = 1.2..4.0;
    let found = (0..60).map(|seed| (dipole(seed, false, NOISE, INERTIA), RESIDUAL_AM2));
    let mean = nees(found);
    println!("NEES of the dipole {mean:.2}");
    assert!(OF_THREE.contains(&mean), "{mean}");
}

#[test]
fn a_wrong_tensor_spoils_the_dipole_more_than_noise_and_a_field_with_a_bias_does_not() {
    let told = |x: f64, y: f64, z: f64| {
        let mut told = INERTIA;
        for (axis, factor) in [x, y, z].into_iter().enumerate() {
            told[axis][axis] *= factor;
        }
        told
    };
    let rms = |errors: Errors, told: [[f64; 3]; 3]| {
        let squares = (0..20).map(|seed| {
            (dipole(seed, false, errors, told).x - Vector3::from(RESIDUAL_AM2)).norm_squared() / 3.0
        });
        (squares.sum::<f64>() / 20.0).sqrt()
    };
    let biased = |bias: f64| Errors { field_bias: [bias, -bias, bias], ..NOISE };
    let noise = rms(NOISE, INERTIA);
    let one = rms(NOISE, told(1.01, 1.0, 0.99));
    let ten = rms(NOISE, told(1.1, 1.0, 0.9));
    let scaled = rms(NOISE, told(1.1, 1.1, 1.1));
    let (bias_1, bias_10) = (rms(biased(1e-6), INERTIA), rms(biased(10e-6), INERTIA));
    println!(
        "rms error of an axis, A m²: noise {noise:.4}; tensor +1/0/−1 % {one:.3}, +10/0/−10 % {ten:.3}, \
         +10 % all {scaled:.3}; field bias 1 µT {bias_1:.4}, 10 µT {bias_10:.3}"
    );
    assert!(ten > 10.0 * noise);
    // The magnetometer's bias is estimated along.
    assert!(bias_1 < 1.5 * noise && bias_10 < 4.0 * noise, "{bias_1} {bias_10}");
    // All moments alike: M follows in proportion.
    assert!((0.005..0.05).contains(&scaled), "{scaled}");
}

#[test]
fn inertia_ratios_are_found_from_a_tensor_that_is_told_wrong() {
    /// Of an entry, kg m²: 0.5 % of a moment.
    const ENTRY_KG_M2: f64 = 3e-4;
    let mut worst = 0.0_f64;
    for seed in 0..20 {
        // A tenth off, products unknown, the trace as it is.
        let told = [[0.056, 0.0, 0.0], [0.0, 0.052, 0.0], [0.0, 0.0, 0.05778]];
        let mut fit = MomentumFit::ratios(told, told_noise()).unwrap();
        tumble(seed, true, NOISE, |_, recorded| fit.add(recorded));
        let solution = fit.solve().unwrap();
        let found = Matrix3::from(fit.tensor(&solution));
        worst = worst.max((found - Matrix3::from(INERTIA)).amax());
        assert!(off(&solution.x.fixed_rows::<3>(0).into()) < 0.05, "{}", solution.x);
    }
    println!("largest error of an entry {worst:.2e} kg m²");
    assert!(worst < ENTRY_KG_M2, "{worst}");
}

#[test]
fn torquers_that_are_reversed_weak_and_skew_are_found_out() {
    /// Of a gain: 0.6 A m² on in half of 1200 s, against the gyros' noise.
    const GAIN: f64 = 0.12;
    let gains = Matrix3::new(-1.0, 0.1, 0.0, 0.0, 0.7, 0.0, 0.05, 0.0, 1.1);
    let mut worst = 0.0_f64;
    for seed in 0..20 {
        let mut fit = MomentumFit::gains(INERTIA, told_noise()).unwrap();
        tumble(seed, true, Errors { gains, ..NOISE }, |_, recorded| fit.add(recorded));
        let solution = fit.solve().unwrap();
        let found = Matrix3::from_iterator(solution.x.iter().skip(3).copied());
        worst = worst.max((found - gains).amax());
    }
    println!("largest error of a gain {worst:.3}");
    assert!(worst < GAIN, "{worst}");
}

#[test]
fn gyro_bias_and_its_slope_are_found_from_the_field() {
    /// Of a bias, and of a slope over ten degrees, deg/s.
    const BIAS_DEG_S: f64 = 0.05;
    let bias = [0.4, -0.3, 0.25].map(f64::to_radians);
    let slope = [0.02, 0.01, -0.02].map(f64::to_radians);
    let errors = Errors { gyro_bias: bias, gyro_slope: slope, ..NOISE };
    let (mut worst, mut worst_slope) = (0.0_f64, 0.0_f64);
    for seed in 0..20 {
        let mut fit = GyroBias::with_temperature(told_noise(), 20.0);
        tumble(seed, false, errors, |t_s, recorded| fit.add(recorded, temperature_c(t_s), None));
        let x = fit.solve().unwrap().x;
        for axis in 0..3 {
            worst = worst.max((x[axis] - bias[axis]).abs().to_degrees());
            worst_slope = worst_slope.max((x[axis + 3] - slope[axis]).abs().to_degrees());
        }
    }
    println!("largest error {worst:.3} deg/s, {worst_slope:.4} deg/s per degree");
    assert!(worst < BIAS_DEG_S && 10.0 * worst_slope < BIAS_DEG_S, "{worst} {worst_slope}");
}

#[test]
fn a_sun_sensor_that_is_mounted_askew_is_found_out_without_an_attitude() {
    /// 0.664 deg and 1 deg of noise in 1000 pairs leave 0.07 deg and more about axes that see little.
    const TURN_DEG: f64 = 0.4;
    let turn = Vector3::new(2.0, -1.0, 1.5).map(f64::to_radians);
    let mut random = Random::new(1);
    let mut fit = SunAlignment::default();
    for _ in 0..1000 {
        let [sun, field] = [0, 1].map(|_| random.vector(1.0).normalize());
        let shown = Rotation3::new(-turn) * sun + random.vector(0.664_f64.to_radians());
        let measured = field * 35e-6 + random.vector(FIELD_NOISE_T);
        fit.add(shown.into(), measured.into(), sun.dot(&field));
    }
    let solution = fit.solve().unwrap();
    let error = (solution.x - turn).amax().to_degrees();
    println!("error {error:.3} deg, sigma {:.3} deg", solution.sigma().amax().to_degrees());
    assert!(error < TURN_DEG, "{error}");
    assert!(error < 5.0 * solution.sigma().amax().to_degrees());
}

#[test]
fn the_papers_torque_is_what_gyro_noise_makes_and_no_torque() {
    // Its table 5.1 says 5.0e-5 N m; the satellite of its residual dipole never feels more than 1.9e-5.
    let dt_s = 2.0;
    let mut rates = Vec::new();
    let mut felt = 0.0_f64;
    tumble(1, false, NOISE, |t_s, recorded| {
        if t_s % dt_s == 0.0 {
            rates.push(recorded.rate_rad_s);
        }
        let field = Vector3::from(recorded.field_t.unwrap());
        felt = felt.max(Vector3::from(RESIDUAL_AM2).cross(&field).norm());
    });
    let torques: Vec<_> = rates
        .windows(3)
        .map(|at| Vector3::from(central_torque(INERTIA, [at[0], at[1], at[2]], dt_s).unwrap()))
        .collect();
    let squares = torques.iter().map(Vector3::norm_squared).sum::<f64>();
    let rms = (squares / (3.0 * torques.len() as f64)).sqrt();
    let [noise, ..] = torque_noise(INERTIA, GYRO_NOISE, dt_s);
    println!("torque rms {rms:.2e}, of noise alone {noise:.2e}, truly {felt:.2e} N m at most");
    assert!(felt < 1.9e-5 && rms > 2.0 * felt);
    assert!((rms / noise - 1.0).abs() < 0.2, "{rms} {noise}");
}

#[test]
fn single_precision_finds_the_same() {
    /// A m²: a tenth of what noise leaves.
    const SAME_AM2: f64 = 1e-3;
    let mut fit =
        MomentumFit::dipole(INERTIA.map(|row| row.map(|x| x as f32)), Noise::default()).unwrap();
    tumble(1, true, NOISE, |_, recorded| {
        fit.add(&Recorded {
            dt_s: recorded.dt_s as f32,
            rate_rad_s: recorded.rate_rad_s.map(|x| x as f32),
            field_t: recorded.field_t.map(|field| field.map(|x| x as f32)),
            dipole_am2: recorded.dipole_am2.map(|x| x as f32),
        });
    });
    let single = fit.solve().unwrap().x.map(f64::from);
    let error = (single - dipole(1, true, NOISE, INERTIA).x).amax();
    assert!(error < SAME_AM2, "{error}");
}

#[test]
fn what_a_record_cannot_support_is_refused_with_the_reason() {
    let still = Recorded {
        dt_s: 1.0,
        rate_rad_s: [0.0; 3],
        field_t: Some([0.0, 0.0, 3e-5]),
        dipole_am2: [0.0; 3],
    };
    let mut fit = MomentumFit::dipole(INERTIA, told_noise()).unwrap();
    let brief = IdentificationError::TooBrief { found_s: 0.0, needed_s: 150.0 };
    assert_eq!(fit.solve(), Err(brief));
    (0..200).for_each(|_| fit.add(&still));
    // A dipole along the field makes no torque.
    let error = fit.solve().unwrap_err();
    assert!(matches!(error, IdentificationError::NotLearnt { .. }), "{error}");
    let unreadable = Recorded { rate_rad_s: [f64::NAN; 3], ..still };
    fit.add(&unreadable);
    assert!(fit.solve().is_err());

    let mut skew = INERTIA;
    skew[0][1] = 0.01;
    assert_eq!(MomentumFit::dipole(skew, told_noise()).unwrap_err(), IdentificationError::Inertia);
    let mut sun = SunAlignment::default();
    sun.add([0.0; 3], [0.0, 0.0, 1.0], 0.5);
    assert_eq!(sun.solve(), Err(IdentificationError::TooFew { found: 0, needed: 9 }));
}
