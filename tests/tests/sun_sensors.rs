//! One orbit of the Sun sensors, from the true light through diodes, converters, bus and drivers to
//! the direction in Body.

use adcs_core::frames::{Body, Eci, Rotation, Vector};
use adcs_core::reading::{MissingReason, Reading};
use adcs_core::sensing::FaceVerdict;
use adcs_link::TruthRecord;
use adcs_sim::scenario::{Scenario, SunFaceFault};
use adcs_tests::{Flight, fly, mission};

/// No honest error exceeds so many σ about both axes together.
const GROSS: f64 = 6.5;

/// An orbit of SPROUT with its torquers acting, from day through night into day.
fn an_orbit() -> Scenario {
    let mut scenario = mission("sprout/despin-calibrated").scenario;
    scenario.flight.cycle_us = 2_500_000;
    scenario.cycles = 2_400;
    scenario
}

/// The same with a broken face +y.
fn an_orbit_with(fault: SunFaceFault) -> Flight {
    let mut scenario = an_orbit();
    let sensors = scenario.world.sun_sensors.as_mut().expect("SPROUT has Sun sensors");
    sensors.faces[2].fault = Some(fault);
    fly(&scenario)
}

fn sun_in_body(truth: &TruthRecord) -> Vector<Body, f64> {
    let [x, y, z] = truth.sun_eci;
    let r_bi: Rotation<Body, Eci, f64> =
        Rotation::from_attitude_quaternion(truth.attitude_xyzw).expect("an attitude");
    r_bi * Vector::new(x, y, z)
}

#[test]
fn the_sun_is_seen_all_day_and_never_at_night() {
    let flight = fly(&an_orbit());
    let (mut day, mut night, mut squares) = (0_u32, 0_u32, 0.0);
    for (truth, record) in flight.truth.iter().zip(&flight.records) {
        // The model on board is that of the truth, but for the interpolated orbit.
        let model = record.sunlit.expect("an orbit");
        if truth.sunlit {
            if model < 1.0 {
                // Penumbra, some ten seconds: the Sun is fainter than any that counts, or is not.
                continue;
            }
            day += 1;
            let Reading::Fresh(found) = record.sun else { panic!("{record:?}") };
            let [x, y, z] = found.body.map(f64::from);
            let error_rad = (Vector::new(x, y, z) - sun_in_body(truth)).norm();
            let in_sigma = error_rad / f64::from(found.sigma_rad);
            assert!(in_sigma < GROSS, "{in_sigma}: {record:?}");
            squares += in_sigma * in_sigma / 2.0;
        } else {
            night += 1;
            assert_eq!(record.sun, Reading::Missing(MissingReason::Dark));
            assert!(model < 0.01, "{model}");
        }
    }
    let normalised = squares / f64::from(day);
    println!("day {day}, night {night}, (error/σ)² about one axis {normalised:.3}");
    assert!(day > 1_400 && night > 700, "{day} {night}");
    // One flight does not sample all attitudes as the σ was made for.
    assert!((0.7..1.4).contains(&normalised), "{normalised}");
    assert_eq!(flight.outcome.end.violations, 0);
    assert_eq!(flight.outcome.health.cycles_with_broken_sun_sensors, 0);
}

#[test]
fn the_sun_of_the_flight_software_is_the_true_one() {
    /// Of f32 components, and the parallax of an orbit that is metres off.
    const TOLERANCE: f64 = 2e-7;
    let flight = fly(&an_orbit());
    for (truth, record) in flight.truth.iter().zip(&flight.records) {
        let model = record.reference_sun_eci.expect("after 1972").map(f64::from);
        for (model, truth) in model.into_iter().zip(truth.sun_eci) {
            assert!((model - truth).abs() < TOLERANCE, "{model} {truth}");
        }
    }
}

#[test]
fn a_dark_face_costs_its_part_of_the_day() {
    let flight = an_orbit_with(SunFaceFault::Dark);
    let day = || flight.records.iter().filter(|record| record.sunlit == Some(1.0));
    let seen = day().filter(|record| record.sun.value().is_some()).count();
    println!("{seen} of {} sunlit cycles", day().count());
    // Of a tumbling satellite's sphere one face alone sees an eighth.
    assert!(seen * 10 > day().count() * 8 && seen < day().count());
    assert!(day().all(|record| record.sun_faces[2] != FaceVerdict::Used));
}

#[test]
fn a_stuck_face_is_contradicted_by_day_and_betrays_itself_at_night() {
    let flight = an_orbit_with(SunFaceFault::Stuck);
    let disagrees = |sunlit| {
        let record = flight.records.iter().filter(move |record| record.sunlit == Some(sunlit));
        let disagree = record.clone().filter(|record| record.sun.missing().is_some()).count();
        (disagree, record.count())
    };
    let (by_day, day) = disagrees(1.0);
    assert!(2 * by_day > day, "{by_day} of {day}");
    // At night it alone shows a Sun, where the record says that there can be none.
    let (at_night, night) = disagrees(0.0);
    assert!(at_night == 0 && night > 700, "{at_night} of {night}");
}
