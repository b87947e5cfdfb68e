//! What the filter as a whole does.

use super::*;
use crate::attitude::mekf::{GivenStart, Mekf, MekfState};
use crate::reading::{MissingReason, Reading};
use nalgebra::{SMatrix, UnitQuaternion};

const FIELD: [f64; 3] = [2e-5, -1e-5, 3e-5];
const SUN: [f64; 3] = [0.6, 0.0, 0.8];

fn parameters(inertia: bool, torque: bool) -> DynamicParameters<f64> {
    DynamicParameters { blocks: Blocks { inertia, torque, ..Blocks::NONE }, ..Default::default() }
}

fn vector<F>([x, y, z]: [f64; 3]) -> Vector<F, f64> {
    Vector::new(x, y, z)
}

/// A satellite that stands still along Eci, in sunlight.
fn inputs(dt_s: f64) -> DynamicInputs<f64> {
    let direction = |xyz| Vector::<Body, f64>::from_xyz(Vector3::from(xyz)).direction();
    DynamicInputs {
        sensors: mekf::Inputs {
            dt_s,
            gyro: Reading::Fresh(Vector::zero()),
            field: Some(FieldPair { body: vector(FIELD), eci: vector(FIELD) }),
            sun: Some(SunPair {
                body: direction(SUN).unwrap(),
                eci: vector(SUN).direction().unwrap(),
                sigma_rad: None,
            }),
        },
        reference_field: Some(vector(FIELD)),
        position: Some(vector([7.0e6, 0.0, 0.0])),
        torquer_dipole: Vector::zero(),
        sunlit: Some(true),
    }
}

/// Both filters, one beside the other.
struct Pair {
    mekf: Mekf<f64>,
    kinematic: MekfState<f64>,
    filter: DynamicFilter<f64>,
    state: DynamicState<f64>,
}

impl Pair {
    fn new(parameters: &DynamicParameters<f64>) -> Self {
        let mekf = Mekf::new(&parameters.sensors).unwrap();
        let mut kinematic = MekfState::default();
        let start = GivenStart {
            r_bi: Rotation::identity(),
            attitude_sigma_rad: 0.05,
            gyro_bias: Vector::zero(),
            gyro_bias_sigma_rad_s: 5e-3,
        };
        mekf.begin(&mut kinematic, &start).unwrap();
        let filter = DynamicFilter::new(parameters).unwrap();
        Self { mekf, kinematic, filter, state: DynamicState::default() }
    }

    fn cycle(&mut self, inputs: &DynamicInputs<f64>) -> DynamicOutput<f64> {
        let kinematic = self.mekf.cycle(&mut self.kinematic, &inputs.sensors);
        self.filter.cycle(&mut self.state, inputs, &kinematic)
    }

    fn covariance(&self) -> Covariance<f64> {
        self.state.tracked.unwrap().covariance
    }
}

#[test]
fn the_start_knows_how_rate_attitude_and_bias_go_together() {
    let parameters = parameters(true, true);
    let mut pair = Pair::new(&parameters);
    // Some seconds, so that attitude and bias go with each other.
    let kinematic = (0..9).map(|_| pair.mekf.cycle(&mut pair.kinematic, &inputs(1.0).sensors));
    let kinematic = kinematic.last().unwrap();
    let output = pair.filter.cycle(&mut pair.state, &inputs(1.0), &kinematic);
    assert_eq!(output.event, Some(DynamicEvent::Started));

    // θ and Δβ as they are, δω = −Δβ − v with the sample's noise v.
    let estimate = kinematic.estimate.unwrap();
    let mut before = SMatrix::<f64, 9, 9>::zeros();
    before.fixed_view_mut::<6, 6>(0, 0).copy_from(&estimate.covariance);
    let noise = parameters.sensors.gyro_noise_rad_s;
    before.fixed_view_mut::<3, 3>(6, 6).fill_diagonal(noise * noise);
    let mut map = SMatrix::<f64, 9, 9>::zeros();
    map.fixed_view_mut::<3, 3>(0, 0).fill_diagonal(1.0);
    map.fixed_view_mut::<3, 3>(3, 3).fill_diagonal(-1.0);
    map.fixed_view_mut::<3, 3>(3, 6).fill_diagonal(-1.0);
    map.fixed_view_mut::<3, 3>(6, 3).fill_diagonal(1.0);
    let expected = map * before * map.transpose();
    let started = pair.covariance();
    let order = [Block::Attitude, Block::Rate, Block::Bias];
    for (i, row) in order.into_iter().enumerate() {
        for (j, column) in order.into_iter().enumerate() {
            let block: Matrix3<f64> = expected.fixed_view::<3, 3>(3 * i, 3 * j).into();
            assert!((started.block(row, column) - block).norm() < 1e-18, "{row:?} {column:?}");
        }
    }
    assert!(estimate.covariance.fixed_view::<3, 3>(0, 3).norm() > 1e-6, "they do");
    // Of the others nothing is known but their priors.
    let dipole = parameters.dipole_prior_am2;
    assert_eq!(started.variance(Block::Dipole), Vector3::repeat(dipole * dipole));
    assert_eq!(started.block(Block::Dipole, Block::Rate), Matrix3::zeros());
}

#[test]
fn a_shadows_edge_makes_the_dipole_uncertain_and_nothing_else() {
    let step = DynamicParameters::<f64>::default().dipole_step_am2;
    for (before, now, more) in [
        (Some(true), Some(false), step * step),
        (Some(false), Some(true), step * step),
        (Some(true), Some(true), 0.0),
        (Some(true), None, 0.0),
        (None, Some(false), 0.0),
    ] {
        let mut pair = Pair::new(&parameters(true, true));
        pair.cycle(&inputs(1.0));
        pair.state.sunlit = before;
        let mut expected = pair.covariance();
        expected.add(Block::Dipole, &Matrix3::from_diagonal_element(more));
        pair.filter.cross_shadow(&mut pair.state, now, 1.0);
        for row in Block::ALL {
            for column in Block::ALL {
                let found = pair.covariance().block(row, column);
                assert_eq!(found, expected.block(row, column), "{row:?} {column:?}");
            }
        }
    }
    // A cycle in which nobody knows is no edge.
    let mut pair = Pair::new(&parameters(true, true));
    pair.cycle(&inputs(1.0));
    for sunlit in [None, Some(true)] {
        pair.filter.cross_shadow(&mut pair.state, sunlit, 1.0);
    }
    let prior = DynamicParameters::<f64>::default().dipole_prior_am2;
    assert_eq!(pair.covariance().variance(Block::Dipole).x, prior * prior);
}

#[test]
fn each_set_of_blocks_flies() {
    for (inertia, torque) in [(false, false), (true, false), (false, true), (true, true)] {
        let mut pair = Pair::new(&parameters(inertia, torque));
        assert_eq!(pair.cycle(&inputs(1.0)).event, Some(DynamicEvent::Started));
        for _ in 0..300 {
            let output = pair.cycle(&inputs(1.0));
            assert_eq!(output.event, None);
            let accepted = [output.gyro, output.field, output.sun];
            assert!(accepted.iter().all(|seen| seen.unwrap().accepted));
            let estimate = output.estimate.unwrap();
            assert!(estimate.trusted && !estimate.gyro_doubtful);
            assert!(estimate.r_bi.angle_rad() < 1e-3);
        }
        let end = pair.state.tracked.unwrap();
        let moved = |state: Vector3<f64>| state != Vector3::zeros();
        assert_eq!([end.moments, end.products].map(moved), [inertia; 2]);
        assert_eq!(moved(end.torque), torque);
    }
}

#[test]
fn a_long_step_is_many_short_ones() {
    let mut once = Pair::new(&parameters(true, true));
    once.cycle(&inputs(1.0));
    let mut often = Pair { state: once.state, ..Pair::new(&parameters(true, true)) };
    for pair in [&mut once, &mut often] {
        let tracked = pair.state.tracked.as_mut().unwrap();
        tracked.motion.omega = Vector3::new(0.06, 0.03, -0.14);
    }
    assert!(once.filter.predict(&mut once.state, &inputs(10.0)));
    for _ in 0..20 {
        assert!(often.filter.predict(&mut often.state, &inputs(0.5)));
    }
    let (once, often) = (once.state.tracked.unwrap(), often.state.tracked.unwrap());
    assert_eq!(once.motion.omega, often.motion.omega);
    let of = |tracked: &Tracked<f64>| tracked.covariance.block(Block::Rate, Block::Dipole);
    assert_eq!(of(&once), of(&often));
}

#[test]
fn what_cannot_be_carried_is_lost_and_told() {
    type Change = fn(&mut DynamicInputs<f64>);
    let changes: [Change; 7] = [
        |inputs| inputs.sensors.dt_s = -1.0,
        |inputs| inputs.sensors.dt_s = f64::NAN,
        |inputs| inputs.sensors.dt_s = 10.1,
        |inputs| inputs.reference_field = None,
        |inputs| inputs.reference_field = Some(vector([f64::NAN, 0.0, 0.0])),
        |inputs| inputs.torquer_dipole = vector([0.0, f64::INFINITY, 0.0]),
        |inputs| inputs.torquer_dipole = vector([1e300, 1e300, 1e300]),
    ];
    for change in changes {
        let mut pair = Pair::new(&parameters(true, true));
        pair.cycle(&inputs(1.0));
        assert!(pair.cycle(&inputs(1.0)).estimate.is_some());
        let mut bad = inputs(1.0);
        change(&mut bad);
        assert_eq!(pair.cycle(&bad).event, Some(DynamicEvent::Lost));
        for _ in 0..3 {
            pair.cycle(&inputs(1.0));
        }
        assert!(pair.cycle(&inputs(1.0)).estimate.is_some(), "and started again");
    }
}

#[test]
fn there_is_no_start_without_gyro_model_or_mekf() {
    type Change = fn(&mut DynamicInputs<f64>);
    let changes: [Change; 4] = [
        |inputs| inputs.sensors.gyro = Reading::Missing(MissingReason::Bus),
        |inputs| inputs.sensors.gyro = Reading::Fresh(vector([f64::NAN, 0.0, 0.0])),
        |inputs| inputs.sensors.gyro = Reading::Fresh(vector([0.0, 100.0, 0.0])),
        |inputs| inputs.reference_field = None,
    ];
    for change in changes {
        let mut pair = Pair::new(&parameters(true, true));
        let kinematic = pair.mekf.cycle(&mut pair.kinematic, &inputs(1.0).sensors);
        let mut bad = inputs(1.0);
        change(&mut bad);
        let output = pair.filter.cycle(&mut pair.state, &bad, &kinematic);
        assert!(output.estimate.is_none() && output.event.is_none());
    }
    let mut pair = Pair::new(&parameters(true, true));
    let nothing = mekf::Output::none(None);
    assert!(pair.filter.cycle(&mut pair.state, &inputs(1.0), &nothing).estimate.is_none());
}

#[test]
fn an_attitude_that_is_too_uncertain_for_linear_equations_is_not_trusted() {
    let mut pair = Pair::new(&parameters(true, true));
    assert!(pair.cycle(&inputs(1.0)).estimate.unwrap().trusted);
    // 30 deg about one axis; the limit is 20.
    let more = Matrix3::from_diagonal(&Vector3::new(0.0, 0.27, 0.0));
    pair.state.tracked.as_mut().unwrap().covariance.add(Block::Attitude, &more);
    assert!(!pair.filter.output(&pair.state, None).estimate.unwrap().trusted);
    // One Sun and one field later it is known again.
    assert!(pair.cycle(&inputs(1.0)).estimate.unwrap().trusted);
}

#[test]
fn a_truth_from_somewhere_else_takes_the_estimates_place_and_keeps_its_covariance() {
    let parameters = parameters(true, true);
    let mut pair = Pair::new(&parameters);
    pair.cycle(&inputs(1.0));
    let before = pair.covariance();
    let truth = Truth {
        r_bi: Rotation::from_hamilton(UnitQuaternion::from_euler_angles(0.1, 0.2, 0.3)),
        omega: Vector3::new(0.01, 0.02, 0.03),
        bias: Vector3::new(1e-3, 2e-3, 3e-3),
        dipole: Vector3::new(0.1, 0.2, 0.3),
        inertia: parameters.inertia() + Matrix3::new(3., 1., 2., 1., 2., 3., 2., 3., 1.) * 1e-4,
        torque: Vector3::new(1e-7, 2e-7, 3e-7),
    };
    pair.state.linearise_at(&truth, &parameters);
    let output = pair.filter.output(&pair.state, None).estimate.unwrap();
    assert!((output.r_bi * truth.r_bi.inverse()).angle_rad() < 1e-15);
    assert_eq!(output.residual_dipole.xyz, truth.dipole);
    assert!((output.torque.xyz - truth.torque).norm() < 1e-20);
    // The tensor follows with the next step.
    pair.filter.predict(&mut pair.state, &inputs(0.5));
    let tensor = pair.state.tracked.unwrap().inertia.tensor;
    assert!((tensor - truth.inertia).norm() < 1e-16);
    let kept = Pair { state: pair.state, ..Pair::new(&parameters) }.covariance();
    assert_eq!(kept.variance(Block::Moments), before.variance(Block::Moments));
}
