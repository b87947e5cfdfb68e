//! B-dot at full dipole: only the sign of each axis counts.
//!
//! mᵢ = m₀ sign((ω × B)ᵢ)   where |(ω × B)ᵢ| > n σᵢ, otherwise 0
//!
//! | symbol | code | meaning |
//! |---|---|---|
//! | ω | `omega_bi` | rate against Eci, rad/s |
//! | B | `field` | flux density, T |
//! | m₀ | [`BangBangParameters::dipole_am2`] | dipole of each axis, A·m² |
//! | n | [`BangBangParameters::dead_band_sigmas`] | half-width of the dead band in σ |
//! | σᵢ | | noise of (ω × B)ᵢ: σᵢ² = σ_ω² (Bⱼ² + Bₖ²) + σ_B² (ωⱼ² + ωₖ²) |
//!
//! The power taken out of the tumble, −m · (ω × B) = −m₀ Σ |(ω × B)ᵢ|, is never positive. Without a dead
//! band a satellite at rest is driven by the sign of its sensors' noise; with it the law falls silent at
//! rates across the field of about n σ_ω, three times 0.163 deg/s for SPROUT's gyros.
//!
//! The signs hold along the axes of the torquers: of a vector of signs that is turned into other axes
//! and clipped there, nothing is known. So `F` should be `TorquerAxes`.
//!
//! Source: Wertz (1978), §18.3 (bang-bang form of Ḃ control).

use core::fmt;

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use crate::frames::Vector;

/// The law as stored and uplinked.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct BangBangParameters {
    /// m₀: the dipole of each axis that acts, A·m².
    pub dipole_am2: f32,
    /// n: half-width of the dead band in σ of the noise; 3 lets through one wrong sign in 370.
    pub dead_band_sigmas: f32,
    /// σ_ω of each axis of the rate, rad/s.
    pub rate_noise_rad_s: f32,
    /// σ_B of each axis of the field, T.
    pub field_noise_t: f32,
}

/// Why the law is refused.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum BangBangError {
    /// The dipole must be positive (a negative one spins the satellite up) and finite.
    Dipole {
        /// What was given, A·m².
        found: f32,
    },
    /// Dead band and noise must be finite and not negative.
    DeadBand {
        /// What was given, in the parameter's unit.
        found: f32,
    },
}

impl fmt::Display for BangBangError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Dipole { found } => {
                write!(f, "the dipole {found} A·m² must be positive and finite")
            }
            Self::DeadBand { found } => {
                write!(f, "{found} in the dead band must be finite and not negative")
            }
        }
    }
}

impl core::error::Error for BangBangError {}

/// The law with accepted parameters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BangBang {
    parameters: BangBangParameters,
}

impl BangBang {
    /// Accepts parameters.
    ///
    /// # Errors
    /// [`BangBangError`] with the value.
    pub fn new(parameters: &BangBangParameters) -> Result<Self, BangBangError> {
        let BangBangParameters { dipole_am2, dead_band_sigmas, rate_noise_rad_s, field_noise_t } =
            *parameters;
        if !(dipole_am2.is_finite() && dipole_am2 > 0.0) {
            return Err(BangBangError::Dipole { found: dipole_am2 });
        }
        for found in [dead_band_sigmas, rate_noise_rad_s, field_noise_t] {
            if !(found.is_finite() && found >= 0.0) {
                return Err(BangBangError::DeadBand { found });
            }
        }
        Ok(Self { parameters: *parameters })
    }

    /// The dipole along the axes in which rate and field are given, A·m². `None` when one of them is
    /// not finite, or so large that their product is not.
    pub fn dipole<F>(&self, omega_bi: Vector<F>, field: Vector<F>) -> Option<Vector<F>> {
        let BangBangParameters { dipole_am2, dead_band_sigmas, rate_noise_rad_s, field_noise_t } =
            self.parameters;
        let (omega, b) = (omega_bi.xyz, field.xyz);
        let omega_cross_b = omega.cross(&b);
        let squares = |v: Vector3<f32>| v.component_mul(&v);
        let (omega2, b2) = (squares(omega), squares(b));
        // Bⱼ² + Bₖ² and ωⱼ² + ωₖ² of each axis.
        let across = |s: Vector3<f32>| Vector3::new(s.y + s.z, s.z + s.x, s.x + s.y);
        let variance = across(b2) * (rate_noise_rad_s * rate_noise_rad_s)
            + across(omega2) * (field_noise_t * field_noise_t);
        if !(omega_cross_b.iter().chain(variance.iter()).all(|x| x.is_finite())) {
            return None;
        }
        Some(Vector::from_xyz(omega_cross_b.zip_map(&variance, |c, variance| {
            let dead_band = dead_band_sigmas * libm::sqrtf(variance);
            match c {
                c if c > dead_band => dipole_am2,
                c if c < -dead_band => -dipole_am2,
                _ => 0.0,
            }
        })))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frames::TorquerAxes;
    use proptest::prelude::*;

    const SPROUT: BangBangParameters = BangBangParameters {
        dipole_am2: 0.6,
        dead_band_sigmas: 3.0,
        rate_noise_rad_s: 0.163 * core::f32::consts::PI / 180.0,
        field_noise_t: 5.86e-7,
    };

    fn law() -> BangBang {
        BangBang::new(&SPROUT).unwrap()
    }

    proptest! {
        #[test]
        fn the_torque_never_adds_power(
            omega in [-0.5_f32..0.5, -0.5_f32..0.5, -0.5_f32..0.5],
            field in [-6e-5_f32..6e-5, -6e-5_f32..6e-5, -6e-5_f32..6e-5],
        ) {
            let [omega, field] =
                [omega, field].map(|[x, y, z]| Vector::<TorquerAxes>::new(x, y, z));
            let dipole = law().dipole(omega, field).unwrap();
            // Rounding of the two cross products and the dot product.
            let rounding = 1e-6 * dipole.norm() * field.norm() * omega.norm();
            prop_assert!(omega.dot(&dipole.cross(&field)) <= rounding);
        }
    }

    #[test]
    fn each_axis_is_off_or_full_and_has_the_sign_of_omega_cross_b() {
        // ω × B = (0.05 · 3e-5, −0.1 · 3e-5, 0): 2.9 and 5.7 deg/s across 30 µT.
        let (omega, field) =
            (Vector::<TorquerAxes>::new(0.1, 0.05, 0.0), Vector::new(0.0, 0.0, 3e-5));
        assert_eq!(law().dipole(omega, field).unwrap().to_array(), [0.6, -0.6, 0.0]);
    }

    #[test]
    fn within_the_dead_band_of_three_sigma_the_torquers_are_off() {
        let field = Vector::<TorquerAxes>::new(0.0, 0.0, 3e-5);
        let turning = |sigmas: f32| Vector::new(SPROUT.rate_noise_rad_s * sigmas, 0.0, 0.0);
        // The field's noise adds a thousandth of σ at these rates.
        assert_eq!(law().dipole(turning(2.99), field).unwrap(), Vector::zero());
        assert_eq!(law().dipole(turning(3.02), field).unwrap().to_array(), [0.0, -0.6, 0.0]);
    }

    #[test]
    fn parameters_that_would_spin_up_or_say_nothing_are_refused() {
        for bad in [0.0, -0.6, f32::NAN, f32::INFINITY] {
            assert!(BangBang::new(&BangBangParameters { dipole_am2: bad, ..SPROUT }).is_err());
        }
        for bad in [-1.0, f32::NAN, f32::INFINITY] {
            assert!(
                BangBang::new(&BangBangParameters { dead_band_sigmas: bad, ..SPROUT }).is_err()
            );
            assert!(
                BangBang::new(&BangBangParameters { rate_noise_rad_s: bad, ..SPROUT }).is_err()
            );
            assert!(BangBang::new(&BangBangParameters { field_noise_t: bad, ..SPROUT }).is_err());
        }
    }
}
