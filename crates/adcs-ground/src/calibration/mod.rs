//! A magnetometer's calibration on the ground: from a table to parameters for the satellite.

mod chart;
mod input;
mod models;
mod naming;
mod outcome;

use std::fmt;

use adcs_core::calibration::{
    CalibrationError, DataSheet, Evidence, MIN_SAMPLES, Parameters, Start,
};
use nalgebra::SVector;

pub use chart::{angle_chart, chart};
pub use input::{Columns, Currents, Measured};
pub use naming::Naming;
pub use outcome::{Correction, Coupling, Judged, Outcome, Range};

/// Most unknowns that a fit has: nine, and three for each of six currents.
const MAX_UNKNOWNS: usize = 27;

/// Which errors are looked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Model {
    /// Scale and bias of each axis.
    Paper,
    /// Angles between the axes too.
    Nine,
    /// The same nine by TWOSTEP.
    TwoStep,
    /// What currents nearby do, too.
    Coupled,
    /// What the data ask for.
    Auto,
}

/// What is asked.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Request<'a> {
    /// Which errors are looked for.
    pub model: Model,
    /// Where searches begin, nT/V and V. The solution with the least cost is taken: E has more minima
    /// than one, and a start far away may end in a wrong one.
    pub starts: &'a [Start<f64>],
    /// What the data sheet says: the readings before the calibration.
    pub before: DataSheet<f64>,
    /// What the satellite's driver turns voltages into field by.
    pub driver: DataSheet<f64>,
    /// Whether to compute in f32, as the satellite does.
    pub single: bool,
    /// Whether to take out the shift that noise makes in |B|².
    pub unbiased: bool,
    /// The currents that the table has.
    pub currents: Currents,
    /// Whether axes that are found wired otherwise are put right.
    pub apply_signs: bool,
    /// The satellite's tensor, for the naming of axes.
    pub inertia_kg_m2: [[f64; 3]; 3],
}

/// Why there is no calibration.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Unsolved {
    /// What the samples do not support.
    Calibration(CalibrationError),
    /// Couplings were asked for, and there are no currents.
    NoCurrents,
}

impl fmt::Display for Unsolved {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Calibration(error) => error.fmt(f),
            Self::NoCurrents => {
                write!(f, "--model coupled needs columns current_1_a, current_2_a, …, or a history")
            }
        }
    }
}

impl std::error::Error for Unsolved {}

impl From<CalibrationError> for Unsolved {
    fn from(error: CalibrationError) -> Self {
        Self::Calibration(error)
    }
}

/// What one model found, in f64 whichever precision it was found in.
#[derive(Debug, Clone, PartialEq)]
struct Fit {
    /// In the order of [`Parameters`].
    unknowns: Vec<f64>,
    sigma: Vec<f64>,
    cost: f64,
    condition: Option<f64>,
    samples: u32,
    iterations: Option<u32>,
    evidence: Evidence,
}

impl Fit {
    fn parameters(&self) -> Parameters<f64, MAX_UNKNOWNS> {
        padded(&self.unknowns)
    }

    fn sigmas(&self) -> Parameters<f64, MAX_UNKNOWNS> {
        padded(&self.sigma)
    }

    /// The calibrated field, nT.
    fn field(&self, measured: &Measured) -> [f64; 3] {
        self.parameters().field(measured.sample.reading, &measured.currents)
    }
}

fn padded(values: &[f64]) -> Parameters<f64, MAX_UNKNOWNS> {
    let mut all = SVector::<f64, MAX_UNKNOWNS>::zeros();
    all.iter_mut().zip(values).for_each(|(to, &from)| *to = from);
    Parameters(all)
}

/// Calibrates.
///
/// # Errors
/// What the samples do not support, as the first search says it, when none ends well.
pub fn solve(measured: &[Measured], request: &Request<'_>) -> Result<Outcome, Unsolved> {
    let settled: Vec<Measured> = measured.iter().copied().filter(|one| one.settled).collect();
    let (name, used, fit, judged) = match request.model {
        Model::Paper => one("paper", &settled, models::extended::<0, 6>(&settled, request)?),
        Model::Nine => one("nine", &settled, models::extended::<0, 9>(&settled, request)?),
        Model::TwoStep => one("twostep", &settled, models::by_twostep(&settled, request)?),
        Model::Coupled => one("coupled", measured, coupled(measured, request)?),
        Model::Auto => by_evidence(&settled, request)?,
    };
    let naming = naming::name(measured, &fit, request.currents.unsettle, request.inertia_kg_m2);
    Ok(Outcome::new(name, used, request, fit, judged, naming))
}

type Chosen<'a> = (&'static str, &'a [Measured], Fit, Vec<Judged>);

fn one<'a>(name: &'static str, used: &'a [Measured], fit: Fit) -> Chosen<'a> {
    let judged = vec![Judged::of(name, &fit.evidence)];
    (name, used, fit, judged)
}

/// The smallest model that no larger one beats.
fn by_evidence<'a>(settled: &'a [Measured], request: &Request<'_>) -> Result<Chosen<'a>, Unsolved> {
    let mut chosen = one("paper", settled, models::extended::<0, 6>(settled, request)?);
    let nine = models::extended::<0, 9>(settled, request).map_err(Unsolved::from);
    let mut larger = vec![("nine", nine)];
    // A history's currents flow in rows that the others cannot use: it is no fair comparison.
    if !request.currents.unsettle && !request.currents.names.is_empty() {
        larger.push(("coupled", coupled(settled, request)));
    }
    // A model that the data cannot support is not what they ask for.
    for (name, fit) in larger.into_iter().filter_map(|(name, fit)| Some((name, fit.ok()?))) {
        chosen.3.push(Judged::of(name, &fit.evidence));
        if fit.evidence.beats(&chosen.2.evidence) {
            chosen = (name, settled, fit, chosen.3);
        }
    }
    Ok(chosen)
}

fn coupled(measured: &[Measured], request: &Request<'_>) -> Result<Fit, Unsolved> {
    let fit = match request.currents.names.len() {
        1 => models::extended::<1, 12>(measured, request),
        2 => models::extended::<2, 15>(measured, request),
        3 => models::extended::<3, 18>(measured, request),
        4 => models::extended::<4, 21>(measured, request),
        5 => models::extended::<5, 24>(measured, request),
        6 => models::extended::<6, 27>(measured, request),
        _ => return Err(Unsolved::NoCurrents),
    };
    Ok(fit?)
}

/// The solution with the least cost: the first of those that are equal but for rounding.
fn least(
    searches: impl Iterator<Item = Result<Fit, CalibrationError>>,
) -> Result<Fit, CalibrationError> {
    /// Above what f32 makes of one minimum, far below what parts two.
    const CLEARLY_LESS: f64 = 0.999;
    searches
        .reduce(|best, next| match (&best, &next) {
            (Ok(a), Ok(b)) if b.cost < a.cost * CLEARLY_LESS => next,
            (Err(_), Ok(_)) => next,
            _ => best,
        })
        .unwrap_or(Err(CalibrationError::TooFew { found: 0, needed: MIN_SAMPLES }))
}
