//! A stretch of time, as commands are given it.

use std::iter;

use adcs_core::time::{MICROS_PER_SECOND, Utc};
use sgp4_lite::Epoch;

/// A stretch of time that does not run backwards.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Span {
    from: Utc,
    to: Utc,
}

impl Span {
    /// The span between two instants; `None` when the second is the earlier one.
    pub fn new(from: Utc, to: Utc) -> Option<Self> {
        (from <= to).then_some(Self { from, to })
    }

    /// Its first instant.
    pub fn from(self) -> Utc {
        self.from
    }

    /// Its length, s.
    pub fn seconds(self) -> f64 {
        self.to.seconds_since(self.from)
    }

    /// How many instants there are in it every `step_us` microseconds (above 0).
    pub fn steps(self, step_us: i64) -> u64 {
        (self.to.micros_since(self.from) / step_us).unsigned_abs() + 1
    }

    /// These instants.
    pub fn instants(self, step_us: i64) -> impl Iterator<Item = Utc> {
        let next = move |utc: &Utc| Some(utc.plus_micros(step_us));
        // A step beyond the last microsecond there is stays where it is.
        let steps = usize::try_from(self.steps(step_us)).unwrap_or(usize::MAX);
        iter::successors(Some(self.from), next).take(steps)
    }
}

/// A step written in seconds, as microseconds.
///
/// # Errors
/// When it is not a number, not positive, below a microsecond, or beyond a century.
pub fn step_micros(text: &str) -> Result<i64, String> {
    const LONGEST_S: f64 = 3.2e9;
    let seconds: f64 = text.parse().map_err(|_| "not a number of seconds".to_owned())?;
    let micros = seconds * MICROS_PER_SECOND as f64;
    if !(1.0..=LONGEST_S * MICROS_PER_SECOND as f64).contains(&micros) {
        return Err("a step is a microsecond at least and a century at most".to_owned());
    }
    Ok(micros.round() as i64)
}

/// The epoch of elements on the clock of everything else.
pub fn utc_of_epoch(epoch: Epoch) -> Utc {
    Utc::from_day(epoch.days_since_j2000_midnight(), epoch.micros_of_day())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_ends_of_a_span_belong_to_it() {
        let at = |text| Utc::parse(text).unwrap();
        let span = Span { from: at("2015-11-19T00:00:00Z"), to: at("2015-11-19T00:00:01.25Z") };
        let half = step_micros("0.5").unwrap();
        let instants: Vec<_> = span.instants(half).collect();
        assert_eq!(instants, [span.from, at("2015-11-19T00:00:00.5Z"), at("2015-11-19T00:00:01Z")]);
        assert_eq!(span.steps(250_000), 6);
        let moment = Span { from: span.from, to: span.from };
        assert_eq!(moment.instants(half).count(), 1);
    }

    #[test]
    fn steps_that_lead_nowhere_are_refused() {
        for text in ["0", "-1", "nan", "inf", "1e-7", "1e300", "ten", ""] {
            assert!(step_micros(text).is_err(), "{text}");
        }
        assert_eq!(step_micros("0.1"), Ok(100_000));
    }
}
