//! QUEST: the quaternion estimator.
//!
//! The eigenvector of K divided by its scalar part is the Gibbs vector, and needs a 3×3 matrix
//! only. With S = B + Bᵀ, z and λ as in [`davenport`](super::davenport):
//!
//! | symbol | code | meaning |
//! |---|---|---|
//! | σ | `sigma` | tr B |
//! | κ, Δ | `kappa`, `delta` | tr adj S, det S |
//! | α | `alpha` | λ² − σ² + κ |
//! | β | `beta` | λ − σ |
//! | γ | `gamma` | (λ + σ) α − Δ |
//! | X | `x` | (α I + β S + S²) z |
//!
//! q = (X, γ) / |(X, γ)|
//!
//! γ and X vanish together at a rotation by 180 deg. There the references are first turned by
//! 180 deg about one of their axes (*sequential rotations*): of q and its three turned forms, one has
//! a scalar part of at least ½.
//!
//! Source: Shuster & Oh (1981), J. Guidance and Control 4(1); Markley & Crassidis (2014), §5.3.2. λ is
//! from Markley's form of their polynomial, which loses fewer digits.

use nalgebra::{Matrix3, Quaternion, RealField, UnitQuaternion, Vector3};

use super::davenport::Profile;
use super::number;

/// A scalar part above this is not lost in rounding; one of the four is at least ½.
const SMALLEST_SCALAR_PART: f64 = 0.3;
/// |(X, γ)| is a product of three gaps between eigenvalues: below this many ε it is rounding.
const ROUNDINGS: f64 = 8.0;

/// The attitude, from Eci to Body; `None` when B does not contain one in this precision.
pub(super) fn attitude<T: RealField + Copy>(profile: &Profile<T>) -> Option<UnitQuaternion<T>> {
    let (zero, one) = (T::zero(), T::one());
    // Hamilton quaternions of: no turn, 180 deg about x, about y, about z.
    [
        [one, zero, zero, zero],
        [zero, one, zero, zero],
        [zero, zero, one, zero],
        [zero, zero, zero, one],
    ]
    .map(|[w, x, y, z]| Quaternion::new(w, x, y, z))
    .into_iter()
    .find_map(|turn| {
        let turned = after_turn(&profile.b, profile.lambda, &turn)?;
        Some(UnitQuaternion::new_unchecked(turned * turn))
    })
}

/// The attitude relative to references that were turned, if its scalar part is large enough.
fn after_turn<T: RealField + Copy>(
    b: &Matrix3<T>,
    lambda: T,
    turn: &Quaternion<T>,
) -> Option<Quaternion<T>> {
    // B D, where D = diag(±1) turns the references: a column keeps its sign when the turn is about
    // its axis, or when there is none.
    let sign = |part: T| if part + turn.w > T::zero() { T::one() } else { -T::one() };
    let b = Matrix3::from_columns(&[
        b.column(0) * sign(turn.i),
        b.column(1) * sign(turn.j),
        b.column(2) * sign(turn.k),
    ]);
    let s = b + b.transpose();
    let z = Vector3::new(b.m23 - b.m32, b.m31 - b.m13, b.m12 - b.m21);
    let sigma = b.trace();
    let kappa = (s.m22 * s.m33 - s.m23 * s.m23)
        + (s.m33 * s.m11 - s.m13 * s.m13)
        + (s.m11 * s.m22 - s.m12 * s.m12);
    let delta = s.determinant();
    let alpha = lambda * lambda - sigma * sigma + kappa;
    let beta = lambda - sigma;
    let gamma = (lambda + sigma) * alpha - delta;
    let s_z = s * z;
    let x = z * alpha + s_z * beta + s * s_z;
    let norm = (x.norm_squared() + gamma * gamma).sqrt();
    let resolved = norm > number::<T>(ROUNDINGS) * T::default_epsilon()
        && gamma.abs() >= number::<T>(SMALLEST_SCALAR_PART) * norm;
    // (X, γ) is the textbook attitude quaternion; Hamilton's is its conjugate.
    resolved.then(|| Quaternion::new(gamma / norm, -x.x / norm, -x.y / norm, -x.z / norm))
}
