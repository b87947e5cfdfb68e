//! Over many satellites.

use adcs_core::commissioning::Rung;

use super::super::despin::{quantile, share};
use super::climb::Climbed;
use super::quantity::{Found, Quantity};

/// A satellite whose mean angle is beyond this has lost its attitude, deg.
const LOST_DEG: f64 = 30.0;

/// How a quantity's σ holds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coverage {
    /// How many numbers were found.
    pub count: usize,
    /// Share of truths inside the reported 2 σ.
    pub inside: f64,
    /// Root mean square of error over σ: 1 when σ is what it should be.
    pub ratio: f64,
    /// Mean of error over σ: 0 without a bias.
    pub mean: f64,
    /// Root mean square of the error.
    pub rms: f64,
    /// Largest error.
    pub worst: f64,
}

/// Many satellites.
#[derive(Debug, Clone)]
pub struct Summary {
    satellites: Vec<Climbed>,
}

impl Summary {
    /// Of these.
    pub fn new(satellites: Vec<Climbed>) -> Self {
        Self { satellites }
    }

    /// They.
    pub fn satellites(&self) -> &[Climbed] {
        &self.satellites
    }

    /// How a quantity's σ holds.
    pub fn coverage(&self, quantity: Quantity) -> Coverage {
        let found = self.satellites.iter().flat_map(|it| &it.found);
        let all: Vec<&Found> = found.filter(|it| it.quantity == quantity).collect();
        let count = all.len();
        let mean =
            |of: &dyn Fn(&Found) -> f64| all.iter().map(|it| of(it)).sum::<f64>() / count as f64;
        Coverage {
            count,
            inside: share(all.iter().map(|it| it.is_inside())),
            ratio: mean(&|it| (it.error / it.sigma).powi(2)).sqrt(),
            mean: mean(&|it| it.error / it.sigma),
            rms: mean(&|it| it.error * it.error).sqrt(),
            worst: all.iter().map(|it| it.error.abs()).fold(0.0, f64::max),
        }
    }

    /// Share of satellites that passed a rung, and the median of when it ended, s.
    pub fn rung(&self, rung: Rung) -> (f64, f64) {
        let ended = || self.satellites.iter().flat_map(|it| &it.rungs).filter(|it| it.rung == rung);
        let passed = self.satellites.iter().map(|it| it.findings.passed(rung));
        (share(passed), quantile(ended().map(|it| it.at_s).collect(), 0.5))
    }

    /// Share of satellites below a rate two or three orbits after the commit.
    pub fn below(&self, rate_rad_s: f64, orbits: usize) -> f64 {
        let rates =
            self.satellites.iter().filter_map(|it| it.after.rate_rad_s.get(orbits - 2)?.as_ref());
        share(rates.map(|rate| *rate < rate_rad_s))
    }

    /// Mean and 95 % of the angle to the Orbit frame, deg, and the worst satellite's mean.
    pub fn pointing_deg(&self) -> (f64, f64, f64) {
        let all =
            || self.satellites.iter().flat_map(|it| &it.after.angles_deg).map(|&it| f64::from(it));
        let mean = all().sum::<f64>() / all().count() as f64;
        let worst = self.satellites.iter().map(mean_deg).fold(0.0, f64::max);
        (mean, quantile(all().collect(), 0.95), worst)
    }

    /// How many have lost their attitude.
    pub fn lost(&self) -> usize {
        self.satellites.iter().filter(|it| mean_deg(it) > LOST_DEG).count()
    }
}

/// Mean angle of a satellite, deg.
fn mean_deg(of: &Climbed) -> f64 {
    let angles = &of.after.angles_deg;
    angles.iter().map(|&angle| f64::from(angle)).sum::<f64>() / angles.len() as f64
}
