//! TRIAD: attitude from two directions, the first trusted completely.
//!
//! | symbol | code | meaning |
//! |---|---|---|
//! | b₁, r₁ | `b1`, `r1` | the anchor: measured (Body) and reference (Eci) unit vector; this direction is kept |
//! | b₂, r₂ | `b2`, `r2` | the pair that settles the turn about it |
//! | c, s | `cosine`, `sine` | of the angle between b₁ and b₂ |
//!
//! t₁ = b₁, t₂ = b₁ × b₂ / s, t₃ = t₁ × t₂; u₁, u₂, u₃ likewise from r; A = Σ t_k u_kᵀ
//!
//! Error in Body: across b₁ it is that of b₁. The turn about b₁ takes over the error of b₂ across
//! the plane of the two, divided by s, and c/s of that of b₁ about t₃; so with v = t₃ − (c/s) t₁
//!
//! P = σ₁² (t₂t₂ᵀ + v vᵀ) + (σ₂/s)² t₁t₁ᵀ
//!
//! (Shuster and Oh's covariance, written as a sum of squares.)
//!
//! Source: Black (1964), AIAA J. 2(7); Markley & Crassidis (2014), §5.1; covariance Shuster & Oh
//! (1981), J. Guidance and Control 4(1).

use nalgebra::{Matrix3, RealField, Vector3};

use super::observation::Observation;
use super::optimum::MAX_TURN_BY_ROUNDING_RAD;
use super::problem::Problem;
use super::{Estimate, NoAttitude, number, quaternion};
use crate::frames::Rotation;

/// The attitude under which the first pair agrees, and the second within their plane. Loss and
/// margin are those of these two pairs.
pub(super) fn solve<T: RealField + Copy>(
    pairs: &[Observation<T>; 2],
) -> Result<Estimate<T>, NoAttitude> {
    let problem = Problem::new(pairs)?;
    let [anchor, second] = pairs;
    let ((b1, r1), (b2, r2)) = (anchor.units(), second.units());
    let (t, sine) = triad(&b1, &b2).ok_or(NoAttitude::NotUnique { margin: 0.0 })?;
    let (u, sine_r) = triad(&r1, &r2).ok_or(NoAttitude::NotUnique { margin: 0.0 })?;
    let margin = margin(&problem, b1.dot(&b2) * r1.dot(&r2), sine * sine_r);
    // Rounding of a component, ε, turns a plane by ε over the sine.
    let turn_by_rounding = T::default_epsilon() * (T::one() / sine + T::one() / sine_r);
    if turn_by_rounding > number(MAX_TURN_BY_ROUNDING_RAD) {
        return Err(NoAttitude::not_unique(margin));
    }
    let attitude = quaternion(&(t * u.transpose()));
    Ok(Estimate {
        attitude: Rotation::from_hamilton(attitude),
        loss: problem.loss(&attitude),
        covariance_rad2: covariance(pairs, &t, sine),
        margin,
    })
}

/// `[t₁ t₂ t₃]` and the sine of the angle between the two; `None` when that is zero.
fn triad<T: RealField + Copy>(v1: &Vector3<T>, v2: &Vector3<T>) -> Option<(Matrix3<T>, T)> {
    let normal = v1.cross(v2);
    let sine = normal.norm();
    let t2 = (sine > T::zero()).then(|| normal / sine)?;
    Some((Matrix3::from_columns(&[*v1, t2, v1.cross(&t2)]), sine))
}

/// P, rad².
fn covariance<T: RealField + Copy>(
    [anchor, second]: &[Observation<T>; 2],
    t: &Matrix3<T>,
    sine: T,
) -> Matrix3<T> {
    let (sigma_1, sigma_2) = (anchor.sigma_rad(), second.sigma_rad() / sine);
    let cosine = anchor.units().0.dot(&second.units().0);
    let [t1, t2, t3] = [t.column(0), t.column(1), t.column(2)];
    let v = t3 - t1 * (cosine / sine);
    (t2 * t2.transpose() + v * v.transpose()) * (sigma_1 * sigma_1)
        + t1 * t1.transpose() * (sigma_2 * sigma_2)
}

/// s₂ of B for two pairs (s₃ = 0), from s₁ s₂ = a₁ a₂ |b₁ × b₂| |r₁ × r₂| and
/// (s₁ + s₂)² = |B|² + 2 s₁ s₂, without cancellation however unequal the weights.
fn margin<T: RealField + Copy>(problem: &Problem<'_, T>, cosines: T, sines: T) -> T {
    let two = number::<T>(2.0);
    let (squares, product) = problem.pairs().fold((T::zero(), T::one()), |(s, p), pair| {
        (s + pair.weight * pair.weight, p * pair.weight)
    });
    let s1_s2 = product * sines;
    let norm_squared = squares + two * product * cosines;
    let sum = (norm_squared + two * s1_s2).max(T::zero()).sqrt();
    let difference = (norm_squared - two * s1_s2).max(T::zero()).sqrt();
    let s1 = (sum + difference) / two;
    if s1 > T::zero() { s1_s2 / s1 } else { T::zero() }
}
