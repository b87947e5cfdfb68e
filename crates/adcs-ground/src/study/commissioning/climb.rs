//! One satellite on the ladder, and afterwards.

use adcs_core::commissioning::{Findings, Outcome, Rung};
use adcs_core::modes::{Mode, Transition};
use adcs_core::schedule::Phase;
use anyhow::Result;

use super::super::closed_loop::ClosedLoop;
use super::super::pointing::flight::angle_deg;
use super::super::sprout::ORBIT_S;
use super::quantity::{Found, found};
use super::satellites::{World, parameters};

/// No ladder takes longer, s: all its rungs to their limits.
const LONGEST_CLIMB_S: f64 = 40_000.0;
/// How long it flies afterwards, orbits, and from when on the pointing counts.
const AFTER_ORBITS: f64 = 8.0;
const SETTLED_ORBITS: f64 = 4.0;

/// A rung that is over.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ended {
    /// Which.
    pub rung: Rung,
    /// How.
    pub outcome: Outcome,
    /// When, s.
    pub at_s: f64,
}

/// One satellite.
#[derive(Debug, Clone, PartialEq)]
pub struct Climbed {
    /// Rung by rung.
    pub rungs: Vec<Ended>,
    /// Every number that was found and passed its gate.
    pub found: Vec<Found>,
    /// What was reported.
    pub findings: Findings,
    /// What it did with it.
    pub after: After,
}

/// What a satellite does with what it found.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct After {
    /// Rate two and three orbits after the commit, rad/s.
    pub rate_rad_s: [Option<f64>; 2],
    /// Total angle to the Orbit frame once a round, from the fifth orbit after it on, deg.
    pub angles_deg: Vec<f32>,
    /// Transitions of the modes.
    pub transitions: Vec<(f64, Transition)>,
}

/// Flies number `seed`; with `afterwards`, for eight orbits more.
///
/// # Errors
/// When the orbit or the field model ends.
pub fn fly(world: World, afterwards: bool, seed: u64) -> Result<Climbed> {
    let told = parameters()?;
    let mut flight = ClosedLoop::new(&world.conditions(), &told, seed)?;
    let (mut rungs, mut numbers) = (Vec::new(), Vec::new());
    let mut after = After::default();
    let mut over_s = None;
    loop {
        let moment = flight.step()?;
        let t_s = moment.truth.t_s;
        if let Some(transition) = moment.thoughts.mode.and_then(|report| report.transition) {
            after.transitions.push((t_s, transition));
        }
        let report = moment.thoughts.commissioning;
        if let Some(ended) = report.and_then(|report| report.ended) {
            rungs.push(Ended { rung: ended.rung, outcome: ended.outcome, at_s: t_s });
            if let Some(finding) = ended.finding.filter(|_| ended.outcome.passed()) {
                numbers.extend(found(&finding, &flight, &moment.truth));
            }
        }
        let left = moment.thoughts.mode.is_none_or(|report| report.mode != Mode::Commissioning);
        if over_s.is_none() && (left || t_s > LONGEST_CLIMB_S) {
            over_s = Some(t_s);
            flight.commit(&told.committed(flight.state().findings()))?;
        }
        let Some(over_s) = over_s else { continue };
        let since = (t_s - over_s) / ORBIT_S;
        if !afterwards || since >= AFTER_ORBITS {
            break;
        }
        for (slot, orbits) in after.rate_rad_s.iter_mut().zip([2.0, 3.0]) {
            if slot.is_none() && since >= orbits {
                *slot = Some(moment.truth.omega_bi.norm());
            }
        }
        if since >= SETTLED_ORBITS && moment.phase == Phase::Measuring {
            after.angles_deg.push(angle_deg(&moment.truth)? as f32);
        }
    }
    let findings = *flight.state().findings();
    Ok(Climbed { rungs, found: numbers, findings, after })
}
