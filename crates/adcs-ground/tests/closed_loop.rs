//! The closed loop of the studies: what it shows the flight code is what is true, and one seed is one
//! flight.

use adcs_app::parameters::LawParameters;
use adcs_core::polarity::SignedPermutation;
use adcs_ground::study::closed_loop::{
    ClosedLoop, Conditions, Device, DipoleStep, Fault, GyroTruth, Moment, Sampling, StartingRate,
    b_dot, dynamic_filter, sprout,
};

const DEG: f64 = core::f64::consts::PI / 180.0;
/// f32 readings of rates and fields, relative.
const SINGLE: f64 = 1e-6;

fn exact() -> Conditions {
    let gyro = GyroTruth {
        noise_rad_s: 0.0,
        bias_rad_s: 0.0,
        walk_rad_s_per_sqrt_s: 0.0,
        sampling: Sampling::EveryCycle,
    };
    Conditions {
        rate: StartingRate::AnyAxis(5.0 * DEG),
        gyro,
        magnetometer_noise_t: 0.0,
        ..Conditions::default()
    }
}

fn fly(conditions: &Conditions, law: LawParameters, seed: u64, cycles: u32) -> Vec<Moment> {
    let mut flight = ClosedLoop::new(conditions, &sprout(law).unwrap(), seed).unwrap();
    (0..cycles).map(|_| flight.step().unwrap()).collect()
}

#[test]
fn the_flight_is_shown_what_is_true_as_it_is_wired() {
    let turned = SignedPermutation::new(21).unwrap();
    for device in [None, Some(Device::Gyro), Some(Device::Magnetometer), Some(Device::Torquers)] {
        let fault = device.map(|device| Fault { device, wiring: turned });
        let conditions = Conditions { fault, ..exact() };
        let wiring = |of| conditions.wiring(of).matrix().cast::<f64>();
        for moment in fly(&conditions, b_dot(), 3, 60) {
            let truth = moment.truth;
            let rate = moment.thoughts.omega_bi.value().unwrap().xyz.cast::<f64>();
            let expected = wiring(Device::Gyro) * truth.omega_bi;
            assert!((rate - expected).norm() < SINGLE * expected.norm());
            if let Some(field) = moment.thoughts.field_b.value() {
                let expected = wiring(Device::Magnetometer) * (truth.r_bi * truth.field_i).xyz;
                assert!((field.xyz.cast::<f64>() - expected).norm() < SINGLE * expected.norm());
            }
            let expected = wiring(Device::Torquers) * moment.carried.xyz.cast::<f64>();
            assert!((truth.torquers - expected).norm() <= SINGLE * expected.norm());
        }
    }
}

#[test]
fn one_seed_is_one_flight_and_another_is_another() {
    let conditions = Conditions { rate: StartingRate::AnyAxis(5.0 * DEG), ..Conditions::default() };
    let end = |seed| fly(&conditions, b_dot(), seed, 100).last().unwrap().truth.omega_bi;
    assert_eq!(end(1), end(1));
    assert_ne!(end(1), end(2));
}

#[test]
fn a_late_orbit_and_a_wrong_field_model_are_seen_as_such() {
    // 2 s of an orbital velocity of 7.56 km/s.
    let late = Conditions { orbit_late_s: 2.0, field_model_error_t: 60e-9, ..exact() };
    let same = fly(&exact(), LawParameters::Off, 5, 2);
    let moments = fly(&late, LawParameters::Off, 5, 2);
    for (moment, same) in moments.iter().zip(&same) {
        let believed = moment.thoughts.orbit.unwrap().position;
        let off_m = (moment.truth.position - believed).norm();
        assert!((15.0e3..15.3e3).contains(&off_m), "{off_m}");
        let error = moment.truth.field_i - same.truth.field_i;
        assert!(error.xyz.iter().all(|axis| (axis.abs() - 60e-9).abs() < 1e-15), "{error:?}");
    }
}

#[test]
fn the_dipole_follows_the_shadow_with_its_lag() {
    let step = |lag_s| Conditions {
        eclipse_step: DipoleStep { share: 0.01, lag_s: [lag_s; 2] },
        ..exact()
    };
    // An orbit: the shadow lasts some 2000 s.
    let moments = |lag_s| fly(&step(lag_s), LawParameters::Off, 1, 11_640);
    let shares = |lag_s| -> Vec<(bool, f64)> {
        let drawing = exact().residual_dipole_am2[0];
        let share = |moment: &Moment| (moment.truth.dipole.x / drawing - 1.0).abs();
        moments(lag_s).iter().map(|moment| (moment.truth.lit, share(moment))).collect()
    };
    // A cycle for the flag to reach the dipole; rounding of 1.01.
    let at_once = shares(0.0);
    assert!(at_once.windows(2).all(|pair| {
        let expected = if pair[0].0 { 0.0 } else { 0.01 };
        (pair[1].1 - expected).abs() < 1e-12
    }));
    let slow = shares(600.0);
    let entry = slow.iter().position(|(lit, _)| !lit).unwrap();
    // 1 − 1/e after one lag of 1200 cycles.
    let after = slow[entry + 1200].1 / 0.01;
    assert!((after - 0.632).abs() < 1e-3, "{after}");
}

#[test]
fn with_the_filters_the_residual_dipole_is_learned_in_the_loop() {
    let flight = dynamic_filter(&sprout(b_dot()).unwrap(), 0.02);
    let conditions = Conditions { rate: StartingRate::AnyAxis(5.0 * DEG), ..Conditions::default() };
    let mut closed_loop = ClosedLoop::new(&conditions, &flight, 1).unwrap();
    let mut last = None;
    for _ in 0..2400 {
        last = Some(closed_loop.step().unwrap());
    }
    let moment = last.unwrap();
    let estimate = moment.thoughts.determination.unwrap().dynamic.estimate.unwrap();
    let error = (estimate.residual_dipole.xyz.cast::<f64>() - moment.truth.dipole).norm();
    // docs/filters: 0.0105 on the worst of sixty axes.
    assert!(error < 0.02, "{error}");
}
