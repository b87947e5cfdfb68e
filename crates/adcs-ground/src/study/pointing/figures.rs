//! Angles pooled over flights.

use super::flight::Flown;

/// A flight whose mean is above this has lost its attitude, deg.
pub const LOST_DEG: f64 = 30.0;

/// What the flights of a case come to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Figures {
    /// Flights.
    pub flights: usize,
    /// Mean of all angles, deg.
    pub mean_deg: f64,
    /// 95 % of all angles are below this, deg.
    pub p95_deg: f64,
    /// Largest mean of a flight, deg.
    pub worst_mean_deg: f64,
    /// Flights that are lost.
    pub lost: usize,
    /// Flights captured within one orbit and within two.
    pub captured: [usize; 2],
}

impl Figures {
    /// Of these flights; `None` when nothing was flown long enough.
    pub fn of(flights: &[Flown]) -> Option<Self> {
        let mut all: Vec<f32> =
            flights.iter().flat_map(|it| it.angles_deg.iter().copied()).collect();
        all.sort_by(f32::total_cmp);
        let p95 = *all.get((0.95 * all.len() as f64) as usize)?;
        let means: Vec<f64> = flights.iter().map(Flown::mean_deg).collect();
        let captured = [1.0, 2.0].map(|orbits| {
            let within = |it: &&Flown| it.captured_orbits.is_some_and(|since| since <= orbits);
            flights.iter().filter(within).count()
        });
        Some(Self {
            flights: flights.len(),
            mean_deg: all.iter().map(|&angle| f64::from(angle)).sum::<f64>() / all.len() as f64,
            p95_deg: f64::from(p95),
            worst_mean_deg: means.iter().copied().fold(0.0, f64::max),
            lost: means.iter().filter(|&&mean| mean > LOST_DEG).count(),
            captured,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_are_pooled_and_flights_counted() {
        let flown =
            |angle: f32, captured_orbits| Flown { angles_deg: vec![angle; 50], captured_orbits };
        let flights = [flown(1.0, Some(0.4)), flown(3.0, Some(1.5)), flown(80.0, None)];
        let figures = Figures::of(&flights).unwrap();
        assert_eq!(figures.mean_deg, 28.0);
        assert_eq!(figures.p95_deg, 80.0);
        assert_eq!((figures.worst_mean_deg, figures.lost), (80.0, 1));
        assert_eq!(figures.captured, [1, 2]);
        assert_eq!(Figures::of(&[]), None);
    }
}
