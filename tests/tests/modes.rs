//! The mode machine in flight: from separation to pointing, and from every failure to safety.

use adcs_core::modes::{Cause, Mode, Sensor, Transition};
use adcs_core::polarity::{SignedPermutation, Suspect};
use adcs_core::reading::MissingReason;
use adcs_ground::report::pointing::Targets;
use adcs_hal::fault::{Fault, FaultKind, SensorAxis};
use adcs_sim::scenario::{COMMANDS, Order, Scenario, TimedCommand};
use adcs_tests::{Flight, fly, fly_with_faults, mission};

const CYCLES_A_SECOND: u32 = 2;

/// Every transition and when it was, s.
fn transitions(flight: &Flight) -> Vec<(f64, Transition)> {
    let at = |cycle: u32| flight.time_s(cycle);
    let records = flight.records.iter();
    records.filter_map(|record| Some((at(record.cycle), record.mode?.transition?))).collect()
}

fn causes(flight: &Flight) -> Vec<(Mode, Cause)> {
    transitions(flight).iter().map(|(_, it)| (it.to, it.cause)).collect()
}

#[test]
fn from_separation_to_nadir_without_a_command() {
    // GIVEN a separation at 10 deg/s, nothing known of attitude and residual dipole
    let scenario = mission("sprout/separation-to-nadir").scenario;
    assert!(scenario.commands.iter().all(Option::is_none));
    // WHEN it flies for five orbits
    let scenario = Scenario { cycles: 29_500 * CYCLES_A_SECOND, ..scenario };
    let flight = fly(&scenario);
    // THEN it goes its way, each step once
    let expected = [
        (Mode::Detumble, Cause::PowerOn),
        (Mode::Acquire, Cause::Despun),
        (Mode::Point, Cause::Trusted),
    ];
    assert_eq!(causes(&flight), expected);
    // AND points: drag leaves an error of 5 deg in the mean, 11 deg at most over eight orbits
    let targets = Targets::of(&scenario);
    let last_orbit = flight.truth.iter().zip(&flight.records).skip(24_000 * 2);
    let worst = last_orbit.filter_map(|(truth, record)| targets.error_deg(truth, record));
    let worst = worst.fold(0.0, f64::max);
    println!("{:?}, worst of the last orbit {worst:.2} deg", transitions(&flight));
    assert!((0.1..15.0).contains(&worst), "{worst}");
}

/// A satellite in this mode, with a sensor that fails after 1000 s. A slow turn, so that every mode could
/// go on.
fn failing(mode: Mode, sensor: Sensor, kind: fn(SensorAxis) -> FaultKind) -> Flight {
    let axes = match sensor {
        Sensor::Gyro => (0..3).map(SensorAxis::Gyro).collect::<Vec<_>>(),
        Sensor::Magnetometer => (0..3).map(SensorAxis::Magnetometer).collect(),
        Sensor::SunSensors => (0..6).map(SensorAxis::SunFace).collect(),
    };
    failing_with(mode, &axes.into_iter().map(kind).collect::<Vec<_>>())
}

/// The same with these faults.
fn failing_with(mode: Mode, kinds: &[FaultKind]) -> Flight {
    const FAILS_AT_S: u32 = 1_000;
    let mut scenario = mission("sprout/separation-to-nadir").scenario;
    scenario.world.omega_bi_rad_s = [0.004, -0.006, 0.002];
    let modes = scenario.flight.modes.as_mut().expect("the mission has modes");
    modes.experiment = Some(modes.despin);
    // Long enough that nothing but the sensor ends a mode, and that no mode leads on to another.
    modes.table.experiment_s = 1e5;
    modes.table.despun_rad_s = 1e-5;
    if mode != Mode::Point {
        modes.table.trusted_for_s = 9_000.0;
    }
    let entered = TimedCommand { cycle: 900 * CYCLES_A_SECOND, order: Order::Enter(mode) };
    scenario.commands = [None; COMMANDS];
    scenario.commands[0] =
        Some(TimedCommand { cycle: 10 * CYCLES_A_SECOND, order: Order::Enter(Mode::Acquire) });
    scenario.commands[1] = Some(entered);
    scenario.cycles = 2_000 * CYCLES_A_SECOND;
    let fault = |kind: &FaultKind| Fault {
        first_cycle: FAILS_AT_S * CYCLES_A_SECOND,
        last_cycle: u32::MAX,
        kind: *kind,
    };
    fly_with_faults(&scenario, &kinds.iter().map(fault).collect::<Vec<_>>())
}

fn bus(axis: SensorAxis) -> FaultKind {
    FaultKind::Missing(axis, MissingReason::Bus)
}

#[test]
fn each_sensor_that_fails_in_each_mode_ends_in_safety_with_its_reason() {
    for mode in [Mode::Acquire, Mode::Point, Mode::Detumble, Mode::Experiment] {
        let points = matches!(mode, Mode::Acquire | Mode::Point);
        for sensor in [Sensor::Gyro, Sensor::Magnetometer, Sensor::SunSensors] {
            if sensor == Sensor::SunSensors && !points {
                // Despin needs none: the next test.
                continue;
            }
            let flight = failing(mode, sensor, bus);
            let all = transitions(&flight);
            let Some((at_s, last)) = all.last() else { panic!("{mode} {sensor:?}: none") };
            println!("{mode} {sensor:?}: {at_s} s {last:?}");
            let expected = Transition { from: mode, to: Mode::Safe, cause: Cause::Silent(sensor) };
            assert_eq!(*last, expected);
            assert!((1_055.0..=1_620.0).contains(at_s), "{mode} {sensor:?}: {at_s}");
            // AND the torquers are off from that cycle on
            let since = flight.records.iter().filter(|it| flight.time_s(it.cycle) >= *at_s);
            assert!(since.clone().count() > 700, "some minutes of them");
            assert!(since.clone().all(|it| it.commanded_am2 == [0.0; 3]), "{mode} {sensor:?}");
        }
    }
}

#[test]
fn torquers_that_refuse_end_despin_and_pointing_in_safety() {
    for mode in [Mode::Detumble, Mode::Point] {
        let flight = failing_with(mode, &[FaultKind::TorquerRefuses { axis: 1 }]);
        let all = transitions(&flight);
        let Some((at_s, last)) = all.last() else { panic!("{mode}: none") };
        assert_eq!((last.from, last.to, last.cause), (mode, Mode::Safe, Cause::TorquersRefuse));
        // Refused from the cycle of 1000 s on, known in the next, for a minute.
        assert!((1_060.0..=1_062.0).contains(at_s), "{mode}: {at_s}");
    }
}

#[test]
fn without_sun_sensors_despin_goes_on_to_its_end_and_then_to_safety() {
    // GIVEN a slow turn and Sun sensors that have never spoken
    let mut scenario = mission("sprout/separation-to-nadir").scenario;
    scenario.world.omega_bi_rad_s = [0.004, -0.006, 0.002];
    let modes = scenario.flight.modes.as_mut().expect("the mission has modes");
    modes.experiment = Some(modes.despin);
    modes.table.experiment_s = 300.0;
    modes.table.sun_gap_s = 60.0;
    scenario.cycles = 3_000 * CYCLES_A_SECOND;
    let dead =
        |face| Fault { first_cycle: 0, last_cycle: u32::MAX, kind: bus(SensorAxis::SunFace(face)) };
    let faults = (0..6).map(dead).collect::<Vec<_>>();
    for (mode, ends_s, cause) in [
        // The residual dipole swings it for some minutes.
        (Mode::Detumble, 120.0..=1_000.0, Cause::Silent(Sensor::SunSensors)),
        (Mode::Experiment, 309.0..=311.0, Cause::Over),
    ] {
        scenario.commands[0] = (mode == Mode::Experiment)
            .then_some(TimedCommand { cycle: 20, order: Order::Enter(mode) });
        // THEN despin goes on to its end, and from there to safety
        let flight = fly_with_faults(&scenario, &faults);
        let all = transitions(&flight);
        let ended = all.iter().find(|(_, it)| it.from == mode);
        let Some((at_s, ended)) = ended else { panic!("{mode}: {all:?}") };
        assert_eq!(*ended, Transition { from: mode, to: Mode::Safe, cause });
        assert!(ends_s.contains(at_s), "{mode}: {at_s}");
        // AND does not leave it for want of a Sun
        if mode == Mode::Detumble {
            assert_eq!(all.last(), Some(&(*at_s, *ended)));
        }
    }
}

#[test]
fn a_sensor_that_freezes_or_gives_no_numbers_is_silent_too() {
    for kind in [FaultKind::Stuck, FaultKind::NotANumber] {
        for sensor in [Sensor::Gyro, Sensor::Magnetometer] {
            let flight = failing(Mode::Point, sensor, kind);
            let last = transitions(&flight).last().map(|(_, it)| (it.to, it.cause));
            assert_eq!(
                last,
                Some((Mode::Safe, Cause::Silent(sensor))),
                "{:?}",
                kind(SensorAxis::Gyro(0))
            );
        }
    }
}

#[test]
fn a_gap_of_half_a_minute_is_ridden_out() {
    let mut scenario = mission("sprout/separation-to-nadir").scenario;
    scenario.cycles = 600 * CYCLES_A_SECOND;
    let gap = |axis| Fault {
        first_cycle: 200 * CYCLES_A_SECOND,
        last_cycle: 230 * CYCLES_A_SECOND,
        kind: bus(axis),
    };
    let axes = (0..3).flat_map(|axis| [SensorAxis::Gyro(axis), SensorAxis::Magnetometer(axis)]);
    let flight = fly_with_faults(&scenario, &axes.map(gap).collect::<Vec<_>>());
    assert_eq!(causes(&flight), [(Mode::Detumble, Cause::PowerOn)]);
}

#[test]
fn commands_of_a_mission_reach_the_satellite_at_their_time() {
    let mut scenario = mission("sprout/separation-to-nadir").scenario;
    scenario.cycles = 100 * CYCLES_A_SECOND;
    for (slot, (seconds, enter)) in scenario.commands.iter_mut().zip([
        (20, Mode::Off),
        (60, Mode::Experiment),
        (80, Mode::Safe),
    ]) {
        *slot = Some(TimedCommand { cycle: seconds * CYCLES_A_SECOND, order: Order::Enter(enter) });
    }
    let flight = fly(&scenario);
    let all = transitions(&flight);
    let at: Vec<_> = all.iter().map(|(at_s, it)| (*at_s, it.to)).collect();
    assert_eq!(at, [(0.0, Mode::Detumble), (20.0, Mode::Off), (80.0, Mode::Safe)]);
    // There is no experiment in this mission, and the satellite says so, once.
    let refused = flight.records.iter().filter_map(|it| Some((it.cycle, it.mode?.refused?)));
    assert_eq!(refused.collect::<Vec<_>>(), [(120, Mode::Experiment)]);
}

/// The satellite after separation, wired as `matrix` says of its magnetometer, in commissioning or not.
fn wired(start: Mode, matrix: [[f64; 3]; 3]) -> Flight {
    let mut scenario = mission("sprout/separation-to-nadir").scenario;
    scenario.world.magnetometer.matrix = matrix;
    scenario.flight.modes.as_mut().expect("the mission has modes").table.start = start;
    scenario.cycles = 600 * CYCLES_A_SECOND;
    fly(&scenario)
}

const RIGHT: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
/// x and y turned round, as in the paper's first experiment.
const TURNED: [[f64; 3]; 3] = [[-1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0]];

#[test]
fn commissioning_lets_a_satellite_go_that_is_wired_as_it_should_be() {
    let flight = wired(Mode::Commissioning, RIGHT);
    println!("{:?}", transitions(&flight));
    let expected = [(Mode::Commissioning, Cause::PowerOn), (Mode::Detumble, Cause::Checked)];
    assert_eq!(causes(&flight), expected);
}

#[test]
fn commissioning_names_a_magnetometer_with_two_signs_turned_round() {
    let flight = wired(Mode::Commissioning, TURNED);
    let all = transitions(&flight);
    println!("{all:?}");
    let Some((_, Transition { to: Mode::Safe, cause: Cause::Miswired(suspect), .. })) = all.last()
    else {
        panic!("{all:?}")
    };
    let Suspect::Magnetometer(wiring) = suspect else { panic!("{suspect}") };
    assert_eq!(wiring.to_string(), "-x -y +z");
    assert_ne!(*wiring, SignedPermutation::IDENTITY);
    assert!(flight.records.iter().rev().take(100).all(|it| it.commanded_am2 == [0.0; 3]));
}

#[test]
fn the_guard_stops_a_despin_with_two_signs_turned_round_for_good() {
    let flight = wired(Mode::Detumble, TURNED);
    let all = transitions(&flight);
    println!("{all:?}");
    let Some((at_s, last)) = all.last() else { panic!("none") };
    assert!(matches!(last.cause, Cause::Miswired(_)) && last.to == Mode::Safe, "{last:?}");
    // The bar for wrong sensors, and then no retry: waiting cures no wiring.
    assert!(*at_s <= 120.0, "{at_s}");
    assert_eq!(all.len(), 2);
}
