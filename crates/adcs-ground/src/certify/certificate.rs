//! The result as a file, and whether a mission is within it.

use adcs_app::LawParameters;
use serde::{Deserialize, Serialize};

use sgp4_lite::Elements;

use super::grid::{Body, Place, altitude_km};

/// One point of the grid.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Entry {
    /// Inclination, deg.
    pub inclination_deg: f64,
    /// Height, km.
    pub altitude_km: f64,
    /// Quarters of a year after the mission's epoch.
    pub season: u8,
    /// Moments of inertia in shares of what the law is told.
    pub moments: [f64; 3],
    /// What an error is multiplied by each orbit.
    pub multiplier: f64,
}

impl Entry {
    /// The multiplier of a point.
    pub fn new(place: &Place, body: &Body, multiplier: f64) -> Self {
        let Place { inclination_deg, altitude_km, season } = *place;
        Self { inclination_deg, altitude_km, season, moments: body.moments, multiplier }
    }
}

/// The multipliers of a law over a grid.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Certificate {
    /// The mission it was made for.
    pub mission: String,
    /// The law with all its numbers.
    pub law: LawParameters,
    /// Torquers on and off, s.
    pub on_off_s: [f32; 2],
    /// The largest multiplier that passes.
    pub limit: f64,
    /// All points.
    pub entries: Vec<Entry>,
}

impl Certificate {
    /// The largest multiplier.
    pub fn worst(&self) -> Option<&Entry> {
        self.entries.iter().max_by(|a, b| a.multiplier.total_cmp(&b.multiplier))
    }

    /// Whether every point passes.
    pub fn holds(&self) -> bool {
        !self.entries.is_empty() && self.entries.iter().all(|entry| entry.multiplier < self.limit)
    }

    /// What of a flight is not covered, in words; empty when all of it is.
    pub fn gaps(
        &self,
        law: &LawParameters,
        on_off_s: [f32; 2],
        elements: &Elements,
    ) -> Vec<String> {
        let (inclination_deg, altitude_km) = (elements.inclination_deg, altitude_km(elements));
        let mut gaps = Vec::new();
        if !self.holds() {
            gaps.push("the certificate itself does not hold: a multiplier is too large".to_owned());
        }
        if *law != self.law {
            gaps.push(format!("the law or its gains are not those certified for {}", self.mission));
        }
        if on_off_s != self.on_off_s {
            let [on, off] = self.on_off_s;
            gaps.push(format!("the schedule is not the certified one, {on} s on and {off} s off"));
        }
        let mut within = |name: &str, found: f64, of: fn(&Entry) -> f64, unit: &str| {
            let (low, high) = self
                .entries
                .iter()
                .map(of)
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
                    (low.min(value), high.max(value))
                });
            if !(low..=high).contains(&found) {
                gaps.push(format!(
                    "the {name}, {found:.1} {unit}, is outside the certified {low:.1} to {high:.1}"
                ));
            }
        };
        within("inclination", inclination_deg, |entry| entry.inclination_deg, "deg");
        within("altitude", altitude_km, |entry| entry.altitude_km, "km");
        gaps
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn certificate(multiplier: f64) -> Certificate {
        let entry = |inclination_deg, altitude_km| Entry {
            inclination_deg,
            altitude_km,
            season: 0,
            moments: [1.0; 3],
            multiplier,
        };
        Certificate {
            mission: "nadir".to_owned(),
            law: LawParameters::Off,
            on_off_s: [5.0, 2.5],
            limit: 0.9,
            entries: vec![entry(40.0, 400.0), entry(98.0, 800.0)],
        }
    }

    #[test]
    fn a_flight_within_the_grid_and_with_the_same_law_is_covered() {
        let sprout = crate::study::sprout::elements().unwrap();
        let gaps = |it: &Certificate, on, inclination_deg, altitude_km| {
            let place = Place { inclination_deg, altitude_km, season: 0 };
            let elements = place.elements(&sprout).unwrap();
            it.gaps(&LawParameters::Off, [on, 2.5], &elements).len()
        };
        let good = certificate(0.3);
        assert!(good.holds());
        assert_eq!(gaps(&good, 5.0, 97.9, 620.0), 0);
        assert_eq!(gaps(&good, 10.0, 97.9, 620.0), 1, "another schedule");
        assert_eq!(gaps(&good, 5.0, 10.0, 620.0), 1, "another inclination");
        assert_eq!(gaps(&good, 5.0, 10.0, 1200.0), 2, "and another altitude");
        let bad = certificate(1.01);
        assert!(!bad.holds());
        assert_eq!(gaps(&bad, 5.0, 97.9, 620.0), 1);
        assert_eq!(bad.worst().map(|it| it.multiplier), Some(1.01));
    }
}
