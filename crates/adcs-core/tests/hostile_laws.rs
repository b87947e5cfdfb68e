//! Whatever comes in, the dipole is finite and within the torquers' limits: a million inputs, half of
//! them made of the worst numbers there are.

use adcs_core::attitude::mekf::MekfParameters;
use adcs_core::control::allocation::{Allocation, Command, Saturation, TorquerParameters};
use adcs_core::control::b_dot::{BDot, BDotGain};
use adcs_core::control::bang_bang::{BangBang, BangBangParameters};
use adcs_core::control::cross_product::{
    CrossProduct, CrossProductParameters, Gravity, PointingError, dipole,
};
use adcs_core::control::feed_forward::{self, FeedForward};
use adcs_core::control::guidance::Goal;
use adcs_core::control::hold;
use adcs_core::control::periodic::{Ahead, Motion, PeriodicLaw, PeriodicParameters, Plan};
use adcs_core::frames::{Body, Rotation, Vector};
use adcs_core::schedule::Round;
use adcs_core::time::Utc;
use rand_core::Rng;
use rand_pcg::Pcg32;

const INPUTS: u32 = 1_000_000;
const LIMIT_AM2: f32 = 0.6;

const WORST: [f32; 12] = [
    f32::NAN,
    f32::INFINITY,
    f32::NEG_INFINITY,
    f32::MAX,
    f32::MIN,
    f32::MIN_POSITIVE,
    1e-45,
    0.0,
    -0.0,
    1.0,
    1e-6,
    1e19,
];

struct Hostile(Pcg32);

impl Hostile {
    /// Any bits, one of the worst, or what a sensor might say.
    fn number(&mut self, scale: f32) -> f32 {
        let bits = self.0.next_u32();
        match bits % 4 {
            0 => f32::from_bits(self.0.next_u32()),
            1 => WORST[(bits / 4) as usize % WORST.len()],
            _ => (self.0.next_u32() as f32 / u32::MAX as f32 - 0.5) * 2.0 * scale,
        }
    }

    fn vector(&mut self, scale: f32) -> Vector<Body> {
        Vector::new(self.number(scale), self.number(scale), self.number(scale))
    }

    /// As sensors give it: finite, of the right size.
    fn tame(&mut self, scale: f32) -> Vector<Body> {
        let mut one = || (self.0.next_u32() as f32 / u32::MAX as f32 - 0.5) * 2.0 * scale;
        Vector::new(one(), one(), one())
    }
}

fn assert_within(command: &Command, input: &dyn core::fmt::Debug) {
    // False for a NaN.
    let within = command.dipole.xyz.iter().all(|m| m.abs() <= LIMIT_AM2);
    assert!(within, "{command:?} from {input:?}");
}

#[test]
fn a_million_hostile_inputs_give_finite_dipoles_within_the_limits() {
    let alignment_xyzw = [0.1, -0.2, 0.3, 0.9];
    let torquers = TorquerParameters { max_dipole_am2: LIMIT_AM2, alignment_xyzw };
    let allocation = Allocation::new(&torquers).unwrap();
    let plain = BDot::new(BDotGain::Plain { gain_am2_s_per_t: 1e5 }).unwrap();
    let normalised = BDot::new(BDotGain::Normalised { gain_n_m_s: 1e-4 }).unwrap();
    let bang_bang = BangBang::new(&BangBangParameters {
        dipole_am2: LIMIT_AM2,
        dead_band_sigmas: 3.0,
        rate_noise_rad_s: MekfParameters::<f32>::default().gyro_noise_rad_s,
        field_noise_t: 5.86e-7,
    })
    .unwrap();
    let pointing = CrossProduct::new(&CrossProductParameters {
        stiffness_n_m_per_rad: 2e-7,
        damping_n_m_s: 3e-4,
        inertia_kg_m2: [[0.05, 0.0, 0.0], [0.0, 0.055, 0.0], [0.0, 0.0, 0.06]],
        gyroscopic: true,
        gravity_gradient: true,
    })
    .unwrap();
    let forward = FeedForward::new(0.01).unwrap();
    let round = Round { on_s: 5.0, off_s: 2.5 };

    let mut hostile = Hostile(Pcg32::new(20_151_119, 0));
    let (mut acted, mut silent) = (0_u32, 0_u32);
    for count in 0..INPUTS {
        // Every second input has one sane half, so that the laws get as far as they can.
        let omega = if count % 4 < 2 { hostile.vector(0.2) } else { hostile.tame(0.2) };
        let field = match count % 8 {
            0 | 2 => omega * 3e-4,
            odd if odd % 2 == 1 => hostile.tame(5e-5),
            _ => hostile.vector(5e-5),
        };
        let residual = hostile.vector(0.4);
        let fed = forward.dipole(residual, hostile.vector(0.01), &round);
        let fed = fed.unwrap_or(Vector::zero());
        let axes = allocation.to_torquers(omega);
        let by_sign = bang_bang.dipole(axes, allocation.to_torquers(field));
        let q =
            [hostile.number(1.0), hostile.number(1.0), hostile.number(1.0), hostile.number(1.0)];
        let r_bi = Rotation::from_attitude_quaternion(q).unwrap_or(Rotation::identity());
        let omega_ti = Vector::from_xyz(hostile.vector(1e-3).xyz);
        let goal = Goal { r_ti: Rotation::identity(), omega_ti };
        let ripple = feed_forward::ripple(residual, field, pointing.inertia_kg_m2(), &round);
        let error = PointingError::new(r_bi, omega - ripple, &goal);
        let gravity = Gravity { up: hostile.vector(1.0), gradient: hostile.number(3.5e-6) };
        let torque = pointing.desired_torque(&error, omega, Some(&gravity));
        for (wanted, saturation) in [
            (plain.dipole(omega, field), Saturation::ClipAxes),
            (normalised.dipole(omega, field), Saturation::ClipAxes),
            (by_sign.map(|m| allocation.to_body(m)), Saturation::ClipAxes),
            (dipole(torque, field), Saturation::ScaleAll),
            (Some(torque), Saturation::ScaleAll),
        ] {
            let Some(wanted) = wanted else {
                silent += 1;
                continue;
            };
            acted += 1;
            let input = (omega, field, torque, fed, wanted);
            assert_within(&allocation.command(wanted), &input);
            let command = allocation.command_beside(fed, wanted, saturation);
            assert_within(&command, &input);
            let useful_s = hold::useful_s(allocation.to_body(command.dipole), omega, field);
            assert!(useful_s >= 0.0, "{useful_s} from {input:?}");
        }
    }
    // Both ways out are taken many times: the test is no test of one branch.
    assert!(acted > INPUTS && silent > INPUTS / 10, "{acted} {silent}");
}

#[test]
fn a_million_hostile_inputs_to_the_law_that_plans_give_finite_dipoles_within_the_limits() {
    let alignment_xyzw = [0.1, -0.2, 0.3, 0.9];
    let torquers = TorquerParameters { max_dipole_am2: LIMIT_AM2, alignment_xyzw };
    let allocation = Allocation::new(&torquers).unwrap();
    let law = PeriodicLaw::new(&PeriodicParameters::default()).unwrap();
    let at = |count: u32| Utc::from_micros_since_2000(i64::from(count) * 500_000);
    let mut hostile = Hostile(Pcg32::new(20_151_120, 0));
    let mut plan = Plan::default();
    let (mut acted, mut planned, mut silent) = (0_u32, 0_u32, 0_u32);
    for count in 0..INPUTS {
        // Sweeps that may end at any slice, and some stretches in which they can be completed.
        let sane = count % 2000 < 1000;
        plan.work(&law, at(count), |_| {
            let (field, omega) = match sane {
                true => (hostile.tame(5e-5), hostile.tame(1e-3)),
                false => (hostile.vector(5e-5), hostile.vector(1e-3)),
            };
            Some(Ahead { field: field.relabel(), omega_t: omega.relabel() })
        });
        if count % 5000 == 4999 {
            plan.forget();
        }
        let Some(gains) = plan.gains(at(count)) else {
            silent += 1;
            continue;
        };
        planned += 1;
        let motion = Motion {
            attitude: hostile.vector(2.0).relabel(),
            rate: hostile.vector(0.2).relabel(),
            torque: hostile.vector(1e-6).relabel(),
        };
        let (field, round_s) = (hostile.vector(5e-5).relabel(), 7.5);
        let Some(wanted) = law.dipole(&gains, &motion, field, round_s) else { continue };
        acted += 1;
        let (wanted, fed) = (wanted.relabel(), hostile.vector(0.4));
        for saturation in [Saturation::ClipAxes, Saturation::ScaleAll] {
            assert_within(&allocation.command_beside(fed, wanted, saturation), &(motion, wanted));
        }
    }
    assert!(acted > INPUTS / 20 && planned > acted && silent > 100, "{acted} {planned} {silent}");
}
