//! The stages: one line each.

use core::{cell::RefCell, convert::Infallible, hint::black_box};

use adcs_app::FlightApp;
use adcs_core::{
    attitude::{
        Method, Observation,
        dynamic::{Blocks, DynamicFilter, DynamicInputs, DynamicParameters, DynamicState},
        mekf::{self, FieldPair, Inputs, Mekf, MekfParameters, MekfState, SunPair},
        selection::{Estimator, EstimatorParameters, EstimatorState, Flies},
    },
    calibration::{
        CoupledSample, DataSheet, Extended, NoiseShift, Sample, Start, Sums,
        axes::{AxesCheck, AxesStep},
        calibrate, calibrate_extended,
    },
    control::b_dot::{BDot, BDotGain},
    control::cross_product::{self, CrossProduct, CrossProductParameters, PointingError},
    control::guidance::{Aim, Guidance},
    control::periodic::{Ahead, Motion, PeriodicLaw, PeriodicParameters, Plan},
    environment::{
        field::FieldModel,
        sun_track::{SunNodes, SunTrack},
        sunlight::Sunlight,
    },
    frames::{Body, Vector},
    orbit::OrbitModel,
    pipeline::{Law, Pointing, State},
    planning::{Models, PlanningState},
    polarity::{Guard, GuardInputs, GuardState, PolarityParameters, Purpose},
    reading::{MissingReason, Reading},
    schedule::Phase,
    sensing::{Expected, SunFaces, SunFacesParameters},
    time::{LeapSeconds, Utc, gmst82_rad},
};
use adcs_firmware::{memory, remembered};
use adcs_link::message::Message;
use adcs_sim::{
    exact_board::ExactBoard,
    fly,
    scenario::{Readings, Scenario},
    world::World,
};
use igrf::{Coefficients, DecimalYear};
use semihosting::eprintln;
use sgp4_lite::{MinutesSinceEpoch, Propagator};

use crate::{counter::Counter, ladder, scenario::despin};

/// Where SPROUT is in the scenario, Earth fixed, km, rounded.
const POSITION_KM: [f64; 3] = [-3_470.0, 3_430.0, 4_990.0];
/// Steps of the truth over which their cost is averaged.
const TRUTH_STEPS: u32 = 25;

/// Counts every stage and prints the results. Nothing here fails with the constants given.
pub fn run(counter: &Counter) {
    // The flights first, and what they take of the stack: the stages alone are not flown so, and keep what they
    // work on there.
    let room = remembered::room().expect("the first and only");
    cycle_with_chips(counter, &despin(Readings::Drivers), remembered::power_on(room));
    let stack = memory::stack_use();
    eprintln!("bytes stack {}", stack.peak_bytes);
    cycle(counter, &despin(Readings::Exact), remembered::power_on(room));
    // Each with a frame of its own: together they are more than the stack.
    models(counter);
    sun(counter);
    attitude(counter);
    kinematic(counter);
    dynamic(counter);
    blocks(counter);
    guard(counter);
    ladder::run(counter);
    pointing(counter);
    planning(counter);
    calibration(counter);
    calibration_of_nine(counter);
    recursive_calibration(counter);
}

/// The models one by one.
#[inline(never)]
fn models(counter: &Counter) {
    let world = despin(Readings::Exact).world;
    let (elements, now) = (world.elements, world.start);
    let minutes = MinutesSinceEpoch(36.0);
    let year = DecimalYear(2015.881);
    let propagator = Propagator::new(&elements).expect("SPROUT is near the Earth");
    let orbit = OrbitModel::new(&elements).expect("SPROUT is near the Earth");
    let position = orbit.state(now).expect("SPROUT is near the Earth").position;
    let field_f64 = Coefficients::<f64>::at(year).expect("within the table");
    let field_f32 = Coefficients::<f32>::at(year).expect("within the table");
    let mut reference = FieldModel::<f32>::new(now).expect("within the table");
    let law = BDot::new(BDotGain::Plain { gain_am2_s_per_t: 1e5 }).expect("positive");
    let (omega, field) = (Vector::new(0.06, 0.03, 0.14), Vector::new(2e-5, -1e-5, 3e-5));

    let stage = Stage { counter };
    stage.count("sgp4_init", elements, |elements| Propagator::new(&elements));
    stage.count("sgp4_propagate", minutes, |minutes| propagator.propagate(minutes));
    stage.count("igrf_prepare_f32", year, Coefficients::<f32>::at);
    stage.count("igrf_field_f64", POSITION_KM, |position| field_f64.field_ecef_nt(position));
    stage.count("igrf_field_f32", POSITION_KM.map(|x| x as f32), |position| {
        field_f32.field_ecef_nt(position)
    });
    stage.count("gmst82", now, |now| gmst82_rad(now.julian_date()));
    stage.count("reference_field", position, |position| reference.eci_t(now, position));
    stage.count("b_dot", (law, omega, field), |(law, omega, field)| law.dipole(omega, field));
}

/// The Sun as it should be seen, and as three faces see it.
fn sun(counter: &Counter) {
    let world = despin(Readings::Exact).world;
    let orbit = OrbitModel::new(&world.elements).expect("SPROUT is near the Earth");
    let position = orbit.state(world.start).expect("SPROUT is near the Earth").position;
    let track = SunTrack::new(LeapSeconds::BUILT_IN);
    let mut nodes = SunNodes::default();
    let sun = track.position_m(&mut nodes, world.start).expect("after 1972");
    let faces = SunFaces::new(&SunFacesParameters::SPROUT).expect("accepted");
    // From (1, 1, 1), 54.7 deg off three axes: the spot is 4.8 of 5 mm off the middle.
    let (low, high) = (7.4e-6, 38.8e-6);
    let towards = [high, low, high, low];
    let lit = [towards, [0.0; 4], towards, [0.0; 4], towards, [0.0; 4]].map(Reading::Fresh);

    let stage = Stage { counter };
    stage.count("sun_track", world.start, |now| track.position_m(&mut nodes, now));
    stage.count("sunlight", (sun, position), |(sun, position)| Sunlight::seen(sun, Some(position)));
    stage.count("sun_sighting", lit, |lit| faces.sight(&lit, &Expected::default()));
}

/// The attitude from Sun and field that disagree by a degree or two.
#[inline(never)]
fn attitude(counter: &Counter) {
    let pair = |body: [f32; 3], reference: [f32; 3], sigma_rad| {
        let (body, reference) = (Vector::from_xyz(body.into()), Vector::from_xyz(reference.into()));
        Observation::new(body, reference, sigma_rad).expect("directions")
    };
    let sun = pair([0.164, 0.976, -0.144], [-0.441, 0.822, 0.361], 0.0116);
    let field = pair([0.37e-5, -3.4e-5, -0.84e-5], [2.76e-5, -2.0e-5, -0.8e-5], 0.05);
    let stage = Stage { counter };
    let (sun_b, sun_i) = (sun.body().vector(), sun.eci().vector());
    stage.count("observation", (sun_b, sun_i), |(body, eci)| Observation::new(body, eci, 0.0116));
    let pairs = [sun, field];
    stage.count("triad", pairs, |pairs| Method::Triad.solve(&pairs));
    stage.count("foam", pairs, |pairs| Method::Foam.solve(&pairs));
    stage.count("q_method", pairs, |pairs| Method::QMethod.solve(&pairs));
    stage.count("quest", pairs, |pairs| Method::Quest.solve(&pairs));
}

/// What the filters are given: a tumble, and field and Sun that disagree by a degree or two.
fn sensed() -> (Reading<Vector<Body>>, FieldPair, SunPair) {
    let field = FieldPair {
        body: Vector::new(0.37e-5, -3.4e-5, -0.84e-5),
        eci: Vector::new(2.76e-5, -2.0e-5, -0.8e-5),
    };
    let sun = SunPair {
        body: Vector::new(0.164, 0.976, -0.144).direction().expect("not zero"),
        eci: Vector::new(-0.441, 0.822, 0.361).direction().expect("not zero"),
        sigma_rad: None,
    };
    (Reading::Fresh(Vector::new(0.06, 0.03, 0.14)), field, sun)
}

/// The filter's parts, and a whole cycle of it, half a second after it started from the same Sun and
/// field.
#[inline(never)]
fn kinematic(counter: &Counter) {
    let mekf = Mekf::<f32>::new(&MekfParameters::default()).expect("accepted");
    let (gyro, field, sun) = sensed();
    let inputs = Inputs { dt_s: 0.5, gyro, field: Some(field), sun: Some(sun) };
    let state = || {
        let mut state = MekfState::default();
        mekf.cycle(&mut state, &inputs);
        state
    };
    let stage = Stage { counter };
    stage.count("mekf_predict", state(), |mut state| {
        let outcome = mekf.predict(&mut state, gyro, 0.5);
        (state, outcome)
    });
    stage.count("mekf_update_field", state(), |mut state| {
        let outcome = mekf.update_field(&mut state, &field);
        (state, outcome)
    });
    stage.count("mekf_update_sun", state(), |mut state| {
        let outcome = mekf.update_sun(&mut state, &sun);
        (state, outcome)
    });
    stage.count("mekf_cycle", state(), |mut state| {
        let outcome = mekf.cycle(&mut state, &inputs);
        (state, outcome)
    });
}

/// The dynamics-aided filter with all its states, a second after it was started: a step of half a second
/// without measurements, each measurement without a step, everything at once, and both filters with the
/// selection between them.
#[inline(never)]
fn dynamic(counter: &Counter) {
    let parameters =
        EstimatorParameters::<f32> { dynamics: DynamicParameters::default(), flies: Flies::Both };
    let estimator = Estimator::new(&parameters).expect("accepted");
    let filter = DynamicFilter::new(&parameters.dynamics).expect("accepted");
    let silent =
        Inputs { dt_s: 0.0, gyro: Reading::Missing(MissingReason::Bus), field: None, sun: None };
    let (gyro, field, sun) = sensed();
    let around = |sensors: Inputs| DynamicInputs {
        sensors,
        reference_field: Some(field.eci),
        position: Some(Vector::new(6.9e6, 1e6, 5e5)),
        torquer_dipole: Vector::new(0.1, -0.2, 0.05),
        sunlit: Some(true),
    };
    let all = around(Inputs { dt_s: 0.5, gyro, field: Some(field), sun: Some(sun) });
    let started = || {
        let mut state = EstimatorState::default();
        for _ in 0..3 {
            estimator.cycle(&mut state, &all);
        }
        state
    };
    let nothing = mekf::Output::none(None);
    let stage = Stage { counter };
    for (name, sensors) in [
        ("dynamic_predict", Inputs { dt_s: 0.5, ..silent }),
        ("dynamic_update_gyro", Inputs { gyro, ..silent }),
        ("dynamic_update_field", Inputs { field: Some(field), ..silent }),
        ("dynamic_update_sun", Inputs { sun: Some(sun), ..silent }),
        ("dynamic_cycle", all.sensors),
    ] {
        stage.count(name, (started(), around(sensors)), |(mut state, inputs)| {
            let outcome = filter.cycle(&mut state.dynamic, &inputs, &nothing);
            (state, outcome)
        });
    }
    stage.count("estimator_cycle", started(), |mut state| {
        let outcome = estimator.cycle(&mut state, &all);
        (state, outcome)
    });
}

/// A cycle of the dynamics-aided filter without optional states, with each kind of them by itself, and
/// with all; and what the filter remembers, whichever of them fly.
#[inline(never)]
fn blocks(counter: &Counter) {
    let stage = Stage { counter };
    for (name, blocks) in [
        ("dynamic_none", Blocks::NONE),
        ("dynamic_inertia", Blocks { inertia: true, ..Blocks::NONE }),
        ("dynamic_torque", Blocks { torque: true, ..Blocks::NONE }),
        ("dynamic_shadow", Blocks { shadow: true, ..Blocks::NONE }),
        ("dynamic_field_bias", Blocks { field_bias: true, ..Blocks::NONE }),
        ("dynamic_all", Blocks::ALL),
    ] {
        let dynamics = DynamicParameters { blocks, ..DynamicParameters::default() };
        let parameters = EstimatorParameters::<f32> { dynamics, flies: Flies::Both };
        let estimator = Estimator::new(&parameters).expect("accepted");
        let filter = DynamicFilter::new(&parameters.dynamics).expect("accepted");
        let (gyro, field, sun) = sensed();
        let inputs = DynamicInputs {
            sensors: Inputs { dt_s: 0.5, gyro, field: Some(field), sun: Some(sun) },
            reference_field: Some(field.eci),
            position: Some(Vector::new(6.9e6, 1e6, 5e5)),
            torquer_dipole: Vector::new(0.1, -0.2, 0.05),
            sunlit: Some(true),
        };
        let mut state = EstimatorState::default();
        for _ in 0..3 {
            estimator.cycle(&mut state, &inputs);
        }
        let nothing = mekf::Output::none(None);
        stage.count(name, state, |mut state| {
            let outcome = filter.cycle(&mut state.dynamic, &inputs, &nothing);
            (state, outcome)
        });
    }
    eprintln!("bytes dynamic_state {}", size_of::<DynamicState<f32>>());
}

/// The polarity guard at the end of a rest, with gyro and field, while the torquers are told something.
#[inline(never)]
fn guard(counter: &Counter) {
    let guard = Guard::new(&PolarityParameters::default()).expect("accepted");
    let start = Utc::from_micros_since_2000(500_000_000_000_000);
    let (omega_bi, field, _) = sensed();
    let at = |cycle: i64| GuardInputs {
        now: start.plus_micros(cycle * 500_000),
        phase: if cycle % 25 == 0 { Phase::Measuring } else { Phase::Acting },
        omega_bi,
        field_b: if cycle % 25 == 0 {
            Reading::Fresh(field.body)
        } else {
            Reading::Missing(MissingReason::TorquersOn)
        },
        carried: Vector::new(0.1, -0.2, 0.05),
    };
    let mut state = GuardState::default();
    for cycle in 0..50 {
        guard.cycle(&mut state, &at(cycle), Purpose::Despin);
    }
    for (name, cycle) in [("guard_round", 50), ("guard_cycle", 51)] {
        let inputs = black_box(at(cycle));
        print(name, counter.count(|| guard.cycle(&mut state, &inputs, Purpose::Despin)));
    }
    eprintln!("bytes guard_state {}", size_of::<GuardState>());
}

const INERTIA: [[f32; 3]; 3] = [[0.05, 0.0, 0.0], [0.0, 0.055, 0.0], [0.0, 0.0, 0.06]];

fn cross_product_law() -> CrossProduct {
    let parameters = CrossProductParameters {
        stiffness_n_m_per_rad: 1.5e-7,
        damping_n_m_s: 3e-4,
        inertia_kg_m2: INERTIA,
        gyroscopic: false,
        gravity_gradient: false,
    };
    CrossProduct::new(&parameters).expect("accepted")
}

fn periodic_law() -> PeriodicLaw {
    let parameters = PeriodicParameters { inertia_kg_m2: INERTIA, ..Default::default() };
    PeriodicLaw::new(&parameters).expect("accepted")
}

/// The pointing laws, and a sweep in a field that costs nothing to predict.
#[inline(never)]
fn pointing(counter: &Counter) {
    let stage = Stage { counter };
    let field = Vector::new(2e-5, -1e-5, 3e-5);
    let (attitude, rate) = (Vector::new(0.1, -0.2, 0.05), Vector::new(1e-3, 2e-3, -1e-3));
    let (law, error) = (cross_product_law(), PointingError { attitude, rate });
    stage.count("cross_product", error, |error| {
        let torque = law.desired_torque(&error, error.rate, None);
        cross_product::dipole(torque, field)
    });

    let law = periodic_law();
    let now = Utc::from_micros_since_2000(500_000_000_000_000);
    let ahead = |_| Some(Ahead { field: field.relabel(), omega_t: Vector::new(0.0, -1e-3, 0.0) });
    let mut plan = Plan::default();
    plan.work(&law, now, ahead);
    print("sweep_step", counter.count(|| plan.work(&law, now, ahead)));
    while plan.gains(now).is_none() {
        plan.work(&law, now, ahead);
    }
    let motion =
        Motion { attitude: attitude.relabel(), rate: rate.relabel(), torque: Vector::zero() };
    stage.count("periodic", motion, |motion| {
        plan.gains(now).and_then(|gains| law.dipole(&gains, &motion, field.relabel(), 7.5))
    });
}

/// The look ahead as it flies, SGP4 and IGRF with it: the costliest slice, and a whole sweep.
#[inline(never)]
fn planning(counter: &Counter) {
    let scenario = despin(Readings::Exact);
    let elements = scenario.flight.elements.expect("an orbit");
    let orbit = OrbitModel::new(&elements).expect("accepted");
    let sun = SunTrack::new(LeapSeconds::BUILT_IN);
    let guidance = Guidance { aim: Aim::Nadir, slew: None };
    let pointing = Pointing { law: cross_product_law(), periodic: Some(periodic_law()), guidance };
    let (law, now) = (Law::Pointing(pointing), orbit.epoch());
    let models = Models { orbit: Some(&orbit), sun: &sun };
    let mut state = PlanningState::default();
    let (mut costliest, mut whole) = (0, 0);
    let mut planned = false;
    while !planned {
        let cost = counter.count(|| planned = state.cycle(&law, &models, now).is_some());
        whole += cost;
        costliest = cost.max(costliest);
    }
    print("plan_slice", costliest);
    print("plan_sweep", whole);
}

/// Scale of x, y, z and bias of x, y, z from the readings below, in bits, as the host computes them
/// (`the_emulated_core_finds_these_bits` of adcs-core's tests).
const CALIBRATED_BITS: [u32; 6] =
    [0x3f666665, 0x3f8ccccd, 0x3f99999b, 0x3727c5ab, 0xb70637bc, 0x36a7c5ad];

/// Scale and bias of the flight software, in bits, as the host finds them from the sums of the same.
const CHOSEN_BITS: [[u32; 3]; 2] =
    [[0x3f666663, 0x3f8ccccf, 0x3f9999a2], [0xb727c5aa, 0x370637c4, 0xb6a7c5cd]];

/// 100 readings from all sides, 6 to 50 µT.
fn readings() -> [Sample<f32>; 100] {
    core::array::from_fn(|k| {
        let [x, y, z] = [k * 7 % 11, k * 5 % 13, k * 3 % 7].map(|step| step as f32);
        let field = Vector::<Body>::new(x - 4.5, y - 5.5, z - 3.5) * 6e-6;
        let [x, y, z] = field.to_array();
        Sample {
            reading: [(x - 1e-5) / 0.9, (y + 8e-6) / 1.1, (z - 5e-6) / 1.2],
            intensity: field.norm(),
        }
    })
}

const DATA_SHEET: DataSheet<f32> = DataSheet { sensitivity: 1.0, zero: 0.0 };

/// A calibration of the magnetometer from 100 readings, from the data sheet to the covariance.
#[inline(never)]
fn calibration(counter: &Counter) {
    let (samples, start) = (readings(), Start::DataSheet(DATA_SHEET));
    let stage = Stage { counter };
    stage.count("calibrate_100", &samples, |samples| {
        calibrate(samples.iter().copied(), &start).expect("from all sides")
    });
    let paper = calibrate(samples, &start).expect("from all sides");
    let [s_x, s_y, s_z] = paper.scale.map(f32::to_bits);
    let [b_x, b_y, b_z] = paper.bias.map(f32::to_bits);
    assert_eq!([s_x, s_y, s_z, b_x, b_y, b_z], CALIBRATED_BITS, "the host finds other bits");
}

/// The same with cross-axis terms.
#[inline(never)]
fn calibration_of_nine(counter: &Counter) {
    let (samples, start) = (readings(), Start::DataSheet(DATA_SHEET));
    let stage = Stage { counter };
    stage.count("calibrate_nine_100", &samples, |samples| {
        let samples = samples.iter().copied().map(CoupledSample::from);
        let found: Result<Extended<f32, 9>, _> =
            calibrate_extended(samples, &start, NoiseShift::Kept);
        found.expect("from all sides")
    });
}

/// The same without keeping the readings; and which axis is which.
#[inline(never)]
fn recursive_calibration(counter: &Counter) {
    let (samples, stage) = (readings(), Stage { counter });
    let mut sums = Sums::new(DATA_SHEET, 3e-5_f32).expect("a data sheet");
    for sample in samples {
        sums.add(sample).expect("a reading");
    }
    let [first, ..] = samples;
    stage.count("sums_add", (sums, first), |(mut sums, sample)| {
        sums.add(sample).expect("a reading");
        sums
    });
    stage.count("sums_calibrate_nine", sums, |sums| {
        sums.calibration::<9>().expect("from all sides")
    });
    stage.count("sums_chosen", sums, |sums| sums.chosen().expect("from all sides"));
    let (found, _) = sums.chosen().expect("from all sides").correction(DATA_SHEET);
    let bits = [found.scale, found.bias].map(|three| three.map(f32::to_bits));
    assert_eq!(bits, CHOSEN_BITS, "the host finds other bits");
    eprintln!("bytes calibration_sums {}", size_of::<Sums<f32>>());
    eprintln!("bytes axes_check {}", size_of::<AxesCheck<f32>>());
    let step = AxesStep {
        dt_s: 0.5,
        rate_rad_s: [0.06, 0.03, 0.14],
        field_t: Some([2e-5, -1e-5, 3e-5]),
        dipole_am2: [0.1, 0.2, -0.3],
    };
    let mut axes = AxesCheck::new([[0.05, 0.0, 0.0], [0.0, 0.05, 0.0], [0.0, 0.0, 0.06]]);
    axes.add(&step);
    stage.count("axes_step", step, |step| axes.add(&step));
}

/// The truth's step, and cycles without the cost of any chip: the first of a flight, which prepares
/// the orbit's nodes and the field's coefficients, and the costliest of the round after it.
#[inline(never)]
fn cycle(counter: &Counter, scenario: &Scenario, state: &mut State) {
    let world = World::new(&scenario.world, &scenario.board).expect("a world");
    let world = RefCell::new(world);
    let app = FlightApp::new(ExactBoard::new(&world), &scenario.flight, state);
    let mut app = app.expect("accepted");
    print("cycle_first", counter.count(|| app.cycle()));
    let mut costliest = 0;
    for _ in 0..scenario.cycles {
        let advanced = world.borrow_mut().advance(scenario.flight.cycle_us);
        advanced.expect("no end of the models in sight");
        let cost = counter.count(|| app.cycle());
        costliest = cost.max(costliest);
    }
    print("cycle", costliest);

    let steps = TRUTH_STEPS * scenario.world.step_us;
    let cost = counter.count(|| world.borrow_mut().advance(steps));
    print("truth_step", cost / u64::from(TRUTH_STEPS));
}

/// The costliest cycle of a round through drivers and simulated chips: what lies between a cycle's
/// truth and its record.
#[inline(never)]
fn cycle_with_chips(counter: &Counter, scenario: &Scenario, state: &mut State) {
    let mut costliest = 0;
    let mut left = counter.now();
    let outcome = fly::fly_in::<Infallible>(state, scenario, &[], |message| {
        let cost = counter.since(left);
        if let Message::Cycle(_) = message {
            costliest = cost.max(costliest);
        }
        left = counter.now();
        Ok(())
    });
    outcome.expect("nothing stops this flight");
    print("cycle_with_chips", costliest);
}

struct Stage<'a> {
    counter: &'a Counter,
}

impl Stage<'_> {
    /// Counts `work` on `input`, hidden from the optimiser. Once: every run takes the same.
    fn count<I, T>(&self, name: &str, input: I, work: impl FnOnce(I) -> T) {
        let input = black_box(input);
        print(name, self.counter.count(|| work(input)));
    }
}

pub fn print(name: &str, instructions: u64) {
    eprintln!("instructions {name} {instructions}");
}
