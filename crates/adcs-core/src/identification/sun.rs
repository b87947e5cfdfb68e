//! Alignment of the Sun sensors to the magnetometer, without an attitude.
//!
//! The angle between Sun and field is the same in every frame, and the models know it:
//!
//! cos γ = (s + δ × s) · b ⇒ δ · (s × b) = cos γ − s · b
//!
//! | symbol | code | meaning |
//! |---|---|---|
//! | s, b | `sun`, `field` | measured directions, Body |
//! | γ | `cosine` | between Sun and field by the models |
//! | δ | | small turn that brings s to where it belongs, Body, rad |
//!
//! Noise of s and b shows in s · b by the sine of the angle, so both sides are divided by it: δ is then seen along the
//! unit vector of s × b, with a noise that does not depend on the angle.
//!
//! Two things remain that do not average out, and are taken off from sums of their own. With both sides divided:
//!
//! | | adds to the right side | code |
//! |---|---|---|
//! | noisy directions are nearer to a right angle: E s · b = cos γ (1 − σ²), σ² being what the residuals show | σ² cot γ | `cotangents` |
//! | a turn is not small enough to be a vector | ½ ((δ · s)(δ · b) − δ² s · b) / sin γ | `bends` |
//!
//! Errors of the magnetometer's own axes are in δ: it is the turn between the two sensors. It is small, as of
//! mounting: beyond 0.2 rad the third order counts.

use nalgebra::{Matrix3, RealField, Vector3};

use super::{IdentificationError, Normal, Solution, number};

/// Sun and field are taken no nearer to each other, or to opposite, than 6 deg.
const MIN_SINE: f64 = 0.1;
/// The second order, put back so often: each time by a factor of δ nearer.
const PASSES: u32 = 4;

/// Sums over a record.
#[derive(Debug, Clone, Copy)]
pub struct SunAlignment<T: RealField + Copy> {
    normal: Normal<T, 3>,
    /// Σ a cot γ, a being the unit vector of s × b.
    cotangents: Vector3<T>,
    /// Of each axis i: Σ aᵢ W with δᵀ W δ the second order.
    bends: [Matrix3<T>; 3],
}

impl<T: RealField + Copy> Default for SunAlignment<T> {
    fn default() -> Self {
        Self {
            normal: Normal::default(),
            cotangents: Vector3::zeros(),
            bends: [Matrix3::zeros(); 3],
        }
    }
}

impl<T: RealField + Copy> SunAlignment<T> {
    /// Takes in a Sun and a field of one instant, of any length, and the cosine of the angle between
    /// their models. What has no direction is left out.
    pub fn add(&mut self, sun: [T; 3], field: [T; 3], cosine: T) {
        let directions = [sun, field].map(|v| Vector3::from(v).try_normalize(T::default_epsilon()));
        let [Some(sun), Some(field)] = directions else { return };
        let axis = sun.cross(&field);
        let sine = axis.norm();
        // A NaN fails both comparisons.
        let usable = sine > number(MIN_SINE) && cosine.abs() <= T::one();
        if !usable {
            return;
        }
        let part = T::one() / sine;
        let axis = axis * part;
        let shown = sun.dot(&field);
        self.normal.add_one(&axis, (cosine - shown) * part);
        self.cotangents += axis * (cosine * part);
        let outer = sun * field.transpose();
        let symmetric = (outer + outer.transpose()) * number::<T>(0.5);
        let bend = (symmetric - Matrix3::from_diagonal_element(shown)) * (part * number(0.5));
        for (sum, of_axis) in self.bends.iter_mut().zip(axis.iter()) {
            *sum += bend * *of_axis;
        }
    }

    /// δ, Body, rad.
    ///
    /// # Errors
    /// [`IdentificationError`]: what the record does not support.
    pub fn solve(&self) -> Result<Solution<T, 3>, IdentificationError> {
        let mut solution = self.normal.solve()?;
        let variance = solution.residual_rms * solution.residual_rms;
        if variance > T::zero() {
            let inverse = solution.covariance / variance;
            let first = solution.x - inverse * (self.cotangents * variance);
            for _ in 0..PASSES {
                let turn = solution.x;
                let bent = Vector3::from(self.bends.map(|bend| turn.dot(&(bend * turn))));
                solution.x = first - inverse * bent;
            }
        }
        let finite = solution.x.iter().all(nalgebra::ComplexField::is_finite);
        if finite { Ok(solution) } else { Err(IdentificationError::OutOfRange) }
    }
}
