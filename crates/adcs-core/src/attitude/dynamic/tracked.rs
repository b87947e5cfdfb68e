//! The estimate while there is one: all states and their covariance, one step after the other.

use nalgebra::{ComplexField, Matrix3, Quaternion, RealField, Unit, Vector3, convert};

use super::block::{Block, Blocks, COUNT, TORQUE_UNIT_N_M};
use super::covariance::{Covariance, Row, Step};
use super::linear::{tensor_of, transition};
use super::parameters::DynamicParameters;
use super::plant::{Inertia, Motion, Plant, Surroundings, Torques};
use crate::attitude::mekf::Innovation;
use crate::frames::Rotation;

/// Everything the filter knows.
#[derive(Debug, Clone, Copy)]
pub(super) struct Tracked<T: RealField + Copy> {
    pub(super) motion: Motion<T>,
    /// Gyro bias, Body, rad/s.
    pub(super) bias: Vector3<T>,
    /// Residual dipole, Body, A·m².
    pub(super) dipole: Vector3<T>,
    /// Moments of inertia beyond the given ones, in units of the mean moment.
    pub(super) moments: Vector3<T>,
    /// Products of inertia beyond the given ones, in units of the mean moment.
    pub(super) products: Vector3<T>,
    /// Torque of unknown cause, Body, in [`TORQUE_UNIT_N_M`].
    pub(super) torque: Vector3<T>,
    /// What the residual dipole changes by in the shadow, soon and late, Body, A·m².
    pub(super) shadow_dipole: [Vector3<T>; 2],
    /// Magnetometer's bias, Body, in [`FIELD_UNIT_T`].
    pub(super) field_bias: Vector3<T>,
    /// How much of each is there now, 0 to 1.
    pub(super) shadow: [T; 2],
    pub(super) inertia: Inertia<T>,
    pub(super) covariance: Covariance<T>,
    pub(super) blocks: Blocks,
}

/// What a step adds to the covariance; each axis alike.
#[derive(Debug, Clone, Copy)]
pub(super) struct ProcessNoise<T> {
    /// Gyro bias, rad²/s³.
    pub(super) bias: T,
    /// Residual dipole, (A·m²)²/s.
    pub(super) dipole: T,
    /// σ of the torque of unknown cause, [`TORQUE_UNIT_N_M`].
    pub(super) torque_sigma: T,
    /// Its correlation time, s.
    pub(super) correlation_s: T,
    /// White torque, (N·m)² s.
    pub(super) white_torque: T,
    /// (ε J)² of the inertia's error, (kg·m²)².
    pub(super) inertia_error: T,
}

/// Share of the white noise that would do the same over long times as a correlated torque; the filter
/// without torque states is then neither too sure nor slow (independent study, docs/filters).
const WHITE_SHARE: f64 = 0.6;

impl<T: RealField + Copy> Tracked<T> {
    /// `dt_s` later. `None` when the inertia has become that of no body.
    pub(super) fn propagate(
        &mut self,
        parameters: &DynamicParameters<T>,
        surroundings: &Surroundings<T>,
        torquer_dipole: Vector3<T>,
        noise: &ProcessNoise<T>,
        dt_s: T,
    ) -> Option<()> {
        let unit: T = convert(TORQUE_UNIT_N_M);
        let mean_moment = parameters.mean_moment();
        if self.blocks.inertia {
            let more = tensor_of(&self.moments, &self.products, mean_moment);
            self.inertia = Inertia::new(parameters.inertia() + more)?;
        }
        let torques = Torques {
            dipole: self.residual_dipole() + torquer_dipole,
            shadow: self.shadow,
            torque: self.torque * unit,
        };
        let plant = Plant { inertia: &self.inertia, surroundings, torques: &torques };
        let after = plant.stepped(&self.motion, dt_s);
        let midway = self.motion.midway(&after);
        let phi = transition(&plant, &midway, mean_moment, self.blocks, dt_s);
        self.motion = after;
        self.covariance.propagate(&phi);
        self.add_noise(noise, dt_s);
        Some(())
    }

    fn add_noise(&mut self, noise: &ProcessNoise<T>, dt_s: T) {
        let ProcessNoise { bias, dipole, torque_sigma, correlation_s, .. } = *noise;
        let speed = self.motion.omega.norm();
        let mut white = noise.white_torque + noise.inertia_error * speed * speed * speed;
        let p = &mut self.covariance;
        p.add(Block::Bias, &Matrix3::from_diagonal_element(bias * dt_s));
        p.add(Block::Dipole, &Matrix3::from_diagonal_element(dipole * dt_s));
        let variance = torque_sigma * torque_sigma;
        if self.blocks.torque {
            // exp(−h/τ), to second order: h is a thousandth of τ.
            let x = dt_s / correlation_s;
            let half: T = convert(0.5);
            let decay = T::one() - x * (T::one() - x * half);
            self.torque *= decay;
            p.scale(Block::Torque, decay);
            let more = variance * (T::one() - decay * decay);
            p.add(Block::Torque, &Matrix3::from_diagonal_element(more));
        } else {
            let unit: T = convert(TORQUE_UNIT_N_M);
            let share: T = convert(WHITE_SHARE);
            white += share * share * convert(2.0) * correlation_s * variance * unit * unit;
        }
        if white > T::zero() {
            let inverse = self.inertia.inverse;
            p.add(Block::Rate, &(inverse * inverse.transpose() * (white * dt_s)));
        }
    }

    /// Holds one vector measurement against the estimate, and absorbs it when its NIS is at most `gate`.
    pub(super) fn absorb<const M: usize>(&mut self, rows: &[Row<T>; M], gate: T) -> Innovation<T> {
        let refused = Innovation { nis: T::max_value().unwrap_or_else(T::one), accepted: false };
        let mut after = self.covariance;
        let mut step: Step<T> = [Vector3::zeros(); COUNT];
        let mut nis = T::zero();
        for row in rows {
            let Some(term) = after.absorb(row, &mut step) else { return refused };
            nis += term;
        }
        if !nis.is_finite() {
            return refused;
        }
        if nis > gate {
            return Innovation { nis, accepted: false };
        }
        self.covariance = after;
        self.correct(&step);
        Innovation { nis, accepted: true }
    }

    /// The residual dipole as it is now, Body, A·m².
    pub(super) fn residual_dipole(&self) -> Vector3<T> {
        let ([s_1, s_2], [now, late]) = (&self.shadow_dipole, self.shadow);
        self.dipole + s_1 * now + s_2 * late
    }

    /// Variance of each axis of [`Self::residual_dipole`], (A·m²)².
    pub(super) fn residual_dipole_variance(&self) -> Vector3<T> {
        let [soon, late] = self.shadow;
        let parts =
            [(Block::Dipole, T::one()), (Block::ShadowSoon, soon), (Block::ShadowLate, late)];
        let mut sum = Vector3::zeros();
        for (row, of_row) in parts {
            for (column, of_column) in parts {
                sum += self.covariance.block(row, column).diagonal() * (of_row * of_column);
            }
        }
        sum
    }

    fn correct(&mut self, step: &Step<T>) {
        let [theta, rate, bias, dipole, moments, products, torque, soon, late, field_bias] = step;
        let e = theta * convert::<f64, T>(-0.5);
        let turned =
            Quaternion::new(T::one(), e.x, e.y, e.z) * self.motion.r_bi.hamilton().into_inner();
        self.motion.r_bi = Rotation::from_hamilton(Unit::new_normalize(turned));
        self.motion.omega += rate;
        self.bias += bias;
        self.dipole += dipole;
        self.moments += moments;
        self.products += products;
        self.torque += torque;
        for (part, step) in self.shadow_dipole.iter_mut().zip([soon, late]) {
            *part += step;
        }
        self.field_bias += field_bias;
    }

    /// Whether every number is finite and no variance negative.
    pub(super) fn is_sound(&self) -> bool {
        let finite = |v: &Vector3<T>| v.iter().all(ComplexField::is_finite);
        let Self { motion, bias, dipole, moments, products, torque, .. } = self;
        let states = [&motion.omega, bias, dipole, moments, products, torque];
        states.into_iter().chain(&self.shadow_dipole).chain([&self.field_bias]).all(finite)
            && motion.r_bi.hamilton().coords.iter().all(ComplexField::is_finite)
            && self.covariance.is_sound()
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use nalgebra::UnitQuaternion;

    /// An estimate at rest, as well known as one that has just been taken over.
    pub(in crate::attitude::dynamic) fn tracked(blocks: Blocks) -> Tracked<f64> {
        let parameters = DynamicParameters::<f64>::default();
        let mut covariance = Covariance::zeros(blocks);
        let mut put = |block: Block, sigma: f64| {
            covariance.set(block, block, &Matrix3::from_diagonal_element(sigma * sigma));
        };
        put(Block::Attitude, 0.02);
        put(Block::Rate, 3e-3);
        put(Block::Bias, 1e-3);
        put(Block::Dipole, 0.5);
        if blocks.inertia {
            put(Block::Moments, 0.08);
            put(Block::Products, 0.05);
        }
        if blocks.torque {
            put(Block::Torque, 0.08);
        }
        if blocks.shadow {
            put(Block::ShadowSoon, 0.004);
            put(Block::ShadowLate, 0.004);
        }
        if blocks.field_bias {
            put(Block::FieldBias, 0.6);
        }
        Tracked {
            motion: Motion { r_bi: Rotation::identity(), omega: Vector3::zeros() },
            bias: Vector3::zeros(),
            dipole: Vector3::zeros(),
            moments: Vector3::zeros(),
            products: Vector3::zeros(),
            torque: Vector3::zeros(),
            shadow_dipole: [Vector3::zeros(); 2],
            field_bias: Vector3::zeros(),
            shadow: [0.0; 2],
            inertia: Inertia::new(parameters.inertia()).unwrap(),
            covariance,
            blocks,
        }
    }

    const ALL: Blocks = Blocks { inertia: true, torque: true, ..Blocks::NONE };
    const NOISE: ProcessNoise<f64> = ProcessNoise {
        bias: 3e-12,
        dipole: 1e-10,
        torque_sigma: 0.08,
        correlation_s: 300.0,
        white_torque: 0.0,
        inertia_error: 0.0,
    };

    fn field() -> Surroundings<f64> {
        Surroundings { field: Vector3::new(2e-5, -1e-5, 3e-5), up: Vector3::x(), gradient: 3.4e-6 }
    }

    fn propagated(
        mut tracked: Tracked<f64>,
        noise: &ProcessNoise<f64>,
        steps: u32,
    ) -> Tracked<f64> {
        for _ in 0..steps {
            tracked
                .propagate(&DynamicParameters::default(), &field(), Vector3::zeros(), noise, 0.5)
                .unwrap();
        }
        tracked
    }

    /// An attitude that is seen by three axes.
    fn rows(innovation: Vector3<f64>) -> [Row<f64>; 3] {
        [Vector3::x(), Vector3::y(), Vector3::z()]
            .map(|axis| Row::new([(Block::Attitude, axis)], innovation.dot(&axis), 1e-4))
    }

    #[test]
    fn a_measurement_moves_every_state_that_goes_with_it() {
        let mut tracked = propagated(tracked(ALL), &NOISE, 20);
        let before = tracked;
        let Innovation { nis, accepted } =
            tracked.absorb(&rows(Vector3::new(0.02, -0.01, 0.015)), 25.9);
        assert!(accepted && nis > 0.0);
        // After ten seconds the attitude goes with rate, dipole and torque; with the bias not: the
        // gyro has not spoken.
        assert!((tracked.motion.omega - before.motion.omega).norm() > 1e-4);
        assert!((tracked.dipole - before.dipole).norm() > 1e-3);
        assert!((tracked.torque - before.torque).norm() > 1e-5);
        assert_eq!(tracked.bias, before.bias);
        // θ is moved into the attitude: A = (I − [θ×]) Â.
        let turn = tracked.motion.r_bi.hamilton() * before.motion.r_bi.inverse().hamilton();
        let towards = -turn.scaled_axis().dot(&Vector3::new(0.02, -0.01, 0.015));
        assert!(towards > 0.0);
    }

    #[test]
    fn a_measurement_above_its_gate_changes_nothing() {
        let mut tracked = propagated(tracked(ALL), &NOISE, 20);
        let before = tracked;
        for wild in [Vector3::repeat(3.0), Vector3::repeat(1e200), Vector3::repeat(f64::NAN)] {
            let Innovation { nis, accepted } = tracked.absorb(&rows(wild), 25.9);
            assert!(!accepted && nis > 25.9 && nis.is_finite());
            assert_eq!(tracked.motion.omega, before.motion.omega);
            assert_eq!(tracked.motion.r_bi.hamilton(), before.motion.r_bi.hamilton());
            for block in Block::ALL {
                let of = |it: &Tracked<f64>| it.covariance.block(block, Block::Attitude);
                assert_eq!(of(&tracked), of(&before));
            }
        }
    }

    #[test]
    fn the_torques_variance_stays_that_of_the_process() {
        // Φ² σ² + σ² (1 − Φ²): nothing is learned, so nothing changes, however long.
        let after = propagated(tracked(ALL), &NOISE, 2000);
        let variance = after.covariance.variance(Block::Torque);
        assert!((variance - Vector3::repeat(0.08 * 0.08)).norm() < 1e-15);
        // exp(−h/τ), whose third order is 1e-9 a step.
        let mut strong = tracked(ALL);
        strong.torque = Vector3::x();
        let after = propagated(strong, &NOISE, 600);
        assert!((after.torque.x - libm::exp(-1.0)).abs() < 1e-6);
    }

    #[test]
    fn without_torque_states_the_rate_takes_its_noise() {
        // A satellite at rest without dipole: 0.6² 2 τ σ² J⁻² t on the rate.
        let only = Blocks::NONE;
        let mut sure = tracked(only);
        sure.covariance = Covariance::zeros(ALL);
        let noise = ProcessNoise { bias: 0.0, dipole: 0.0, ..NOISE };
        let after = propagated(sure, &noise, 1);
        let inverse = after.inertia.inverse;
        let density = 0.36 * 2.0 * 300.0 * (0.08e-6 * 0.08e-6);
        let expected = inverse * inverse.transpose() * (density * 0.5);
        let found = after.covariance.block(Block::Rate, Block::Rate);
        assert!((found - expected).norm() < 1e-12 * expected.norm());
    }

    #[test]
    fn blocks_that_do_not_fly_have_no_variance_and_never_move() {
        for (inertia, torque) in [(false, false), (true, false), (false, true), (true, true)] {
            let mut it = tracked(Blocks { inertia, torque, ..Blocks::NONE });
            it.motion.omega = Vector3::new(0.06, 0.03, -0.14);
            for cycle in 0..100 {
                it = propagated(it, &NOISE, 2);
                let innovation = Vector3::new(1e-3, -2e-3, 1e-3) * libm::sin(f64::from(cycle));
                assert!(it.absorb(&rows(innovation), 25.9).accepted, "{cycle}");
            }
            for (block, flies, state) in [
                (Block::Moments, inertia, it.moments),
                (Block::Products, inertia, it.products),
                (Block::Torque, torque, it.torque),
            ] {
                let mixed = Block::ALL.map(|other| it.covariance.block(block, other).norm());
                assert_eq!(mixed.iter().any(|norm| *norm > 0.0), flies, "{block:?}");
                assert_eq!(state != Vector3::zeros(), flies, "{block:?}");
            }
            assert!(it.is_sound());
        }
    }

    #[test]
    fn estimated_parameters_of_inertia_turn_the_body() {
        let mut heavier = tracked(ALL);
        heavier.moments = Vector3::new(0.1, 0.0, 0.0);
        heavier.products = Vector3::new(0.0, 0.02, 0.0);
        let after = propagated(heavier, &NOISE, 1);
        let given = DynamicParameters::<f64>::default();
        let more = after.inertia.tensor - given.inertia();
        let mean = given.mean_moment();
        assert!((more[(0, 0)] - 0.1 * mean).abs() < 1e-15);
        assert!((more[(0, 2)] - 0.02 * mean).abs() < 1e-15);
        // The inertia of no body.
        let mut none = tracked(ALL);
        none.moments = Vector3::new(-2.0, 0.0, 0.0);
        let gone =
            none.propagate(&DynamicParameters::default(), &field(), Vector3::zeros(), &NOISE, 0.5);
        assert!(gone.is_none());
    }

    #[test]
    fn a_number_that_is_none_is_seen() {
        assert!(tracked(ALL).is_sound());
        for bad in [f64::NAN, f64::INFINITY] {
            let changes: [fn(&mut Tracked<f64>, f64); 4] = [
                |it, bad| it.motion.omega.y = bad,
                |it, bad| it.bias.x = bad,
                |it, bad| it.products.z = bad,
                |it, bad| {
                    let q = Quaternion::new(bad, 0.0, 0.0, 0.0);
                    it.motion.r_bi = Rotation::from_hamilton(UnitQuaternion::new_unchecked(q));
                },
            ];
            for change in changes {
                let mut it = tracked(ALL);
                change(&mut it, bad);
                assert!(!it.is_sound());
            }
        }
    }
}
