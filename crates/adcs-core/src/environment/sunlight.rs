//! The Sun as the satellite should see it: where, how bright, and how much of it.

use super::eclipse::{self, EarthShape};
use super::sun::ASTRONOMICAL_UNIT_M;
use crate::frames::{Direction, Eci, Vector};

/// The Sun from the satellite.
#[derive(Debug, Clone, Copy)]
pub struct Sunlight {
    /// Where it stands. Without an orbit as seen from the Earth's centre, 0.003 deg away at most.
    pub direction: Direction<Eci>,
    /// (1 au / r)²: 0.967 in July to 1.034 in January.
    pub irradiance: f32,
    /// Fraction of its disc that the Earth leaves free, 0 in the umbra to 1; `None` without an
    /// orbit.
    pub lit: Option<f32>,
}

impl Sunlight {
    /// The Sun at `sun_m`, seen from `satellite_m` (both from the Earth's centre, Eci, m). `None`
    /// when they are no two places.
    pub fn seen(sun_m: Vector<Eci, f64>, satellite_m: Option<Vector<Eci, f64>>) -> Option<Self> {
        let to_sun = sun_m - satellite_m.unwrap_or(Vector::zero());
        let direction = to_sun.to_f32().direction()?;
        let ratio = ASTRONOMICAL_UNIT_M / to_sun.norm();
        let lit_from =
            |satellite_m| eclipse::lit_fraction(satellite_m, sun_m, EarthShape::Ellipsoid);
        let lit = satellite_m.map(|satellite_m| lit_from(satellite_m) as f32);
        Some(Self { direction, irradiance: (ratio * ratio) as f32, lit })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sun(au: f64) -> Vector<Eci, f64> {
        Vector::new(ASTRONOMICAL_UNIT_M * au, 0.0, 0.0)
    }

    #[test]
    fn it_is_brighter_when_near_and_hidden_behind_the_earth() {
        let noon = Sunlight::seen(sun(0.9833), Some(Vector::new(7e6, 0.0, 0.0))).unwrap();
        assert!((noon.irradiance - 1.0343).abs() < 2e-4);
        assert_eq!(noon.lit, Some(1.0));
        let midnight = Sunlight::seen(sun(1.0), Some(Vector::new(-7e6, 0.0, 0.0))).unwrap();
        assert_eq!(midnight.lit, Some(0.0));
    }

    #[test]
    fn without_an_orbit_the_direction_is_that_from_the_earth() {
        let from_earth = Sunlight::seen(sun(1.0), None).unwrap();
        assert_eq!(from_earth.direction.vector(), Vector::new(1.0, 0.0, 0.0));
        assert_eq!(from_earth.lit, None);
        let side = Sunlight::seen(sun(1.0), Some(Vector::new(0.0, 7e6, 0.0))).unwrap();
        let apart = (side.direction.vector() - from_earth.direction.vector()).norm();
        assert!(apart.to_degrees() < 0.003, "{apart}");
    }

    #[test]
    fn a_sun_at_the_satellite_is_no_sun() {
        assert!(Sunlight::seen(sun(1.0), Some(sun(1.0))).is_none());
    }
}
