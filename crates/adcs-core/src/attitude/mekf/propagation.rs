//! From one instant to the next with the gyro: the step's rotation, Φ and Q in closed form.
//!
//! With a rate ω that is constant over a step of Δt, a = |ω| Δt:
//!
//! | symbol | code | meaning |
//! |---|---|---|
//! | δq | [`Step::rotation`] | exp(−ω Δt / 2): Body then to Body now, `q_bi⁺ = δq ⊗ q_bi` |
//! | Φ₁₁ | [`Step::phi_attitude`] | I − [ω×] Δt sin a / a + [ω×]² Δt² (1 − cos a) / a², the matrix of δq |
//! | Φ₁₂ | [`Step::phi_bias`] | −I Δt + [ω×] Δt² (1 − cos a) / a² − [ω×]² Δt³ (a − sin a) / a³ |
//! | Q | [`ProcessNoise`] | [σ_v² Δt + σ_u² Δt³/3, −σ_u² Δt²/2; −σ_u² Δt²/2, σ_u² Δt], each times I |
//!
//! Φ solves θ̇ = −ω × θ − Δβ, Δβ̇ = 0 exactly. Q is exact for ω = 0 and, its attitude part being
//! isotropic, within 1e-6 for 0.1 rad/s and 2.5 s.
//!
//! Source: Markley & Crassidis (2014), §6.2.4; Farrenkopf (1978) for Q.

use nalgebra::{Matrix3, Matrix6, Quaternion, RealField, Unit, UnitQuaternion, Vector3, convert};

/// The step of a satellite that turns at a constant rate.
#[derive(Debug, Clone, Copy)]
pub(super) struct Step<T: RealField + Copy> {
    /// δq.
    pub(super) rotation: UnitQuaternion<T>,
    /// Φ₁₁.
    pub(super) phi_attitude: Matrix3<T>,
    /// Φ₁₂, s.
    pub(super) phi_bias: Matrix3<T>,
}

impl<T: RealField + Copy> Step<T> {
    /// A step of `dt_s` with the rate `omega_bi_b`, Body, rad/s.
    pub(super) fn new(omega_bi_b: Vector3<T>, dt_s: T) -> Self {
        let turn = omega_bi_b * dt_s;
        let ratios = Ratios::of(turn.norm_squared());
        let e = turn * (-ratios.half_sine * convert(0.5));
        let rotation = Unit::new_normalize(Quaternion::new(ratios.half_cosine, e.x, e.y, e.z));
        let cross = turn.cross_matrix();
        let versine = ratios.half_sine * ratios.half_sine * convert(0.5);
        let in_steps = cross * versine - Matrix3::identity() - cross * cross * ratios.deficit;
        Self {
            rotation,
            phi_attitude: rotation.to_rotation_matrix().into_inner(),
            phi_bias: in_steps * dt_s,
        }
    }

    /// P⁺ = Φ P Φᵀ + Q of attitude error and gyro bias, block by block (Φ₂₁ = 0, Φ₂₂ = I).
    pub(super) fn covariance(&self, before: &Matrix6<T>, noise: &ProcessNoise<T>) -> Matrix6<T> {
        let attitude: Matrix3<T> = before.fixed_view::<3, 3>(0, 0).into_owned();
        let cross: Matrix3<T> = before.fixed_view::<3, 3>(0, 3).into_owned();
        let bias: Matrix3<T> = before.fixed_view::<3, 3>(3, 3).into_owned();

        // [Φ₁₁ Φ₁₂] P, its two blocks.
        let left = self.phi_attitude * attitude + self.phi_bias * cross.transpose();
        let right = self.phi_attitude * cross + self.phi_bias * bias;
        let attitude = left * self.phi_attitude.transpose() + right * self.phi_bias.transpose();
        let half: T = convert(0.5);
        let attitude = (attitude + attitude.transpose()) * half
            + Matrix3::from_diagonal_element(noise.attitude);
        let cross = right + Matrix3::from_diagonal_element(noise.cross);
        let bias = bias + Matrix3::from_diagonal_element(noise.bias);

        let mut after = Matrix6::zeros();
        after.fixed_view_mut::<3, 3>(0, 0).copy_from(&attitude);
        after.fixed_view_mut::<3, 3>(0, 3).copy_from(&cross);
        after.fixed_view_mut::<3, 3>(3, 0).copy_from(&cross.transpose());
        after.fixed_view_mut::<3, 3>(3, 3).copy_from(&bias);
        after
    }
}

/// Q of one step; each block is this times I.
#[derive(Debug, Clone, Copy)]
pub(super) struct ProcessNoise<T> {
    /// Attitude, rad².
    pub(super) attitude: T,
    /// Attitude with bias, rad²/s.
    pub(super) cross: T,
    /// Bias, rad²/s².
    pub(super) bias: T,
}

impl<T: RealField + Copy> ProcessNoise<T> {
    /// Rate noise that adds `rate_variance_rad2` to the attitude's variance over this step, and a bias
    /// that walks with σ_u² = `walk_rad2_s3`.
    pub(super) fn new(rate_variance_rad2: T, walk_rad2_s3: T, dt_s: T) -> Self {
        let (third, half): (T, T) = (convert(1.0 / 3.0), convert(0.5));
        let bias = walk_rad2_s3 * dt_s;
        Self {
            attitude: rate_variance_rad2 + bias * dt_s * dt_s * third,
            cross: -bias * dt_s * half,
            bias,
        }
    }
}

/// The functions of the angle a that stay finite at a = 0.
struct Ratios<T> {
    /// sin(a/2) / (a/2).
    half_sine: T,
    /// cos(a/2).
    half_cosine: T,
    /// (a − sin a) / a³.
    deficit: T,
}

impl<T: RealField + Copy> Ratios<T> {
    /// From a². Up to 1 rad by power series, whose eight terms leave less than 1e-16 and cost a
    /// twentieth of a software sine; above, where nothing cancels, by the closed form.
    fn of(a2: T) -> Self {
        if a2 <= T::one() {
            let quarter = a2 * convert(0.25);
            Self {
                half_sine: series(quarter, SINE),
                half_cosine: series(quarter, COSINE),
                deficit: series(a2, DEFICIT),
            }
        } else {
            let a = a2.sqrt();
            let half = a * convert(0.5);
            let (sine, half_cosine) = half.sin_cos();
            let sine_of_a = sine * half_cosine * convert(2.0);
            Self { half_sine: sine / half, half_cosine, deficit: (a - sine_of_a) / (a2 * a) }
        }
    }
}

/// 1 / (2n+1)!, n = 0 to 7.
const SINE: [f64; 8] = [
    1.0,
    1.0 / 6.0,
    1.0 / 120.0,
    1.0 / 5_040.0,
    1.0 / 362_880.0,
    1.0 / 39_916_800.0,
    1.0 / 6_227_020_800.0,
    1.0 / 1_307_674_368_000.0,
];
/// 1 / (2n)!, n = 0 to 7.
const COSINE: [f64; 8] = [
    1.0,
    1.0 / 2.0,
    1.0 / 24.0,
    1.0 / 720.0,
    1.0 / 40_320.0,
    1.0 / 3_628_800.0,
    1.0 / 479_001_600.0,
    1.0 / 87_178_291_200.0,
];
/// 1 / (2n+3)!, n = 0 to 7.
const DEFICIT: [f64; 8] = [
    1.0 / 6.0,
    1.0 / 120.0,
    1.0 / 5_040.0,
    1.0 / 362_880.0,
    1.0 / 39_916_800.0,
    1.0 / 6_227_020_800.0,
    1.0 / 1_307_674_368_000.0,
    1.0 / 355_687_428_096_000.0,
];

/// Σ (−x)ⁿ cₙ by Horner's rule.
fn series<T: RealField + Copy>(x: T, coefficients: [f64; 8]) -> T {
    coefficients.iter().rev().fold(T::zero(), |sum, &c| convert::<f64, T>(c) - x * sum)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector6;

    /// Rounding of some twenty f64 products of order one.
    const ROUNDING: f64 = 1e-15;

    fn rates() -> [Vector3<f64>; 5] {
        [
            Vector3::new(0.0, 0.0, 0.0),
            Vector3::new(1e-9, -2e-9, 3e-9),
            Vector3::new(0.06, 0.03, -0.14),
            Vector3::new(-0.9, 1.1, 0.2),
            Vector3::new(2.0, -3.0, 1.0),
        ]
    }

    #[test]
    fn the_ratios_are_continuous_where_series_and_closed_form_meet() {
        let (below, above) = (Ratios::of(1.0_f64), Ratios::of(1.0 + 1e-15));
        assert!((below.half_sine - above.half_sine).abs() < ROUNDING);
        assert!((below.half_cosine - above.half_cosine).abs() < ROUNDING);
        assert!((below.deficit - above.deficit).abs() < ROUNDING);
        assert!((below.half_sine - 2.0 * libm::sin(0.5)).abs() < ROUNDING);
        assert!((below.half_cosine - libm::cos(0.5)).abs() < ROUNDING);
    }

    #[test]
    fn two_half_steps_are_one_step() {
        for omega in rates() {
            let (whole, half) = (Step::new(omega, 0.8), Step::new(omega, 0.4));
            let twice = half.rotation * half.rotation;
            assert!(
                twice.angle_to(&whole.rotation) < 1e-7 && {
                    (twice.coords - whole.rotation.coords).norm() < 4.0 * ROUNDING
                }
            );
            let phi_bias = half.phi_attitude * half.phi_bias + half.phi_bias;
            assert!((phi_bias - whole.phi_bias).norm() < 10.0 * ROUNDING, "{omega:?}");
        }
    }

    #[test]
    fn the_step_turns_body_by_the_rate() {
        // Yawing at +0.1 rad/s for 2 s: a star along Body x goes to −y by 0.2 rad.
        let step = Step::new(Vector3::new(0.0, 0.0, 0.1), 2.0);
        let star = step.rotation * Vector3::x();
        let expected = Vector3::new(libm::cos(0.2), -libm::sin(0.2), 0.0);
        assert!((star - expected).norm() < ROUNDING);
    }

    /// The error of an estimate after the step, from the error before it: (θ, Δβ) is put in, both
    /// attitudes are propagated with their own rates, and θ is read out again.
    fn propagated_error(omega: Vector3<f64>, dt_s: f64, before: Vector6<f64>) -> Vector3<f64> {
        let theta: Vector3<f64> = before.fixed_rows::<3>(0).into_owned();
        let bias_error: Vector3<f64> = before.fixed_rows::<3>(3).into_owned();
        let estimate = UnitQuaternion::identity();
        let truth = UnitQuaternion::from_scaled_axis(-theta) * estimate;
        // The true bias is larger than the estimated one, so the true rate is smaller.
        let truth = Step::new(omega - bias_error, dt_s).rotation * truth;
        let estimate = Step::new(omega, dt_s).rotation * estimate;
        -(truth * estimate.inverse()).scaled_axis()
    }

    #[test]
    fn phi_is_the_numerical_jacobian_of_the_propagation() {
        // Central differences of 1e-5 leave 1e-10 of the third derivative and 1e-11 of rounding.
        const STEP: f64 = 1e-5;
        const TOLERANCE: f64 = 1e-9;
        for omega in rates() {
            let step = Step::new(omega, 0.7);
            for column in 0..6 {
                let mut before = Vector6::zeros();
                before[column] = STEP;
                let change =
                    propagated_error(omega, 0.7, before) - propagated_error(omega, 0.7, -before);
                let numerical = change / (2.0 * STEP);
                let phi = if column < 3 { step.phi_attitude } else { step.phi_bias };
                let analytic = phi.column(column % 3).into_owned();
                assert!((numerical - analytic).norm() < TOLERANCE, "{omega:?} column {column}");
            }
        }
    }

    #[test]
    fn the_covariance_is_phi_p_phi_transposed_plus_q() {
        let step = Step::new(Vector3::new(0.06, 0.03, -0.14), 0.5_f64);
        let noise = ProcessNoise::new(2e-6, 3e-10, 0.5);
        let root = Matrix6::from_fn(|i, j| libm::sin((7 * i + 3 * j) as f64));
        let before = root * root.transpose();
        let mut phi = Matrix6::identity();
        phi.fixed_view_mut::<3, 3>(0, 0).copy_from(&step.phi_attitude);
        phi.fixed_view_mut::<3, 3>(0, 3).copy_from(&step.phi_bias);
        let mut q = Matrix6::zeros();
        for axis in 0..3 {
            q[(axis, axis)] = noise.attitude;
            q[(axis, axis + 3)] = noise.cross;
            q[(axis + 3, axis)] = noise.cross;
            q[(axis + 3, axis + 3)] = noise.bias;
        }
        let expected = phi * before * phi.transpose() + q;
        let after = step.covariance(&before, &noise);
        assert!((after - expected).norm() < 20.0 * ROUNDING * expected.norm());
        assert_eq!(after, after.transpose());
    }

    #[test]
    fn two_steps_of_noise_add_up_to_one_of_twice_the_length() {
        // A satellite at rest: P after two steps of Q from nothing is Q of the whole.
        let rest = Step::new(Vector3::zeros(), 0.5_f64);
        let noise = |dt_s: f64| ProcessNoise::new(8e-6 * dt_s, 3e-7, dt_s);
        let nothing = Matrix6::zeros();
        let twice = rest.covariance(&rest.covariance(&nothing, &noise(0.5)), &noise(0.5));
        let once = Step::new(Vector3::zeros(), 1.0).covariance(&nothing, &noise(1.0));
        assert!((twice - once).norm() < ROUNDING * once.norm());
    }
}
