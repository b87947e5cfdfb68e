//! Attitude from field and Sun of one instant: how the filter starts by itself, and starts again.
//!
//! The filter's equations are linear about an estimate. Where there is none, or none to speak of, the
//! attitude is solved for by a method that needs no estimate ([`Method`]), and its covariance becomes
//! the filter's.

use nalgebra::{Matrix3, RealField, Vector3, convert};

use super::{FieldPair, Mekf, SunPair};
use crate::attitude::Observation;
use crate::frames::{Body, Eci, Rotation};

/// An attitude found without the filter.
#[derive(Debug, Clone, Copy)]
pub(super) struct Alignment<T: RealField + Copy> {
    pub(super) r_bi: Rotation<Body, Eci, T>,
    /// Of the attitude error, Body, rad².
    pub(super) covariance: Matrix3<T>,
}

/// Largest square of the difference between the measured and the modelled angle from field to Sun,
/// in units of its variance: good sensors exceed it once in 1e5 (χ² quantile, 1 degree of freedom).
const DISAGREEMENT_GATE: f64 = 19.51;

impl<T: RealField + Copy> Mekf<T> {
    /// Attitude from one field and one Sun. `None` when they are too close to parallel to know the
    /// attitude within the limit of linearity, or when they do not fit each other: the angle between
    /// them is the same in every attitude, so this judges the sensors and not the filter.
    pub(super) fn align(&self, field: &FieldPair<T>, sun: &SunPair<T>) -> Option<Alignment<T>> {
        let field_noise_rad = self.field_noise_t / field.eci.norm();
        let sun_noise_rad = self.parameters.sun_noise_rad;
        let (sun_b, sun_i) = (sun.body.vector(), sun.eci.vector());

        let disagreement =
            angle_rad(field.body.xyz, sun_b.xyz) - angle_rad(field.eci.xyz, sun_i.xyz);
        let variance = field_noise_rad * field_noise_rad + sun_noise_rad * sun_noise_rad;
        let fits = disagreement * disagreement <= variance * convert(DISAGREEMENT_GATE);
        if !fits {
            return None;
        }

        let observations = [
            Observation::new(sun_b, sun_i, sun_noise_rad).ok()?,
            Observation::new(field.body, field.eci, field_noise_rad).ok()?,
        ];
        let solution = self.parameters.start.solve(&observations).ok()?;
        let largest = solution.covariance_rad2.diagonal().max();
        let limit = self.parameters.limits.linear_rad;
        (largest <= limit * limit)
            .then_some(Alignment { r_bi: solution.attitude, covariance: solution.covariance_rad2 })
    }
}

/// The angle between two vectors, 0 to π, accurate for all angles.
fn angle_rad<T: RealField + Copy>(a: Vector3<T>, b: Vector3<T>) -> T {
    a.cross(&b).norm().atan2(a.dot(&b))
}
