//! The rate from the magnetometer alone, when the gyros have failed.
//!
//! Between two settled measurements Δt apart the field turns in Body against the satellite's own turn,
//! b₂ = exp(−[ω×] Δt) b₁, so that across the field
//!
//! ω⊥ = (b₂ × b₁) / (|b₁| |b₂|) · (α / sin α) / Δt,   α the angle between b₁ and b₂.
//!
//! | what it does not see | how large |
//! |---|---|
//! | the rate along the field | anything; B-dot needs none of it |
//! | the field's own turn along the orbit | up to 0.13 deg/s, twice the orbital rate |
//! | noise | √2 σ / (|B| Δt): 0.5 deg/s for 500 nT, 40 µT and 2 s |
//!
//! Source: Wertz (1978), §18.3, for Ḃ ≈ −ω × B.

use nalgebra::{RealField, Vector3, convert};

use crate::frames::{Body, Vector};

/// Measurements further apart are of no use, s: at 10 deg/s the field may have turned by 50 deg, and
/// with the torquers' command in between the rate has changed.
const LONGEST_S: f64 = 5.0;
/// Nearer ones give more noise than rate, s.
const SHORTEST_S: f64 = 0.2;
/// Smallest flux density with a usable direction, T.
const WEAKEST_FIELD_T: f64 = 1e-6;

/// A rate across the field.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AcrossField<T: RealField + Copy = f32> {
    /// Rate of Body relative to Eci, Body, rad/s; its part along the field is zero.
    pub omega_bi: Vector<Body, T>,
    /// σ across the field, rad/s.
    pub sigma_rad_s: T,
}

/// The last settled field and its age. `Default` is power-on.
#[derive(Debug, Clone, Copy)]
pub struct FieldRate<T: RealField + Copy = f32> {
    last: Option<(Vector3<T>, T)>,
}

impl<T: RealField + Copy> Default for FieldRate<T> {
    fn default() -> Self {
        Self { last: None }
    }
}

impl<T: RealField + Copy> FieldRate<T> {
    /// Takes in one cycle, `dt_s` after the last: the field if it was measured with the torquers at
    /// rest, and σ of each of its axes, T. `None` when there are no two fields near enough in time, or
    /// they are no fields.
    pub fn cycle(
        &mut self,
        field: Option<Vector<Body, T>>,
        sigma_t: T,
        dt_s: T,
    ) -> Option<AcrossField<T>> {
        let plausible = |field: &Vector<Body, T>| {
            let norm = field.norm();
            norm.is_finite() && norm >= convert(WEAKEST_FIELD_T)
        };
        // A NaN or a negative time makes the age useless.
        let before = self.last.take().map(|(field, age_s)| (field, age_s + dt_s));
        let before =
            before.filter(|(_, age_s)| *age_s >= T::zero() && *age_s <= convert(LONGEST_S));
        let Some(now) = field.filter(plausible) else {
            self.last = before;
            return None;
        };
        self.last = Some((now.xyz, T::zero()));
        let (before, age_s) = before.filter(|(_, age_s)| *age_s >= convert(SHORTEST_S))?;
        let (sine, cosine) = (now.xyz.cross(&before), now.xyz.dot(&before));
        // Beyond a quarter turn the shorter way need not be the true one.
        if cosine <= T::zero() {
            return None;
        }
        let product = now.xyz.norm() * before.norm();
        let turn = sine / product * ratio(sine.norm() / product);
        let two: T = convert(2.0);
        let sigma_rad_s = two.sqrt() * sigma_t / (now.norm() * age_s);
        let omega_bi = Vector::from_xyz(turn / age_s);
        omega_bi.is_finite().then_some(AcrossField { omega_bi, sigma_rad_s })
    }
}

/// α / sin α from sin α, 0 ≤ α ≤ π/2.
fn ratio<T: RealField + Copy>(sine: T) -> T {
    let small: T = convert(1e-3);
    if sine < small {
        T::one() + sine * sine / convert(6.0)
    } else {
        sine.min(T::one()).asin() / sine
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::UnitQuaternion;

    /// Rounding of an arcsine near a quarter turn, relative.
    const ROUNDING: f64 = 1e-12;
    const SIGMA_T: f64 = 5e-7;

    fn turned(omega: Vector3<f64>, field: Vector3<f64>, t_s: f64) -> Option<Vector<Body, f64>> {
        Some(Vector::from_xyz(UnitQuaternion::from_scaled_axis(-omega * t_s) * field))
    }

    #[test]
    fn a_turn_across_the_field_is_found_exactly_and_one_along_it_not_at_all() {
        let field = Vector3::new(2e-5, -1e-5, 3e-5);
        let across = field.cross(&Vector3::x()).normalize();
        for rate in [1e-4, 0.02, 0.16, 0.6] {
            let omega = across * rate;
            let mut state = FieldRate::default();
            assert!(state.cycle(turned(omega, field, 0.0), SIGMA_T, 0.0).is_none());
            let found = state.cycle(turned(omega, field, 2.0), SIGMA_T, 2.0).unwrap();
            assert!((found.omega_bi.xyz - omega).norm() < ROUNDING * rate.max(1e-2));
        }
        let mut state = FieldRate::default();
        let along = field.normalize() * 0.1;
        state.cycle(turned(along, field, 0.0), SIGMA_T, 0.0);
        let found = state.cycle(turned(along, field, 2.0), SIGMA_T, 2.0).unwrap();
        assert!(found.omega_bi.norm() < ROUNDING);
    }

    #[test]
    fn noise_is_as_promised() {
        let field = Vector3::new(0.0, 0.0, 4e-5);
        let mut state = FieldRate::default();
        state.cycle(Some(Vector::from_xyz(field)), SIGMA_T, 0.0);
        let off = Vector3::new(SIGMA_T, 0.0, 0.0);
        let found = state.cycle(Some(Vector::from_xyz(field + off)), SIGMA_T, 2.0).unwrap();
        // One field off by σ along one axis: 1/√2 of the promise, which counts both.
        let share = found.omega_bi.norm() / found.sigma_rad_s;
        assert!((share - core::f64::consts::FRAC_1_SQRT_2).abs() < 1e-3, "{share}");
    }

    #[test]
    fn fields_too_far_apart_or_of_no_field_give_no_rate() {
        let field = Some(Vector::<Body, f64>::new(2e-5, 0.0, 0.0));
        let across = Some(Vector::new(-1e-9, 2e-5, 0.0));
        let rate = |first, second, dt_s| {
            let mut state = FieldRate::default();
            state.cycle(first, SIGMA_T, 0.0);
            state.cycle(second, SIGMA_T, dt_s)
        };
        assert!(rate(field, field, 1.0).is_some());
        assert!(rate(field, across, 1.0).is_none(), "beyond a quarter turn");
        for dt_s in [0.1, 5.1, -1.0, f64::NAN, f64::INFINITY] {
            assert!(rate(field, field, dt_s).is_none(), "{dt_s}");
        }
        for bad in [0.0, f64::NAN, f64::INFINITY] {
            assert!(rate(field, Some(Vector::new(bad, 0.0, 0.0)), 1.0).is_none());
            assert!(rate(Some(Vector::new(bad, 0.0, 0.0)), field, 1.0).is_none());
        }
    }

    #[test]
    fn a_cycle_without_field_lets_the_last_one_grow_older() {
        let omega = Vector3::new(0.0, 0.0, 0.1);
        let field = Vector3::new(3e-5, 0.0, 0.0);
        let mut state = FieldRate::default();
        state.cycle(turned(omega, field, 0.0), SIGMA_T, 0.0);
        assert!(state.cycle(None, SIGMA_T, 1.0).is_none());
        let found = state.cycle(turned(omega, field, 2.0), SIGMA_T, 1.0).unwrap();
        assert!((found.omega_bi.xyz - omega).norm() < ROUNDING);
    }
}
