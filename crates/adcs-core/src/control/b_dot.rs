//! B-dot despin from gyro and magnetometer.
//!
//! In Body the field turns past the satellite: dB/dt ≈ −ω × B. The law opposes that change,
//!
//! m = −k dB/dt = k (ω × B)
//!
//! and its torque T = m × B takes power ω · T = −k |ω × B|² ≤ 0 out of the tumble.
//!
//! | symbol | code | meaning |
//! |---|---|---|
//! | ω | `omega_bi` | rate of Body relative to Eci, Body, rad/s |
//! | B | `field` | flux density, Body, T |
//! | m | result | dipole, Body, A·m², before any limit |
//!
//! Source: the paper names the law and its gain (100000) without a formula or unit; this is the
//! reading under which that gain neither saturates nor sleeps (docs/paper). Stickler & Alfriend
//! (1976) for B-dot, Wertz (1978) §18.3.

use core::fmt;

use serde::{Deserialize, Serialize};

use crate::frames::{Body, Vector};

/// Which form of the law, with its gain.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum BDotGain {
    /// m = k (ω × B), k in A·m²·s/T. The paper's 100000 in SI.
    Plain {
        /// k, A·m²·s/T.
        gain_am2_s_per_t: f32,
    },
    /// m = K (ω × B) / |B|²: damping that does not fall with the field. The paper's 100000, if it
    /// was meant for nanotesla, is K = 1e-4 N·m·s; the two agree at |B| = 31.6 µT.
    Normalised {
        /// K, N·m·s.
        gain_n_m_s: f32,
    },
}

/// Why a gain is refused: it must be positive (a negative one spins the satellite up) and finite.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct GainError {
    /// The gain that was given.
    pub found: f32,
}

impl fmt::Display for GainError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the gain {} must be positive and finite", self.found)
    }
}

impl core::error::Error for GainError {}

/// The despin law with an accepted gain.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BDot {
    gain: BDotGain,
}

/// Fields weaker than this are no geomagnetic field anywhere in low orbit (the weakest is about
/// 17 µT at 620 km); the normalised law does not divide by them.
const WEAKEST_FIELD_T: f32 = 1e-6;

impl BDot {
    /// Accepts a gain.
    ///
    /// # Errors
    /// [`GainError`] when it is not positive and finite.
    pub fn new(gain: BDotGain) -> Result<Self, GainError> {
        let (BDotGain::Plain { gain_am2_s_per_t: value }
        | BDotGain::Normalised { gain_n_m_s: value }) = gain;
        if value.is_finite() && value > 0.0 {
            Ok(Self { gain })
        } else {
            Err(GainError { found: value })
        }
    }

    /// The dipole that opposes the turning of the field, Body, A·m², not yet limited. `None` when
    /// the inputs do not give a finite dipole, or when the normalised law has no field to divide by;
    /// the torquers then stay off.
    pub fn dipole(&self, omega_bi: Vector<Body>, field: Vector<Body>) -> Option<Vector<Body>> {
        let omega_cross_b = omega_bi.cross(&field);
        let dipole = match self.gain {
            BDotGain::Plain { gain_am2_s_per_t } => omega_cross_b * gain_am2_s_per_t,
            BDotGain::Normalised { gain_n_m_s } => {
                let b2 = field.dot(&field);
                if b2 < WEAKEST_FIELD_T * WEAKEST_FIELD_T {
                    return None;
                }
                omega_cross_b * (gain_n_m_s / b2)
            }
        };
        dipole.is_finite().then_some(dipole)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const PAPER: BDotGain = BDotGain::Plain { gain_am2_s_per_t: 1e5 };
    const NORMALISED: BDotGain = BDotGain::Normalised { gain_n_m_s: 1e-4 };

    fn vector(range: core::ops::Range<f32>) -> impl Strategy<Value = Vector<Body>> {
        [range.clone(), range.clone(), range].prop_map(|[x, y, z]| Vector::new(x, y, z))
    }

    proptest! {
        #[test]
        fn the_torque_never_adds_power(
            omega in vector(-0.5..0.5), field in vector(-6e-5..6e-5),
        ) {
            for gain in [PAPER, NORMALISED] {
                if let Some(dipole) = BDot::new(gain).unwrap().dipole(omega, field) {
                    let torque = dipole.cross(&field);
                    // Rounding of the two cross products and the dot product.
                    let rounding = 1e-6 * dipole.norm() * field.norm() * omega.norm();
                    prop_assert!(omega.dot(&torque) <= rounding);
                }
            }
        }

        #[test]
        fn whatever_comes_in_nothing_infinite_comes_out(
            omega in [any::<f32>(), any::<f32>(), any::<f32>()],
            field in [any::<f32>(), any::<f32>(), any::<f32>()],
        ) {
            let [omega, field] = [omega, field].map(|[x, y, z]| Vector::new(x, y, z));
            for gain in [PAPER, NORMALISED] {
                if let Some(dipole) = BDot::new(gain).unwrap().dipole(omega, field) {
                    prop_assert!(dipole.is_finite());
                }
            }
        }
    }

    #[test]
    fn plain_and_normalised_agree_at_31_6_microtesla() {
        let omega = Vector::new(0.05, -0.02, 0.1);
        let field = Vector::new(31.622_777e-6, 0.0, 0.0);
        let plain = BDot::new(PAPER).unwrap().dipole(omega, field).unwrap();
        let normalised = BDot::new(NORMALISED).unwrap().dipole(omega, field).unwrap();
        assert!((plain - normalised).norm() < 1e-6 * plain.norm());
    }

    #[test]
    fn gains_that_would_spin_up_or_say_nothing_are_refused() {
        for bad in [0.0, -1e5, f32::NAN, f32::INFINITY] {
            assert!(BDot::new(BDotGain::Plain { gain_am2_s_per_t: bad }).is_err());
            assert!(BDot::new(BDotGain::Normalised { gain_n_m_s: bad }).is_err());
        }
    }

    #[test]
    fn the_normalised_law_has_no_dipole_without_a_field() {
        let law = BDot::new(NORMALISED).unwrap();
        assert!(law.dipole(Vector::new(0.1, 0.0, 0.0), Vector::zero()).is_none());
    }
}
