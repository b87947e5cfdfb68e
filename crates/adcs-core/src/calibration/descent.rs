//! Gauss–Newton descent of a sum of squares, held back where a step would climb.
//!
//! x ← x − (JᵀJ + λ D²)⁻¹ Jᵀr, D² = diag(JᵀJ), λ = 0 unless a step was taken back (Levenberg 1944,
//! Marquardt 1963).

use nalgebra::{RealField, SMatrix, SVector};

use super::error::CalibrationError;
use super::number;
use super::symmetric::Spectrum;

/// Walks through the samples; from the data sheet it takes about ten.
pub const MAX_PASSES: u32 = 60;

/// λ of the first shortened step, as Marquardt (1963) begins.
const FIRST_DAMPING: f64 = 1e-2;
/// Growth when a step is taken back, decline when one is good (Marquardt 1963).
const DAMPING_FACTOR: f64 = 10.0;
/// λ that makes no difference to a step any more.
const LEAST_DAMPING: f64 = 1e-5;
/// The last step, relative to sensor and field. A step squares or at least divides the error by ten:
/// what remains is far below 1e-3 nT.
const CONVERGED: f64 = 1e-11;
/// The same where rounding is coarser, in roundings.
const CONVERGED_ROUNDINGS: f64 = 50.0;
/// How much E may seem to rise by the rounding of its sum, in roundings.
const COST_ROUNDINGS: f64 = 50.0;

/// Sums over all samples, at one x.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pass<T: RealField + Copy, const N: usize> {
    /// Σ r²
    pub cost: T,
    /// Jᵀr
    pub gradient: SVector<T, N>,
    /// JᵀJ
    pub normal: SMatrix<T, N, N>,
}

impl<T: RealField + Copy, const N: usize> Pass<T, N> {
    pub fn zero() -> Self {
        Self { cost: T::zero(), gradient: SVector::zeros(), normal: SMatrix::zeros() }
    }

    /// Adds a residual and its derivative.
    pub fn add(&mut self, residual: T, row: &SVector<T, N>) {
        self.cost += residual * residual;
        self.gradient += row * residual;
        self.normal += row * row.transpose();
    }
}

/// What is minimised, in units in which the unknowns are of order one.
pub(super) trait Problem<T: RealField + Copy, const N: usize> {
    /// Its sums at x.
    fn pass(&self, x: &SVector<T, N>) -> Pass<T, N>;

    /// What the cost is uncertain by, beside the rounding of its own size.
    fn cancellation(&self) -> T {
        T::zero()
    }
}

/// Where the descent ended.
#[derive(Debug, Clone, Copy)]
pub(super) struct Descent<T: RealField + Copy, const N: usize> {
    pub x: SVector<T, N>,
    /// At `x`.
    pub pass: Pass<T, N>,
    pub steps: u32,
    pub converged: bool,
}

pub(super) fn descend<T: RealField + Copy, const N: usize>(
    problem: &impl Problem<T, N>,
    start: SVector<T, N>,
) -> Result<Descent<T, N>, CalibrationError> {
    let rounding = T::default_epsilon();
    let small = number::<T>(CONVERGED).max(rounding * number(CONVERGED_ROUNDINGS));
    let slack = T::one() + rounding * number(COST_ROUNDINGS);
    let mut at = Descent { x: start, pass: problem.pass(&start), steps: 0, converged: false };
    if !at.pass.cost.is_finite() {
        return Err(CalibrationError::OutOfRange);
    }
    let mut damping = T::zero();
    for _ in 0..MAX_PASSES {
        let step = Spectrum::of(&at.pass.normal).step(&at.pass.gradient, damping);
        let x = at.x + step;
        let next = problem.pass(&x);
        // Of unknowns of order one. Neither comparison holds for a NaN.
        let last = step.amax() <= small;
        if next.cost <= at.pass.cost * slack + problem.cancellation() {
            at = Descent { x, pass: next, steps: at.steps + 1, converged: last };
            damping /= number(DAMPING_FACTOR);
            if damping < number(LEAST_DAMPING) {
                damping = T::zero();
            }
        } else {
            at.converged = last;
            damping = (damping * number(DAMPING_FACTOR)).max(number(FIRST_DAMPING));
        }
        if at.converged {
            break;
        }
    }
    Ok(at)
}
