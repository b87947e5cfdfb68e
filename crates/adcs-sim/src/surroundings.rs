//! Where the satellite really is and what surrounds it there.

use adcs_core::environment::eclipse::{self, EarthShape};
use adcs_core::environment::field::FieldModel;
use adcs_core::environment::sun::ApparentSun;
use adcs_core::frames::{Eci, Vector};
use adcs_core::orbit::OrbitModel;
use adcs_core::time::{LeapSeconds, Utc};
use sgp4_lite::Elements;

use crate::fly::FlightError;

/// Orbit, field and Sun at one instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Surroundings {
    /// Position, Eci, m.
    pub position: Vector<Eci, f64>,
    /// Velocity, Eci, m/s.
    pub velocity: Vector<Eci, f64>,
    /// Geomagnetic field, Eci, T.
    pub field_t: Vector<Eci, f64>,
}

/// The Sun as it stands for a while.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sunlight {
    /// From the satellite to the Sun, Eci, m.
    pub to_sun: Vector<Eci, f64>,
    /// Fraction of the Sun's disc in sight, 0 to 1.
    pub lit: f64,
}

impl Sunlight {
    /// The direction to the Sun, a unit vector.
    pub fn direction(&self) -> Vector<Eci, f64> {
        // The Sun is never where the satellite is.
        self.to_sun.direction().map_or(Vector::zero(), |direction| direction.vector())
    }
}

/// The models of the truth: SGP4 and IGRF in f64, evaluated at every instant that is asked for.
#[derive(Debug, Clone)]
pub struct Nature {
    orbit: OrbitModel,
    field: FieldModel<f64>,
}

impl Nature {
    /// The orbit of `elements` and the field of the day of `start`.
    ///
    /// # Errors
    /// Elements that SGP4 refuses, or a date outside the field model.
    pub fn new(elements: &Elements, start: Utc) -> Result<Self, FlightError> {
        Ok(Self {
            orbit: OrbitModel::new(elements).map_err(FlightError::Orbit)?,
            field: FieldModel::new(start).map_err(FlightError::Field)?,
        })
    }

    /// Orbit and field at `now`.
    ///
    /// # Errors
    /// An orbit that decays, a date outside the field model.
    pub fn at(&mut self, now: Utc) -> Result<Surroundings, FlightError> {
        let orbit = self.orbit.state(now).map_err(FlightError::Orbit)?;
        let field_t = self.field.eci_t(now, orbit.position).map_err(FlightError::Field)?;
        Ok(Surroundings { position: orbit.position, velocity: orbit.velocity, field_t })
    }

    /// The Sun at `now`, as seen from `position` (Eci, m).
    ///
    /// # Errors
    /// A date before leap seconds.
    pub fn sunlight(&self, now: Utc, position: Vector<Eci, f64>) -> Result<Sunlight, FlightError> {
        let tt = now.to_tt(&LeapSeconds::BUILT_IN).map_err(FlightError::Time)?;
        let sun = ApparentSun::at(tt).position_eci_m();
        let lit = eclipse::lit_fraction(position, sun, EarthShape::Ellipsoid);
        Ok(Sunlight { to_sun: sun - position, lit })
    }
}
