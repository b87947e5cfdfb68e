//! The field at geocentric spherical and at geodetic positions.

use crate::many::{self, BLOCK, Block};
use crate::{Coefficients, Error, Real};

/// Semi-major axis of the WGS84 ellipsoid, km (NIMA TR8350.2, table 3.1).
const WGS84_SEMI_MAJOR_AXIS_KM: f64 = 6378.137;
/// Flattening of the WGS84 ellipsoid (NIMA TR8350.2, table 3.1).
const WGS84_FLATTENING: f64 = 1.0 / 298.257_223_563;
/// e² = f (2 − f).
const WGS84_ECCENTRICITY_SQUARED: f64 = WGS84_FLATTENING * (2.0 - WGS84_FLATTENING);

/// A position in geocentric spherical coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct GeocentricPosition<T> {
    /// Distance from the Earth's centre, km.
    pub radius_km: T,
    /// Angle θ from the north pole, 0 … π, rad.
    pub colatitude_rad: T,
    /// Longitude φ, positive eastwards, any finite value, rad.
    pub longitude_rad: T,
}

/// The field along the unit vectors of geocentric spherical coordinates, nT.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct GeocentricField<T> {
    /// Away from the Earth's centre, nT.
    pub radial_nt: T,
    /// Along growing colatitude (southwards), nT.
    pub theta_nt: T,
    /// Along growing longitude (eastwards), nT.
    pub phi_nt: T,
}

/// A position over the WGS84 ellipsoid.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct GeodeticPosition<T> {
    /// Geodetic latitude, −π/2 … π/2, rad.
    pub latitude_rad: T,
    /// Longitude, positive eastwards, any finite value, rad.
    pub longitude_rad: T,
    /// Height above the ellipsoid, km.
    pub height_km: T,
}

/// The field in the local axes of a geodetic position, nT.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct GeodeticField<T> {
    /// Along the meridian towards the north pole, nT.
    pub north_nt: T,
    /// Eastwards, nT.
    pub east_nt: T,
    /// Along the inward normal of the ellipsoid, nT.
    pub down_nt: T,
}

impl<T: Real> Coefficients<T> {
    /// The field along the geocentric spherical unit vectors (r, θ, φ).
    ///
    /// At the poles θ and φ are the limits along the given meridian.
    ///
    /// # Errors
    /// [`Error::NotFinite`], [`Error::Colatitude`], [`Error::Radius`].
    pub fn field_geocentric_nt(
        &self,
        position: GeocentricPosition<T>,
    ) -> Result<GeocentricField<T>, Error> {
        let GeocentricPosition { radius_km, colatitude_rad, longitude_rad } = position;
        require_finite([radius_km, colatitude_rad, longitude_rad])?;
        if !(T::ZERO..=T::PI).contains(&colatitude_rad) {
            return Err(Error::Colatitude { colatitude_rad: colatitude_rad.to_f64() });
        }
        if radius_km < T::ZERO {
            return Err(Error::Radius { radius_km: radius_km.to_f64() });
        }
        let (sin_theta, cos_theta) = colatitude_rad.sin_cos();
        let meridian = Meridian::at(longitude_rad);
        let from_axis = radius_km * sin_theta;
        let field_nt = self.field_ecef_nt(meridian.position(from_axis, radius_km * cos_theta))?;
        let [outward, east, along_axis] = meridian.cylindrical(field_nt);
        Ok(GeocentricField {
            radial_nt: sin_theta * outward + cos_theta * along_axis,
            theta_nt: cos_theta * outward - sin_theta * along_axis,
            phi_nt: east,
        })
    }

    /// The field north, east and down at a position over the WGS84 ellipsoid.
    ///
    /// At the poles north and east are the limits along the given meridian.
    ///
    /// # Errors
    /// [`Error::NotFinite`], [`Error::Latitude`], [`Error::Radius`].
    pub fn field_geodetic_nt(
        &self,
        position: GeodeticPosition<T>,
    ) -> Result<GeodeticField<T>, Error> {
        let place = GeodeticPlace::new(position)?;
        self.field_ecef_nt(place.position_km).map(|field_nt| place.local(field_nt))
    }

    /// [`Coefficients::field_geodetic_nt`] at each of many positions, in their order and to the
    /// bit; the rest is said at [`Coefficients::fields_ecef_nt`].
    pub fn fields_geodetic_nt<I>(
        &self,
        positions: I,
    ) -> impl Iterator<Item = Result<GeodeticField<T>, Error>> + use<'_, T, I>
    where
        I: IntoIterator<Item = GeodeticPosition<T>>,
    {
        many::in_blocks(positions, |block| self.geodetic_block_nt(block))
    }

    fn geodetic_block_nt(
        &self,
        block: Block<GeodeticPosition<T>>,
    ) -> Block<Result<GeodeticField<T>, Error>> {
        let places = block.map(GeodeticPlace::new);
        // Where a position is refused already, the field at the centre is, and is not looked at.
        let mut positions_km = [[T::ZERO; 3]; BLOCK];
        for (position_km, place) in positions_km.iter_mut().zip(&places) {
            if let Ok(place) = place {
                *position_km = place.position_km;
            }
        }
        let mut fields = [Err(Error::NotFinite); BLOCK];
        for ((field, place), field_nt) in
            fields.iter_mut().zip(places).zip(self.block_nt(positions_km))
        {
            *field = place.and_then(|place| Ok(place.local(field_nt?)));
        }
        fields
    }
}

/// A position over the ellipsoid, Earth fixed, and the axes there.
#[derive(Clone, Copy)]
struct GeodeticPlace<T> {
    position_km: [T; 3],
    meridian: Meridian<T>,
    sin_phi: T,
    cos_phi: T,
}

impl<T: Real> GeodeticPlace<T> {
    #[inline(always)]
    fn new(position: GeodeticPosition<T>) -> Result<Self, Error> {
        let GeodeticPosition { latitude_rad, longitude_rad, height_km } = position;
        require_finite([latitude_rad, longitude_rad, height_km])?;
        if !(-T::HALF_PI..=T::HALF_PI).contains(&latitude_rad) {
            return Err(Error::Latitude { latitude_rad: latitude_rad.to_f64() });
        }
        let (sin_phi, cos_phi) = latitude_rad.sin_cos();
        let meridian = Meridian::at(longitude_rad);
        // Radius of curvature in the prime vertical, N = a / √(1 − e² sin² φ).
        let e2 = T::from_f64(WGS84_ECCENTRICITY_SQUARED);
        let prime_vertical_km =
            T::from_f64(WGS84_SEMI_MAJOR_AXIS_KM) / (T::ONE - e2 * sin_phi * sin_phi).sqrt();
        let from_axis = (prime_vertical_km + height_km) * cos_phi;
        let along_axis = ((T::ONE - e2) * prime_vertical_km + height_km) * sin_phi;
        let position_km = meridian.position(from_axis, along_axis);
        Ok(Self { position_km, meridian, sin_phi, cos_phi })
    }

    /// North, east and down of an Earth-fixed field.
    #[inline(always)]
    fn local(&self, field_nt: [T; 3]) -> GeodeticField<T> {
        let [outward, east, along_axis] = self.meridian.cylindrical(field_nt);
        let Self { sin_phi, cos_phi, .. } = *self;
        GeodeticField {
            north_nt: cos_phi * along_axis - sin_phi * outward,
            east_nt: east,
            down_nt: -(cos_phi * outward + sin_phi * along_axis),
        }
    }
}

/// The half plane of one longitude. It has a direction at the poles too, which is what makes
/// the local axes there well defined.
#[derive(Clone, Copy)]
struct Meridian<T> {
    sin: T,
    cos: T,
}

impl<T: Real> Meridian<T> {
    fn at(longitude_rad: T) -> Self {
        let (sin, cos) = longitude_rad.sin_cos();
        Self { sin, cos }
    }

    /// Earth-fixed position from the distance to the axis and the coordinate along it.
    fn position(&self, from_axis: T, along_axis: T) -> [T; 3] {
        [from_axis * self.cos, from_axis * self.sin, along_axis]
    }

    /// Earth-fixed components to: away from the axis, east, along the axis.
    fn cylindrical(&self, [x, y, z]: [T; 3]) -> [T; 3] {
        [x * self.cos + y * self.sin, y * self.cos - x * self.sin, z]
    }
}

fn require_finite<T: Real>(coordinates: [T; 3]) -> Result<(), Error> {
    if coordinates.into_iter().all(T::is_finite) { Ok(()) } else { Err(Error::NotFinite) }
}
