//! What the filter is given in a cycle, and what it may be given to start with.

use nalgebra::{RealField, convert};

use crate::frames::{Body, Direction, Eci, Rotation, Vector};
use crate::reading::Reading;

/// What the world says in one cycle.
#[derive(Debug, Clone, Copy)]
pub struct Inputs<T: RealField + Copy = f32> {
    /// Time since the last cycle, measured, s. Zero: the same instant.
    pub dt_s: T,
    /// Rate of Body relative to Eci as the gyro shows it, rad/s.
    pub gyro: Reading<Vector<Body, T>>,
    /// Field, when the torquers have rested and the model has an answer.
    pub field: Option<FieldPair<T>>,
    /// Sun, when a sensor is lit and the satellite is not in eclipse.
    pub sun: Option<SunPair<T>>,
}

/// A measured field beside the model's, T.
#[derive(Debug, Clone, Copy)]
pub struct FieldPair<T: RealField + Copy = f32> {
    /// As measured, with the torquers at rest.
    pub body: Vector<Body, T>,
    /// As the model gives it at the satellite.
    pub eci: Vector<Eci, T>,
}

/// A measured direction of the Sun beside the model's.
#[derive(Debug, Clone, Copy)]
pub struct SunPair<T: RealField + Copy = f32> {
    /// As measured by a lit sensor.
    pub body: Direction<Body, T>,
    /// As the model gives it, outside eclipse.
    pub eci: Direction<Eci, T>,
    /// σ of this measurement across the line of sight, each of two axes, rad; `None`: as the
    /// parameters say.
    pub sigma_rad: Option<T>,
}

/// An attitude from somewhere else: the ground, or a filter that ran before.
#[derive(Debug, Clone, Copy)]
pub struct GivenStart<T: RealField + Copy = f32> {
    /// Attitude at the next cycle's instant, whose `dt_s` is then zero.
    pub r_bi: Rotation<Body, Eci, T>,
    /// σ of the attitude about each Body axis, rad, at most π.
    pub attitude_sigma_rad: T,
    /// Gyro bias, Body, rad/s.
    pub gyro_bias: Vector<Body, T>,
    /// σ of the bias, each axis, rad/s.
    pub gyro_bias_sigma_rad_s: T,
}

/// Largest flux density that can be the Earth's, T: 67 µT at the surface near the magnetic poles, and
/// room for an uncalibrated magnetometer.
const STRONGEST_FIELD_T: f64 = 2e-4;
/// Smallest σ that a Sun sensor may claim, rad: the parameters accept no smaller one either.
const SMALLEST_SUN_SIGMA_RAD: f64 = 1e-4;
/// Smallest flux density with a usable direction, T: that of the dipole 30 Earth radii out.
const WEAKEST_FIELD_T: f64 = 1e-9;

impl<T: RealField + Copy> SunPair<T> {
    /// σ across the line of sight, rad: the measurement's own, if it can be one, else that of the
    /// parameters.
    pub(in crate::attitude) fn sigma_rad(&self, of_parameters: T) -> T {
        let possible = |sigma: &T| *sigma >= convert(SMALLEST_SUN_SIGMA_RAD) && *sigma <= T::pi();
        self.sigma_rad.filter(possible).unwrap_or(of_parameters)
    }
}

impl<T: RealField + Copy> FieldPair<T> {
    /// Whether both can be a field of the Earth: finite, neither too strong nor too weak.
    pub(in crate::attitude) fn is_plausible(&self) -> bool {
        let range = convert(WEAKEST_FIELD_T)..=convert(STRONGEST_FIELD_T);
        range.contains(&self.body.norm()) && range.contains(&self.eci.norm())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_the_earths_field_is_not_plausible() {
        let field =
            FieldPair { body: Vector::new(2e-5, 0.0, 3e-5), eci: Vector::new(0.0, 3.6e-5, 0.0) };
        assert!(field.is_plausible());
        for bad in [0.0_f32, 1e-30, 1e-3, 1e30, f32::NAN, f32::INFINITY] {
            assert!(!FieldPair { body: Vector::new(0.0, bad, 0.0), ..field }.is_plausible());
            assert!(!FieldPair { eci: Vector::new(bad, 0.0, 0.0), ..field }.is_plausible());
        }
    }
}
