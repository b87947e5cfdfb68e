//! FOAM: the fast optimal attitude matrix.
//!
//! With the singular value decomposition B = U diag(s₁, s₂, d s₃) Vᵀ, U and V rotations, d = ±1 the
//! sign of det B, the best attitude is A = U Vᵀ. Markley found it without the decomposition:
//!
//! A = [(κ + |B|²) B + λ adj Bᵀ − B Bᵀ B] / ζ
//!
//! | symbol | code | meaning | in singular values |
//! |---|---|---|---|
//! | λ | `profile.lambda` | largest eigenvalue of K | s₁ + s₂ + d s₃ |
//! | κ | `kappa` | (λ² − \|B\|²) / 2 | s₂ d s₃ + d s₃ s₁ + s₁ s₂ |
//! | ζ | `zeta` | κ λ − det B | (s₂ + d s₃)(d s₃ + s₁)(s₁ + s₂) |
//! | adj Bᵀ | `profile.cofactor` | adjugate of the transpose | |
//!
//! ζ contains the margin s₂ + d s₃ as a factor and goes to zero with it.
//!
//! Source: Markley (1993), J. Astronaut. Sci. 41(2), eqs. (14), (18), (19); derivation in docs/attitude.

use nalgebra::{Matrix3, RealField, UnitQuaternion};

use super::davenport::Profile;
use super::{number, quaternion};

/// ζ is a sum of products of order one, each rounded: below this many ε it is rounding.
const ROUNDINGS: f64 = 8.0;

/// The attitude, from Eci to Body; `None` when B does not contain one in this precision.
pub(super) fn attitude<T: RealField + Copy>(profile: &Profile<T>) -> Option<UnitQuaternion<T>> {
    let Profile { b, cofactor, determinant, norm_squared, lambda } = *profile;
    let kappa = (lambda * lambda - norm_squared) * number(0.5);
    let zeta = kappa * lambda - determinant;
    if zeta <= number::<T>(ROUNDINGS) * T::default_epsilon() {
        return None;
    }
    let a: Matrix3<T> = (b * (kappa + norm_squared) + cofactor * lambda - b * b.tr_mul(&b)) / zeta;
    // A is orthogonal only to ε / ζ; `quaternion` normalises.
    Some(quaternion(&a))
}
