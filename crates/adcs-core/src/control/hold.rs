//! How long a held command goes on taking energy out of a spin.
//!
//! A command is computed at the end of a rest and held in Body while the satellite turns. With the
//! rate ω constant, the vector that decides over the power, c = ω × B, turns about ω against the spin:
//!
//! c(t) = c₀ cos α − (ω̂ × c₀) sin α,   α = |ω| t
//!
//! P(t) = ω · (m × B(t)) = −m · c(t) = −(A cos α − S sin α),   A = m · c₀,  S = m · (ω̂ × c₀)
//!
//! | held until | energy it takes out |
//! |---|---|
//! | α | (A sin α − S (1 − cos α)) / \|ω\| |
//! | α* = atan2(A, S) | most of all: beyond it the command drives the spin |
//! | 2 α* | nothing: everything was given back |
//!
//! For an unclipped B-dot command m ∥ c₀ and S = 0: the mean of the damping over the hold is
//! sin α / α, α* is a quarter turn, and at half a turn the law does not damp at all, however strong it
//! is. A clipped or bang-bang command stands beside c₀, and α* is nearer or further by that angle.
//!
//! The angle is that of the *body* about its rate. The field itself turns in Body by less,
//! sin(β/2) = sin γ sin(α/2), γ the angle between rate and field; that is no comfort, because the part
//! of the field along ω does no work.
//!
//! The turning point is a zero of the power, so an error δ in rate or time costs δ² / 2 of the energy:
//! no margin is needed.
//!
//! | symbol | code | meaning |
//! |---|---|---|
//! | m | `dipole` | held dipole, Body, A·m² |
//! | ω | `omega_bi` | rate of Body relative to Eci at the start, Body, rad/s |
//! | B | `field` | field at the start, Body, T |
//!
//! Source: the derivation above.

use nalgebra::RealField;

use crate::frames::{Body, Vector};

/// Time after which a held dipole begins to drive the spin, s: it should be switched off by then.
///
/// Infinite when nothing turns, or when nothing is known of it (something is not finite): then there
/// is no reason to cut. Zero when the dipole drives the spin from the start.
///
/// A `field` that is parallel to the rate, or a dipole that does no work, gives infinity too. With a
/// rate known only across the field ([`crate::attitude::field_slope`]) the true turn is faster and the time is
/// too long.
pub fn useful_s<T: RealField + Copy>(
    dipole: Vector<Body, T>,
    omega_bi: Vector<Body, T>,
    field: Vector<Body, T>,
) -> T {
    let forever: T = T::one() / T::zero();
    let rate = omega_bi.norm();
    // The directions alone matter; lengths of 1e-5 T and less would underflow in the products.
    let (Some(m), Some(axis), Some(b)) =
        (dipole.direction(), omega_bi.direction(), field.direction())
    else {
        return forever;
    };
    let c = axis.vector().cross(&b.vector());
    let along = m.vector().dot(&c);
    let beside = m.vector().dot(&axis.vector().cross(&c));
    let small = T::default_epsilon().sqrt();
    if along.abs() < small && beside.abs() < small {
        return forever;
    }
    if along <= T::zero() {
        return T::zero();
    }
    along.atan2(beside) / rate
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::{FRAC_PI_2, PI};
    use nalgebra::{UnitQuaternion, Vector3};
    use proptest::prelude::*;

    const STEPS: u32 = 2000;

    /// Work of a held dipole on a body that spins evenly in a constant field, J: the midpoint rule
    /// over m × B(t), with the field turned by the quaternion, not by the formula under test.
    fn work_j(m: Vector3<f64>, omega: Vector3<f64>, b: Vector3<f64>, hold_s: f64) -> f64 {
        let dt = hold_s / f64::from(STEPS);
        let power = |t: f64| {
            let b_t = UnitQuaternion::from_scaled_axis(-omega * t) * b;
            omega.dot(&m.cross(&b_t))
        };
        (0..STEPS).map(|k| power((f64::from(k) + 0.5) * dt) * dt).sum()
    }

    fn vector<F>(v: Vector3<f64>) -> Vector<F, f64> {
        Vector::from_xyz(v)
    }

    const B: Vector3<f64> = Vector3::new(2e-5, -1e-5, 3e-5);
    const OMEGA: Vector3<f64> = Vector3::new(0.06, 0.03, 0.14);

    #[test]
    fn the_mean_damping_over_a_hold_is_that_at_its_start_times_sin_alpha_over_alpha() {
        // The midpoint rule's α² / 24 STEPS².
        const QUADRATURE: f64 = 1e-6;
        let m = OMEGA.cross(&B) * 1e5;
        let at_the_start = -1e5 * OMEGA.cross(&B).norm_squared();
        for alpha in [0.1, 1.0, FRAC_PI_2, 3.0, PI, 4.5, 6.0] {
            let hold_s = alpha / OMEGA.norm();
            let mean = work_j(m, OMEGA, B, hold_s) / hold_s / at_the_start;
            assert!((mean - libm::sin(alpha) / alpha).abs() < QUADRATURE, "{alpha}: {mean}");
        }
    }

    #[test]
    fn a_command_held_beyond_half_a_turn_adds_energy_and_one_cut_in_time_never_does() {
        let m = OMEGA.cross(&B) * 1e5;
        let half_turn_s = PI / OMEGA.norm();
        assert!(work_j(m, OMEGA, B, 0.98 * half_turn_s) < 0.0);
        assert!(work_j(m, OMEGA, B, 1.3 * half_turn_s) > 0.0);
        let useful = useful_s(vector(m), vector(OMEGA), vector(B));
        assert!((useful - 0.5 * half_turn_s).abs() < 1e-9, "a quarter turn");
        for scheduled_s in [5.0, 10.0, 20.0, 60.0_f64] {
            assert!(work_j(m, OMEGA, B, scheduled_s.min(useful)) < 0.0);
        }
    }

    #[test]
    fn without_a_turn_there_is_no_end_and_a_dipole_that_drives_is_off_at_once() {
        let m = OMEGA.cross(&B) * 1e5;
        assert_eq!(useful_s(vector(m), Vector::zero(), vector(B)), f64::INFINITY);
        assert_eq!(useful_s(Vector::zero(), vector(OMEGA), vector(B)), f64::INFINITY);
        assert_eq!(useful_s(vector(m), vector(B * 1e3), vector(B)), f64::INFINITY);
        assert_eq!(useful_s(vector(-m), vector(OMEGA), vector(B)), 0.0);
        for bad in [f64::NAN, f64::INFINITY] {
            assert_eq!(
                useful_s(Vector::new(bad, 0.0, 0.0), vector(OMEGA), vector(B)),
                f64::INFINITY
            );
        }
    }

    fn component() -> impl Strategy<Value = f64> {
        -1.0..1.0_f64
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 200, ..ProptestConfig::default() })]

        #[test]
        fn no_other_hold_of_a_clipped_command_takes_out_more(
            omega in [component(), component(), component()],
            field in [component(), component(), component()],
            limit in 0.001..0.6_f64,
            other in 0.0..2.0_f64,
        ) {
            let (omega, b) = (Vector3::from(omega) * 0.3, Vector3::from(field) * 5e-5);
            prop_assume!(omega.norm() > 0.01 && b.norm() > 1e-5);
            let c = omega.cross(&b);
            prop_assume!(c.norm() > 0.05 * omega.norm() * b.norm());
            let m = (c * 1e5).map(|m| m.clamp(-limit, limit));
            let useful = useful_s(vector(m), vector(omega), vector(b));
            let best = work_j(m, omega, b, useful);
            prop_assert!(best < 0.0);
            // Anything within half a turn more or less.
            let found = work_j(m, omega, b, useful * other);
            prop_assert!(found >= best * (1.0 + 1e-5));
        }

        #[test]
        fn f32_agrees_with_its_f64_twin(
            omega in [component(), component(), component()],
            field in [component(), component(), component()],
        ) {
            let (omega, b) = (Vector3::from(omega) * 0.3, Vector3::from(field) * 5e-5);
            prop_assume!(omega.norm() > 0.01 && b.norm() > 1e-5);
            let c = omega.cross(&b);
            prop_assume!(c.norm() > 0.05 * omega.norm() * b.norm());
            let m = (c * 1e5).map(|m| m.clamp(-0.05, 0.05));
            let double = useful_s(vector(m), vector(omega), vector(b));
            let single = useful_s::<f32>(
                vector(m).to_f32(), vector(omega).to_f32(), vector(b).to_f32());
            // 6e-8 of the inputs over a cosine of at least 0.05 between rate and field.
            prop_assert!((f64::from(single) / double - 1.0).abs() < 1e-4);
        }
    }
}
