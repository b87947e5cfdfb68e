//! The estimate while there is one: all states and their covariance, one step after the other.

use nalgebra::{Matrix3, Quaternion, RealField, Unit, Vector3, convert};

use super::block::{Block, Blocks, COUNT, TORQUE_UNIT_N_M};
use super::covariance::{Covariance, Row, Step};
use super::linear::{tensor_of, transition};
use super::parameters::DynamicParameters;
use super::plant::{Inertia, Motion, Plant, Surroundings, Torques};
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
        let torques =
            Torques { dipole: self.dipole + torquer_dipole, torque: self.torque * unit };
        let plant = Plant { inertia: &self.inertia, surroundings, torques: &torques };
        let phi = transition(&plant, &self.motion, mean_moment, self.blocks, dt_s);
        self.motion = plant.stepped(&self.motion, dt_s);
        self.covariance.propagate(&phi);
        self.add_noise(noise, dt_s);
        Some(())
    }

    fn add_noise(&mut self, noise: &ProcessNoise<T>, dt_s: T) {
        let ProcessNoise { bias, dipole, torque_sigma, correlation_s } = *noise;
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
            let density = share * share * convert(2.0) * correlation_s * variance * unit * unit;
            let inverse = self.inertia.inverse;
            p.add(Block::Rate, &(inverse * inverse.transpose() * (density * dt_s)));
        }
    }

    /// Holds one vector measurement against the estimate: its NIS, and whether it was at most `gate` and
    /// has been absorbed.
    pub(super) fn absorb<const M: usize>(&mut self, rows: &[Row<T>; M], gate: T) -> (T, bool) {
        let refused = (T::max_value().unwrap_or_else(T::one), false);
        let mut after = self.covariance;
        let mut step: Step<T> = [Vector3::zeros(); COUNT];
        let mut nis = T::zero();
        for row in rows {
            let Some(term) = after.absorb(row, &mut step) else { return refused };
            nis += term;
        }
        // NaN is refused as well.
        if !(nis <= gate) {
            return (nis, false);
        }
        self.covariance = after;
        self.correct(&step);
        (nis, true)
    }

    fn correct(&mut self, step: &Step<T>) {
        let [theta, rate, bias, dipole, moments, products, torque] = step;
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
    }

    /// Whether every number is finite and no variance negative.
    pub(super) fn is_sound(&self) -> bool {
        let finite = |v: &Vector3<T>| v.iter().all(|x| x.is_finite());
        let Self { motion, bias, dipole, moments, products, torque, .. } = self;
        [&motion.omega, bias, dipole, moments, products, torque].into_iter().all(finite)
            && motion.r_bi.hamilton().coords.iter().all(|x| x.is_finite())
            && self.covariance.is_sound()
    }
}
