//! Whether the estimate deserves belief: by its own innovations, and beside the MEKF.
//!
//! | sign | what it means | what follows |
//! |---|---|---|
//! | a measurement above its gate | it, or the estimate, is wrong | not used |
//! | several in a row that the MEKF accepts and this filter does not | this filter is wrong | starts again from the MEKF |
//! | gyro alone above its gate | the gyro is wrong: field and Sun bear the dynamics out | goes on without it |
//! | attitude contradicts the MEKF's, χ² of the difference | one of both is wrong | not trusted; after [`PATIENCE_S`] starts again |
//! | mean NIS too large | noise, or torque, is larger than believed | not trusted, until the torque's σ has grown |
//!
//! The MEKF is the judge because it assumes less: no inertia, no torque, no torquers.

use nalgebra::{RealField, convert};

use super::block::Block;
use super::tracked::Tracked;
use crate::attitude::mekf::monitor::Channel;
use crate::attitude::mekf::{self, FilterEstimate, Gates, Innovation};

/// A difference to the MEKF above this χ² (3 degrees of freedom) is no chance: once in 1e3, and both
/// share their measurements, which makes them more alike than the sum of covariances says.
const DIFFERENCE_GATE: f64 = 16.27;

/// How long the MEKF may contradict before the estimate is given up, s: a part of an eclipse, in which
/// the MEKF's own error wanders as slowly.
const PATIENCE_S: f64 = 300.0;

/// The attitude's difference from the MEKF's, χ² with 3 degrees of freedom.
fn difference<T: RealField + Copy>(tracked: &Tracked<T>, kinematic: &FilterEstimate<T>) -> T {
    // q_mekf = (1, −θ/2) ⊗ q_dynamic.
    let between = (kinematic.r_bi * tracked.motion.r_bi.inverse()).hamilton();
    let two: T = if between.w < T::zero() { convert(2.0) } else { convert(-2.0) };
    let theta = between.imag() * two;
    let of_kinematic = kinematic.covariance.fixed_view::<3, 3>(0, 0).into_owned();
    let sum = of_kinematic + tracked.covariance.block(Block::Attitude, Block::Attitude);
    let chi2 = sum.cholesky().map(|factor| theta.dot(&factor.solve(&theta)));
    chi2.unwrap_or_else(|| T::max_value().unwrap_or_else(T::one))
}

/// What this filter made of the measurements of one cycle.
#[derive(Debug, Clone, Copy)]
pub(super) struct Seen<T> {
    pub(super) gyro: Option<Innovation<T>>,
    pub(super) field: Option<Innovation<T>>,
    pub(super) sun: Option<Innovation<T>>,
}

/// What was seen of late.
#[derive(Debug, Clone, Copy)]
pub(super) struct Watch<T> {
    gyro: Channel<T>,
    field: Channel<T>,
    sun: Channel<T>,
    /// Measurements in a row that the MEKF accepted and this filter did not.
    alone: u8,
    /// How long the MEKF has contradicted, s.
    differs_s: T,
}

impl<T: RealField + Copy> Watch<T> {
    pub(super) fn new() -> Self {
        Self {
            gyro: Channel::new(3.0),
            field: Channel::new(3.0),
            sun: Channel::new(2.0),
            alone: 0,
            differs_s: T::zero(),
        }
    }

    /// Takes in one cycle of `dt_s`.
    pub(super) fn see(
        &mut self,
        gates: &Gates<T>,
        seen: &Seen<T>,
        kinematic: &mekf::Output<T>,
        tracked: &Tracked<T>,
        dt_s: T,
    ) {
        let note = |channel: &mut Channel<T>, seen: Option<Innovation<T>>, gate: T| {
            if let Some(seen) = seen {
                channel.judge(seen.nis, gate);
            }
        };
        note(&mut self.gyro, seen.gyro, gates.field_nis);
        note(&mut self.field, seen.field, gates.field_nis);
        note(&mut self.sun, seen.sun, gates.sun_nis);
        self.compare(seen.field, kinematic.field);
        self.compare(seen.sun, kinematic.sun);
        if let Some(estimate) = kinematic.estimate.as_ref().filter(|it| it.consistent) {
            let agrees = difference(tracked, estimate) <= convert(DIFFERENCE_GATE);
            // Cycles between the MEKF's do not count: it did not speak.
            self.differs_s = if agrees { T::zero() } else { self.differs_s + dt_s };
        }
    }

    fn compare(&mut self, here: Option<Innovation<T>>, there: Option<Innovation<T>>) {
        if let (Some(here), Some(there)) = (here, there) {
            self.alone = match (here.accepted, there.accepted) {
                (true, _) => 0,
                (false, true) => self.alone.saturating_add(1),
                (false, false) => self.alone,
            };
        }
    }

    /// Whether the estimate has to be given up.
    pub(super) fn gives_up(&self, gates: &Gates<T>) -> bool {
        self.alone >= gates.contradictions_in_a_row || self.differs_s > convert(PATIENCE_S)
    }

    /// Whether innovations and MEKF bear the estimate out.
    pub(super) fn trusts(&self) -> bool {
        let agrees = self.alone == 0 && self.differs_s == T::zero();
        agrees && self.field.is_consistent() && self.sun.is_consistent()
    }

    /// Whether the gyro has contradicted the dynamics `limit` times in a row.
    pub(super) fn gyro_is_doubtful(&self, limit: u8) -> bool {
        self.gyro.contradicts(limit)
    }
}
