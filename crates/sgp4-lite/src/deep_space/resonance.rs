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
    held: Option<Held>,
}

/// A step of the integration, and the first one, which tells whose it is.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Held {
    at_epoch: Step,
    last: Step,
}

/// The solution at one step of the integration, and its derivatives there.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Step {
    minutes: f64,
    solution: Solution,
    rates: Derivatives,
}

/// Mean motion and resonance angle at one time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Solution {
    pub longitude: f64,
    pub mean_motion: f64,
}

/// λ̇, ṅ and n̈ at a step.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Derivatives {
    longitude: f64,
    mean_motion: f64,
    mean_motion_second: f64,
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

/// The pull that changes n, and the rate of λ at n = 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Motion {
    pub pull: Pull,
    pub longitude_rate_without_n: f64,
}

/// A resonant orbit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Resonance {
    motion: Motion,
    at_epoch: Step,
}

impl Resonance {
    pub fn new(at_epoch: Solution, motion: Motion) -> Self {
        Self { motion, at_epoch: motion.step(0.0, at_epoch) }
    }

    pub fn pull(&self) -> &Pull {
        &self.motion.pull
    }

    /// The solution at `t` minutes from the epoch, for |t| up to [`MAX_MINUTES`], going on from
    /// `resume` where that lies on the way, and leaving the last step there.
    pub fn at(&self, t: f64, resume: &mut ResonanceState) -> Solution {
        let mut last = match resume.held {
            Some(Held { at_epoch, last })
                if at_epoch == self.at_epoch && lies_between_epoch_and(t, last.minutes) =>
            {
                last
            }
            _ => self.at_epoch,
        };
        let step = STEP_MIN.copysign(t);
        // At most 14,610 times, because |t| is limited.
        while (t - last.minutes).abs() >= STEP_MIN {
            last = self.motion.step(last.minutes + step, last.after(step));
        }
        resume.held = Some(Held { at_epoch: self.at_epoch, last });
        last.after(t - last.minutes)
    }
}

impl Step {
    /// λ + λ̇δ + ½ṅδ², n + ṅδ + ½n̈δ²
    fn after(&self, delta: f64) -> Solution {
        let half_delta2 = 0.5 * delta * delta;
        let (solution, rates) = (&self.solution, &self.rates);
        Solution {
            longitude: solution.longitude
                + rates.longitude * delta
                + rates.mean_motion * half_delta2,
            mean_motion: solution.mean_motion
                + rates.mean_motion * delta
                + rates.mean_motion_second * half_delta2,
        }
    }
}

impl Motion {
    fn step(&self, minutes: f64, solution: Solution) -> Step {
        let l = SinCos::of(solution.longitude);
        let mut sum = Sum::default();
        match &self.pull {
            Pull::Synchronous(pull) => {
                let l2 = l.plus(l);
                sum.add(&pull.once, 1.0, l);
                sum.add(&pull.twice, 2.0, l2);
                sum.add(&pull.thrice, 3.0, l2.plus(l));
            }
            Pull::HalfDay(pull, perigee) => {
                let w = SinCos::of(perigee.at_epoch + perigee.rate * minutes);
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
        // λ̇ = n + …, n̈ = λ̇ ∂ṅ/∂λ
        let longitude = solution.mean_motion + self.longitude_rate_without_n;
        let rates = Derivatives {
            longitude,
            mean_motion: sum.pull,
            mean_motion_second: sum.slope * longitude,
        };
        Step { minutes, solution, rates }
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
