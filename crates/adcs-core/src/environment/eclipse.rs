//! The Earth's shadow: how much of the Sun's disc a satellite sees.
//!
//! ```text
//!   Sun                       Earth              penumbra: part of the disc is hidden
//!    ___                        _      _ _ _ _ - - - -
//!   /   \                     /   \  ─────────────────
//!   \___/                     \ _ /  ───────── umbra: all of it
//!                                    - - - - _ _ _ _
//! ```
//!
//! Seen from the satellite, Sun and Earth are two discs; everything follows from their angular
//! radii and the angle between their centres. Left out: the atmosphere, which makes the shadow
//! larger by some 10 km and its edge softer (seconds in low orbit), and the darkening of the Sun
//! towards its limb.

use core::f64::consts::{FRAC_PI_2, PI};

use nalgebra::Vector3;

use super::geodetic::{EQUATORIAL_RADIUS_M, FLATTENING};
use crate::frames::{Eci, Vector};

/// Nominal radius of the Sun, m (IAU 2015 Resolution B3).
pub const SUN_RADIUS_M: f64 = 695_700e3;

/// What casts the shadow.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum EarthShape {
    /// A sphere of the equatorial radius, 6378.137 km.
    Sphere,
    /// The ellipsoid WGS84, up to 21 km smaller: in a low polar orbit the satellite enters up to
    /// 7 s later and leaves as much earlier.
    #[default]
    Ellipsoid,
}

/// Which border of the shadow.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shadow {
    /// Some of the Sun's disc is hidden.
    Penumbra,
    /// All of the Sun's disc is hidden.
    Umbra,
    /// Behind the Earth for a Sun that is a point at infinity: the simple model, between the two.
    Cylinder,
}

/// Sun and Earth as discs in the satellite's sky.
///
/// | symbol | code | meaning |
/// |---|---|---|
/// | a | `sun_rad` | angular radius of the Sun, asin(R_Sun / distance) |
/// | b | `earth_rad` | angular radius of the Earth, asin(R_Earth / distance) |
/// | c | `separation_rad` | angle between the centres |
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Discs {
    /// a, rad.
    pub sun_rad: f64,
    /// b, rad; π/2 on the surface and below.
    pub earth_rad: f64,
    /// c, rad, 0 to π.
    pub separation_rad: f64,
}

impl Discs {
    /// What is seen from `satellite`, with the Sun's centre at `sun` (both from the Earth's centre,
    /// Eci, m, finite).
    pub fn seen_from(
        satellite: Vector<Eci, f64>,
        sun: Vector<Eci, f64>,
        shape: EarthShape,
    ) -> Self {
        let (satellite, sun) = (as_for_sphere(satellite, shape), as_for_sphere(sun, shape));
        let to_sun = sun - satellite;
        Self {
            sun_rad: angular_radius_rad(SUN_RADIUS_M, to_sun.norm()),
            earth_rad: angular_radius_rad(EQUATORIAL_RADIUS_M, satellite.norm()),
            separation_rad: angle_between_rad(&-satellite, &to_sun),
        }
    }

    /// The same for a Sun that is a point at infinity in the direction of `sun`.
    pub fn of_distant_point(
        satellite: Vector<Eci, f64>,
        sun: Vector<Eci, f64>,
        shape: EarthShape,
    ) -> Self {
        let (satellite, sun) = (as_for_sphere(satellite, shape), as_for_sphere(sun, shape));
        Self {
            sun_rad: 0.0,
            earth_rad: angular_radius_rad(EQUATORIAL_RADIUS_M, satellite.norm()),
            separation_rad: angle_between_rad(&-satellite, &sun),
        }
    }

    /// The part of the Sun's disc that is not hidden, 0 to 1.
    ///
    /// Two overlapping circles; with x = (c² + a² − b²) / 2c and y = √(a² − x²) the hidden area is
    ///
    /// A = a² acos(x / a) + b² acos((c − x) / b) − c y
    ///
    /// of π a². The discs are taken as flat, which changes the fraction by less than 0.001 in low
    /// orbit.
    ///
    /// Source: Montenbruck & Gill (2000), eqs (3.87), (3.92), (3.93).
    pub fn lit_fraction(&self) -> f64 {
        let Self { sun_rad: a, earth_rad: b, separation_rad: c } = *self;
        if c >= a + b {
            return 1.0;
        }
        if c <= b - a {
            return 0.0;
        }
        if c <= a - b {
            // The whole Earth stands before the Sun.
            return 1.0 - (b * b) / (a * a);
        }
        let x = (c * c + a * a - b * b) / (2.0 * c);
        let y = libm::sqrt((a * a - x * x).max(0.0));
        let hidden = a * a * arc_cosine_rad(x / a) + b * b * arc_cosine_rad((c - x) / b) - c * y;
        (1.0 - hidden / (PI * a * a)).clamp(0.0, 1.0)
    }
}

/// The part of the Sun's disc that lights the satellite, 0 (umbra) to 1.
///
/// | argument | meaning |
/// |---|---|
/// | `satellite`, `sun` | from the Earth's centre, Eci, m, finite |
/// | `shape` | what casts the shadow |
pub fn lit_fraction(satellite: Vector<Eci, f64>, sun: Vector<Eci, f64>, shape: EarthShape) -> f64 {
    Discs::seen_from(satellite, sun, shape).lit_fraction()
}

/// How far the satellite is from the border of the shadow, as an angle in its sky, rad: negative
/// inside. It is continuous and grows steadily across the border, so that the instant of crossing
/// can be searched ([`Crossings`](super::crossings::Crossings)).
///
/// Penumbra c − (b + a), umbra c − (b − a), with the symbols of [`Discs`].
pub fn shadow_margin_rad(
    shadow: Shadow,
    satellite: Vector<Eci, f64>,
    sun: Vector<Eci, f64>,
    shape: EarthShape,
) -> f64 {
    let discs = match shadow {
        Shadow::Penumbra | Shadow::Umbra => Discs::seen_from(satellite, sun, shape),
        Shadow::Cylinder => Discs::of_distant_point(satellite, sun, shape),
    };
    let Discs { sun_rad, earth_rad, separation_rad } = discs;
    match shadow {
        Shadow::Penumbra => separation_rad - (earth_rad + sun_rad),
        Shadow::Umbra | Shadow::Cylinder => separation_rad - (earth_rad - sun_rad),
    }
}

/// Space stretched along the Earth's axis until the ellipsoid is a sphere of the equatorial radius.
///
/// Straight lines stay straight and tangents stay tangents, so that a point of the Sun is hidden
/// after the stretch exactly when it was before. The Sun itself is stretched by 1/298 of its radius
/// too, which is not taken into account: 0.0009 deg, 0.015 s in low orbit.
fn as_for_sphere(position: Vector<Eci, f64>, shape: EarthShape) -> Vector3<f64> {
    let [x, y, z] = position.to_array();
    match shape {
        EarthShape::Sphere => Vector3::new(x, y, z),
        EarthShape::Ellipsoid => Vector3::new(x, y, z / (1.0 - FLATTENING)),
    }
}

fn angular_radius_rad(radius_m: f64, distance_m: f64) -> f64 {
    if distance_m <= radius_m { FRAC_PI_2 } else { libm::asin(radius_m / distance_m) }
}

/// Of full precision also for small and for flat angles.
fn angle_between_rad(a: &Vector3<f64>, b: &Vector3<f64>) -> f64 {
    libm::atan2(a.cross(b).norm(), a.dot(b))
}

fn arc_cosine_rad(cosine: f64) -> f64 {
    libm::acos(cosine.clamp(-1.0, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::environment::sun::ASTRONOMICAL_UNIT_M;
    use proptest::prelude::*;

    const SUN: [f64; 3] = [ASTRONOMICAL_UNIT_M, 0.0, 0.0];

    fn sun() -> Vector<Eci, f64> {
        Vector::new(SUN[0], SUN[1], SUN[2])
    }

    #[test]
    fn full_sun_before_the_earth_and_none_behind_it() {
        for shape in [EarthShape::Sphere, EarthShape::Ellipsoid] {
            assert_eq!(lit_fraction(Vector::new(7e6, 0.0, 0.0), sun(), shape), 1.0);
            assert_eq!(lit_fraction(Vector::new(-7e6, 0.0, 0.0), sun(), shape), 0.0);
            assert_eq!(lit_fraction(Vector::new(0.0, 7e6, 0.0), sun(), shape), 1.0);
        }
    }

    #[test]
    fn on_the_edge_of_the_cylinder_half_of_the_disc_is_seen() {
        /// The limb is not straight: it bulges over its chord by 0.21 a / b of the disc.
        const CURVATURE_OF_LIMB: f64 = 1e-3;
        // On the line from the Sun's centre over the limb.
        let rise_m = 2e6 * EQUATORIAL_RADIUS_M / ASTRONOMICAL_UNIT_M;
        let edge = Vector::new(-2e6, EQUATORIAL_RADIUS_M + rise_m, 0.0);
        let lit = lit_fraction(edge, sun(), EarthShape::Sphere);
        assert!((lit - 0.5).abs() < CURVATURE_OF_LIMB, "{lit}");
    }

    #[test]
    fn behind_the_tip_of_the_umbra_a_ring_of_the_sun_remains() {
        // The umbra ends some 1.38 million km behind the Earth.
        let far =
            |x_km: f64| lit_fraction(Vector::new(-x_km * 1e3, 0.0, 0.0), sun(), EarthShape::Sphere);
        assert_eq!(far(1.37e6), 0.0);
        let ring = far(2.0e6);
        let (a, b) = (SUN_RADIUS_M / (ASTRONOMICAL_UNIT_M + 2e9), EQUATORIAL_RADIUS_M / 2e9);
        assert!((ring - (1.0 - b * b / (a * a))).abs() < 1e-4, "{ring}");
    }

    #[test]
    fn below_the_surface_the_horizon_is_at_90_deg() {
        let inside = Discs::seen_from(Vector::new(1e6, 0.0, 0.0), sun(), EarthShape::Sphere);
        assert_eq!(inside.earth_rad, FRAC_PI_2);
        assert_eq!(inside.lit_fraction(), 1.0);
    }

    #[test]
    fn the_fraction_falls_steadily_through_the_penumbra() {
        let mut last = 1.0;
        let (mut partial, mut dark) = (0, 0);
        for step in 0..2_000 {
            let inwards =
                Vector::new(-2.5e6, EQUATORIAL_RADIUS_M + 20e3 - 20.0 * f64::from(step), 0.0);
            let lit = lit_fraction(inwards, sun(), EarthShape::Sphere);
            assert!(lit <= last, "at step {step}");
            partial += usize::from(lit > 0.0 && lit < 1.0);
            dark += usize::from(lit == 0.0);
            last = lit;
        }
        // 2.5e6 m × the Sun's diameter of 0.0093 rad = 23 km, in steps of 20 m.
        assert!((1_150..1_180).contains(&partial) && dark > 100, "{partial} {dark}");
    }

    proptest! {
        #[test]
        fn the_margins_and_the_fraction_agree(
            x in -4e7..4e7, y in -4e7..4e7, z in -4e7..4e7, oblate: bool,
        ) {
            let satellite = Vector::<Eci, f64>::new(x, y, z);
            prop_assume!(satellite.norm() > 6.4e6);
            let shape = if oblate { EarthShape::Ellipsoid } else { EarthShape::Sphere };
            let lit = lit_fraction(satellite, sun(), shape);
            let margin = |shadow| shadow_margin_rad(shadow, satellite, sun(), shape);
            prop_assert_eq!(margin(Shadow::Penumbra) >= 0.0, lit == 1.0);
            prop_assert_eq!(margin(Shadow::Umbra) <= 0.0, lit == 0.0);
            prop_assert!(margin(Shadow::Penumbra) <= margin(Shadow::Umbra));
        }

        /// The line from the satellite to a point at infinity meets the ellipsoid
        /// x²/a² + y²/a² + z²/b² = 1 ahead of the satellite: the quadratic has two roots.
        #[test]
        fn the_ellipsoid_hides_what_a_ray_cannot_pass(
            x in -1e7..1e7, y in -1e7..1e7, z in -1e7..1e7,
            sun_y in -1.0..1.0, sun_z in -0.45..0.45,
        ) {
            const POLAR_RADIUS_M: f64 = EQUATORIAL_RADIUS_M * (1.0 - FLATTENING);
            let satellite = Vector::<Eci, f64>::new(x, y, z);
            prop_assume!(satellite.norm() > 6.4e6);
            let sun = Vector::<Eci, f64>::new(1.0, sun_y, sun_z) * ASTRONOMICAL_UNIT_M;
            let weights = Vector3::new(EQUATORIAL_RADIUS_M, EQUATORIAL_RADIUS_M, POLAR_RADIUS_M);
            let r = satellite.xyz.component_div(&weights);
            let d = sun.xyz.component_div(&weights).normalize();
            let (b, c) = (r.dot(&d), r.norm_squared() - 1.0);
            let discriminant = b * b - c;
            // Rounding decides within a millimetre of the limb.
            prop_assume!(discriminant.abs() > 1e-9);
            let hidden = b < 0.0 && discriminant > 0.0;
            let margin = shadow_margin_rad(Shadow::Cylinder, satellite, sun, EarthShape::Ellipsoid);
            prop_assert_eq!(margin < 0.0, hidden);
        }
    }
}
