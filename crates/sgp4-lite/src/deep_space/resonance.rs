//! Orbits whose period is a day or half a day: the Earth's tesseral harmonics pull at them in step,
//! so their mean motion has to be integrated.
//!
//! | symbol | code | meaning |
//! |---|---|---|
//! | λ | `longitude` | resonance angle: λ = M + Ω + ω − Θ (day), M + 2Ω − 2Θ (half a day) |
//! | n, ṅ, n̈ | `mean_motion`, … | rad/min, rad/min², rad/min³ |
//! | λ̇ | `longitude_rate` | n + the rate of λ at n = 0 |
//! | Θ | | Greenwich sidereal time |
//!
//! The integration is Euler–Maclaurin with fixed steps of 720 minutes from the epoch, as in the
//! source: other steps would give other results.
//!
//! Source: Hoots & Roehrich, Spacetrack Report No. 3, section 10 (subroutine DEEP).

use super::geopotential::{HalfDay, Harmonic, Synchronous};
use crate::angle::SinCos;

/// Step of the integration, minutes.
const STEP_MIN: f64 = 720.0;

/// Furthest time from the epoch that the integration goes to: 20 Julian years, 14,610 steps.
pub(super) const MAX_MINUTES: f64 = 20.0 * 365.25 * 1440.0;

/// Where the integration of a resonant orbit stands, to go on from there.
///
/// [`Propagator::propagate`](crate::Propagator::propagate) integrates from the epoch on every call.
/// When times follow each other,
/// [`Propagator::propagate_resumed`](crate::Propagator::propagate_resumed) with one `ResonanceState`
/// for each propagator does the same with the few steps in between, and gives the same bits.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ResonanceState {
    node: Option<Node>,
}

/// The solution at one step of the integration.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Node {
    /// The orbit it belongs to.
    start: Start,
    minutes: f64,
    longitude: f64,
    mean_motion: f64,
}

/// The solution at the epoch, and the rate of λ at n = 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Start {
    pub longitude: f64,
    pub mean_motion: f64,
    pub longitude_rate_without_n: f64,
}

/// The argument of perigee, as the integration sees it: by the zonal harmonics alone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct PerigeeMotion {
    pub at_epoch: f64,
    pub rate: f64,
}

/// Which resonance, with its harmonics.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Pull {
    Synchronous(Synchronous),
    HalfDay(HalfDay, PerigeeMotion),
}

/// A resonant orbit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Resonance {
    pub start: Start,
    pub pull: Pull,
}

/// Mean motion and resonance angle at one time.
pub(super) struct Resonant {
    pub mean_motion: f64,
    pub longitude: f64,
}

/// λ̇, ṅ and n̈ at a step.
struct Derivatives {
    longitude: f64,
    mean_motion: f64,
    mean_motion_second: f64,
}

impl Resonance {
    /// The solution at `t` minutes from the epoch, for |t| up to [`MAX_MINUTES`], going on from
    /// `resume` where that lies on the way, and leaving the last step there.
    pub fn at(&self, t: f64, resume: &mut ResonanceState) -> Resonant {
        let mut node = match resume.node {
            Some(node) if node.start == self.start && lies_between_epoch_and(t, node.minutes) => {
                node
            }
            _ => Node {
                start: self.start,
                minutes: 0.0,
                longitude: self.start.longitude,
                mean_motion: self.start.mean_motion,
            },
        };
        let step = STEP_MIN.copysign(t);
        let mut rates = self.derivatives(&node);
        // At most 14,610 times, because |t| is limited.
        while (t - node.minutes).abs() >= STEP_MIN {
            self.advance(&mut node, &rates, step);
            node.minutes += step;
            rates = self.derivatives(&node);
        }
        resume.node = Some(node);
        let beyond = t - node.minutes;
        self.advance(&mut node, &rates, beyond);
        Resonant { mean_motion: node.mean_motion, longitude: node.longitude }
    }

    /// λ += λ̇δ + ½ṅδ², n += ṅδ + ½n̈δ²
    fn advance(&self, node: &mut Node, rates: &Derivatives, delta: f64) {
        let half_delta2 = 0.5 * delta * delta;
        node.longitude += rates.longitude * delta + rates.mean_motion * half_delta2;
        node.mean_motion += rates.mean_motion * delta + rates.mean_motion_second * half_delta2;
    }

    fn derivatives(&self, node: &Node) -> Derivatives {
        let l = SinCos::of(node.longitude);
        let mut sum = Sum::default();
        match &self.pull {
            Pull::Synchronous(pull) => {
                let l2 = l.plus(l);
                sum.add(&pull.once, 1.0, l);
                sum.add(&pull.twice, 2.0, l2);
                sum.add(&pull.thrice, 3.0, l2.plus(l));
            }
            Pull::HalfDay(pull, perigee) => {
                let w = SinCos::of(perigee.at_epoch + perigee.rate * node.minutes);
                let minus_w = SinCos { sin: -w.sin, cos: w.cos };
                let l_plus_w = l.plus(w);
                let l2 = l.plus(l);
                sum.add(&pull.l, 1.0, l);
                sum.add(&pull.l_plus_w, 1.0, l_plus_w);
                sum.add(&pull.l_minus_w, 1.0, l.plus(minus_w));
                sum.add(&pull.l_plus_2w, 1.0, l_plus_w.plus(w));
                sum.add(&pull.l2, 2.0, l2);
                sum.add(&pull.l2_plus_w, 2.0, l2.plus(w));
                sum.add(&pull.l2_minus_w, 2.0, l2.plus(minus_w));
                sum.add(&pull.l2_plus_2w, 2.0, l_plus_w.plus(l_plus_w));
            }
        }
        let longitude = node.mean_motion + self.start.longitude_rate_without_n;
        Derivatives { longitude, mean_motion: sum.pull, mean_motion_second: sum.slope * longitude }
    }
}

/// Sum of harmonics, and its derivative with respect to λ.
#[derive(Default)]
struct Sum {
    pull: f64,
    slope: f64,
}

impl Sum {
    /// A sin α + B cos α, for an angle α that holds λ `multiple` times.
    fn add(&mut self, harmonic: &Harmonic, multiple: f64, alpha: SinCos) {
        self.pull += harmonic.sin * alpha.sin + harmonic.cos * alpha.cos;
        self.slope += multiple * (harmonic.sin * alpha.cos - harmonic.cos * alpha.sin);
    }
}

/// Whether a step at `minutes` is passed on the way from the epoch to `t`.
fn lies_between_epoch_and(t: f64, minutes: f64) -> bool {
    minutes * t >= 0.0 && minutes.abs() <= t.abs()
}
