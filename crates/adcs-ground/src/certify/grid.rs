//! Orbits, seasons and bodies.

use sgp4_lite::{Elements, Epoch};

/// Days between the seasons.
const QUARTER_DAYS: i32 = 91;

/// One orbit at one time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    /// Inclination, deg.
    pub inclination_deg: f64,
    /// Height above the equator's radius, km.
    pub altitude_km: f64,
    /// Quarters of a year after the mission's epoch.
    pub season: u8,
}

/// How the true body differs from what the law is told: principal moments in shares of themselves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Body {
    /// Of x, y, z.
    pub moments: [f64; 3],
}

/// Everything that is tried.
#[derive(Debug, Clone, PartialEq)]
pub struct Grid {
    /// Inclinations, deg.
    pub inclinations_deg: Vec<f64>,
    /// Heights, km.
    pub altitudes_km: Vec<f64>,
    /// Seasons, quarters of a year.
    pub seasons: Vec<u8>,
    /// Largest error of a moment of inertia, as a share of itself.
    pub inertia: f64,
}

impl Grid {
    /// Each orbit at each season, inclination by inclination.
    pub fn places(&self) -> Vec<Place> {
        let mut places = Vec::new();
        for &inclination_deg in &self.inclinations_deg {
            for &altitude_km in &self.altitudes_km {
                for &season in &self.seasons {
                    places.push(Place { inclination_deg, altitude_km, season });
                }
            }
        }
        places
    }

    /// The body as it is told, and each moment once larger and once smaller.
    pub fn bodies(&self) -> Vec<Body> {
        let mut bodies = vec![Body { moments: [1.0; 3] }];
        for axis in 0..3 {
            for sign in [1.0, -1.0] {
                let mut moments = [1.0; 3];
                moments[axis] += sign * self.inertia;
                bodies.push(Body { moments });
            }
        }
        bodies
    }
}

impl Place {
    /// A nearly circular orbit there; the rest as in `like`.
    pub fn elements(&self, like: &Elements) -> Option<Elements> {
        let day = like.epoch.days_since_j2000_midnight() + QUARTER_DAYS * i32::from(self.season);
        Some(Elements {
            epoch: Epoch::from_days(day, like.epoch.micros_of_day())?,
            bstar_per_earth_radius: 0.0,
            inclination_deg: self.inclination_deg,
            eccentricity: 0.001,
            mean_motion_rev_per_day: mean_motion_rev_per_day(self.altitude_km),
            ..*like
        })
    }
}

/// WGS72, as SGP4 has it.
const MU_KM3_S2: f64 = 398_600.8;
const RADIUS_KM: f64 = 6378.135;
const DAY_S: f64 = 86_400.0;

/// Kepler's third law.
fn mean_motion_rev_per_day(altitude_km: f64) -> f64 {
    let radius = RADIUS_KM + altitude_km;
    (MU_KM3_S2 / (radius * radius * radius)).sqrt() * DAY_S / core::f64::consts::TAU
}

/// Height of an orbit of this mean motion, km.
pub(super) fn altitude_km(elements: &Elements) -> f64 {
    let rate = elements.mean_motion_rev_per_day * core::f64::consts::TAU / DAY_S;
    (MU_KM3_S2 / (rate * rate)).cbrt() - RADIUS_KM
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sprout_flies_some_620_km_high_and_heights_come_back() {
        let sprout = crate::study::sprout::elements().unwrap();
        assert!((altitude_km(&sprout) - 620.0).abs() < 15.0, "{}", altitude_km(&sprout));
        let place = Place { inclination_deg: 51.6, altitude_km: 417.0, season: 1 };
        assert!((altitude_km(&place.elements(&sprout).unwrap()) - 417.0).abs() < 1e-6);
    }
}
