//! Stage II in flight: both filters over drivers and simulated chips, with sensors that work and sensors
//! that fail.
//!
//! `cargo test -p adcs-tests --test attitude -- --nocapture` prints the errors.

use adcs_core::attitude::selection::{AttitudeSource, Flies, RateSource, Reason};
use adcs_core::frames::{Body, Eci, Rotation};
use adcs_core::reading::{MissingReason, Reading};
use adcs_core::sensing::sun_faces::FACES;
use adcs_hal::fault::{Fault, FaultKind, SensorAxis};
use adcs_link::message::DeterminationRecord;
use adcs_link::{CycleRecord, TruthRecord};
use adcs_sim::scenario::Scenario;
use adcs_tests::{Flight, fly, fly_with_faults, mission};
use nalgebra::Vector3;

const CYCLES_A_SECOND: u32 = 2;
/// When sensors fail: in sunlight, the filters settled, the tumble not yet over.
const FAILS_S: u32 = 1500;

/// Two orbits from the tumble.
fn two_orbits() -> Scenario {
    mission("sprout/attitude").scenario
}

/// The first part of it, from day into night.
fn into_the_night() -> Scenario {
    Scenario { cycles: 4500 * CYCLES_A_SECOND, ..two_orbits() }
}

fn from_then_on(kind: FaultKind) -> Fault {
    Fault { first_cycle: FAILS_S * CYCLES_A_SECOND, last_cycle: u32::MAX, kind }
}

fn gyro_fails(kind: fn(SensorAxis) -> FaultKind) -> [Fault; 3] {
    [0, 1, 2].map(|axis| from_then_on(kind(SensorAxis::Gyro(axis))))
}

fn gone(axis: SensorAxis) -> FaultKind {
    FaultKind::Missing(axis, MissingReason::Bus)
}

fn stage_two(record: &CycleRecord) -> DeterminationRecord {
    record.determination.expect("stage II flies")
}

/// Angle to the truth, deg.
fn error_deg(truth: &TruthRecord, record: &CycleRecord) -> Option<f64> {
    let believed: Rotation<Body, Eci, f64> =
        Rotation::from_attitude_quaternion(stage_two(record).attitude?.xyzw.map(f64::from))?;
    let attitude: Rotation<Body, Eci, f64> =
        Rotation::from_attitude_quaternion(truth.attitude_xyzw)?;
    Some((attitude * believed.inverse()).angle_rad().to_degrees())
}

/// What a stretch of a flight comes to.
#[derive(Debug, Default)]
struct Errors {
    sunlit_deg: f64,
    eclipse_deg: f64,
    largest_deg: f64,
    /// Share of the cycles with an attitude.
    known: f64,
    /// Mean square of the error in units of the promised σ, both of the whole angle: 1 when σ is right.
    in_sigma_squared: f64,
}

/// Above this mean square σ would be no promise. One flight holds some tens of independent errors.
const PROMISED: f64 = 1.6;

fn errors(flight: &Flight, from_s: u32) -> Errors {
    let mut sums = [(0.0, 0.0); 2];
    let (mut errors, mut cycles, mut known) = (Errors::default(), 0.0, 0.0);
    let pairs = flight.truth.iter().zip(&flight.records);
    for (truth, record) in pairs.skip((from_s * CYCLES_A_SECOND) as usize) {
        cycles += 1.0;
        let Some(error) = error_deg(truth, record) else { continue };
        known += 1.0;
        let (sum, count) = &mut sums[usize::from(truth.sunlit)];
        *sum += error * error;
        *count += 1.0;
        errors.largest_deg = errors.largest_deg.max(error);
        let sigma = stage_two(record).attitude.expect("known").sigma_rad.map(f64::from);
        let sigma_deg = Vector3::from(sigma).norm().to_degrees();
        errors.in_sigma_squared += (error / sigma_deg).powi(2);
    }
    let [eclipse, sunlit] = sums.map(|(sum, count): (f64, f64)| (sum / count).sqrt());
    let in_sigma_squared = errors.in_sigma_squared / known;
    let known = known / cycles;
    Errors { sunlit_deg: sunlit, eclipse_deg: eclipse, known, in_sigma_squared, ..errors }
}

/// Share of the cycles from `from_s` on for which it is so.
fn share(flight: &Flight, from_s: u32, so: impl Fn(&CycleRecord) -> bool) -> f64 {
    let records = &flight.records[(from_s * CYCLES_A_SECOND) as usize..];
    records.iter().filter(|record| so(record)).count() as f64 / records.len() as f64
}

fn rate_source(record: &CycleRecord) -> Option<RateSource> {
    stage_two(record).rate.map(|rate| rate.source)
}

fn attitude_source(record: &CycleRecord) -> Option<AttitudeSource> {
    stage_two(record).attitude.map(|attitude| attitude.source)
}

#[test]
fn from_the_tumble_to_rest_the_attitude_is_known_by_day_and_by_night() {
    // GIVEN SPROUT with an inertia that is told 5 % wrong WHEN it despins for two orbits
    let flight = fly(&two_orbits());
    // THEN the filters start by themselves within a round of the schedule,
    assert_eq!(stage_two(&flight.records[0]).reason, Reason::MekfNotStarted);
    let first = flight.records.iter().position(|record| attitude_source(record).is_some());
    assert!(first.is_some_and(|cycle| cycle <= 25), "{first:?}");
    // THEN ten minutes later the attitude is known for good, better than field and Sun alone would say,
    let dynamic = errors(&flight, 600);
    println!("dynamics-aided where trusted: {dynamic:?}");
    assert_eq!(dynamic.known, 1.0);
    assert!(dynamic.sunlit_deg < 0.5 && dynamic.eclipse_deg < 2.5, "{dynamic:?}");
    assert!(dynamic.in_sigma_squared < PROMISED, "{dynamic:?}");
    assert!(share(&flight, 600, |it| attitude_source(it) == Some(AttitudeSource::Dynamic)) > 0.98);
    // THEN the satellite knows its residual dipole.
    let learned = stage_two(flight.records.last().unwrap()).residual_dipole_am2.unwrap();
    for (learned, truth) in learned.into_iter().zip([-0.3211, -0.2094, -0.0201]) {
        assert!((learned - truth).abs() < 0.02, "{learned} {truth}");
    }
    // THEN and the MEKF alone would not be as good.
    let mut alone = two_orbits();
    alone.flight.attitude.as_mut().unwrap().flies = Flies::Mekf;
    let alone = fly(&alone);
    let mekf = errors(&alone, 600);
    println!("MEKF: {mekf:?}");
    assert_eq!(stage_two(alone.records.last().unwrap()).reason, Reason::DynamicNotFlown);
    assert!(mekf.sunlit_deg < 1.5 && mekf.eclipse_deg < 5.9, "{mekf:?}");
    assert!(dynamic.eclipse_deg < 0.7 * mekf.eclipse_deg);
}

#[test]
fn when_the_gyros_die_the_dynamics_carry_the_attitude_through_the_night() {
    let flight = fly_with_faults(&into_the_night(), &gyro_fails(gone));
    let after = errors(&flight, FAILS_S + 60);
    println!("{after:?}");
    assert!(after.known > 0.99 && after.largest_deg < 12.0, "{after:?}");
    let dynamic = share(&flight, FAILS_S + 60, |it| rate_source(it) == Some(RateSource::Dynamic));
    assert!(dynamic > 0.9, "{dynamic}");
    // Despin goes on with it.
    let rate = |time_s: f64| flight.rate_deg_s(time_s).norm();
    assert!(rate(4500.0) < 0.5 * rate(f64::from(FAILS_S)));
}

#[test]
fn gyros_that_freeze_are_found_and_count_as_dead() {
    let flight = fly_with_faults(&into_the_night(), &gyro_fails(FaultKind::Stuck));
    let frozen = Reading::Missing(MissingReason::Frozen);
    // Forty repetitions, 20 s.
    let found = share(&flight, FAILS_S + 21, |it| it.omega_bi_rad_s == frozen);
    assert_eq!(found, 1.0);
    let after = errors(&flight, FAILS_S + 300);
    println!("{after:?}");
    assert!(after.known > 0.99 && after.largest_deg < 12.0, "{after:?}");
}

#[test]
fn without_gyros_from_the_start_the_field_gives_the_rate_across_it_and_despin_works() {
    // GIVEN a satellite whose gyros never spoke WHEN it despins
    let faults = [0, 1, 2]
        .map(|axis| Fault { first_cycle: 0, ..from_then_on(gone(SensorAxis::Gyro(axis))) });
    let flight = fly_with_faults(&into_the_night(), &faults);
    // THEN there is a rate when the field of a rest has been measured three times of five,
    let across = |it: &CycleRecord| rate_source(it) == Some(RateSource::AcrossField);
    let measured = share(&flight, 0, |it| it.field_body_t.value().is_some());
    assert!(share(&flight, 0, across) > 0.5 * measured, "{measured}");
    // THEN which takes the energy out of the tumble.
    let energy = |time_s: f64| flight.truth_at(time_s).kinetic_energy_j;
    println!("energy {:.2e} to {:.2e} J", energy(0.0), energy(4500.0));
    assert!(energy(1200.0) < 0.6 * energy(0.0) && energy(4500.0) < 0.1 * energy(0.0));
}

#[test]
fn without_a_magnetometer_the_sun_carries_the_attitude_and_the_error_is_as_promised() {
    let faults = [0, 1, 2].map(|axis| from_then_on(gone(SensorAxis::Magnetometer(axis))));
    let flight = fly_with_faults(&into_the_night(), &faults);
    let after = errors(&flight, FAILS_S);
    println!("{after:?}");
    // One vector and the dynamics by day; by night the dynamics alone, and then honestly so.
    assert!(after.in_sigma_squared < PROMISED && after.largest_deg < 15.0, "{after:?}");
}

#[test]
fn without_sun_sensors_the_field_carries_the_attitude_and_the_error_is_as_promised() {
    let faults: Vec<Fault> =
        (0..FACES).map(|face| from_then_on(gone(SensorAxis::SunFace(face)))).collect();
    let flight = fly_with_faults(&into_the_night(), &faults);
    let after = errors(&flight, FAILS_S);
    println!("{after:?}");
    assert!(after.known > 0.99 && after.in_sigma_squared < PROMISED, "{after:?}");
}

#[test]
fn nothing_that_a_sensor_says_makes_the_record_anything_but_numbers() {
    // GIVEN every axis failing in its own way, now and then
    let kinds: [fn(SensorAxis) -> FaultKind; 3] = [FaultKind::Stuck, FaultKind::NotANumber, gone];
    let axes = [0, 1, 2]
        .into_iter()
        .flat_map(|axis| [SensorAxis::Gyro(axis), SensorAxis::Magnetometer(axis)])
        .chain((0..FACES).map(SensorAxis::SunFace));
    let faults: Vec<Fault> = axes
        .zip(0_u32..)
        .flat_map(|(axis, at)| {
            kinds.into_iter().zip(0_u32..).map(move |(kind, which)| {
                let first_cycle = 200 + 137 * at + 1900 * which;
                Fault { first_cycle, last_cycle: first_cycle + 400, kind: kind(axis) }
            })
        })
        .collect();
    let flight = fly_with_faults(&into_the_night(), &faults);
    for record in &flight.records {
        let DeterminationRecord { attitude, rate, gyro_bias_rad_s, residual_dipole_am2, .. } =
            stage_two(record);
        let numbers = attitude
            .iter()
            .flat_map(|it| it.xyzw.into_iter().chain(it.sigma_rad))
            .chain(rate.iter().flat_map(|it| it.omega_bi_rad_s.into_iter().chain([it.sigma_rad_s])))
            .chain(gyro_bias_rad_s.into_iter().flatten())
            .chain(residual_dipole_am2.into_iter().flatten())
            .chain(record.commanded_am2);
        assert!(numbers.into_iter().all(f32::is_finite), "{record:?}");
    }
    // THEN what is believed at the end, long after the last fault, is right.
    let last = errors(&flight, 3600);
    println!("{last:?}");
    assert!(last.known == 1.0 && last.largest_deg < 10.0, "{last:?}");
}
