//! Which axis of the magnetometer is which: all 48 cases, flown with the law that does not know.

mod tumble_support;

use adcs_core::calibration::axes::{AxesCheck, AxesError, AxesStep};
use adcs_core::frames::SignedPermutation;
use nalgebra::{Matrix3, Vector3};
use tumble_support::{FIELD_NOISE_T, GYRO_NOISE, INERTIA, LIMIT_AM2, Random, Satellite};

/// A m² s / T, the paper's.
const GAIN: f64 = 1e5;
/// How far the response may be from 1: what 1.5 % in each of nine entries does to m × B, and noise,
/// where the residual dipole did nearly the same work.
const RESPONSE: f64 = 0.5;
const CYCLE_S: f64 = 0.5;
/// Torquers 5 s on, 2.5 s off: in cycles.
const ON: u32 = 10;
const OFF: u32 = 5;

/// What the torquers do.
#[derive(Clone, Copy)]
enum Torquers {
    /// B-dot with the field as it is shown.
    Law,
    /// Full dipoles of random signs, whatever the field: a test pattern.
    Pattern,
}

/// A despin flight of 1200 s with a magnetometer that is mounted as `mounted`, recorded.
fn flight(
    mounted: SignedPermutation,
    torquers: Torquers,
    seed: u64,
    mut record: impl FnMut(&AxesStep<f64>),
) {
    let mut random = Random::new(seed);
    let rate = random.vector(4_f64.to_radians());
    let mut satellite = Satellite::new(&mut random, rate);
    // What a calibration leaves: 1 % of scale, 2 % from axis to axis, 500 nT.
    let errors = Matrix3::identity() + Matrix3::from_fn(|_, _| 0.015 * random.gaussian());
    let bias = random.vector(500e-9);
    let to_body = Matrix3::from_columns(&[
        mounted.apply(Vector3::x()),
        mounted.apply(Vector3::y()),
        mounted.apply(Vector3::z()),
    ]);
    let mut dipole = Vector3::zeros();
    for cycle in 0..2400 {
        let rate = satellite.rate + random.vector(GYRO_NOISE);
        let field = to_body.transpose() * satellite.field();
        let shown = errors * field + bias + random.vector(FIELD_NOISE_T);
        let within = cycle % (ON + OFF);
        record(&AxesStep {
            dt_s: if cycle == 0 { 0.0 } else { CYCLE_S },
            rate_rad_s: rate.into(),
            field_t: (dipole == Vector3::zeros()).then_some(shown.into()),
            dipole_am2: dipole.into(),
        });
        if within == OFF {
            dipole =
                match torquers {
                    // The flight software takes the sensor's axes for Body's.
                    Torquers::Law => {
                        (rate.cross(&shown) * GAIN).map(|m| m.clamp(-LIMIT_AM2, LIMIT_AM2))
                    }
                    Torquers::Pattern => Vector3::from_fn(|_, _| {
                        if random.uniform() < 0.5 { -LIMIT_AM2 } else { LIMIT_AM2 }
                    }),
                };
        } else if within == 0 {
            dipole = Vector3::zeros();
        }
        satellite.advance(CYCLE_S, dipole);
    }
}

#[test]
fn all_48_namings_are_told_apart_on_20_flights_each() {
    let mut least = (f64::INFINITY, f64::INFINITY);
    for (index, mounted) in (0..).zip(SignedPermutation::all()) {
        for seed in 0..20 {
            let mut check = AxesCheck::new(INERTIA);
            flight(mounted, Torquers::Pattern, 1000 * index + seed, |step| check.add(step));
            let axes = check.verdict().unwrap_or_else(|error| panic!("{mounted}, {seed}: {error}"));
            assert_eq!(axes.permutation, mounted, "seed {seed}");
            assert!((axes.response - 1.0).abs() < RESPONSE, "{axes:?}");
            let sigmas = axes.response / axes.response_sigma;
            least = (least.0.min(axes.gyro_ratio), least.1.min(sigmas));
        }
    }
    println!("least ratio by the gyros {:.1}, least response {:.1} sigma", least.0, least.1);
}

#[test]
fn under_the_law_that_does_not_know_the_verdict_is_right_or_there_is_none() {
    /// Of 144: a law that works by wrong axes may do hardly any work on the whole.
    const MAX_OPEN: u32 = 15;
    let mut open = 0;
    for (index, mounted) in (0..).zip(SignedPermutation::all()) {
        for seed in 0..3 {
            let mut check = AxesCheck::new(INERTIA);
            flight(mounted, Torquers::Law, 1000 * index + seed, |step| check.add(step));
            match check.verdict() {
                Ok(axes) => assert_eq!(axes.permutation, mounted, "seed {seed}"),
                Err(error) => {
                    assert!(matches!(error, AxesError::NoResponse { .. }), "{mounted}: {error}");
                    open += 1;
                }
            }
            let (pair, _) = check.by_gyros().unwrap();
            assert!([pair, pair.negated()].contains(&mounted), "{pair}");
        }
    }
    println!("open {open} of 144");
    assert!(open <= MAX_OPEN, "{open}");
}

#[test]
fn single_precision_names_the_same() {
    for (seed, mounted) in (0..).zip(SignedPermutation::all()) {
        let mut check = AxesCheck::new(INERTIA.map(|row| row.map(|x| x as f32)));
        flight(mounted, Torquers::Pattern, seed, |step| {
            check.add(&AxesStep {
                dt_s: step.dt_s as f32,
                rate_rad_s: step.rate_rad_s.map(|x| x as f32),
                field_t: step.field_t.map(|field| field.map(|x| x as f32)),
                dipole_am2: step.dipole_am2.map(|x| x as f32),
            });
        });
        assert_eq!(check.verdict().unwrap().permutation, mounted);
    }
}

#[test]
fn without_torquers_the_common_sign_stays_open_and_the_rest_does_not() {
    let mounted = SignedPermutation::all().nth(29).unwrap();
    let mut check = AxesCheck::new(INERTIA);
    flight(mounted, Torquers::Law, 3, |step| {
        check.add(&AxesStep { dipole_am2: [0.0; 3], ..*step });
    });
    let error = check.verdict().unwrap_err();
    assert!(matches!(error, AxesError::NoResponse { .. }), "{error}");
    let (pair, _) = check.by_gyros().unwrap();
    assert!([pair, pair.negated()].contains(&mounted), "{pair}");
}
