//! One step of the Riccati equation, backwards in time.
//!
//! With x⁺ = Φ x + Γ m + Γ_d d and the cost (|x|² + |m|²) Δ + x⁺ᵀ P x⁺ + 2 x⁺ᵀ W d of a step,
//!
//! ```text
//! L  = (Δ I + Γᵀ P Γ)⁻¹ Γᵀ P Φ
//! F  = Φ − Γ L
//! P⁻ = Δ I + Φᵀ P F
//! W⁻ = Fᵀ (P Γ_d + W)
//! ```
//!
//! The matrix that is inverted is the identity and something positive: there is always an inverse, at
//! any field and any step. P is made symmetric after each step.
//!
//! Source: Anderson & Moore (1990), §2.4; for W the costate of a known disturbance, §4.3.

use nalgebra::{ComplexField, Matrix3, RealField, SMatrix, convert};

use super::model::Step;
use crate::rolled::{product, transposed_product};

/// Where a sweep begins, the cost of being off at its end beside that of a second: large enough not to
/// matter two orbits later, small enough for f32.
const TERMINAL: f64 = 100.0;

/// The cost to go at one instant.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cost<T> {
    p: SMatrix<T, 6, 6>,
    w: SMatrix<T, 6, 3>,
}

/// What the cycle needs of the cost to go at one instant: its slope against the rate, in units of the
/// weights; d in N·m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gains<T = f32> {
    /// P₂₁: for each unit of attitude error.
    pub attitude: Matrix3<T>,
    /// P₂₂: for each unit of rate.
    pub rate: Matrix3<T>,
    /// W₂: for each N·m of known torque.
    pub torque: Matrix3<T>,
}

impl<T: RealField + Copy> Gains<T> {
    /// None at all.
    pub(super) fn zero() -> Self {
        Self { attitude: Matrix3::zeros(), rate: Matrix3::zeros(), torque: Matrix3::zeros() }
    }

    /// `share` of the way to `other`.
    pub(super) fn towards(&self, other: &Self, share: T) -> Self {
        let between = |a: &Matrix3<T>, b: &Matrix3<T>| a + (b - a) * share;
        Self {
            attitude: between(&self.attitude, &other.attitude),
            rate: between(&self.rate, &other.rate),
            torque: between(&self.torque, &other.torque),
        }
    }
}

impl<T: RealField + Copy> Cost<T> {
    /// At the end of the horizon.
    pub(super) fn terminal() -> Self {
        let p = SMatrix::from_diagonal_element(convert(TERMINAL));
        Self { p, w: SMatrix::zeros() }
    }

    /// One step of `dt_s` earlier; `None` when a number is not finite.
    pub(super) fn before(&self, step: &Step<T>, dt_s: T) -> Option<Self> {
        let Step { phi, gamma, gamma_d } = step;
        let p_gamma = product(&self.p, gamma);
        let effort = Matrix3::from_diagonal_element(dt_s) + transposed_product(gamma, &p_gamma);
        let l = effort.try_inverse()? * transposed_product(&p_gamma, phi);
        let closed = phi - product(gamma, &l);
        let p = transposed_product(phi, &product(&self.p, &closed))
            + SMatrix::from_diagonal_element(dt_s);
        let p = (p + p.transpose()) * convert::<f64, T>(0.5);
        let w = transposed_product(&closed, &(product(&self.p, gamma_d) + self.w));
        let finite = p.iter().chain(&w).all(ComplexField::is_finite);
        finite.then_some(Self { p, w })
    }

    pub(super) fn gains(&self) -> Gains<T> {
        Gains {
            attitude: self.p.fixed_view::<3, 3>(3, 0).into_owned(),
            rate: self.p.fixed_view::<3, 3>(3, 3).into_owned(),
            torque: self.w.fixed_view::<3, 3>(3, 0).into_owned(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::model::tests::{model, polar};
    use super::*;
    use crate::frames::Vector;
    use nalgebra::{SVector, Vector3};

    const STEP_S: f64 = 120.0;

    fn step(k: i32) -> Step<f64> {
        let t = f64::from(k) * STEP_S;
        model().step(&polar(t), &polar(t + STEP_S), STEP_S)
    }

    /// The cost to go at each step of a horizon of 90.
    fn costs() -> [Cost<f64>; 91] {
        let mut costs = [Cost::terminal(); 91];
        for k in (0..90).rev() {
            costs[k] = costs[k + 1].before(&step(k as i32), STEP_S).unwrap();
        }
        costs
    }

    /// What a flight of the horizon costs with the optimal dipole, plus `more` of it in step 10.
    fn spent(
        costs: &[Cost<f64>],
        start: SVector<f64, 6>,
        d: Vector3<f64>,
        more: Vector3<f64>,
    ) -> f64 {
        let (mut x, mut sum) = (start, 0.0);
        for k in 0..90 {
            let Step { phi, gamma, gamma_d } = step(k as i32);
            let next = &costs[k + 1];
            let effort = Matrix3::from_diagonal_element(STEP_S) + gamma.tr_mul(&(next.p * gamma));
            let slope = gamma.tr_mul(&(next.p * (phi * x + gamma_d * d) + next.w * d));
            let m = -effort.try_inverse().unwrap() * slope
                + if k == 10 { more } else { Vector3::zeros() };
            sum += (x.norm_squared() + m.norm_squared()) * STEP_S;
            x = phi * x + gamma * m + gamma_d * d;
        }
        sum + TERMINAL * x.norm_squared()
    }

    #[test]
    fn the_swept_cost_is_what_the_flight_costs_and_any_other_dipole_costs_more() {
        let costs = costs();
        let start = SVector::<f64, 6>::from([2.0, -1.0, 0.5, 1.0, 0.3, -2.0]);
        let least = spent(&costs, start, Vector3::zeros(), Vector3::zeros());
        let promised = start.dot(&(costs[0].p * start));
        assert!((least / promised - 1.0).abs() < 1e-9, "{least} {promised}");
        let d = Vector3::new(2e-8, -1e-8, 3e-8);
        for torque in [Vector3::zeros(), d] {
            let least = spent(&costs, start, torque, Vector3::zeros());
            for axis in [Vector3::x(), Vector3::y(), Vector3::z()] {
                for more in [0.3, -0.3] {
                    assert!(spent(&costs, start, torque, axis * more) > least);
                }
            }
        }
    }

    #[test]
    fn the_end_of_the_horizon_is_forgotten() {
        // One and three quarters of an orbit before the end, another terminal cost makes no difference.
        let other = Cost { p: SMatrix::from_diagonal_element(10.0 * TERMINAL), ..Cost::terminal() };
        let back =
            |end: Cost<f64>| (0..90).rev().fold(end, |c, k| c.before(&step(k), STEP_S).unwrap());
        let (a, b) = (back(Cost::terminal()), back(other));
        assert!((a.p - b.p).norm() < 1e-2 * a.p.norm());
        assert!((a.gains().rate - b.gains().rate).norm() < 1e-2 * a.gains().rate.norm());
    }

    #[test]
    fn without_a_field_the_cost_grows_and_stays_finite() {
        let still = super::super::Ahead { field: Vector::zero(), omega_t: Vector::zero() };
        let step = model().step(&still, &still, STEP_S);
        let end = (0..90).try_fold(Cost::terminal(), |cost, _| cost.before(&step, STEP_S)).unwrap();
        assert!(end.gains().rate.norm() > 1e3);
    }

    #[test]
    fn numbers_that_are_none_end_the_sweep() {
        let mut bad = step(0);
        bad.gamma[(4, 1)] = f64::NAN;
        assert!(Cost::terminal().before(&bad, STEP_S).is_none());
        bad = step(0);
        bad.phi[(0, 3)] = f64::INFINITY;
        assert!(Cost::terminal().before(&bad, STEP_S).is_none());
    }
}
