//! The damping ratio of a rate that swings, from its successive negative peaks.
//!
//! δ = ln(a₁ / a₂),   ξ = δ / √(4π² + δ²)
//!
//! | symbol | meaning |
//! |---|---|
//! | a₁, a₂ | depths of the first two negative peaks of the smoothed rate |
//! | δ | logarithmic decrement |
//! | ξ | damping ratio |
//!
//! Source: the logarithmic decrement of any textbook on vibrations. The paper gives damping ratios
//! without saying how they were found; this way gives its simulated values for preset A2.

use serde::Serialize;
use std::f64::consts::TAU;

/// The rate is averaged over this long before peaks are looked for, s: it hides the steps of the
/// torquers' rounds and the gyros' noise, and is short against a swing of some minutes.
const SMOOTHING_S: f64 = 9.0;

/// Two successive peaks and what they say.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Damping {
    /// ξ; negative when the swing grows.
    pub ratio: f64,
    /// When the first negative peak was, s since the start.
    pub first_peak_s: f64,
    /// Its rate, deg/s.
    pub first_peak_deg_s: f64,
    /// When the second was.
    pub second_peak_s: f64,
    /// Its rate, deg/s.
    pub second_peak_deg_s: f64,
}

/// The damping ratio of `rate` (deg/s, one value each `cycle_s`); `None` when it has fewer than two
/// negative peaks.
pub fn damping(rate: &[f64], cycle_s: f64) -> Option<Damping> {
    let smooth = smoothed(rate, (SMOOTHING_S / cycle_s / 2.0).round() as usize);
    let [(first, a1), (second, a2), ..] = negative_peaks(&smooth)[..] else { return None };
    let decrement = (a1 / a2).ln();
    Some(Damping {
        ratio: decrement / (TAU * TAU + decrement * decrement).sqrt(),
        first_peak_s: first as f64 * cycle_s,
        first_peak_deg_s: a1,
        second_peak_s: second as f64 * cycle_s,
        second_peak_deg_s: a2,
    })
}

/// Each value averaged with `reach` neighbours on both sides, fewer at the ends.
fn smoothed(values: &[f64], reach: usize) -> Vec<f64> {
    (0..values.len())
        .map(|at| {
            let window = &values[at.saturating_sub(reach)..(at + reach + 1).min(values.len())];
            window.iter().sum::<f64>() / window.len() as f64
        })
        .collect()
}

/// Where and how deep each swing below zero is deepest. A swing that has not turned when the record
/// begins or ends has no peak.
fn negative_peaks(values: &[f64]) -> Vec<(usize, f64)> {
    let mut peaks = Vec::new();
    let mut deepest: Option<(usize, f64)> = None;
    for (at, &value) in values.iter().enumerate() {
        if value < 0.0 {
            if deepest.is_none_or(|(_, depth)| value < depth) {
                deepest = Some((at, value));
            }
        } else {
            peaks.extend(deepest.take());
        }
    }
    peaks.extend(deepest);
    peaks.retain(|&(at, _)| at > 0 && at + 1 < values.len());
    peaks
}

#[cfg(test)]
mod tests {
    use super::*;

    const CYCLE_S: f64 = 0.5;

    fn swing(ratio: f64, duration_s: f64) -> Vec<f64> {
        let omega = TAU / 400.0;
        let decay = ratio / (1.0 - ratio * ratio).sqrt() * omega;
        (0..(duration_s / CYCLE_S) as usize)
            .map(|k| k as f64 * CYCLE_S)
            .map(|t| 5.0 * (-decay * t).exp() * (omega * t).cos())
            .collect()
    }

    #[test]
    fn a_damped_swing_gives_back_its_ratio() {
        // Averaging over 9 s of a 400 s swing changes both peaks alike; their place in time is good to
        // half a cycle.
        const TOLERANCE: f64 = 1e-3;
        for ratio in [0.0, 0.07, 0.2, 0.3, -0.05] {
            let found = damping(&swing(ratio, 1200.0), CYCLE_S).unwrap();
            assert!((found.ratio - ratio).abs() < TOLERANCE, "{ratio}: {found:?}");
            assert!((found.second_peak_s - found.first_peak_s - 400.0).abs() <= CYCLE_S);
        }
    }

    #[test]
    fn one_peak_or_none_gives_no_ratio() {
        assert_eq!(damping(&swing(0.1, 500.0), CYCLE_S), None);
        assert_eq!(damping(&[1.0; 2400], CYCLE_S), None);
        assert_eq!(damping(&[-1.0; 2400], CYCLE_S), None);
        assert_eq!(damping(&[], CYCLE_S), None);
    }

    #[test]
    fn a_swing_that_has_not_turned_at_the_end_is_no_peak() {
        let falling: Vec<f64> = (0..100).map(|k| 1.0 - 0.1 * f64::from(k)).collect();
        assert_eq!(negative_peaks(&falling), []);
    }
}
