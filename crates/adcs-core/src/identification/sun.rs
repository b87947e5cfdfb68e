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
//! Errors of the magnetometer's own axes are in δ: it is the turn between the two sensors. It is small, as of
//! mounting: beyond 0.1 rad the products of it that are left out count.

use nalgebra::{RealField, Vector3};

use super::{IdentificationError, Normal, Solution};

/// Sums over a record.
#[derive(Debug, Clone, Copy)]
pub struct SunAlignment<T: RealField + Copy> {
    normal: Normal<T, 3>,
}

impl<T: RealField + Copy> Default for SunAlignment<T> {
    fn default() -> Self {
        Self { normal: Normal::default() }
    }
}

impl<T: RealField + Copy> SunAlignment<T> {
    /// Takes in a Sun and a field of one instant, of any length, and the cosine of the angle between
    /// their models. What has no direction is left out.
    pub fn add(&mut self, sun: [T; 3], field: [T; 3], cosine: T) {
        let directions = [sun, field].map(|v| Vector3::from(v).try_normalize(T::default_epsilon()));
        let [Some(sun), Some(field)] = directions else { return };
        let finite = sun.iter().chain(field.iter()).all(nalgebra::ComplexField::is_finite);
        if finite && cosine.abs() <= T::one() {
            self.normal.add_one(&sun.cross(&field), cosine - sun.dot(&field));
        }
    }

    /// δ, Body, rad.
    ///
    /// # Errors
    /// [`IdentificationError`]: what the record does not support.
    pub fn solve(&self) -> Result<Solution<T, 3>, IdentificationError> {
        self.normal.solve()
    }
}
