//! What passes and what stays, estimated together: a Kalman filter whose covariance is kept in three parts.
//!
//! | symbol | code | meaning |
//! |---|---|---|
//! | s | `state` | what moves: fields, rates |
//! | p | `unknown` | what is asked for: constants |
//! | P_ss, P_sp, P_pp | | their covariance |
//!
//! An equation that is made of readings (a field turned on by noisy gyros, a gyroscopic torque) shares its noise
//! with its neighbours, and least squares that take it for new in every row promise too much. Here each reading
//! is one measurement with a noise of its own, everything between readings is state, and P is honest.
//!
//! Source: Crassidis & Junkins, Optimal Estimation of Dynamic Systems, 2nd ed., §3.6 (the extended Kalman
//! filter), readings taken one number at a time.

use nalgebra::{ComplexField, Matrix3, RealField, SMatrix, SVector, Vector3};

use super::{IdentificationError, Solution, number, shown};
use crate::calibration::Spectrum;
use crate::rolled::{product, product_transposed, subtract_outer, transposed_product};

/// Readings, counted by numbers, for each unknown.
const PER_UNKNOWN: u32 = 3;
/// An unknown is found when no more than this is left of what its sigma was at first.
const MAX_LEFT_OF_PRIOR: f64 = 0.5;

/// Estimate of `S` states and `N` unknowns.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Joint<T: RealField + Copy, const S: usize, const N: usize> {
    pub state: SVector<T, S>,
    pub unknown: SVector<T, N>,
    state_covariance: SMatrix<T, S, S>,
    shared_covariance: SMatrix<T, S, N>,
    unknown_covariance: SMatrix<T, N, N>,
    prior_sigma: SVector<T, N>,
    /// Σ of squared innovations over their variances.
    squares: T,
    readings: u32,
}

impl<T: RealField + Copy, const S: usize, const N: usize> Joint<T, S, N> {
    /// Nothing known but how large the unknowns may be off.
    pub fn new(unknown: SVector<T, N>, prior_sigma: SVector<T, N>) -> Self {
        Self {
            state: SVector::zeros(),
            unknown,
            state_covariance: SMatrix::zeros(),
            shared_covariance: SMatrix::zeros(),
            unknown_covariance: SMatrix::from_diagonal(&prior_sigma.component_mul(&prior_sigma)),
            prior_sigma,
            squares: T::zero(),
            readings: 0,
        }
    }

    /// Three states, from `first` on.
    pub fn three(&self, first: usize) -> Vector3<T> {
        self.state.fixed_rows::<3>(first).into()
    }

    /// Puts three states, from `first` on.
    pub fn put(&mut self, first: usize, value: &Vector3<T>) {
        self.state.fixed_rows_mut::<3>(first).copy_from(value);
    }

    /// Begins three states, from `first` on, afresh.
    #[inline(never)]
    pub fn begin(&mut self, first: usize, value: &Vector3<T>, sigma: T) {
        self.put(first, value);
        self.state_covariance.fixed_rows_mut::<3>(first).fill(T::zero());
        self.state_covariance.fixed_columns_mut::<3>(first).fill(T::zero());
        self.shared_covariance.fixed_rows_mut::<3>(first).fill(T::zero());
        let own = Matrix3::from_diagonal_element(sigma * sigma);
        self.state_covariance.fixed_view_mut::<3, 3>(first, first).copy_from(&own);
    }

    /// Keeps the estimate, and of what led to it one part in `factor`².
    pub fn forget(&mut self, factor: T) {
        let square = factor * factor;
        self.state_covariance *= square;
        self.shared_covariance *= square;
        self.unknown_covariance *= square;
        // No unknown is less certain than at first.
        let prior_sigma = self.prior_sigma;
        for (axis, sigma) in SMatrix::<T, N, N>::identity().column_iter().zip(&prior_sigma) {
            let axis = axis.into_owned();
            self.read_one(&SVector::zeros(), &axis, axis.dot(&self.unknown), *sigma * *sigma);
        }
        (self.squares, self.readings) = (T::zero(), 0);
    }

    /// Carries the covariance over a step: δs' = F δs + L δp + noise.
    #[inline(never)]
    pub fn carry(
        &mut self,
        of_state: &SMatrix<T, S, S>,
        of_unknown: &SMatrix<T, S, N>,
        noise: &SMatrix<T, S, S>,
    ) {
        let states = product(of_state, &self.state_covariance)
            + product_transposed(of_unknown, &self.shared_covariance);
        let shared = product(of_state, &self.shared_covariance)
            + product(of_unknown, &self.unknown_covariance);
        let carried =
            product_transposed(&states, of_state) + product_transposed(&shared, of_unknown) + noise;
        // Rounding must not make it lopsided.
        self.state_covariance = (carried + carried.transpose()) * number::<T>(0.5);
        self.shared_covariance = shared;
    }

    /// Takes in a reading of three axes, of so many states and unknowns each.
    #[inline(never)]
    pub fn read(
        &mut self,
        of_state: &SMatrix<T, 3, S>,
        of_unknown: &SMatrix<T, 3, N>,
        reading: &Vector3<T>,
        variance: T,
    ) {
        let rows = of_state.row_iter().zip(of_unknown.row_iter());
        for ((of_state, of_unknown), value) in rows.zip(reading.iter()) {
            self.read_one(&of_state.transpose(), &of_unknown.transpose(), *value, variance);
        }
    }

    #[inline(never)]
    fn read_one(
        &mut self,
        of_state: &SVector<T, S>,
        of_unknown: &SVector<T, N>,
        reading: T,
        variance: T,
    ) {
        let states = product(&self.state_covariance, of_state)
            + product(&self.shared_covariance, of_unknown);
        let unknowns = transposed_product(&self.shared_covariance, of_state)
            + product(&self.unknown_covariance, of_unknown);
        let total = of_state.dot(&states) + of_unknown.dot(&unknowns) + variance;
        let innovation = reading - of_state.dot(&self.state) - of_unknown.dot(&self.unknown);
        let usable = total.is_finite() && total > T::zero() && innovation.is_finite();
        if !usable {
            return;
        }
        let part = T::one() / total;
        self.state += states * (innovation * part);
        self.unknown += unknowns * (innovation * part);
        subtract_outer(&mut self.state_covariance, &states, &states, part);
        subtract_outer(&mut self.shared_covariance, &states, &(unknowns * part), T::one());
        subtract_outer(&mut self.unknown_covariance, &unknowns, &unknowns, part);
        self.squares += innovation * innovation * part;
        self.readings = self.readings.saturating_add(1);
    }

    /// The unknowns. Their covariance is scaled by what the innovations show of the noise that was told;
    /// `noise` so scaled is the residual.
    #[inline(never)]
    pub fn solve(&self, noise: T) -> Result<Solution<T, N>, IdentificationError> {
        let (found, needed) = (self.readings, PER_UNKNOWN * N as u32);
        if found < needed {
            return Err(IdentificationError::TooFew { found, needed });
        }
        let scale = self.squares / number(f64::from(found));
        let spectrum = Spectrum::of(&self.unknown_covariance);
        let covariance = self.unknown_covariance * scale;
        let finite = self.unknown.iter().chain(covariance.iter()).all(ComplexField::is_finite);
        let variances = self.unknown_covariance.diagonal();
        let positive = variances.iter().all(|variance| *variance > T::zero());
        if !finite || !positive {
            return Err(IdentificationError::OutOfRange);
        }
        let left = variances.map(T::sqrt).component_div(&self.prior_sigma);
        let limit = number(MAX_LEFT_OF_PRIOR);
        if left.max() > limit {
            return Err(IdentificationError::NotLearnt {
                left: shown(left.max()),
                limit: shown(limit),
                weakest: left.imax() as u8,
            });
        }
        Ok(Solution {
            x: self.unknown,
            covariance,
            residual_rms: noise * scale.sqrt(),
            condition: spectrum.condition(),
            equations: found,
        })
    }
}
