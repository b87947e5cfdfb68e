//! When something changes sign: entries and exits between two instants.

/// Whether the margin became negative or positive.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CrossingKind {
    /// From outside (margin ≥ 0) to inside (margin < 0).
    Entry,
    /// From inside to outside.
    Exit,
}

/// One change of sign.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Crossing {
    /// Which way.
    pub kind: CrossingKind,
    /// When, in the seconds of the margin function, within [`RESOLUTION_S`].
    pub seconds: f64,
}

/// How closely an instant is found, s.
pub const RESOLUTION_S: f64 = 1e-4;

/// A step for shadows, s. Distance from the shadow turns a few times per revolution, which lasts 85
/// minutes or more: 30 s never hold more than one extremum.
pub const SHADOW_STEP_S: f64 = 30.0;

/// Over this time the slope at a step is taken, s: as long as a crossing needs to be told apart.
const SLOPE_INTERVAL_S: f64 = 1e-3;

/// The greatest number of halvings: 2⁶⁰ steps of the resolution are 10¹⁴ s.
const MAX_HALVINGS: usize = 60;

/// The changes of sign of a function of time, in order, without storing them.
///
/// The function is looked at in steps of fixed length. Where the sign differs at the two ends, the
/// instant is found by bisection. Where it is the same, but the function goes towards zero at the
/// beginning and away from zero at the end, the extremum between is looked for, so that a grazing
/// entry and exit within one step are found as well, down to a few milliseconds' length. So per
/// step a function with at most one extremum is understood completely; one that turns more often
/// needs a shorter step.
///
/// The function may fail; the iterator then yields its error, and ends.
///
/// ```
/// use adcs_core::environment::crossings::{CrossingKind, Crossings};
///
/// let cosine = |t: f64| Ok::<f64, ()>(libm::cos(t));
/// let mut crossings = Crossings::new(cosine, 6.0, 0.5).unwrap();
/// let first = crossings.next().unwrap().unwrap();
/// assert_eq!(first.kind, CrossingKind::Entry);
/// assert!((first.seconds - core::f64::consts::FRAC_PI_2).abs() < 1e-4);
/// assert_eq!(crossings.count(), 1);
/// ```
#[derive(Debug, Clone)]
pub struct Crossings<F> {
    margin: F,
    end_s: f64,
    step_s: f64,
    /// Steps that were taken.
    step: u64,
    /// The last look at the function; `None` before the first and after the last step.
    left: Option<Look>,
    /// The second half of a step that has an extremum beyond zero.
    second_half: Option<[Look; 2]>,
    finished: bool,
}

/// The function at one instant.
#[derive(Debug, Clone, Copy)]
struct Look {
    seconds: f64,
    value: f64,
    slope: f64,
}

impl Look {
    fn inside(&self) -> bool {
        self.value < 0.0
    }
}

impl<E, F: FnMut(f64) -> Result<f64, E>> Crossings<F> {
    /// The crossings of `margin` from 0 to `end_s`, looked at every `step_s`.
    ///
    /// `None` when the end is negative, the step not positive, or one of them not finite.
    pub fn new(margin: F, end_s: f64, step_s: f64) -> Option<Self> {
        let usable = end_s >= 0.0 && step_s > 0.0 && end_s.is_finite() && step_s.is_finite();
        usable.then_some(Self {
            margin,
            end_s,
            step_s,
            step: 0,
            left: None,
            second_half: None,
            finished: false,
        })
    }

    fn look(&mut self, seconds: f64) -> Result<Look, E> {
        let value = (self.margin)(seconds)?;
        // Backwards, so that the function is never asked beyond the end (but just before 0).
        let before = (self.margin)(seconds - SLOPE_INTERVAL_S)?;
        Ok(Look { seconds, value, slope: value - before })
    }

    /// The next crossing, or `None` at the end.
    fn advance(&mut self) -> Result<Option<Crossing>, E> {
        if let Some([from, to]) = self.second_half.take() {
            return self.bisect(from, to).map(Some);
        }
        let mut left = match self.left {
            Some(left) => left,
            None => self.look(0.0)?,
        };
        while left.seconds < self.end_s {
            self.step += 1;
            let right = self.look((self.step as f64 * self.step_s).min(self.end_s))?;
            self.left = Some(right);
            if left.inside() != right.inside() {
                return self.bisect(left, right).map(Some);
            }
            if let Some(beyond) = self.extremum_beyond_zero(left, right)? {
                self.second_half = Some([beyond, right]);
                return self.bisect(left, beyond).map(Some);
            }
            left = right;
        }
        Ok(None)
    }

    /// Halves an interval with a change of sign until it is as short as the resolution.
    fn bisect(&mut self, mut from: Look, mut to: Look) -> Result<Crossing, E> {
        let kind = if from.inside() { CrossingKind::Exit } else { CrossingKind::Entry };
        for _ in 0..MAX_HALVINGS {
            if to.seconds - from.seconds <= RESOLUTION_S {
                break;
            }
            let seconds = 0.5 * (from.seconds + to.seconds);
            let middle = Look { seconds, value: (self.margin)(seconds)?, slope: 0.0 };
            if middle.inside() == from.inside() {
                from = middle;
            } else {
                to = middle;
            }
        }
        Ok(Crossing { kind, seconds: 0.5 * (from.seconds + to.seconds) })
    }

    /// A point on the other side of zero between two points on the same side, when the function
    /// turns back between them: golden-section search for the extremum, ended as soon as zero is
    /// passed.
    fn extremum_beyond_zero(&mut self, left: Look, right: Look) -> Result<Option<Look>, E> {
        /// (√5 − 1) / 2.
        const GOLDEN: f64 = 0.618_033_988_749_894_9;
        let sign = if left.inside() { -1.0 } else { 1.0 };
        let turns_back = sign * left.slope < 0.0 && sign * right.slope > 0.0;
        if !turns_back {
            return Ok(None);
        }
        let (mut from, mut to) = (left.seconds, right.seconds);
        let mut early_s = to - GOLDEN * (to - from);
        let mut late_s = from + GOLDEN * (to - from);
        let mut early = (self.margin)(early_s)?;
        let mut late = (self.margin)(late_s)?;
        for _ in 0..MAX_HALVINGS {
            let (seconds, value) =
                if sign * early < sign * late { (early_s, early) } else { (late_s, late) };
            let nearest = Look { seconds, value, slope: 0.0 };
            if nearest.inside() != left.inside() {
                return Ok(Some(nearest));
            }
            if to - from <= RESOLUTION_S {
                break;
            }
            if sign * early < sign * late {
                to = late_s;
                (late_s, late) = (early_s, early);
                early_s = to - GOLDEN * (to - from);
                early = (self.margin)(early_s)?;
            } else {
                from = early_s;
                (early_s, early) = (late_s, late);
                late_s = from + GOLDEN * (to - from);
                late = (self.margin)(late_s)?;
            }
        }
        Ok(None)
    }
}

impl<E, F: FnMut(f64) -> Result<f64, E>> Iterator for Crossings<F> {
    type Item = Result<Crossing, E>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.finished {
            return None;
        }
        let found = self.advance().transpose();
        self.finished = !matches!(found, Some(Ok(_)));
        found
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use core::convert::Infallible;
    use core::f64::consts::{PI, TAU};
    use proptest::prelude::*;
    use std::vec::Vec;

    fn crossings(margin: impl Fn(f64) -> f64, end_s: f64, step_s: f64) -> Vec<Crossing> {
        let margin = |t| Ok::<f64, Infallible>(margin(t));
        Crossings::new(margin, end_s, step_s).unwrap().map(Result::unwrap).collect()
    }

    #[test]
    fn every_crossing_of_a_sine_is_found_in_order() {
        const PERIOD_S: f64 = 5_800.0;
        let found = crossings(|t| libm::cos(TAU * t / PERIOD_S), 10.0 * PERIOD_S, 30.0);
        assert_eq!(found.len(), 20);
        for (index, crossing) in found.iter().enumerate() {
            let expected_s = PERIOD_S * (0.25 + 0.5 * index as f64);
            assert!((crossing.seconds - expected_s).abs() <= RESOLUTION_S);
            let kind = if index % 2 == 0 { CrossingKind::Entry } else { CrossingKind::Exit };
            assert_eq!(crossing.kind, kind);
        }
    }

    #[test]
    fn a_margin_that_touches_but_does_not_cross_has_no_crossing() {
        let touching = |t: f64| 1.0 + libm::cos(TAU * t / 5_800.0) + 1e-12;
        assert!(crossings(touching, 58_000.0, 30.0).is_empty());
    }

    #[test]
    fn an_error_is_yielded_once_and_ends_the_search() {
        let margin = |t: f64| if t < 1_000.0 { Ok(libm::sin(t / 100.0)) } else { Err("decayed") };
        let mut search = Crossings::new(margin, 5_000.0, 30.0).unwrap();
        let found: Vec<_> = search.by_ref().collect();
        assert_eq!(found.len(), 4, "the sine crosses zero at 314, 628 and 942 s");
        assert_eq!(found.last(), Some(&Err("decayed")));
        assert!(search.next().is_none());
    }

    #[test]
    fn a_span_of_no_length_has_no_crossing_and_a_useless_step_is_refused() {
        assert!(crossings(|t| t - 1.0, 0.0, 30.0).is_empty());
        let new = |end_s, step_s| Crossings::new(Ok::<f64, Infallible>, end_s, step_s);
        for (end_s, step_s) in
            [(-1.0, 1.0), (1.0, 0.0), (1.0, -1.0), (f64::NAN, 1.0), (1.0, f64::NAN)]
        {
            assert!(new(end_s, step_s).is_none());
        }
        assert!(new(f64::INFINITY, 1.0).is_none() && new(1.0, f64::INFINITY).is_none());
    }

    proptest! {
        /// An eclipse of any length from 10 ms on, anywhere in the span, with any phase to the
        /// steps.
        #[test]
        fn a_grazing_event_is_found_wherever_it_lies(
            middle_s in 1.0..5_799.0_f64,
            log_length in libm::log(0.01)..libm::log(2_000.0),
            inverted: bool,
        ) {
            const PERIOD_S: f64 = 5_800.0;
            let half_s = 0.5 * libm::exp(log_length);
            let (enter_s, leave_s) = (middle_s - half_s, middle_s + half_s);
            prop_assume!(enter_s > 0.0 && leave_s < PERIOD_S);
            let phase = |t: f64| libm::cos(PI + TAU * (t - middle_s) / PERIOD_S);
            let depth = libm::cos(PI + TAU * half_s / PERIOD_S);
            let sign = if inverted { -1.0 } else { 1.0 };
            let found = crossings(|t| sign * (phase(t) - depth), PERIOD_S, 30.0);
            let expected_first = if inverted { CrossingKind::Exit } else { CrossingKind::Entry };
            prop_assert_eq!(found.len(), 2);
            prop_assert_eq!(found[0].kind, expected_first);
            // A shallow dip resolves its ends to rounding / slope.
            prop_assert!((found[0].seconds - enter_s).abs() < 1e-3);
            prop_assert!((found[1].seconds - leave_s).abs() < 1e-3);
        }
    }
}
