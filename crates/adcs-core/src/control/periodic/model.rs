//! One step of the linear equations, in units in which every weight is one.
//!
//! x = (e/e₀, ω_e/ω₀), m in m₀, d in N·m. Over a step Δ, with the target's rate constant and the field
//! linear in time,
//!
//! ```text
//! x⁺  = Φ x + Γ m + Γ_d d
//! Φ   = [I, ∫ exp(X s) ds; 0, exp(X Δ)],   X = −[ω_t ×]
//! Γ   = ∫ Φ(Δ − s) (0, V(s)) ds            by Simpson's rule
//! ```

use nalgebra::{Matrix3, RealField, SMatrix, convert};

use crate::frames::{Target, Vector};

/// What is ahead at one instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ahead<T: RealField + Copy = f32> {
    /// Flux density in the target's axes, T.
    pub field: Vector<Target, T>,
    /// Rate of the target against Eci, in its own axes, rad/s.
    pub omega_t: Vector<Target, T>,
}

/// Units and inertia.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Model<T> {
    /// e₀, rad.
    pub(super) attitude: T,
    /// ω₀, rad/s.
    pub(super) rate: T,
    /// m₀, A·m².
    pub(super) dipole: T,
    /// J⁻¹, 1/(kg·m²).
    pub(super) inverse_inertia: Matrix3<T>,
}

/// How the state follows over one step.
#[derive(Debug, Clone, Copy)]
pub(super) struct Step<T> {
    pub(super) phi: SMatrix<T, 6, 6>,
    pub(super) gamma: SMatrix<T, 6, 3>,
    /// For 1 N·m.
    pub(super) gamma_d: SMatrix<T, 6, 3>,
}

impl<T: RealField + Copy> Model<T> {
    /// V m₀ / ω₀: what a dipole of m₀ along each axis does to the rate, ω₀ per second.
    pub(super) fn influence(&self, field: Vector<Target, T>) -> Matrix3<T> {
        self.inverse_inertia * field.xyz.cross_matrix() * (-self.dipole / self.rate)
    }

    /// The step of `dt_s` between two instants.
    pub(super) fn step(&self, from: &Ahead<T>, to: &Ahead<T>, dt_s: T) -> Step<T> {
        let half: T = convert(0.5);
        let [sixth, four]: [T; 2] = [convert(1.0 / 6.0), convert(4.0)];
        let omega = (from.omega_t.xyz + to.omega_t.xyz) * half;
        let whole = self.free(&omega.cross_matrix(), dt_s);
        let rest = self.free(&omega.cross_matrix(), dt_s * half);
        let [v_0, v_1] = [from, to].map(|ahead| self.influence(ahead.field));
        let v_m = (v_0 + v_1) * half;
        let torque = self.inverse_inertia / self.rate;
        let integral = |start: Matrix3<T>, middle: Matrix3<T>, end: Matrix3<T>| {
            let mut gamma = SMatrix::<T, 6, 3>::zeros();
            let weight = dt_s * sixth;
            let upper = (whole.0 * start + rest.0 * middle * four) * weight;
            let lower = (whole.1 * start + rest.1 * middle * four + end) * weight;
            gamma.fixed_view_mut::<3, 3>(0, 0).copy_from(&upper);
            gamma.fixed_view_mut::<3, 3>(3, 0).copy_from(&lower);
            gamma
        };
        let mut phi = SMatrix::<T, 6, 6>::identity();
        phi.fixed_view_mut::<3, 3>(0, 3).copy_from(&whole.0);
        phi.fixed_view_mut::<3, 3>(3, 3).copy_from(&whole.1);
        Step { phi, gamma: integral(v_0, v_m, v_1), gamma_d: integral(torque, torque, torque) }
    }

    /// What a rate does to the attitude, and to the rate, within `dt_s`: two blocks of Φ. To third order
    /// in the turn of the target, at most 0.26 rad in 240 s of a low orbit.
    fn free(&self, omega_cross: &Matrix3<T>, dt_s: T) -> (Matrix3<T>, Matrix3<T>) {
        let x = -omega_cross * dt_s;
        let (x2, one) = (x * x, Matrix3::identity());
        let x3 = x2 * x;
        let share = |n: f64| convert::<f64, T>(1.0 / n);
        let of_rate = one + x + x2 * share(2.0) + x3 * share(6.0);
        let of_attitude = one + x * share(2.0) + x2 * share(6.0) + x3 * share(24.0);
        (of_attitude * (dt_s * self.rate / self.attitude), of_rate)
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use nalgebra::{SVector, Vector3};

    /// SPROUT with the default weights.
    pub(in crate::control::periodic) fn model() -> Model<f64> {
        let inertia = Matrix3::new(
            0.05184, 0.00058, -0.00077, 0.00058, 0.05416, 0.00069, -0.00077, 0.00069, 0.05978,
        );
        let deg = core::f64::consts::PI / 180.0;
        Model {
            attitude: 5.0 * deg,
            rate: 0.05 * deg,
            dipole: 0.01,
            inverse_inertia: inertia.try_inverse().unwrap(),
        }
    }

    /// A dipole's field along a polar orbit of 97 minutes, in the Orbit frame: twice as strong along the
    /// vertical over the poles as along the track over the equator.
    pub(in crate::control::periodic) fn polar(t_s: f64) -> Ahead<f64> {
        let n = core::f64::consts::TAU / 5820.0;
        let (s, c) = libm::sincos(n * t_s);
        let side = 3e-6 * libm::sin(0.3 * n * t_s + 1.0);
        Ahead {
            field: Vector::new(2.3e-5 * c, side, 4.6e-5 * s),
            omega_t: Vector::new(0.0, -n, 0.0),
        }
    }

    /// The equations themselves, by small steps of Runge and Kutta, with the field linear in time.
    fn integrated(model: &Model<f64>, dt_s: f64, x: [Vector3<f64>; 2], m: Vector3<f64>) -> Step1 {
        let (from, to) = (polar(1000.0), polar(1000.0 + dt_s));
        let omega = (from.omega_t.xyz + to.omega_t.xyz) * 0.5;
        let slope = |t: f64, [e, w]: [Vector3<f64>; 2]| {
            let field = from.field.xyz + (to.field.xyz - from.field.xyz) * (t / dt_s);
            let push = model.influence(Vector::from_xyz(field)) * m;
            let _ = e;
            [w * (model.rate / model.attitude), push - omega.cross(&w)]
        };
        let (mut x, steps) = (x, 1000);
        let h = dt_s / f64::from(steps);
        for k in 0..steps {
            let t = f64::from(k) * h;
            let add = |a: [Vector3<f64>; 2], s: f64| [x[0] + a[0] * s, x[1] + a[1] * s];
            let k1 = slope(t, x);
            let k2 = slope(t + 0.5 * h, add(k1, 0.5 * h));
            let k3 = slope(t + 0.5 * h, add(k2, 0.5 * h));
            let k4 = slope(t + h, add(k3, h));
            let mean = |i: usize| (k1[i] + (k2[i] + k3[i]) * 2.0 + k4[i]) / 6.0;
            x = [x[0] + mean(0) * h, x[1] + mean(1) * h];
        }
        x
    }

    type Step1 = [Vector3<f64>; 2];

    #[test]
    fn a_step_is_what_the_equations_give() {
        // Fourth order of the turn in 240 s, 0.26⁴ / 24, for the free motion; Simpson's rule on a product
        // of two factors of first and second order is exact but for the same.
        const TOLERANCE: f64 = 3e-4;
        for dt_s in [60.0, 120.0, 240.0] {
            let step = model().step(&polar(1000.0), &polar(1000.0 + dt_s), dt_s);
            let cases = [
                ([Vector3::new(1.0, -2.0, 0.5), Vector3::zeros()], Vector3::zeros()),
                ([Vector3::zeros(), Vector3::new(0.3, 1.0, -0.8)], Vector3::zeros()),
                ([Vector3::zeros(); 2], Vector3::new(1.0, 0.5, -2.0)),
            ];
            for (x, m) in cases {
                let mut start = SVector::<f64, 6>::zeros();
                start.fixed_rows_mut::<3>(0).copy_from(&x[0]);
                start.fixed_rows_mut::<3>(3).copy_from(&x[1]);
                let found = step.phi * start + step.gamma * m;
                let [e, w] = integrated(&model(), dt_s, x, m);
                let mut expected = SVector::<f64, 6>::zeros();
                expected.fixed_rows_mut::<3>(0).copy_from(&e);
                expected.fixed_rows_mut::<3>(3).copy_from(&w);
                let off = (found - expected).norm();
                assert!(off < TOLERANCE * expected.norm(), "{dt_s} {off}");
            }
        }
    }

    #[test]
    fn a_torque_turns_as_its_inertia_lets_it() {
        let still = Ahead { field: Vector::zero(), omega_t: Vector::zero() };
        let step = model().step(&still, &still, 60.0);
        let torque = Vector3::new(1e-7, -2e-7, 3e-7);
        let x = step.gamma_d * torque;
        let acceleration = model().inverse_inertia * torque;
        let rate = x.fixed_rows::<3>(3) * model().rate;
        let attitude = x.fixed_rows::<3>(0) * model().attitude;
        assert!((rate - acceleration * 60.0).norm() < 1e-12 * rate.norm());
        assert!((attitude - acceleration * 1800.0).norm() < 1e-12 * attitude.norm());
    }
}
