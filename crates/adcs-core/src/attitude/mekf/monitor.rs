//! Whether the filter still deserves belief: gates, runs of contradictions, mean NIS, covariance.
//!
//! | monitor | what it sees | what follows |
//! |---|---|---|
//! | gate | one measurement that contradicts the estimate (NIS above a χ² quantile) | it is not used |
//! | run | several contradictions in a row of one sensor | the estimate is in doubt: found anew if field and Sun agree with each other, and have done so for longer than they disagreed before; withheld if nothing vouches for it |
//! | mean NIS | innovations that are too large on average for what the covariance promised | the estimate is marked inconsistent |
//! | covariance | a variance that is negative or not finite, or no Cholesky factor | start again |

use nalgebra::{Cholesky, ComplexField, Matrix6, RealField, convert};

use super::output::Innovation;

/// What one sensor has said of late.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::attitude) struct Channel<T> {
    degrees_of_freedom: T,
    /// Contradictions since the last measurement that was accepted.
    contradictions: u8,
    /// NIS over its degrees of freedom, smoothed; 1 when all is as promised.
    mean_ratio: T,
}

/// The weight of a new NIS in the mean: fifty measurements, so that with two degrees of freedom the
/// mean scatters by 0.1 about 1.
const NEW_WEIGHT: f64 = 0.02;
/// A mean ratio above this is no scatter (ten σ): noise, calibration or field model are not what the
/// filter was told.
const INCONSISTENT_RATIO: f64 = 2.0;

impl<T: RealField + Copy> Channel<T> {
    /// A sensor that has said nothing yet.
    pub(in crate::attitude) fn new(degrees_of_freedom: f64) -> Self {
        Self {
            degrees_of_freedom: convert(degrees_of_freedom),
            contradictions: 0,
            mean_ratio: T::one(),
        }
    }

    /// Holds a measurement's `nis` against its `gate`.
    pub(in crate::attitude) fn judge(&mut self, nis: T, gate: T) -> Innovation<T> {
        let accepted = nis <= gate;
        self.contradictions = if accepted { 0 } else { self.contradictions.saturating_add(1) };
        // One wild value counts as one at the gate, or it would be remembered for hours.
        let ratio = nis.min(gate) / self.degrees_of_freedom;
        self.mean_ratio += (ratio - self.mean_ratio) * convert(NEW_WEIGHT);
        Innovation { nis, accepted }
    }

    /// Whether the sensor has contradicted the estimate `limit` times in a row.
    pub(in crate::attitude) fn contradicts(&self, limit: u8) -> bool {
        self.contradictions >= limit
    }

    /// Whether innovations are as large as promised, on average.
    pub(in crate::attitude) fn is_consistent(&self) -> bool {
        self.mean_ratio <= convert(INCONSISTENT_RATIO)
    }
}

/// Both sensors, and whether anything still vouches for the estimate.
#[derive(Debug, Clone, Copy)]
pub(super) struct Monitor<T> {
    field: Channel<T>,
    sun: Channel<T>,
    /// Contradictions since the last measurement of either sensor that was accepted.
    unvouched: u8,
    /// How often in a row field and Sun agreed with each other, all disagreements paid for.
    agreements: u8,
    /// Disagreements that are not paid for by as many agreements yet: a broken sensor agrees by chance
    /// now and then, but not for as long as it was wrong.
    unpaid: u8,
}

impl<T: RealField + Copy> Monitor<T> {
    pub(super) fn new() -> Self {
        Self {
            field: Channel::new(3.0),
            sun: Channel::new(2.0),
            unvouched: 0,
            agreements: 0,
            unpaid: 0,
        }
    }

    pub(super) fn judge_field(&mut self, nis: T, gate: T) -> Innovation<T> {
        let innovation = self.field.judge(nis, gate);
        self.count(innovation)
    }

    pub(super) fn judge_sun(&mut self, nis: T, gate: T) -> Innovation<T> {
        let innovation = self.sun.judge(nis, gate);
        self.count(innovation)
    }

    fn count(&mut self, innovation: Innovation<T>) -> Innovation<T> {
        self.unvouched = if innovation.accepted { 0 } else { self.unvouched.saturating_add(1) };
        innovation
    }

    /// Notes whether field and Sun of one instant agree with each other, whatever the estimate.
    pub(super) fn judge_pair(&mut self, agree: bool) {
        (self.agreements, self.unpaid) = match (agree, self.unpaid) {
            (true, 0) => (self.agreements.saturating_add(1), 0),
            (true, unpaid) => (0, unpaid.saturating_sub(1)),
            (false, unpaid) => (0, unpaid.saturating_add(1)),
        };
    }

    /// Whether field and Sun have agreed with each other `times` in a row, after as many agreements as
    /// there were disagreements before.
    pub(super) fn sensors_agree(&self, times: u8) -> bool {
        self.agreements >= times
    }

    /// Whether either sensor has contradicted the estimate `limit` times in a row.
    pub(super) fn is_in_doubt(&self, limit: u8) -> bool {
        self.field.contradicts(limit) || self.sun.contradicts(limit)
    }

    /// Whether one of the last `limit` measurements agreed with the estimate, or none was made.
    pub(super) fn is_vouched_for(&self, limit: u8) -> bool {
        self.unvouched < limit
    }

    /// Whether the innovations of both sensors are as large as promised, on average.
    pub(super) fn is_consistent(&self) -> bool {
        self.field.is_consistent() && self.sun.is_consistent()
    }

    /// Both sensors are heard afresh: the estimate they spoke of is gone. What they said of each other
    /// stands.
    pub(super) fn restart(&mut self) {
        let Self { agreements, unpaid, .. } = *self;
        *self = Self { agreements, unpaid, ..Self::new() };
    }
}

/// Whether `covariance` can be one: finite, and with a Cholesky factor.
pub(super) fn is_covariance<T: RealField + Copy>(covariance: &Matrix6<T>) -> bool {
    covariance.iter().all(ComplexField::is_finite) && Cholesky::new(*covariance).is_some()
}

#[cfg(test)]
mod tests {
    use super::*;

    const GATE: f32 = 25.9;

    #[test]
    fn a_measurement_above_the_gate_or_without_a_number_is_refused() {
        let mut field = Channel::new(3.0);
        assert!(field.judge(GATE, GATE).accepted);
        assert!(!field.judge(GATE + 0.1, GATE).accepted);
        assert!(!field.judge(f32::INFINITY, GATE).accepted);
    }

    #[test]
    fn contradictions_count_in_a_row_only() {
        let mut field = Channel::new(3.0);
        for nis in [100.0, 100.0, 3.0, 100.0, 100.0] {
            field.judge(nis, GATE);
        }
        assert!(field.contradicts(2) && !field.contradicts(3));
        for _ in 0..1000 {
            field.judge(100.0, GATE);
        }
        assert!(field.contradicts(255));
    }

    #[test]
    fn sensors_that_disagreed_are_believed_after_agreeing_for_longer() {
        let mut monitor = Monitor::<f32>::new();
        let agreeing_after = |monitor: &mut Monitor<f32>, agreements: u32| {
            (0..agreements).for_each(|_| monitor.judge_pair(true));
            monitor.sensors_agree(5)
        };
        assert!(agreeing_after(&mut monitor, 5));
        (0..20).for_each(|_| monitor.judge_pair(false));
        assert!(!agreeing_after(&mut monitor, 24));
        assert!(agreeing_after(&mut monitor, 1));
        monitor.restart();
        assert!(monitor.sensors_agree(5), "they spoke of each other, not of the estimate");
    }

    #[test]
    fn the_mean_sees_what_the_gate_lets_through() {
        let mut sun = Channel::new(2.0);
        // Three times the promised variance: no single value is suspicious.
        for _ in 0..100 {
            assert!(sun.judge(6.0_f32, 23.0).accepted);
        }
        assert!(!sun.is_consistent());
    }

    #[test]
    fn one_wild_value_does_not_make_the_mean_inconsistent() {
        let mut sun = Channel::new(2.0);
        sun.judge(1e30_f32, 23.0);
        assert!(sun.is_consistent());
    }

    #[test]
    fn what_is_no_covariance_is_seen() {
        let sound = Matrix6::<f32>::identity() * 1e-6;
        assert!(is_covariance(&sound));
        let mut correlated = sound;
        (correlated[(0, 3)], correlated[(3, 0)]) = (1.1e-6, 1.1e-6);
        assert!(!is_covariance(&correlated));
        let mut infinite = sound;
        infinite[(2, 2)] = f32::INFINITY;
        assert!(!is_covariance(&infinite));
        assert!(!is_covariance(&-sound));
    }
}
