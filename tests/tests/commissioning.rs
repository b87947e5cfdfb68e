//! A satellite of which nobody knows anything finds out what is wrong with itself.

use std::cell::RefCell;

use adcs_app::FlightApp;
use adcs_core::commissioning::{Commit, Findings, Outcome, Rung};
use adcs_core::modes::{Cause, Mode};
use adcs_core::pipeline::State;
use adcs_ground::report::pointing::Targets;
use adcs_link::CycleRecord;
use adcs_sim::exact_board::ExactBoard;
use adcs_sim::scenario::{COMMANDS, Order, Scenario, TimedCommand};
use adcs_sim::world::World;
use adcs_tests::{brief_commissioning, fly, mission};

/// Every rung that ended, and how.
fn ended(records: &[CycleRecord]) -> Vec<(Rung, Outcome)> {
    let ended = records.iter().filter_map(|it| it.commissioning?.ended);
    ended.map(|it| (it.rung, it.outcome)).collect()
}

fn all_passed() -> Vec<(Rung, Outcome)> {
    Rung::ALL.map(|rung| (rung, Outcome::Passed)).to_vec()
}

#[test]
fn it_calibrates_itself_and_points_without_a_command() {
    // GIVEN a magnetometer, gyros, Sun sensors and torquers that are wrong, and a tumble
    let scenario = mission("sprout/commissioning").scenario;
    assert!(scenario.commands.iter().all(Option::is_none));
    // WHEN it is left alone
    let flight = fly(&scenario);
    // THEN every rung passes, and what was found is put in force once
    assert_eq!(ended(&flight.records), all_passed());
    assert_eq!(flight.records.iter().filter(|it| it.committed).count(), 1);
    // AND it goes from commissioning to pointing, each step once
    let transitions = flight.records.iter().filter_map(|it| it.mode?.transition);
    let expected = [
        (Mode::Commissioning, Cause::PowerOn),
        (Mode::Detumble, Cause::Commissioned),
        (Mode::Acquire, Cause::Despun),
        (Mode::Point, Cause::Trusted),
    ];
    assert_eq!(transitions.map(|it| (it.to, it.cause)).collect::<Vec<_>>(), expected);
    // AND it points, with the Earth's light in its Sun sensors and 2 to 3 % in its torquers
    let targets = Targets::of(&scenario);
    let settled = flight.truth.iter().zip(&flight.records).skip(2 * 30_000);
    let errors: Vec<f64> =
        settled.filter_map(|(truth, record)| targets.error_deg(truth, record)).collect();
    let mean = errors.iter().sum::<f64>() / errors.len() as f64;
    println!("mean of the last 28,500 s {mean:.2} deg");
    assert!((0.1..9.0).contains(&mean), "{mean}");
}

#[test]
fn without_what_it_found_the_same_satellite_does_not_point() {
    let mut scenario = mission("sprout/commissioning").scenario;
    scenario.flight.modes.as_mut().expect("modes").table.start = Mode::Detumble;
    scenario.cycles = 2 * 20_000;
    let flight = fly(&scenario);
    let pointed = flight.records.iter().any(|it| it.mode.is_some_and(|it| it.mode == Mode::Point));
    let last = flight.records.last().and_then(|it| it.mode).map(|it| it.mode);
    println!("pointed: {pointed}, at the end {last:?}");
    assert!(!pointed || last != Some(Mode::Point));
}

#[test]
fn the_ground_may_keep_the_decision_to_itself() {
    // GIVEN results that wait for the ground
    let mut scenario = brief_commissioning();
    let modes = scenario.flight.modes.as_mut().expect("modes");
    modes.commissioning.as_mut().expect("a ladder").commit = Commit::ByGround;
    let done = |scenario: &Scenario| {
        let flight = fly(scenario);
        let over = flight.records.iter().position(|it| {
            it.mode.and_then(|it| it.transition).is_some_and(|it| it.cause == Cause::Commissioned)
        });
        (over.expect("the ladder ends"), flight)
    };
    let (over, waiting) = done(&scenario);
    assert!(waiting.records.iter().all(|it| !it.committed));
    // WHEN it says so
    let at = over as u32 + 10;
    scenario.commands = [None; COMMANDS];
    scenario.commands[0] = Some(TimedCommand { cycle: at, order: Order::Commit });
    let (_, told) = done(&scenario);
    // THEN from that cycle on they fly, and not before
    let committed: Vec<u32> =
        told.records.iter().filter(|it| it.committed).map(|it| it.cycle).collect();
    assert_eq!(committed, [at]);
    let field = |records: &[CycleRecord], cycle: u32| {
        records.iter().skip(cycle as usize).find_map(|it| it.field_body_t.value()).expect("a field")
    };
    assert_eq!(field(&told.records, at - 60), field(&waiting.records, at - 60));
    let (before, after) = (field(&waiting.records, at), field(&told.records, at));
    let moved = (0..3).map(|i| (after[i] - before[i]).abs()).fold(0.0, f32::max);
    assert!(moved > 5e-6, "the calibration moves the field by {moved} T");
}

/// Flies the ladder on exact sensors, with a reset after `reset` cycles; every rung that ended, and what was
/// found.
fn climbed(scenario: &Scenario, reset: Option<u32>) -> (Vec<(Rung, Outcome)>, Findings) {
    let world = RefCell::new(World::new(&scenario.world, &scenario.board).expect("a world"));
    let mut notebook = postcard::to_stdvec(&Findings::default()).expect("bytes");
    let mut rungs = Vec::new();
    let mut cycle = 0;
    for until in [reset.unwrap_or(0), scenario.cycles] {
        // Power-on, with what the notebook has.
        let mut state = State::default();
        let board = ExactBoard::new(&world);
        let mut app = FlightApp::new(board, &scenario.flight, &mut state).expect("an application");
        app.resume(postcard::from_bytes(&notebook).expect("findings"));
        while cycle < until {
            let record = app.cycle();
            if let Some(ended) = record.commissioning.and_then(|report| report.ended) {
                rungs.push((ended.rung, ended.outcome));
                notebook = postcard::to_stdvec(app.findings()).expect("bytes");
            }
            world.borrow_mut().advance(scenario.flight.cycle_us).expect("the world goes on");
            cycle += 1;
        }
    }
    (rungs, postcard::from_bytes(&notebook).expect("findings"))
}

#[test]
fn a_reset_costs_the_rung_that_was_being_climbed_and_nothing_else() {
    let mut scenario = brief_commissioning();
    scenario.cycles += 1_000;
    let (rungs, _) = climbed(&scenario, None);
    assert_eq!(rungs, all_passed());
    // In the midst of the magnetometer, of the gyro, of the dipole.
    for reset in [200, 700, 1_000] {
        let (rungs, findings) = climbed(&scenario, Some(reset));
        assert_eq!(rungs, all_passed(), "each once, with a reset after {reset} cycles");
        assert_eq!(findings.next(), None);
        assert!(findings.magnetometer.is_some() && findings.inertia.is_some());
    }
}
