//! Despin from hundreds of random starts: how far, how fast, how many.

use adcs_app::parameters::{FlightParameters, LawParameters};
use adcs_core::pipeline::SteeringParameters;
use anyhow::Result;

use super::closed_loop::{ClosedLoop, Conditions, StartingRate, b_dot, dynamic_filter, sprout};
use super::sprout::{DEG, InertiaError, ORBIT_S};

/// The paper's despin lasted so long, s.
pub const EXPERIMENT_S: f64 = 1200.0;
/// The residual dipole is fed forward from this σ of each axis on, A·m²: a twentieth of it.
const FEED_FORWARD_SIGMA_AM2: f32 = 0.02;

/// What is done about the tumble.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Despin {
    /// Nothing.
    Off,
    /// B-dot, and nothing known of the residual dipole.
    Uncorrected,
    /// B-dot with the dynamics-aided filter, which finds the residual dipole on the way, and its
    /// feed-forward.
    Estimated,
}

impl Despin {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Off, Self::Uncorrected, Self::Estimated];

    /// What it is called on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Off => "off",
            Self::Uncorrected => "uncorrected",
            Self::Estimated => "estimated",
        }
    }

    /// How long it is flown, s.
    fn length_s(self) -> f64 {
        match self {
            Self::Off => EXPERIMENT_S,
            Self::Uncorrected | Self::Estimated => 3.0 * ORBIT_S,
        }
    }

    fn flight(self) -> Result<FlightParameters> {
        let steering = SteeringParameters { cut_hold: true, ..SteeringParameters::default() };
        let b_dot = FlightParameters { steering, ..sprout(b_dot())? };
        Ok(match self {
            Self::Off => sprout(LawParameters::Off)?,
            Self::Uncorrected => b_dot,
            Self::Estimated => dynamic_filter(&b_dot, FEED_FORWARD_SIGMA_AM2),
        })
    }
}

/// What is true: rates to (8, 8, 12) deg/s, moments and products of inertia within 20 % of the drawing's
/// (products of the mean moment), anywhere within two days, the paper's sensors.
pub fn conditions() -> Conditions {
    Conditions {
        rate: StartingRate::Within([8.0 * DEG, 8.0 * DEG, 12.0 * DEG]),
        start_in_sunlight: false,
        inertia: InertiaError::Within(0.20),
        ..Conditions::default()
    }
}

/// One flight.
#[derive(Debug, Clone, Copy)]
pub struct Outcome {
    /// Rate at the start, rad/s.
    pub start_rad_s: f64,
    /// Rate after 1200 s over that at the start.
    pub ratio: f64,
    /// Energy then over that at the start.
    pub energy: f64,
    /// Rate after one, two and three orbits, rad/s; not flown with torquers off.
    pub after_orbits_rad_s: [Option<f64>; 3],
}

/// Flies number `seed`.
///
/// # Errors
/// When the orbit or the field model ends.
pub fn fly(despin: Despin, seed: u64) -> Result<Outcome> {
    let flight = despin.flight()?;
    let cycle_s = f64::from(flight.cycle_us) * 1e-6;
    let mut closed_loop = ClosedLoop::new(&conditions(), &flight, seed)?;
    let first = closed_loop.step()?.truth;
    let start_rad_s = first.omega_bi.norm();
    let (mut ratio, mut energy, mut after_orbits_rad_s) = (f64::NAN, f64::NAN, [None; 3]);
    let cycle_at = |t_s: f64| (t_s / cycle_s).round() as u32;
    let experiment = cycle_at(EXPERIMENT_S);
    let orbits = [1.0, 2.0, 3.0].map(|orbits| cycle_at(orbits * ORBIT_S));
    for cycle in 1..=cycle_at(despin.length_s()) {
        let truth = closed_loop.step()?.truth;
        let rate = truth.omega_bi.norm();
        if cycle == experiment {
            ratio = rate / start_rad_s;
            energy = truth.kinetic_energy_j / first.kinetic_energy_j;
        }
        if let Some(orbit) = orbits.iter().position(|at| *at == cycle) {
            after_orbits_rad_s[orbit] = Some(rate);
        }
    }
    Ok(Outcome { start_rad_s, ratio, energy, after_orbits_rad_s })
}

/// What many flights come to.
#[derive(Debug, Clone)]
pub struct Summary {
    flights: Vec<Outcome>,
}

impl Summary {
    /// Of these flights.
    pub fn new(flights: Vec<Outcome>) -> Self {
        Self { flights }
    }

    /// The flights.
    pub fn flights(&self) -> &[Outcome] {
        &self.flights
    }

    /// Median of the ratio of rates at 1200 s.
    pub fn median_ratio(&self) -> f64 {
        quantile(self.flights.iter().map(|it| it.ratio).collect(), 0.5)
    }

    /// Share of flights with less energy at 1200 s than at the start.
    pub fn energy_fell(&self) -> f64 {
        share(self.flights.iter().map(|it| it.energy < 1.0))
    }

    /// Share of flights below a rate after 1, 2 or 3 orbits; NaN when not flown.
    pub fn below(&self, rate_deg_s: f64, orbits: usize) -> f64 {
        share(self.rates(orbits).into_iter().map(|rate| rate < rate_deg_s * DEG))
    }

    /// Quantile of the rate after 1, 2 or 3 orbits, deg/s; NaN when not flown.
    pub fn rate_deg_s(&self, quantile_of: f64, orbits: usize) -> f64 {
        quantile(self.rates(orbits), quantile_of) / DEG
    }

    fn rates(&self, orbits: usize) -> Vec<f64> {
        let rate = |it: &Outcome| it.after_orbits_rad_s.get(orbits - 1).copied().flatten();
        self.flights.iter().filter_map(rate).collect()
    }
}

/// The share of those that are true; NaN of none.
pub fn share(of: impl Iterator<Item = bool>) -> f64 {
    let (mut yes, mut all) = (0_u32, 0_u32);
    for it in of {
        yes += u32::from(it);
        all += 1;
    }
    f64::from(yes) / f64::from(all)
}

/// The smallest value that this share of them does not exceed; NaN of none.
pub fn quantile(mut values: Vec<f64>, share: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    let last = values.len().saturating_sub(1);
    let at = ((values.len() as f64 * share).ceil() as usize).saturating_sub(1).min(last);
    values.get(at).copied().unwrap_or(f64::NAN)
}
