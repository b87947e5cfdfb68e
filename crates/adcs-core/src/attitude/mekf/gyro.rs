//! The rate over a step, and how far it may be wrong, whether the gyro spoke or not.

use nalgebra::{RealField, Vector3, convert};
use serde::{Deserialize, Serialize};

use super::parameters::MekfParameters;
use crate::frames::{Body, Vector};
use crate::reading::Reading;

/// What a gyro sample stands for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum GyroSampling {
    /// The rate at the instant of the sample: over a step, the mean of its two ends.
    Instant,
    /// The mean rate since the sample before (an integrating gyro, or a slow low-pass filter).
    Interval,
}

/// The last gyro sample, Body, rad/s.
#[derive(Debug, Clone, Copy)]
pub(super) struct HeldRate<T> {
    pub(super) sample_b: Vector3<T>,
    /// How long it has stood for newer ones, s; zero when it was measured in the last cycle.
    held_s: T,
}

/// The rate that carries the attitude over a step, bias not removed.
#[derive(Debug, Clone, Copy)]
pub(super) struct StepRate<T> {
    /// Body, rad/s.
    pub(super) rate_b: Vector3<T>,
    /// What its error adds to the variance of the attitude about each axis, rad².
    pub(super) variance_rad2: T,
}

impl<T: RealField + Copy> HeldRate<T> {
    /// Whether the sample was measured in the last cycle.
    pub(super) fn is_fresh(&self) -> bool {
        self.held_s == T::zero()
    }
}

/// The rate over a step of `dt_s` that ends with `reading`, from it and from what was `held` before.
/// `None` when there is no rate, or the last one is too old; `held` is then empty.
pub(super) fn over_step<T: RealField + Copy>(
    parameters: &MekfParameters<T>,
    held: &mut Option<HeldRate<T>>,
    reading: Reading<Vector<Body, T>>,
    dt_s: T,
) -> Option<StepRate<T>> {
    match parameters.limits.possible_rate(reading) {
        Some(sample) => {
            let before = held.replace(HeldRate { sample_b: sample.xyz, held_s: T::zero() });
            Some(measured(parameters, before, sample.xyz, dt_s))
        }
        None => {
            let (rate, still_held) = last(parameters, (*held)?, dt_s).unzip();
            *held = still_held;
            rate
        }
    }
}

/// The gyro spoke.
fn measured<T: RealField + Copy>(
    parameters: &MekfParameters<T>,
    before: Option<HeldRate<T>>,
    sample_b: Vector3<T>,
    dt_s: T,
) -> StepRate<T> {
    let half: T = convert(0.5);
    let before = before.filter(HeldRate::is_fresh);
    let rate_b = match (parameters.gyro_sampling, before) {
        (GyroSampling::Instant, Some(before)) => (before.sample_b + sample_b) * half,
        (GyroSampling::Instant, None) | (GyroSampling::Interval, _) => sample_b,
    };
    // One sample's error, held over the step: σ_v² Δt with σ_v² = σ² Δt. Means of neighbours share
    // samples, so that over many steps they wander as single samples do.
    let angle = parameters.gyro_noise_rad_s * dt_s;
    StepRate { rate_b, variance_rad2: angle * angle }
}

/// The gyro is silent: its last sample goes on, and with it that sample's error, σ t, and what the
/// acceleration since has made of the rate, ½ a t².
fn last<T: RealField + Copy>(
    parameters: &MekfParameters<T>,
    held: HeldRate<T>,
    dt_s: T,
) -> Option<(StepRate<T>, HeldRate<T>)> {
    let limits = &parameters.limits;
    let (from_s, to_s) = (held.held_s, held.held_s + dt_s);
    if to_s > limits.coast_s {
        return None;
    }
    let variance = |t: T| {
        let noise = parameters.gyro_noise_rad_s * t;
        let acceleration = limits.coast_acceleration_rad_s2 * t * t * convert(0.5);
        noise * noise + acceleration * acceleration
    };
    let variance_rad2 = variance(to_s) - variance(from_s);
    let rate = StepRate { rate_b: held.sample_b, variance_rad2 };
    Some((rate, HeldRate { held_s: to_s, ..held }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reading::MissingReason;

    const MISSING: Reading<Vector<Body, f64>> = Reading::Missing(MissingReason::Bus);
    /// Rounding of a few f64 products.
    const ROUNDING: f64 = 1e-15;

    fn fresh(x: f64) -> Reading<Vector<Body, f64>> {
        Reading::Fresh(Vector::new(x, 0.0, 0.0))
    }

    /// What steps of 1 s make of these readings.
    fn rates<const N: usize>(
        gyro_sampling: GyroSampling,
        readings: [Reading<Vector<Body, f64>>; N],
    ) -> [Option<StepRate<f64>>; N] {
        let parameters = MekfParameters { gyro_sampling, ..Default::default() };
        let mut held = None;
        readings.map(|reading| over_step(&parameters, &mut held, reading, 1.0))
    }

    #[test]
    fn instants_are_averaged_over_the_step_and_intervals_are_not() {
        let readings = [fresh(0.1), fresh(0.3), MISSING, fresh(0.5)];
        let x = |rate: Option<StepRate<f64>>| rate.unwrap().rate_b.x;
        // After a gap the sample before is not the other end of the step.
        assert_eq!(rates(GyroSampling::Instant, readings).map(x), [0.1, 0.2, 0.3, 0.5]);
        assert_eq!(rates(GyroSampling::Interval, readings).map(x), [0.1, 0.3, 0.3, 0.5]);
    }

    #[test]
    fn a_silent_gyro_is_bridged_for_its_time_and_no_longer() {
        let mut readings = [MISSING; 14];
        readings[1] = fresh(0.1);
        let rates = rates(GyroSampling::Instant, readings);
        assert!(rates[0].is_none(), "nothing was held yet");
        assert!(rates[1..=11].iter().all(Option::is_some), "10 s");
        assert!(rates[12..].iter().all(Option::is_none));
        // After t = 10 s: (σ t)² + (½ a t²)².
        let MekfParameters { gyro_noise_rad_s, limits, .. } = MekfParameters::<f64>::default();
        let total: f64 = rates[2..=11].iter().map(|rate| rate.unwrap().variance_rad2).sum();
        let (noise, acceleration) =
            (gyro_noise_rad_s * 10.0, limits.coast_acceleration_rad_s2 * 50.0);
        assert!((total - noise * noise - acceleration * acceleration).abs() < ROUNDING);
    }

    #[test]
    fn what_no_gyro_of_this_range_reports_counts_as_missing() {
        for bad in [f64::NAN, f64::INFINITY, 5.3, -1e300] {
            let [_, bridged] = rates(GyroSampling::Instant, [fresh(0.1), fresh(bad)]);
            assert!((bridged.unwrap().rate_b.x - 0.1).abs() < ROUNDING);
        }
    }
}
