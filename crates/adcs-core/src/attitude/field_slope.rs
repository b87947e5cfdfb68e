//! How fast the field turns while the torquers rest: the rate across it from the magnetometer alone.
//!
//! A straight line through the settled measurements of one rest, by least squares:
//!
//! Ḃ = Σ (tᵢ − t̄)(Bᵢ − B̄) / Σ (tᵢ − t̄)²,   ω⊥ = (Ḃ × B̄) / |B̄|²   from Ḃ = −ω × B
//!
//! | what it does not see | how large |
//! |---|---|
//! | the rate along the field | anything; B-dot needs none of it |
//! | the field's own turn along the orbit | up to 0.13 deg/s, twice the orbital rate |
//! | noise | σ / (\|B\| √Σ(t − t̄)²): 0.6 deg/s for five samples in 2 s, 586 nT and 35 µT |
//! | the bend of the arc over a turn of α | α² / 37 of the rate for five samples, α² / 60 for many: 0.3 % at 10 deg/s and 2 s |
//! | a turn of more than half a circle within the rest | it folds over |
//!
//! Rests are not joined: between two of them, at the rates for which noise does not matter, the body
//! turns too far, and at those for which it would pay the law is linear and averages by itself, over
//! 1 / (k |B|² t_on / J) rounds.
//!
//! Source: Wertz (1978), §18.3, for Ḃ ≈ −ω × B; the rest is the textbook's straight line.

use nalgebra::{RealField, Vector3, convert};

use crate::frames::{Body, Vector};

/// A line through longer rests would be no line, s: at 10 deg/s it turns by 50 deg.
const LONGEST_S: f64 = 5.0;
/// Shorter ones give more noise than rate, s.
const SHORTEST_S: f64 = 0.2;
/// Smallest flux density with a usable direction, T.
const WEAKEST_FIELD_T: f64 = 1e-6;

/// The rate across the field that a rest has shown.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SlopeRate<T: RealField + Copy = f32> {
    /// Rate of Body relative to Eci, Body, rad/s; its part along the field is zero.
    pub omega_bi: Vector<Body, T>,
    /// σ across the field for a field noise of 1 T on each axis, rad/s/T.
    pub sigma_per_tesla: T,
}

/// The sums over the rest so far, fields less the first. `Default` is power-on.
#[derive(Debug, Clone, Copy)]
pub struct FieldSlope<T: RealField + Copy = f32> {
    first: Option<Vector3<T>>,
    elapsed_s: T,
    count: T,
    sum_t: T,
    sum_tt: T,
    sum_b: Vector3<T>,
    sum_tb: Vector3<T>,
}

impl<T: RealField + Copy> Default for FieldSlope<T> {
    fn default() -> Self {
        let (zero, none) = (T::zero(), Vector3::zeros());
        Self {
            first: None,
            elapsed_s: zero,
            count: zero,
            sum_t: zero,
            sum_tt: zero,
            sum_b: none,
            sum_tb: none,
        }
    }
}

impl<T: RealField + Copy> FieldSlope<T> {
    /// Takes in one cycle, `dt_s` after the last: whether the torquers are at rest and the field has
    /// settled, and the field if it was measured. What is not a field is left out; a cycle that is not
    /// settled begins anew.
    pub fn cycle(&mut self, settled: bool, field: Option<Vector<Body, T>>, dt_s: T) {
        let elapsed_s = self.elapsed_s + dt_s;
        // Also begins anew after a NaN, and when time ran backwards.
        let goes_on = settled && dt_s >= T::zero() && elapsed_s <= convert(LONGEST_S);
        if !goes_on {
            *self = Self::default();
        }
        if self.first.is_some() {
            self.elapsed_s = elapsed_s;
        }
        let plausible = |field: &Vector<Body, T>| {
            let norm = field.norm();
            norm.is_finite() && norm >= convert(WEAKEST_FIELD_T)
        };
        let Some(field) = field.filter(plausible).filter(|_| settled) else { return };
        let (t, b) = (self.elapsed_s, field.xyz - *self.first.get_or_insert(field.xyz));
        self.count += T::one();
        self.sum_t += t;
        self.sum_tt += t * t;
        self.sum_b += b;
        self.sum_tb += b * t;
    }

    /// What the rest has shown so far; `None` before three fields over a fifth of a second.
    pub fn rate(&self) -> Option<SlopeRate<T>> {
        let three: T = convert(3.0);
        let first = self.first.filter(|_| self.count >= three)?;
        let mean_t = self.sum_t / self.count;
        let mean_b = self.sum_b / self.count;
        // Σ (t − t̄)²; three samples over T give T²/2.
        let spread = self.sum_tt - self.sum_t * mean_t;
        let least: T = convert(SHORTEST_S * SHORTEST_S / 2.0);
        let field = first + mean_b;
        let norm = field.norm();
        if !(spread >= least && norm >= convert(WEAKEST_FIELD_T)) {
            return None;
        }
        let slope = (self.sum_tb - mean_b * self.sum_t) / spread;
        let omega_bi = Vector::from_xyz(slope.cross(&field) / (norm * norm));
        let sigma_per_tesla = T::one() / (norm * spread.sqrt());
        (omega_bi.is_finite() && sigma_per_tesla.is_finite())
            .then_some(SlopeRate { omega_bi, sigma_per_tesla })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::UnitQuaternion;

    const STEP_S: f64 = 0.5;
    const SAMPLES: u32 = 5;

    fn rest(omega: Vector3<f64>, field: Vector3<f64>) -> FieldSlope<f64> {
        let mut slope = FieldSlope::default();
        slope.cycle(false, None, STEP_S);
        for k in 0..SAMPLES {
            let turn = UnitQuaternion::from_scaled_axis(-omega * (f64::from(k) * STEP_S));
            slope.cycle(true, Some(Vector::from_xyz(turn * field)), STEP_S);
        }
        slope
    }

    #[test]
    fn the_rate_across_the_field_is_found_but_for_the_bend_of_the_arc() {
        let field = Vector3::new(2e-5, -1e-5, 3e-5);
        let across = field.cross(&Vector3::x()).normalize();
        for rate in [1e-4, 0.02, 0.1, 0.17] {
            let found = rest(across * rate, field).rate().unwrap().omega_bi.xyz;
            let turn = rate * 2.0;
            // Five samples: α²/16 from the shortened mean less 0.85 α²/24 from the flattened slope.
            let bend = rate * turn * turn * (1.0 / 16.0 - 0.85 / 24.0);
            // A tenth for the next order of the arc.
            assert!((found - across * rate).norm() < 1.1 * bend + 1e-12, "{rate} {found}");
        }
    }

    #[test]
    fn the_rate_along_the_field_is_not_seen() {
        let field = Vector3::new(2e-5, -1e-5, 3e-5);
        let found = rest(field.normalize() * 0.1, field).rate().unwrap();
        // Rounding of differences of a field that does not change.
        assert!(found.omega_bi.norm() < 1e-12);
    }

    #[test]
    fn its_torque_takes_energy_out_of_a_spin() {
        use crate::control::b_dot::{BDot, BDotGain};
        let law = BDot::new(BDotGain::Plain { gain_am2_s_per_t: 1e5 }).unwrap();
        let (omega, field) = (Vector3::new(0.05, 0.1, -0.08), Vector3::new(2e-5, -1e-5, 3e-5));
        let seen = rest(omega, field).rate().unwrap().omega_bi.to_f32();
        let last = UnitQuaternion::from_scaled_axis(-omega * 2.0) * field;
        let at_the_end: Vector<Body, f64> = Vector::from_xyz(last);
        let dipole = law.dipole(seen, at_the_end.to_f32()).unwrap();
        assert!(omega.dot(&dipole.xyz.cast::<f64>().cross(&last)) < 0.0);
    }

    #[test]
    fn sigma_is_that_of_a_straight_line() {
        // Σ (t − t̄)² of five samples 0.5 s apart is 2.5 s².
        let found = rest(Vector3::zeros(), Vector3::new(0.0, 0.0, 3.5e-5)).rate().unwrap();
        let expected = 1.0 / (3.5e-5 * libm::sqrt(2.5));
        assert!((found.sigma_per_tesla / expected - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_rest_that_is_too_short_or_no_rest_shows_nothing() {
        let field = Some(Vector::<Body, f64>::new(2e-5, 0.0, 0.0));
        let mut slope = FieldSlope::default();
        for _ in 0..2 {
            slope.cycle(true, field, STEP_S);
            assert!(slope.rate().is_none(), "fewer than three");
        }
        slope.cycle(true, field, STEP_S);
        assert!(slope.rate().is_some());
        slope.cycle(false, field, STEP_S);
        assert!(slope.rate().is_none(), "the torquers were on");
        for dt_s in [0.0, -1.0, 6.0, f64::NAN, f64::INFINITY] {
            let mut slope = FieldSlope::default();
            (0..4).for_each(|_| slope.cycle(true, field, dt_s));
            assert!(slope.rate().is_none(), "{dt_s}");
        }
        for bad in [0.0, f64::NAN, f64::INFINITY] {
            let mut slope = FieldSlope::default();
            (0..4).for_each(|_| slope.cycle(true, Some(Vector::new(bad, 0.0, 0.0)), STEP_S));
            assert!(slope.rate().is_none(), "{bad}");
        }
    }

    #[test]
    fn a_measurement_that_is_missing_leaves_the_line_as_it_is() {
        let (omega, field) = (Vector3::new(0.0, 0.0, 0.02), Vector3::new(3e-5, 0.0, 0.0));
        let mut slope = FieldSlope::<f32>::default();
        for k in 0..SAMPLES {
            let turn = UnitQuaternion::from_scaled_axis(-omega * (f64::from(k) * STEP_S));
            let seen: Vector<Body, f64> = Vector::from_xyz(turn * field);
            slope.cycle(true, (k != 2).then(|| seen.to_f32()), STEP_S as f32);
        }
        // f32: 3e-5 T rounds to 2e-12 T, over 2 s and a rate of 0.02 rad/s.
        assert!((slope.rate().unwrap().omega_bi.xyz.z - 0.02).abs() < 1e-5);
    }
}
