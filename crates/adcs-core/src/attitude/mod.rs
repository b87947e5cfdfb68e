//! Stage II from a single moment: attitude from directions measured in Body and known in Eci.
//!
//! ```text
//! Sun sensor, magnetometer ─► Observation (b, r, σ) ─► Method::solve ─► Estimate
//! Sun, field models ───────────▲                             └─► NoAttitude, and why
//! ```
//!
//! Each [`Method`] turns weighted pairs into an attitude with its loss, covariance and margin, or
//! says that there is none. [`Method::Foam`], [`Method::QMethod`] and [`Method::Quest`] are three
//! ways to the same optimum, the minimum of Wahba's loss
//!
//! L(A) = ½ Σ a_i |b_i − A r_i|², a_i = σ_i⁻² / Σ σ_j⁻²
//!
//! and share what comes after: the attitude that the method found is taken to the last digit and
//! proved to be the optimum (`optimum.rs`). [`Method::Triad`] keeps the first direction and uses two.
//!
//! ```
//! use adcs_core::attitude::{Method, Observation};
//! use adcs_core::frames::Vector;
//!
//! // Body is yawed by 90 deg: inertial y is along Body x, inertial x against Body y.
//! let sun = Observation::new(Vector::new(1.0, 0.0, 0.0), Vector::new(0.0, 1.0, 0.0), 0.012)?;
//! let field = Observation::new(Vector::new(0.0, -2e-5, 2e-5), Vector::new(2e-5, 0.0, 2e-5), 0.05)?;
//! let estimate = Method::Foam.solve(&[sun, field])?;
//! let [.., q_z, q_w]: [f32; 4] = estimate.attitude.attitude_quaternion();
//! assert!((q_z - 0.7071).abs() < 1e-4 && (q_w - 0.7071).abs() < 1e-4);
//! assert!(Method::Foam.solve(&[sun, sun]).is_err()); // the turn about the Sun is unknown
//! # Ok::<(), Box<dyn core::error::Error>>(())
//! ```
//!
//! Source: Wahba (1965); Markley & Crassidis (2014), ch. 5. Derivations: docs/attitude.

mod davenport;
pub mod dynamic;
pub mod field_slope;
mod foam;
mod information;
pub mod mekf;
mod observation;
mod optimum;
mod problem;
mod q_method;
mod quest;
pub mod selection;
mod triad;

use core::fmt;

use nalgebra::{Matrix3, RealField, Rotation3, UnitQuaternion};
use serde::{Deserialize, Serialize};

pub use observation::{Observation, ObservationError, Side};

use crate::frames::{Body, Eci, Rotation};
use davenport::Profile;
use problem::Problem;

/// How the attitude is found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Method {
    /// From the first two pairs, of which the first is trusted completely (TRIAD).
    Triad,
    /// Optimal: Markley's fast optimal attitude matrix (FOAM).
    Foam,
    /// Optimal: Davenport's q-method.
    QMethod,
    /// Optimal: Shuster's quaternion estimator (QUEST), with sequential rotations.
    Quest,
}

/// An attitude and how good it is.
#[derive(Debug, Clone, Copy)]
pub struct Estimate<T: RealField + Copy = f32> {
    /// `r_bi`.
    pub attitude: Rotation<Body, Eci, T>,
    /// L = ½ Σ a_i |b_i − A r_i|² of the pairs that were used, Σ a_i = 1, no unit. For n pairs with
    /// the noise that their σ promise, 2 L Σ σ_i⁻² is χ² distributed with 2n − 3 degrees of freedom
    /// (optimal methods): a value far above says that a pair is wrong.
    pub loss: T,
    /// Covariance of the small rotation from true to estimated Body, Body axes, rad². For the
    /// optimal methods [Σ σ_i⁻² (I − b_i b_iᵀ)]⁻¹ (Shuster & Oh (1981)), first order in σ.
    pub covariance_rad2: Matrix3<T>,
    /// How much the loss rises for the rotation about which least is known: L grows by
    /// ½ margin φ². s₂ + d s₃ of the attitude profile matrix, from 0 (not unique) to 2/3.
    pub margin: T,
}

/// Why there is no attitude.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum NoAttitude {
    /// Fewer than two pairs.
    TooFew {
        /// How many there were.
        found: usize,
    },
    /// The pairs leave a rotation open, as parallel ones do: many attitudes are equally good, or
    /// differ by less than rounding in this precision.
    NotUnique {
        /// The margin as far as it could be resolved; 0 when not at all.
        margin: f32,
    },
}

impl fmt::Display for NoAttitude {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooFew { found } => write!(f, "{found} pairs of vectors, two are needed"),
            Self::NotUnique { margin } => write!(f, "the attitude is not unique: margin {margin}"),
        }
    }
}

impl core::error::Error for NoAttitude {}

impl NoAttitude {
    fn not_unique<T: RealField + Copy>(margin: T) -> Self {
        Self::NotUnique { margin: nalgebra::try_convert::<T, f64>(margin).unwrap_or(0.0) as f32 }
    }
}

impl Method {
    /// The attitude that these pairs give, of which there may be any number; TRIAD takes the first two.
    ///
    /// # Errors
    /// [`NoAttitude`] when the pairs do not determine one. The caller then keeps what it has.
    pub fn solve<T: RealField + Copy>(
        self,
        observations: &[Observation<T>],
    ) -> Result<Estimate<T>, NoAttitude> {
        let start = match self {
            Self::Triad => {
                let too_few = NoAttitude::TooFew { found: observations.len() };
                return triad::solve(observations.first_chunk().ok_or(too_few)?);
            }
            Self::Foam => foam::attitude,
            Self::QMethod => q_method::attitude,
            Self::Quest => quest::attitude,
        };
        let problem = Problem::new(observations)?;
        optimum::find(&problem, start(&Profile::of(&problem)))
    }
}

/// A constant in the precision at hand.
fn number<T: RealField>(value: f64) -> T {
    nalgebra::convert(value)
}

/// The quaternion of a matrix that is a rotation within rounding.
fn quaternion<T: RealField + Copy>(a: &Matrix3<T>) -> UnitQuaternion<T> {
    let q = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(*a));
    UnitQuaternion::new_normalize(q.into_inner())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frames::Vector;
    use nalgebra::{Quaternion, Vector3};
    use proptest::prelude::*;

    /// What a method loses beside rounding of B, as a multiple of ε / margin.
    const ROUNDINGS: f64 = 50.0;

    const DIRECTION: [core::ops::Range<f64>; 3] = [0.05..1.0, -1.0..1.0, -1.0..1.0];
    /// Any rotation.
    const ANY: [core::ops::Range<f64>; 4] = [0.05..1.0, -1.0..1.0, -1.0..1.0, -1.0..1.0];
    /// By 180 deg about any axis.
    const HALF: [core::ops::Range<f64>; 4] = [0.0..1e-300, 0.05..1.0, -1.0..1.0, -1.0..1.0];

    proptest! {
        /// Without what makes the last digits, so that it hides nothing.
        #[test]
        fn each_optimal_method_finds_the_optimum_by_itself(
            q in prop_oneof![ANY, HALF],
            references in [DIRECTION, DIRECTION, DIRECTION],
            errors in [[-0.1..0.1, -0.1..0.1, -0.1..0.1], [-0.1..0.1, -0.1..0.1, -0.1..0.1], [-0.1..0.1_f64, -0.1..0.1, -0.1..0.1]],
            sigmas in [0.01..0.1_f64, 0.01..0.1, 0.01..0.1],
        ) {
            let [w, x, y, z] = q;
            let q = UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z));
            let pairs: [_; 3] = core::array::from_fn(|i| {
                let reference = Vector3::from(references[i]);
                let body = q * (reference + Vector3::from(errors[i]));
                Observation::new(Vector::from_xyz(body), Vector::from_xyz(reference), sigmas[i]).unwrap()
            });
            let problem = Problem::new(&pairs).unwrap();
            let profile = Profile::of(&problem);
            for start in [foam::attitude, q_method::attitude, quest::attitude] {
                let Ok(best) = optimum::find(&problem, None) else {
                    return Err(TestCaseError::reject("parallel"));
                };
                prop_assume!(best.margin > 1e-6);
                let found = start(&profile).unwrap();
                let error = found.angle_to(&best.attitude.hamilton());
                prop_assert!(error * best.margin < ROUNDINGS * f64::EPSILON, "{error} {}", best.margin);
            }
        }
    }
}
