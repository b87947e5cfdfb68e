//! Guard and active check against the flight code in a closed loop; `adcs study polarity` is the same with
//! all wirings.

use adcs_core::modes::Cause;
use adcs_core::polarity::{CheckReport, PolarityParameters, Suspect};
use adcs_ground::study::campaign::fly_all;
use adcs_ground::study::closed_loop::{Conditions, Device, Fault, Sampling, StartingRate};
use adcs_ground::study::polarity::pointing::{Trouble, fly_pointing, troubles};
use adcs_ground::study::polarity::{
    CheckFigures, Checked, DEAD, DeadFigures, GuardFigures, Guarded, conditions, faults, fly_check,
    fly_guarded,
};

const RATE_DEG_S: f64 = 5.0;
const LISTEN_S: f64 = 125.0;
/// Every ninth of the 141 wrong wirings: 15 or 16, 5 or more of each device.
const EVERY: usize = 9;

fn with(fault: Option<Fault>) -> Conditions {
    conditions(RATE_DEG_S, Sampling::OnceASecond, fault)
}

fn some_faults() -> Vec<Fault> {
    faults().into_iter().step_by(EVERY).collect()
}

fn guarded() -> Vec<Guarded> {
    let (faults, p) = (some_faults(), PolarityParameters::default());
    let fly = |number| {
        let fault = faults[number as usize - 1];
        fly_guarded(&with(Some(fault)), &p, LISTEN_S, number, true)
    };
    fly_all(faults.len() as u64, fly, || ()).unwrap()
}

fn checked() -> Vec<Checked> {
    let (faults, p) = (some_faults(), PolarityParameters::default());
    let fly = |number| fly_check(&with(Some(faults[number as usize - 1])), &p, number);
    fly_all(faults.len() as u64, fly, || ()).unwrap()
}

#[test]
fn harmful_wirings_are_stopped_before_they_have_done_harm() {
    let flights = guarded();
    for (device, within_s) in
        [(Device::Magnetometer, 120.0), (Device::Gyro, 120.0), (Device::Torquers, 300.0)]
    {
        let of = GuardFigures::of(device, &flights);
        assert!(of.count() > 0);
        assert_eq!(of.stopped_within(within_s), 1.0, "{}", device.name());
        assert_eq!(of.within_bounds(), 1.0, "{}", of.largest_controlled());
    }
}

#[test]
fn the_active_check_names_device_and_wiring() {
    let checks = checked();
    for device in Device::ALL {
        let of = CheckFigures::of(Some(device), &checks);
        assert!(of.count() >= 5);
        assert!(of.device_named() >= 0.95 && of.wiring_named() >= 0.90, "{}", device.name());
    }
}

#[test]
fn a_satellite_that_is_wired_well_is_found_to_be_so() {
    let p = PolarityParameters::default();
    let fly = |seed| fly_guarded(&with(None), &p, LISTEN_S, seed, false);
    let flights = fly_all(20, fly, || ()).unwrap();
    assert!(flights.iter().all(|flight| flight.stop.is_none()));
    let checks = fly_all(20, |seed| fly_check(&with(None), &p, seed), || ()).unwrap();
    assert!(!checks.iter().any(|check| matches!(check.report, CheckReport::Wrong(_))));
    assert!(CheckFigures::of(None, &checks).device_named() >= 0.95);
}

#[test]
fn while_the_satellite_points_the_guard_lets_it_and_stops_torquers_that_turn_wrong() {
    let slowly = StartingRate::AnyAxis(0.5 * core::f64::consts::PI / 180.0);
    let sound = fly_all(4, |seed| fly_pointing(slowly, 1.0, None, seed), || ()).unwrap();
    assert!(sound.iter().all(|it| it.began_s.is_some() && it.ended.is_none()), "{sound:?}");
    let of_torquers = |trouble: &Trouble| match trouble {
        Trouble::Turned(fault) => fault.device == Device::Torquers,
        Trouble::Dead(_) => false,
    };
    for trouble in troubles().into_iter().filter(of_torquers) {
        let flight = fly_pointing(slowly, 0.5, Some(trouble), 1).unwrap();
        let Some((after_s, cause)) = flight.ended else { panic!("{flight:?}") };
        // Which axis is not always named right; the whole loop is what stops.
        assert!(matches!(cause, Cause::Miswired(_)), "{trouble:?}: {cause:?}");
        assert!(after_s < 1800.0, "{trouble:?}: {after_s} s");
    }
}

#[test]
fn the_active_check_names_dead_torquers_and_the_guard_stops_a_despin_without_any() {
    let p = PolarityParameters::default();
    for dead in DEAD {
        let conditions = Conditions { dead, ..with(None) };
        let checks = fly_all(3, |seed| fly_check(&conditions, &p, seed), || ()).unwrap();
        let guarded = |seed| fly_guarded(&conditions, &p, LISTEN_S, seed, false);
        let flights = fly_all(if dead == [true; 3] { 3 } else { 0 }, guarded, || ()).unwrap();
        assert_eq!(DeadFigures::of(&flights, &checks).named_by_check(), 1.0, "{checks:?}");
        assert!(flights.iter().all(|flight| flight.stop.is_some()), "{flights:?}");
    }
}

#[test]
fn a_torquer_that_dies_while_the_satellite_points_ends_pointing() {
    let slowly = StartingRate::AnyAxis(0.5 * core::f64::consts::PI / 180.0);
    // Along z there is so little residual dipole that it takes up to an hour.
    for dead in DEAD.into_iter().filter(|dead| *dead != [false, false, true]) {
        let flight = fly_pointing(slowly, 0.5, Some(Trouble::Dead(dead)), 1).unwrap();
        let (after_s, cause) = flight.ended.unwrap();
        // The pointing error that grows is sooner now and then.
        assert!(matches!(cause, Cause::Miswired(_) | Cause::ErrorGrows), "{dead:?}: {cause:?}");
        assert!(after_s < 600.0, "{dead:?}: {after_s} s");
    }
}

#[test]
fn a_magnetometer_that_turns_wrong_while_the_satellite_points_is_named() {
    let slowly = StartingRate::AnyAxis(0.5 * core::f64::consts::PI / 180.0);
    let wiring = adcs_core::polarity::SignedPermutation::REVERSED;
    let trouble = Trouble::Turned(Fault { device: Device::Magnetometer, wiring });
    let flight = fly_pointing(slowly, 0.5, Some(trouble), 1).unwrap();
    let suspect = Suspect::Magnetometer(wiring);
    assert!(
        matches!(flight.ended, Some((t_s, Cause::Miswired(it))) if it == suspect && t_s < 60.0)
    );
}

#[test]
fn a_magnetometer_reversed_as_a_whole_looks_like_reversed_torquers() {
    let reversed = adcs_core::polarity::SignedPermutation::REVERSED;
    let p = PolarityParameters::default();
    for device in [Device::Magnetometer, Device::Torquers] {
        let check = fly_check(&with(Some(Fault { device, wiring: reversed })), &p, 1).unwrap();
        assert_eq!(check.report, CheckReport::Wrong(Suspect::ReversedTorquersOrMagnetometer));
    }
}
