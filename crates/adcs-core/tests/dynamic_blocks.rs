//! The dynamics-aided filter's optional states: what each of them is there for.

mod dynamic_support;

use adcs_core::attitude::dynamic::{Blocks, DynamicInputs, DynamicParameters};
use adcs_core::frames::Vector;
use dynamic_support::{Filters, World};
use nalgebra::Vector3;

/// A tumble like that of the first hours.
const RATE_DEG_S: [f64; 3] = [0.4, -0.3, 0.5];
/// Sunlight and shadow by turns, s.
const ARC_S: u32 = 1200;
/// What panels change.
const JUMP_AM2: [f64; 3] = [0.06, -0.04, 0.03];

fn parameters(blocks: Blocks) -> DynamicParameters<f32> {
    DynamicParameters { blocks, dipole_step_am2: 0.05, ..DynamicParameters::default() }
}

/// Rms of the error of the residual dipole over the last two arcs, A·m²: sunlight and shadow by turns, the
/// dipole following with a lag.
fn dipole_error(blocks: Blocks, lag_s: f64) -> f64 {
    let (mut filters, mut world) = (Filters::new(&parameters(blocks)), World::new(3, RATE_DEG_S));
    let (sunlit, mut jump) = (world.residual, Vector3::zeros());
    let (mut sum, mut count) = (0.0, 0.0);
    for second in 0..6 * ARC_S {
        world.lit = (second / ARC_S).is_multiple_of(2);
        let target = if world.lit { Vector3::zeros() } else { Vector3::from(JUMP_AM2) };
        jump += (target - jump) / lag_s.max(1.0);
        world.residual = sunlit + jump;
        let inputs = world.next();
        let (_, dynamic) = filters.cycle(&inputs);
        if second >= 4 * ARC_S {
            let found = dynamic.estimate.expect("there is one").residual_dipole.xyz.cast::<f64>();
            sum += (found - world.residual).norm_squared();
            count += 1.0;
        }
    }
    libm::sqrt(sum / count)
}

#[test]
fn what_the_shadow_does_is_learned_once_and_known_from_then_on_whatever_its_lag() {
    // What has to be found anew at each edge is wrong for minutes. A jump without any lag is found within
    // the minute in which the shorter of the two lags still sees it coming.
    let both = Blocks { inertia: true, torque: true, ..Blocks::NONE };
    for (lag_s, share) in [(0.0, 1.3), (60.0, 0.3), (200.0, 0.3), (500.0, 0.3)] {
        let anew = dipole_error(both, lag_s);
        let learned = dipole_error(Blocks { shadow: true, ..both }, lag_s);
        assert!(learned < share * anew, "{lag_s} s: {learned} A·m², without {anew}");
    }
}

/// Rms of the attitude over the last 20 minutes of two hours, deg, with a biased magnetometer.
fn attitude_error(field_bias: bool) -> f64 {
    const BIAS_T: [f32; 3] = [1.2e-6, -0.9e-6, 0.7e-6];
    let blocks = Blocks { inertia: true, torque: true, field_bias, ..Blocks::NONE };
    let (mut filters, mut world) = (Filters::new(&parameters(blocks)), World::new(5, RATE_DEG_S));
    let biased = |inputs: &mut DynamicInputs| {
        if let Some(pair) = &mut inputs.sensors.field {
            pair.body = pair.body + Vector::from_xyz(Vector3::from(BIAS_T));
        }
    };
    let (mut sum, mut count) = (0.0, 0.0);
    filters.fly(&mut world, 7200, biased, |second, world, _, dynamic| {
        if second >= 6000 {
            let error = world.error_deg(&dynamic.estimate.expect("there is one").r_bi);
            sum += error * error;
            count += 1.0;
        }
    });
    libm::sqrt(sum / count)
}

#[test]
fn a_magnetometer_that_shows_too_much_is_found_out_by_the_field_that_turns() {
    let (with, without) = (attitude_error(true), attitude_error(false));
    assert!(with < 0.6 * without, "{with} deg, without the states {without}");
}

#[test]
fn an_allowance_for_the_inertia_keeps_a_fast_tumble_without_its_states() {
    // The world's moments are 5 % off. At some deg/s that is a torque of 1e-5 N·m.
    let believed = |inertia_allowance: f32| {
        let parameters = DynamicParameters {
            inertia_allowance,
            ..parameters(Blocks { torque: true, ..Blocks::NONE })
        };
        let (mut filters, mut world) = (Filters::new(&parameters), World::new(7, [4.0, -3.0, 5.0]));
        let mut seconds = 0;
        filters.fly(
            &mut world,
            1200,
            |_| (),
            |second, _, _, dynamic| {
                let trusted = dynamic.estimate.is_some_and(|estimate| estimate.trusted);
                seconds += u32::from(second >= 300 && trusted);
            },
        );
        seconds
    };
    let (with, without) = (believed(0.05), believed(0.0));
    assert!(with > 850, "{with} s of 900");
    assert!(with > without, "{with} s, without {without}");
}
