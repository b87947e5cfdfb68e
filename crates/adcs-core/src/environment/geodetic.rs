//! Latitude, longitude and height over the WGS84 ellipsoid.

use core::fmt;

use crate::frames::{Ecef, Vector};

/// Equatorial radius of WGS84, m (NIMA TR8350.2, table 3.1).
pub const EQUATORIAL_RADIUS_M: f64 = 6_378_137.0;
/// Flattening of WGS84 (NIMA TR8350.2, table 3.1).
pub const FLATTENING: f64 = 1.0 / 298.257_223_563;
/// Polar radius, b = a (1 − f), m.
pub const POLAR_RADIUS_M: f64 = EQUATORIAL_RADIUS_M * (1.0 - FLATTENING);

/// First eccentricity squared, e² = f (2 − f).
const ECCENTRICITY_SQUARED: f64 = FLATTENING * (2.0 - FLATTENING);
/// Second eccentricity squared, e'² = e² / (1 − e²).
const SECOND_ECCENTRICITY_SQUARED: f64 = ECCENTRICITY_SQUARED / (1.0 - ECCENTRICITY_SQUARED);

/// Nearer to the Earth's centre than this a position is refused. Within 43 km (e² a, the evolute of
/// the ellipse) more than one point of the ellipsoid is vertically above; the iteration is exact to
/// rounding from here outwards.
pub const LEAST_RADIUS_M: f64 = 1_000e3;

/// A place given as on a map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Geodetic {
    /// Angle of the ellipsoid's normal to the equator, positive north, rad, −π/2 to π/2.
    pub latitude_rad: f64,
    /// From Greenwich, positive east, rad, −π to π. On the axis, where it has no meaning, 0 or ±π.
    pub longitude_east_rad: f64,
    /// Above the ellipsoid along its normal, m.
    pub height_m: f64,
}

/// Why a position has no geodetic coordinates.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum GeodeticError {
    /// A component is NaN or infinite.
    NotFinite,
    /// Nearer to the Earth's centre than [`LEAST_RADIUS_M`].
    NearCentre {
        /// Distance from the centre, m.
        radius_m: f64,
    },
}

impl fmt::Display for GeodeticError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotFinite => write!(f, "a component of the position is not finite"),
            Self::NearCentre { radius_m } => write!(
                f,
                "{radius_m} m from the Earth's centre, latitude is defined from {LEAST_RADIUS_M} m"
            ),
        }
    }
}

impl core::error::Error for GeodeticError {}

impl Geodetic {
    /// The Earth-fixed position, m.
    ///
    /// With N = a / √(1 − e² sin² φ):
    /// x, y = (N + h) cos φ (cos λ, sin λ), z = (N (1 − e²) + h) sin φ.
    pub fn position(&self) -> Vector<Ecef, f64> {
        let (sin_latitude, cos_latitude) = libm::sincos(self.latitude_rad);
        let (sin_longitude, cos_longitude) = libm::sincos(self.longitude_east_rad);
        let normal_m = EQUATORIAL_RADIUS_M
            / libm::sqrt(1.0 - ECCENTRICITY_SQUARED * sin_latitude * sin_latitude);
        let from_axis_m = (normal_m + self.height_m) * cos_latitude;
        Vector::new(
            from_axis_m * cos_longitude,
            from_axis_m * sin_longitude,
            (normal_m * (1.0 - ECCENTRICITY_SQUARED) + self.height_m) * sin_latitude,
        )
    }

    /// The geodetic coordinates of an Earth-fixed position (m).
    ///
    /// Bowring's iteration on the reduced latitude β, always three rounds (they gain four digits
    /// each near the surface), without trigonometric functions on the way:
    ///
    /// tan φ = (z + e'² b sin³ β) / (p − e² a cos³ β), tan β = (1 − f) tan φ
    ///
    /// | symbol | code | meaning |
    /// |---|---|---|
    /// | p, z | `p`, `z` | distance from the axis and above the equator |
    /// | β | `sin_beta`, `cos_beta` | reduced latitude |
    /// | φ | `above`, `out` | latitude, as the legs of its triangle |
    ///
    /// Source: B. R. Bowring, Survey Review 23 (181), 1976, and the starting value of 28 (218),
    /// 1985, which is good at all heights.
    ///
    /// # Errors
    /// [`GeodeticError`] for a position that is not finite or too near to the centre.
    pub fn from_position(position: Vector<Ecef, f64>) -> Result<Self, GeodeticError> {
        let [x, y, z] = position.to_array();
        let p = libm::hypot(x, y);
        let radius_m = libm::hypot(p, z);
        if !radius_m.is_finite() {
            return Err(GeodeticError::NotFinite);
        }
        if radius_m < LEAST_RADIUS_M {
            return Err(GeodeticError::NearCentre { radius_m });
        }
        let (sin_latitude, cos_latitude) = latitude_sine_cosine(p, z, radius_m);
        // h = p cos φ + z sin φ − a √(1 − e² sin² φ): of full precision at every latitude.
        let surface_m = EQUATORIAL_RADIUS_M
            * libm::sqrt(1.0 - ECCENTRICITY_SQUARED * sin_latitude * sin_latitude);
        Ok(Self {
            latitude_rad: libm::atan2(sin_latitude, cos_latitude),
            longitude_east_rad: libm::atan2(y, x),
            height_m: p * cos_latitude + z * sin_latitude - surface_m,
        })
    }
}

fn latitude_sine_cosine(p: f64, z: f64, radius_m: f64) -> (f64, f64) {
    const ROUNDS: usize = 3;
    let start = 1.0 + SECOND_ECCENTRICITY_SQUARED * POLAR_RADIUS_M / radius_m;
    let (mut above, mut out) = (z * start * (1.0 - FLATTENING), p / (1.0 - FLATTENING));
    for _ in 0..ROUNDS {
        let (sin_beta, cos_beta) = normalised((1.0 - FLATTENING) * above, out);
        above = z + SECOND_ECCENTRICITY_SQUARED * POLAR_RADIUS_M * sin_beta * sin_beta * sin_beta;
        out = p - ECCENTRICITY_SQUARED * EQUATORIAL_RADIUS_M * cos_beta * cos_beta * cos_beta;
    }
    normalised(above, out)
}

/// Sine and cosine of the angle with these legs, at least one of which is far from zero.
fn normalised(opposite: f64, adjacent: f64) -> (f64, f64) {
    let hypotenuse = libm::sqrt(opposite * opposite + adjacent * adjacent);
    (opposite / hypotenuse, adjacent / hypotenuse)
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::{FRAC_PI_2, PI};
    use proptest::prelude::*;

    /// The bars of the project: 1e-9 deg and 1e-6 km.
    const ANGLE_TOLERANCE_RAD: f64 = 1e-9 * PI / 180.0;
    const LENGTH_TOLERANCE_M: f64 = 1e-3;

    #[test]
    fn the_poles_and_the_equator_are_exact() {
        let up = |x, y, z| Geodetic::from_position(Vector::new(x, y, z)).unwrap();
        let north = up(0.0, 0.0, POLAR_RADIUS_M + 500e3);
        assert_eq!(north.latitude_rad, FRAC_PI_2);
        assert!((north.height_m - 500e3).abs() < 1e-8);
        let south = up(0.0, 0.0, -POLAR_RADIUS_M);
        assert_eq!((south.latitude_rad, south.height_m), (-FRAC_PI_2, 0.0));
        let equator = up(0.0, -EQUATORIAL_RADIUS_M, 0.0);
        assert_eq!(equator.latitude_rad, 0.0);
        assert_eq!(equator.longitude_east_rad, -FRAC_PI_2);
        assert_eq!(equator.height_m, 0.0);
    }

    #[test]
    fn the_centre_of_the_earth_and_nan_are_refused() {
        let refused = |x| Geodetic::from_position(Vector::new(x, 0.0, 0.0));
        assert_eq!(refused(0.0), Err(GeodeticError::NearCentre { radius_m: 0.0 }));
        assert_eq!(refused(999e3), Err(GeodeticError::NearCentre { radius_m: 999e3 }));
        assert_eq!(refused(f64::NAN), Err(GeodeticError::NotFinite));
        assert_eq!(refused(f64::INFINITY), Err(GeodeticError::NotFinite));
    }

    #[test]
    fn the_iteration_has_converged_at_medium_height() {
        // Evaluated in 50-digit arithmetic.
        const EXACT_LATITUDE_RAD: f64 = 61.250_838_475_977_53_f64 / 180.0 * PI;
        let far =
            Vector::new(2.480_819_389_648_710_5e6, -1.145_643_492_209_283_8e7, 2.132_952_355_3e7);
        let found = Geodetic::from_position(far).unwrap();
        assert!((found.latitude_rad - EXACT_LATITUDE_RAD).abs() < 1e-15);
        assert!((found.height_m - 17_976_589.445_509_324).abs() < 1e-8);
    }

    proptest! {
        #[test]
        fn coordinates_survive_the_way_to_the_position_and_back(
            latitude_rad in -FRAC_PI_2..FRAC_PI_2,
            longitude_east_rad in -PI..PI,
            // From deep inside the Earth to beyond the Moon, as many near as far.
            log_radius in libm::log(1_050e3)..libm::log(5e8),
        ) {
            let height_m = libm::exp(log_radius) - EQUATORIAL_RADIUS_M;
            let place = Geodetic { latitude_rad, longitude_east_rad, height_m };
            let found = Geodetic::from_position(place.position()).unwrap();
            prop_assert!((found.latitude_rad - latitude_rad).abs() < ANGLE_TOLERANCE_RAD);
            let turn = libm::remainder(found.longitude_east_rad - longitude_east_rad, 2.0 * PI);
            // Beside the pole a rounding of the position turns the longitude by any amount.
            prop_assert!(turn.abs() * libm::cos(latitude_rad) < ANGLE_TOLERANCE_RAD);
            prop_assert!((found.height_m - height_m).abs() < LENGTH_TOLERANCE_M);
        }
    }
}
