//! Sunlight that the Earth sends back, as a satellite sees it: patches of its disc.
//!
//! The disc of angular radius ρ, sin ρ = R/r, is cut into `RINGS` rings of equal solid angle and
//! each into `SECTORS` sectors. In direction u, at the angle η from nadir, a patch stands for the
//! ground at
//!
//! d = r cos η − √(R² − r² sin² η),  n = (r + d u)/R
//!
//! and a ground that scatters evenly to all sides (Lambert) sends
//!
//! E/E_Sun = (a/π) max(n · ŝ, 0) ΔΩ
//!
//! to a plate that faces it. Summed over the disc for a high Sun this is a (R/r)², the view factor
//! of a sphere.
//!
//! | symbol | code | meaning |
//! |---|---|---|
//! | a | `albedo` | part of the sunlight that the ground sends back |
//! | R | `EARTH_RADIUS_M` | of a spherical Earth |
//! | r | `position` | of the satellite from the centre |
//! | ŝ | `to_sun` | direction of the Sun |
//! | ΔΩ | `solid_angle_sr` | of a patch |
//!
//! Source of the radiance of a Lambertian ground and the sum over patches: Bhanderi & Bak (2005),
//! "Modeling Earth albedo for satellites in Earth orbit". One albedo stands for all ground: 0.3, the
//! Earth's mean (0.29 by Stephens et al. (2015), Rev. Geophys. 53); clouds reach 0.8.

use core::f64::consts::{PI, TAU};

use adcs_core::environment::geodetic::EQUATORIAL_RADIUS_M as EARTH_RADIUS_M;
use adcs_core::frames::{Direction, Eci, Vector};

/// Rings of the disc.
const RINGS: usize = 4;
/// Sectors of each ring.
const SECTORS: usize = 8;
/// Patches of the disc, 20 deg across from low orbit.
pub const PATCHES: usize = RINGS * SECTORS;

/// A patch of the sunlit Earth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Patch {
    /// Where it is, a unit vector.
    pub towards: Vector<Eci, f64>,
    /// What it gives to a plate that faces it, as a fraction of the Sun's irradiance.
    pub irradiance: f64,
}

/// The light of the Earth at `position` (Eci, m), dark patches included.
pub fn patches(
    position: Vector<Eci, f64>,
    to_sun: Direction<Eci, f64>,
    albedo: f64,
) -> [Patch; PATCHES] {
    let dark = Patch { towards: Vector::zero(), irradiance: 0.0 };
    let mut patches = [dark; PATCHES];
    let distance_m = position.norm().max(EARTH_RADIUS_M);
    let Some([nadir, across, along]) = axes(position) else { return patches };
    let sin_rho = EARTH_RADIUS_M / distance_m;
    let cos_rho = libm::sqrt(1.0 - sin_rho * sin_rho);
    let solid_angle_sr = TAU * (1.0 - cos_rho) / PATCHES as f64;
    for (index, patch) in patches.iter_mut().enumerate() {
        // The middles of ring and sector; equal steps of cos η are equal solid angles.
        let ring = ((index / SECTORS) as f64 + 0.5) / RINGS as f64;
        let sector = ((index % SECTORS) as f64 + 0.5) / SECTORS as f64;
        let cos_eta = 1.0 - ring * (1.0 - cos_rho);
        let sin_eta = libm::sqrt(1.0 - cos_eta * cos_eta);
        let (sin_phi, cos_phi) = libm::sincos(TAU * sector);
        let towards = nadir * cos_eta + (across * cos_phi + along * sin_phi) * sin_eta;
        let half_chord_2 = EARTH_RADIUS_M * EARTH_RADIUS_M - libm::pow(distance_m * sin_eta, 2.0);
        let range_m = distance_m * cos_eta - libm::sqrt(half_chord_2.max(0.0));
        let normal = (nadir * -distance_m + towards * range_m) * (1.0 / EARTH_RADIUS_M);
        let cos_zenith = normal.dot(&to_sun.vector()).max(0.0);
        *patch = Patch { towards, irradiance: albedo / PI * cos_zenith * solid_angle_sr };
    }
    patches
}

/// Nadir and two directions across it.
fn axes(position: Vector<Eci, f64>) -> Option<[Vector<Eci, f64>; 3]> {
    let nadir = (-position).direction()?.vector();
    // An axis that is far from parallel.
    let other = if nadir.xyz.z.abs() < 0.7 { [0.0, 0.0, 1.0] } else { [1.0, 0.0, 0.0] };
    let [x, y, z] = other;
    let across = nadir.cross(&Vector::new(x, y, z)).direction()?.vector();
    Some([nadir, across, nadir.cross(&across)])
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALTITUDE_M: f64 = 615e3;
    const ALBEDO: f64 = 0.3;

    fn seen(position: [f64; 3], to_sun: [f64; 3]) -> [Patch; PATCHES] {
        let vector = |[x, y, z]: [f64; 3]| Vector::new(x, y, z);
        patches(vector(position), vector(to_sun).direction().unwrap(), ALBEDO)
    }

    fn over_noon() -> [Patch; PATCHES] {
        seen([0.0, EARTH_RADIUS_M + ALTITUDE_M, 0.0], [0.0, 1.0, 0.0])
    }

    #[test]
    fn a_plate_that_faces_the_earth_gets_the_view_factor_of_a_sphere() {
        // Were the whole ground lit from straight above: a (R/r)². Coarse patches miss it by some
        // parts in a thousand.
        const COARSE: f64 = 0.01;
        let cos_rho =
            libm::sqrt(1.0 - libm::pow(EARTH_RADIUS_M / (EARTH_RADIUS_M + ALTITUDE_M), 2.0));
        let each = ALBEDO / PI * TAU * (1.0 - cos_rho) / PATCHES as f64;
        let sum: f64 = over_noon().iter().map(|p| each * -p.towards.xyz.y).sum();
        let expected = ALBEDO * libm::pow(EARTH_RADIUS_M / (EARTH_RADIUS_M + ALTITUDE_M), 2.0);
        assert!((sum / expected - 1.0).abs() < COARSE, "{sum} {expected}");
    }

    #[test]
    fn over_noon_the_earth_gives_a_fifth_to_a_quarter_of_the_sun() {
        let sum: f64 = over_noon().iter().map(|p| p.irradiance * -p.towards.xyz.y).sum();
        assert!((0.2..0.25).contains(&sum), "{sum}");
    }

    #[test]
    fn over_midnight_it_gives_nothing_and_at_the_terminator_half_of_it_does() {
        let night = seen([0.0, 7e6, 0.0], [0.0, -1.0, 0.0]);
        assert!(night.iter().all(|patch| patch.irradiance == 0.0));
        let terminator = seen([0.0, 7e6, 0.0], [1.0, 0.0, 0.0]);
        let lit = terminator.iter().filter(|patch| patch.irradiance > 0.0);
        assert!(lit.clone().count() == PATCHES / 2, "{}", lit.count());
        assert!(terminator.iter().all(|p| (p.irradiance > 0.0) == (p.towards.xyz.x > 0.0)));
    }

    #[test]
    fn all_patches_are_on_the_disc_and_point_to_the_ground() {
        let patches = over_noon();
        let sin_rho = EARTH_RADIUS_M / (EARTH_RADIUS_M + ALTITUDE_M);
        for patch in patches {
            assert!((patch.towards.norm() - 1.0).abs() < 1e-14);
            let sin_eta = libm::hypot(patch.towards.xyz.x, patch.towards.xyz.z);
            assert!(sin_eta < sin_rho && patch.towards.xyz.y < 0.0);
        }
    }
}
