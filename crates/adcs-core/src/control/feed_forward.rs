//! What the torquers add so that the satellite's own magnetism does not turn it.
//!
//! The residual dipole M acts all the time, the torquers only for t_on of each round t_on + t_off. Its
//! mean torque over a round vanishes when
//!
//! m_ff t_on + M (t_on + t_off) = 0,   m_ff = −M (t_on + t_off) / t_on
//!
//! Both are fixed in Body, so m_ff never grows stale however the body turns. What is left is a ripple:
//! during the rest M × B is not compensated, during the action it is compensated too much, and the rate
//! at the end of the rest, where it is measured, is off its mean over the round by
//!
//! δω = ½ t_off J⁻¹ (M × B)
//!
//! | symbol | code | meaning |
//! |---|---|---|
//! | M | `residual` | residual dipole as estimated, Body, A·m² |
//! | t_on, t_off | [`Round`] | action and rest, s |
//! | J | `inertia_kg_m2` | inertia tensor, Body, kg·m² |
//! | B | `field` | flux density, Body, T |
//!
//! Source: the impulse of one round, as above. The ripple is a triangle of height t_off J⁻¹ (M × B).

use core::fmt;

use nalgebra::Matrix3;

use crate::frames::{Body, Vector};
use crate::schedule::Round;

/// From which accuracy on the residual dipole is fed forward.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FeedForward {
    largest_sigma_am2: f32,
}

/// Why a σ is refused: it must be positive and finite.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct SigmaError {
    /// The σ that was given, A·m².
    pub found: f32,
}

impl fmt::Display for SigmaError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "the largest σ of a residual dipole, {} A·m², must be positive and finite",
            self.found
        )
    }
}

impl core::error::Error for SigmaError {}

impl FeedForward {
    /// Accepts the largest σ of any axis, A·m², with which an estimate is good enough.
    ///
    /// # Errors
    /// [`SigmaError`] when it is not positive and finite.
    pub fn new(largest_sigma_am2: f32) -> Result<Self, SigmaError> {
        if largest_sigma_am2.is_finite() && largest_sigma_am2 > 0.0 {
            Ok(Self { largest_sigma_am2 })
        } else {
            Err(SigmaError { found: largest_sigma_am2 })
        }
    }

    /// m_ff, Body, A·m², not yet limited; `None` when the estimate is too vague or not finite, and the
    /// law then flies without.
    pub fn dipole(
        &self,
        residual: Vector<Body>,
        sigma_am2: Vector<Body>,
        round: &Round,
    ) -> Option<Vector<Body>> {
        // A NaN is within nothing.
        let known = sigma_am2.xyz.iter().all(|sigma| *sigma <= self.largest_sigma_am2);
        let dipole = residual * -round.inverse_duty();
        (known && dipole.is_finite()).then_some(dipole)
    }
}

/// What the rate at the end of a rest is above its mean over the round while M is fed forward, Body,
/// rad/s; zero when the tensor is that of no body.
pub fn ripple(
    residual: Vector<Body>,
    field: Vector<Body>,
    inertia_kg_m2: &Matrix3<f32>,
    round: &Round,
) -> Vector<Body> {
    let torque = residual.cross(&field).xyz;
    let acceleration = inertia_kg_m2.try_inverse().map(|inverse| inverse * torque);
    let ripple = Vector::from_xyz(acceleration.unwrap_or_default() * (0.5 * round.off_s));
    if ripple.is_finite() { ripple } else { Vector::zero() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    const ROUND: Round = Round { on_s: 5.0, off_s: 2.5 };
    const RESIDUAL: [f32; 3] = [-0.3211, -0.2094, -0.0201];
    const SIGMA: f32 = 0.01;

    fn m() -> Vector<Body> {
        let [x, y, z] = RESIDUAL;
        Vector::new(x, y, z)
    }

    fn fed(sigma: f32) -> Option<Vector<Body>> {
        FeedForward::new(SIGMA).unwrap().dipole(m(), Vector::new(0.001, sigma, 0.001), &ROUND)
    }

    #[test]
    fn the_impulse_of_a_whole_round_vanishes() {
        let impulse = fed(0.005).unwrap() * ROUND.on_s + m() * (ROUND.on_s + ROUND.off_s);
        // Rounding of products of a few A·m²·s.
        assert!(impulse.norm() < 1e-6, "{impulse:?}");
    }

    #[test]
    fn an_estimate_that_is_too_vague_or_not_a_number_is_not_fed_forward() {
        assert!(fed(0.0101).is_none());
        assert!(fed(f32::NAN).is_none());
        let forward = FeedForward::new(SIGMA).unwrap();
        assert!(forward.dipole(Vector::new(f32::NAN, 0.0, 0.0), Vector::zero(), &ROUND).is_none());
    }

    #[test]
    fn the_ripple_is_what_a_step_by_step_round_shows() {
        // Rate against time in steps of 10 ms: the mean's rectangle rule is off by half a step.
        const STEP_S: f32 = 0.01;
        const TOLERANCE: f32 = 0.01;
        let inertia = Matrix3::from_diagonal(&Vector3::new(0.052, 0.054, 0.060));
        let field = Vector::<Body>::new(2e-5, -1e-5, 3e-5);
        let inverse = inertia.try_inverse().unwrap();
        let fed = fed(0.005).unwrap();
        let (mut rate, mut sum, mut at_the_end) = (Vector3::zeros(), Vector3::zeros(), None);
        for step in 0..750 {
            let acting = step >= 250;
            if step == 250 {
                at_the_end = Some(rate);
            }
            let dipole = if acting { m() + fed } else { m() };
            rate += inverse * dipole.cross(&field).xyz * STEP_S;
            sum += rate / 750.0;
        }
        let seen = at_the_end.unwrap() - sum;
        let expected = ripple(m(), field, &inertia, &ROUND).xyz;
        assert!((seen - expected).norm() < TOLERANCE * expected.norm(), "{seen} {expected}");
        // About a hundredth of a degree per second, as large as the orbital rate's sixth.
        assert!(expected.norm() > 1e-4);
        assert_eq!(ripple(m(), field, &Matrix3::zeros(), &ROUND), Vector::zero());
    }

    #[test]
    fn a_largest_sigma_that_lets_nothing_or_everything_through_is_refused() {
        for bad in [0.0, -1.0, f32::NAN, f32::INFINITY] {
            assert!(FeedForward::new(bad).is_err());
        }
    }
}
