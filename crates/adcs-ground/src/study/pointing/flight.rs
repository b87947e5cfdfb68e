//! One flight.

use adcs_core::orbit::OrbitState;
use adcs_core::orbit::frame::OrbitFrame;
use adcs_core::schedule::Phase;
use anyhow::{Context as _, Result};

use super::super::closed_loop::{ClosedLoop, Truth};
use super::super::sprout::ORBIT_S;
use super::case::{Case, Knowledge};
use super::knowing::Knowing;

/// Figures count from here on, orbits.
pub const SETTLED_ORBITS: f64 = 2.0;
/// A satellite that stays within this is captured, deg.
pub const CAPTURED_DEG: f64 = 10.0;

/// What a flight comes to.
#[derive(Debug, Clone, PartialEq)]
pub struct Flown {
    /// Total angle to the Orbit frame once a round, from the third orbit on, deg.
    pub angles_deg: Vec<f32>,
    /// Since when it has been captured, orbits; `None` when it was not at the end.
    pub captured_orbits: Option<f64>,
}

impl Flown {
    /// Mean angle, deg.
    pub fn mean_deg(&self) -> f64 {
        let sum: f64 = self.angles_deg.iter().map(|&angle| f64::from(angle)).sum();
        sum / self.angles_deg.len() as f64
    }
}

/// Flies number `seed` of a case for `orbits`.
///
/// # Errors
/// When the orbit or the field model ends, which those of the cases do not.
pub fn fly(case: &Case, orbits: f64, seed: u64) -> Result<Flown> {
    let mut flight = ClosedLoop::new(&case.conditions, &case.parameters()?, seed)?;
    let configuration = flight.configuration().clone();
    let mut knowing = Knowing::default();
    let end_s = orbits * ORBIT_S;
    let (mut angles_deg, mut last_far_s) = (Vec::new(), 0.0);
    let mut t_s = 0.0;
    while t_s < end_s {
        let moment = match case.knowledge {
            Knowledge::Filters => flight.step()?,
            other => flight.step_with(|moment| knowing.decide(&configuration, other, moment))?,
        };
        t_s = moment.truth.t_s;
        if moment.phase != Phase::Measuring {
            continue;
        }
        let angle = angle_deg(&moment.truth)?;
        if angle >= CAPTURED_DEG {
            last_far_s = t_s;
        }
        if t_s >= SETTLED_ORBITS * ORBIT_S {
            angles_deg.push(angle as f32);
        }
    }
    let captured_orbits = (last_far_s < t_s - 60.0).then_some(last_far_s / ORBIT_S);
    Ok(Flown { angles_deg, captured_orbits })
}

/// Total angle from Body to the Orbit frame, deg.
pub(in super::super) fn angle_deg(truth: &Truth) -> Result<f64> {
    let orbit = OrbitState { position: truth.position, velocity: truth.velocity };
    let frame = OrbitFrame::of(&orbit).context("the orbit has no plane")?;
    Ok((truth.r_bi * frame.r_oi.inverse()).angle_rad().to_degrees())
}
