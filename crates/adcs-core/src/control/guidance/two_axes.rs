//! An attitude from two axes: the first is met exactly, the second as well as the first lets it.
//!
//! ```text
//! t₁ = p,  t₂ = (p × s) / |p × s|,  t₃ = t₁ × t₂      in Eci: U,  in Body: B
//! R_ti = B Uᵀ
//! ```
//!
//! | symbol | code | meaning |
//! |---|---|---|
//! | p | `primary`, `boresight` | what the first axis of Body is pointed at |
//! | s | `second` | what the second axis is brought as near to as it goes |
//!
//! Source: the construction of TRIAD, Markley & Crassidis (2014), §5.1.

use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};

use super::AimError;
use crate::frames::{Direction, Eci, Rotation, Target, Vector};

/// Axes of Body that are nearer to parallel than this are refused, deg: an error of one of them would
/// come out ten times larger in the turn about the other.
pub(super) const LEAST_APART_DEG: f32 = 5.7;
/// The sine of that.
const LEAST_SINE: f32 = 0.1;

/// Which axes of Body are to point, as stored and uplinked; of any length. `Default` is z, with y as the
/// second: the axes that the Orbit frame has at nadir.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct BodyAxesParameters {
    /// The axis that is pointed at the target, Body.
    pub boresight: [f32; 3],
    /// The axis that settles the turn about it, Body.
    pub second: [f32; 3],
}

impl Default for BodyAxesParameters {
    fn default() -> Self {
        Self { boresight: [0.0, 0.0, 1.0], second: [0.0, 1.0, 0.0] }
    }
}

/// Accepted axes of Body, as B.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct BodyAxes(Matrix3<f32>);

impl BodyAxes {
    pub(super) fn new(parameters: &BodyAxesParameters) -> Result<Self, AimError> {
        let direction = |xyz: [f32; 3]| Direction::<Target>::new(Vector::from_xyz(xyz.into()));
        let primary = direction(parameters.boresight).ok_or(AimError::Axes)?;
        let second = direction(parameters.second).ok_or(AimError::Axes)?;
        let (axes, sine) = axes(primary.vector().xyz, second.vector().xyz).ok_or(AimError::Axes)?;
        if sine < LEAST_SINE { Err(AimError::Axes) } else { Ok(Self(axes)) }
    }

    /// The boresight, unit, along the target's axes.
    pub(super) fn boresight(&self) -> Vector3<f32> {
        self.0.column(0).into_owned()
    }

    #[inline(never)]
    /// The attitude with the boresight along `primary` and the second axis towards `second`; and the
    /// sine of the angle between the two. `None` when they are parallel.
    pub(super) fn towards(
        &self,
        primary: Direction<Eci>,
        second: Direction<Eci>,
    ) -> Option<Aligned> {
        let (eci, sine) = axes(primary.vector().xyz, second.vector().xyz)?;
        let rotation = Rotation3::from_matrix_unchecked(self.0 * eci.transpose());
        let r_ti = Rotation::from_hamilton(UnitQuaternion::from_rotation_matrix(&rotation));
        Some(Aligned { r_ti, eci, sine })
    }
}

/// An attitude from two axes.
pub(super) struct Aligned {
    pub(super) r_ti: Rotation<Target, Eci>,
    /// t₁, t₂, t₃ as columns, Eci.
    pub(super) eci: Matrix3<f32>,
    /// |p × s|.
    pub(super) sine: f32,
}

/// `[t₁ t₂ t₃]` and |p × s|; `None` when that vanishes.
fn axes(primary: Vector3<f32>, second: Vector3<f32>) -> Option<(Matrix3<f32>, f32)> {
    let normal = primary.cross(&second);
    let sine = normal.norm();
    // Rounding of two unit vectors: below this the plane of the two is noise.
    let t2 = (sine > 1e-5).then(|| normal / sine)?;
    Some((Matrix3::from_columns(&[primary, t2, primary.cross(&t2)]), sine))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn unit(xyz: [f32; 3]) -> Direction<Eci> {
        Vector::new(xyz[0], xyz[1], xyz[2]).direction().unwrap()
    }

    proptest! {
        #[test]
        fn the_first_axis_is_met_and_the_second_lies_in_the_plane_on_its_side(
            p in [-1.0..1.0_f32, -1.0..1.0_f32, 0.2..1.0_f32],
            s in [-1.0..1.0_f32, 0.2..1.0_f32, -1.0..-0.2_f32],
        ) {
            let parameters = BodyAxesParameters { boresight: [0.0, -2.0, 1.0], second: [3.0, 0.5, 0.0] };
            let body = BodyAxes::new(&parameters).unwrap();
            let (p, s) = (unit(p), unit(s));
            let Some(aligned) = body.towards(p, s) else { return Ok(()) };
            prop_assume!(aligned.sine > 0.05);
            // Rounding of f32, divided by the sine.
            const ROUNDING: f32 = 1e-5;
            let seen = aligned.r_ti * p.vector();
            prop_assert!((seen.xyz - body.boresight()).norm() < ROUNDING);
            let second = Vector3::new(3.0, 0.5, 0.0).normalize();
            let seen = (aligned.r_ti * s.vector()).xyz;
            let normal = body.boresight().cross(&second);
            prop_assert!(seen.dot(&normal).abs() < ROUNDING, "in the plane of the two");
            prop_assert!(body.boresight().cross(&seen).dot(&normal) > 0.0, "on its side");
        }
    }

    #[test]
    fn axes_that_settle_no_attitude_are_refused() {
        for (boresight, second) in [
            ([0.0; 3], [0.0, 1.0, 0.0]),
            ([0.0, 0.0, 1.0], [f32::NAN, 0.0, 0.0]),
            ([0.0, 0.0, 1.0], [0.0, 0.05, 1.0]),
            ([0.0, 0.0, 1.0], [0.0, 0.0, -5.0]),
            ([f32::INFINITY, 0.0, 1.0], [0.0, 1.0, 0.0]),
        ] {
            let refused = BodyAxes::new(&BodyAxesParameters { boresight, second });
            assert_eq!(refused, Err(AimError::Axes), "{boresight:?} {second:?}");
        }
    }
}
