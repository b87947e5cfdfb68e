//! What the application does on boards that fail: safe cycles, never a panic, never a NaN on a
//! torquer.

use adcs_app::{FlightApp, FlightParameters, LawParameters, ParameterError};
use adcs_core::control::allocation::TorquerParameters;
use adcs_core::control::b_dot::BDotGain;
use adcs_core::frames::{TorquerAxes, Vector};
use adcs_core::pipeline::State;
use adcs_core::pipeline::{ControlStatus, SteeringParameters};
use adcs_core::reading::{MissingReason, Reading};
use adcs_core::schedule::{Phase, ScheduleError, ScheduleParameters};
use adcs_core::sensing::sun_faces::FACES;
use adcs_core::sensing::{FaceVerdict, SunFacesParameters, TriadParameters};
use adcs_core::time::Utc;
use adcs_hal::board::{Board, Samples, TorquerFault};
use adcs_hal::fault::{Fault, FaultInjector, FaultKind, SensorAxis};
use adcs_link::CycleRecord;
use proptest::prelude::*;

const LIMIT_AM2: f32 = 0.6;
/// One round of the schedule below: one cycle at rest, two of action.
const ROUND: u32 = 3;

fn despin() -> FlightParameters {
    FlightParameters {
        cycle_us: 500_000,
        schedule: ScheduleParameters { on_us: 1_000_000, off_us: 500_000, settle_us: 500_000 },
        law: LawParameters::BDot(BDotGain::Plain { gain_am2_s_per_t: 1e5 }),
        steering: SteeringParameters::default(),
        modes: None,
        gyro: TriadParameters::default(),
        magnetometer: TriadParameters::default(),
        sun_sensors: Some(SunFacesParameters::SPROUT),
        attitude: None,
        torquers: TorquerParameters {
            max_dipole_am2: LIMIT_AM2,
            alignment_xyzw: [0.0, 0.0, 0.0, 1.0],
        },
        elements: None,
    }
}

/// A board that always reads the same, and takes every dipole.
struct Steady {
    samples: Samples,
}

impl Steady {
    fn tumbling() -> Self {
        let samples = Samples {
            rate_rad_s: [0.05, -0.02, 0.1].map(Reading::Fresh),
            field_t: [2e-5, -1e-5, 3e-5].map(Reading::Fresh),
            // The Sun straight before face 1.
            sun_a: core::array::from_fn(|face| Reading::Fresh([40e-6 * f32::from(face == 1); 4])),
        };
        Self { samples }
    }
}

impl Board for Steady {
    fn now(&mut self) -> Utc {
        Utc::from_micros_since_2000(0)
    }
    fn sample(&mut self) -> Samples {
        self.samples
    }
    fn drive(&mut self, dipole: Vector<TorquerAxes>) -> Result<Vector<TorquerAxes>, TorquerFault> {
        assert!(dipole.xyz.iter().all(|m| m.abs() <= LIMIT_AM2), "{dipole:?}");
        Ok(dipole)
    }
}

fn fly(board: impl Board, cycles: u32) -> (Vec<CycleRecord>, adcs_app::Health) {
    let mut state = State::default();
    let mut app = FlightApp::new(board, &despin(), &mut state).unwrap();
    let records = (0..cycles).map(|_| app.cycle()).collect();
    (records, app.health())
}

#[test]
fn a_round_rests_measures_and_acts() {
    let (records, health) = fly(Steady::tumbling(), 2 * ROUND);
    let phases: Vec<Phase> = records.iter().map(|record| record.phase).collect();
    let round = [Phase::Settling, Phase::Measuring, Phase::Acting];
    assert_eq!(phases, [round, round].concat());
    assert_eq!(records[0].commanded_am2, [0.0; 3]);
    assert_ne!(records[1].commanded_am2, [0.0; 3]);
    assert_eq!(records[2].commanded_am2, records[1].commanded_am2);
    assert_eq!(records[3].commanded_am2, [0.0; 3]);
    assert_eq!(health.cycles_with_missing_readings, 0);
}

#[test]
fn a_silent_magnetometer_keeps_the_torquers_off_until_it_speaks_again() {
    let kind = FaultKind::Missing(SensorAxis::Magnetometer(2), MissingReason::Bus);
    let script = [Fault { first_cycle: 0, last_cycle: ROUND - 1, kind }];
    let (records, health) = fly(FaultInjector::new(Steady::tumbling(), &script), 2 * ROUND);
    assert_eq!(records[1].control, ControlStatus::NoField(MissingReason::Bus));
    assert!(records[..ROUND as usize].iter().all(|record| record.commanded_am2 == [0.0; 3]));
    assert_eq!(records[ROUND as usize + 1].control, ControlStatus::Acting);
    assert_eq!(health.cycles_with_missing_readings, ROUND);
}

#[test]
fn a_silent_sun_sensor_is_in_the_record_and_counted() {
    let face = SensorAxis::SunFace(1);
    let silent = FaultKind::Missing(face, MissingReason::Bus);
    let script = [
        Fault { first_cycle: 1, last_cycle: 1, kind: silent },
        Fault { first_cycle: 2, last_cycle: 2, kind: FaultKind::NotANumber(face) },
    ];
    let (records, health) = fly(FaultInjector::new(Steady::tumbling(), &script), ROUND);
    let seen = records[0].sun.value().unwrap();
    assert!((seen.body[0] + 1.0).abs() < 1e-6, "{seen:?}");
    assert_eq!(records[0].sun_faces[1], FaceVerdict::Used);
    assert_eq!(records[1].sun, Reading::Missing(MissingReason::Bus));
    assert_eq!(records[2].sun_faces[1], FaceVerdict::Missing(MissingReason::NotFinite));
    assert_eq!(health.cycles_with_broken_sun_sensors, 2);
}

#[test]
fn a_board_without_sun_sensors_flies_and_counts_nothing() {
    let mut board = Steady::tumbling();
    board.samples.sun_a = Samples::NO_SUN_SENSORS;
    let (records, health) = fly(board, 2 * ROUND);
    assert_eq!(records[1].sun, Reading::Missing(MissingReason::NotFitted));
    assert_eq!(records[1].control, ControlStatus::Acting);
    assert_eq!(health, adcs_app::Health { cycles_without_orbit: 2 * ROUND, ..Default::default() });
}

#[test]
fn a_nan_of_a_driver_is_missing_before_anything_computes_with_it() {
    let kind = FaultKind::NotANumber(SensorAxis::Gyro(0));
    let script = [Fault { first_cycle: 0, last_cycle: u32::MAX, kind }];
    let (records, _) = fly(FaultInjector::new(Steady::tumbling(), &script), ROUND);
    for record in &records {
        assert_eq!(record.gyro_rad_s[0], Reading::Missing(MissingReason::NotFinite));
        assert_eq!(record.commanded_am2, [0.0; 3]);
    }
    assert_eq!(records[1].control, ControlStatus::NoRate(MissingReason::NotFinite));
}

#[test]
fn a_torquer_that_refuses_is_in_the_record_and_counted() {
    let kind = FaultKind::TorquerRefuses { axis: 1 };
    let script = [Fault { first_cycle: 1, last_cycle: 1, kind }];
    let (records, health) = fly(FaultInjector::new(Steady::tumbling(), &script), ROUND);
    assert_eq!(records[1].driven_am2, None);
    assert!(records[2].driven_am2.is_some());
    assert_eq!(health.torquer_faults, 1);
}

#[test]
fn parameters_are_refused_before_the_flight() {
    let mut never = despin();
    never.schedule.on_us = 0;
    assert_eq!(
        FlightApp::new(Steady::tumbling(), &never, &mut State::default()).err(),
        Some(ParameterError::Schedule(ScheduleError::NeverActs))
    );
}

#[test]
fn the_digest_tells_flights_apart_by_one_bit() {
    let digest = |x: f32| {
        let mut board = Steady::tumbling();
        board.samples.field_t[0] = Reading::Fresh(x);
        let mut state = State::default();
        let mut app = FlightApp::new(board, &despin(), &mut state).unwrap();
        app.cycle();
        app.digest()
    };
    assert_eq!(digest(2e-5), digest(2e-5));
    assert_ne!(digest(2e-5), digest(f32::from_bits(2e-5_f32.to_bits() + 1)));
}

fn any_reading() -> impl Strategy<Value = Reading<f32>> {
    prop_oneof![
        any::<f32>().prop_map(Reading::Fresh),
        Just(Reading::Missing(MissingReason::OutOfRange)),
    ]
}

proptest! {
    #[test]
    fn whatever_the_sensors_say_the_command_is_finite_and_within_limits(
        rate in [any_reading(), any_reading(), any_reading()],
        field in [any_reading(), any_reading(), any_reading()],
        sun in prop::collection::vec(prop::array::uniform4(any::<f32>()), FACES),
    ) {
        let sun_a = std::array::from_fn(|face| Reading::Fresh(sun[face]));
        let board = Steady { samples: Samples { rate_rad_s: rate, field_t: field, sun_a } };
        let mut state = State::default();
    let mut app = FlightApp::new(board, &despin(), &mut state).unwrap();
        for _ in 0..ROUND {
            let record = app.cycle();
            prop_assert!(record.commanded_am2.iter().all(|m| m.abs() <= LIMIT_AM2));
            let seen = record.sun.value();
            prop_assert!(seen.is_none_or(|sun| sun.body.iter().all(|x| x.is_finite())));
        }
    }
}
