//! Divergence: something that should shrink grows, round after round.

/// When growth counts as divergence.
#[derive(Debug, Clone, Copy)]
pub(super) struct Limits {
    /// Rounds that went up, more than went down, in a row.
    pub(super) rounds: u16,
    /// By how much the whole has grown.
    pub(super) factor: f32,
    /// What it has to exceed; below, growth is noise, or a swing.
    pub(super) floor: f32,
}

/// A quantity watched from round to round. `Default` has seen none.
///
/// A round that goes up counts one, a round that goes down takes one away: noise wanders near zero, and
/// a swing gives back what it took.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Growth {
    last: Option<f32>,
    /// Where it stood when the count left zero.
    start: f32,
    count: u16,
}

impl Growth {
    /// Takes in the value of a round; whether it diverges. A value that is no number is passed over.
    pub(super) fn diverges(&mut self, value: f32, limits: &Limits) -> bool {
        if !value.is_finite() {
            return false;
        }
        match self.last {
            Some(last) if value > last => {
                if self.count == 0 {
                    self.start = last;
                }
                self.count = self.count.saturating_add(1);
            }
            Some(_) => self.count = self.count.saturating_sub(1),
            None => {}
        }
        self.last = Some(value);
        self.count >= limits.rounds && value >= limits.floor && value >= self.start * limits.factor
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMITS: Limits = Limits { rounds: 10, factor: 1.5, floor: 1.0 };

    fn first(values: impl Iterator<Item = f32>) -> Option<usize> {
        let mut growth = Growth::default();
        values.into_iter().position(|value| growth.diverges(value, &LIMITS))
    }

    #[test]
    fn steady_growth_is_found_when_all_three_limits_are_passed() {
        assert_eq!(first((0..100).map(|k| 2.0 + 0.2 * k as f32)), Some(10), "the rounds last");
        assert_eq!(first((0..100).map(|k| 2.0 + 0.05 * k as f32)), Some(20), "the factor last");
        assert_eq!(first((0..100).map(|k| 0.05 * k as f32)), Some(20), "the floor last");
    }

    #[test]
    fn growth_under_noise_is_found_too() {
        // Three steps up for one down.
        let walk = (0..200).map(|k| 2.0 + 0.02 * k as f32 - if k % 4 == 0 { 0.05 } else { 0.0 });
        assert!(first(walk).is_some_and(|round| (18..60).contains(&round)));
    }

    #[test]
    fn decay_swings_and_noise_are_no_divergence() {
        assert_eq!(first((0..1_000).map(|k| 10.0 * (-0.01 * k as f32).exp())), None);
        // A swing of nine rounds up and nine down.
        assert_eq!(first((0..1_000).map(|k| 3.0 - 2.0 * (k as f32 * 0.349).cos())), None);
        // Noise of any kind below the floor.
        assert_eq!(first((0..1_000_u32).map(|k| 0.9 * ((k * k % 97) as f32 / 97.0))), None);
    }

    #[test]
    fn what_is_no_number_is_passed_over() {
        let values = (0..100).map(|k| if k % 2 == 0 { 2.0 + 0.1 * k as f32 } else { f32::NAN });
        assert_eq!(first(values), Some(20));
    }
}
