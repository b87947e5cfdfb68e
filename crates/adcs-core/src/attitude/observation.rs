//! One direction, seen from Body and known in Eci.

use core::fmt;

use nalgebra::{RealField, Vector3};

use crate::frames::{Body, Direction, Eci, Vector};

/// A direction measured in Body beside the same direction as a model gives it in Eci, and how well
/// the two should agree.
#[derive(Debug, Clone, Copy)]
pub struct Observation<T: RealField + Copy = f32> {
    body: Direction<Body, T>,
    eci: Direction<Eci, T>,
    sigma_rad: T,
}

/// Why a pair is no observation; the caller goes on without it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum ObservationError {
    /// A component of a vector is NaN or infinite.
    NotFinite(Side),
    /// A vector is too short to have a direction: the fourth power of the machine epsilon, 2e-28
    /// in f32, or less.
    ZeroLength(Side),
    /// The standard deviation is not positive, not finite, or its square does not fit in the
    /// floating-point type (f32: 1e-14 to 7e13 rad are taken).
    Sigma,
}

/// Which vector of a pair.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Side {
    /// The measured one, in Body.
    Body,
    /// The reference, in Eci.
    Eci,
}

impl fmt::Display for ObservationError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotFinite(side) => write!(f, "the {side} vector is not finite"),
            Self::ZeroLength(side) => write!(f, "the {side} vector has no direction"),
            Self::Sigma => write!(f, "the standard deviation is not a usable positive number"),
        }
    }
}

impl fmt::Display for Side {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Body => "measured",
            Self::Eci => "reference",
        })
    }
}

impl core::error::Error for ObservationError {}

impl<T: RealField + Copy> Observation<T> {
    /// Accepts a pair: two vectors of any length and unit, of which only the directions are used.
    ///
    /// `sigma_rad` is the standard deviation of the angle between the two about each axis across
    /// the line of sight, rad (1-σ): errors of sensor, mounting and reference together.
    ///
    /// # Errors
    /// [`ObservationError`] when a vector has no direction or `sigma_rad` is no standard deviation.
    pub fn new(
        body: Vector<Body, T>,
        eci: Vector<Eci, T>,
        sigma_rad: T,
    ) -> Result<Self, ObservationError> {
        let variance = sigma_rad * sigma_rad;
        // A NaN fails all comparisons.
        let usable = sigma_rad > T::zero()
            && variance >= negligible()
            && variance * negligible() <= T::one();
        if !usable {
            return Err(ObservationError::Sigma);
        }
        Ok(Self { body: direction(body, Side::Body)?, eci: direction(eci, Side::Eci)?, sigma_rad })
    }

    /// The measured direction.
    pub fn body(&self) -> Direction<Body, T> {
        self.body
    }

    /// The reference direction.
    pub fn eci(&self) -> Direction<Eci, T> {
        self.eci
    }

    /// Standard deviation about each axis across the line of sight, rad.
    pub fn sigma_rad(&self) -> T {
        self.sigma_rad
    }

    /// `(b, r)`: the two unit vectors without their frames.
    pub(super) fn units(&self) -> (Vector3<T>, Vector3<T>) {
        (self.body.vector().xyz, self.eci.vector().xyz)
    }
}

/// The direction of `v`, whose components are first brought to order one: a norm squares them, and
/// what is short of the type's range before need not be after.
fn direction<F, T: RealField + Copy>(
    v: Vector<F, T>,
    side: Side,
) -> Result<Direction<F, T>, ObservationError> {
    if !v.is_finite() {
        return Err(ObservationError::NotFinite(side));
    }
    let largest = v.xyz.amax();
    if largest <= negligible() {
        return Err(ObservationError::ZeroLength(side));
    }
    // The norm of the scaled vector is between 1 and √3.
    let scaled = v.xyz / largest;
    Ok(Direction::from_unit(Vector::from_xyz(scaled / scaled.norm())))
}

/// ε⁴: 2e-28 in f32, 2e-63 in f64.
fn negligible<T: RealField + Copy>() -> T {
    let epsilon_squared = T::default_epsilon() * T::default_epsilon();
    epsilon_squared * epsilon_squared
}

#[cfg(test)]
mod tests {
    use super::*;

    fn with_body(x: f32) -> Result<Observation, ObservationError> {
        Observation::new(Vector::new(x, 0.0, 0.0), Vector::new(0.0, 1.0, 0.0), 0.01)
    }

    #[test]
    fn only_the_direction_counts_whatever_the_unit() {
        for length in [1e-20, 3e-5, 1.0, 45_000.0, f32::MAX] {
            let units = with_body(length).unwrap().units();
            assert_eq!(units, (Vector3::x(), Vector3::y()), "{length}");
        }
    }

    #[test]
    fn vectors_without_a_direction_are_refused_with_their_side() {
        for (bad, error) in [
            (f32::NAN, ObservationError::NotFinite(Side::Body)),
            (f32::NEG_INFINITY, ObservationError::NotFinite(Side::Body)),
            (0.0, ObservationError::ZeroLength(Side::Body)),
            (f32::MIN_POSITIVE, ObservationError::ZeroLength(Side::Body)),
        ] {
            assert_eq!(with_body(bad).unwrap_err(), error);
        }
        let no_reference = Observation::new(Vector::new(1.0, 0.0, 0.0), Vector::zero(), 0.01);
        assert_eq!(no_reference.unwrap_err(), ObservationError::ZeroLength(Side::Eci));
    }

    #[test]
    fn a_standard_deviation_is_positive_and_its_square_a_number() {
        let x: Vector<Body> = Vector::new(1.0, 0.0, 0.0);
        for bad in [0.0, -0.01, f32::NAN, f32::INFINITY, 1e-20, 1e20] {
            let refused = Observation::new(x, x.relabel(), bad);
            assert_eq!(refused.unwrap_err(), ObservationError::Sigma, "{bad}");
        }
        for good in [1e-12, 1e-6, 0.05, 3.0] {
            assert!(Observation::new(x, x.relabel(), good).is_ok());
        }
    }
}
