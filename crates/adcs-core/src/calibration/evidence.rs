//! Which model the data ask for: more unknowns always leave less, and noise can be fitted too.
//!
//! BIC = n ln (Σρ² / n) + p ln n, ρ = (|B|² − I²) / 2I
//!
//! The residuals are taken relative to 2I because noise enters |B|² with that factor: ρ scatters alike
//! everywhere, as the criterion assumes. Sources: Schwarz (1978), Ann. Statist. 6(2), 461–464; Kass &
//! Raftery (1995), J. Am. Stat. Assoc. 90(430), 773–795, for the scale of differences.

use nalgebra::{RealField, convert_unchecked};

use super::Extended;

/// A larger model is taken when its BIC is lower by this: "very strong evidence" (Kass & Raftery).
pub const VERY_STRONG: f64 = 10.0;

/// What a fit left, and with how many unknowns.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Evidence {
    /// n.
    pub samples: u32,
    /// p.
    pub unknowns: u32,
    /// Root mean square of ρ, in any unit that the compared fits share.
    pub rms: f64,
}

impl Evidence {
    /// Of a calibration.
    pub fn of<T: RealField + Copy, const N: usize>(found: &Extended<T, N>) -> Self {
        Self {
            samples: found.samples,
            unknowns: N as u32,
            rms: convert_unchecked(found.norm_error_rms),
        }
    }

    /// Schwarz' criterion; the lower, the better. Only differences mean something.
    pub fn bic(&self) -> f64 {
        let n = f64::from(self.samples.max(1));
        // A fit without residual is as good as doubles can tell.
        2.0 * n * libm::log(self.rms.max(f64::MIN_POSITIVE))
            + f64::from(self.unknowns) * libm::log(n)
    }

    /// Whether this larger model is asked for by the data that left `smaller` with the other.
    pub fn beats(&self, smaller: &Self) -> bool {
        self.bic() < smaller.bic() - VERY_STRONG
    }

    /// The F statistic of the unknowns that this model has beside those of `smaller`: about 1 when they
    /// fit noise. `None` when the two cannot be compared.
    ///
    /// F = (R₀ − R₁) / (p₁ − p₀) / (R₁ / (n − p₁)), R being Σρ².
    pub fn f_statistic(&self, smaller: &Self) -> Option<f64> {
        let more = self.unknowns.checked_sub(smaller.unknowns).filter(|more| *more > 0)?;
        let left = self.samples.checked_sub(self.unknowns).filter(|left| *left > 0)?;
        let ratio = (smaller.rms / self.rms) * (smaller.rms / self.rms);
        let f = (ratio - 1.0) * f64::from(left) / f64::from(more);
        f.is_finite().then_some(f)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn evidence(unknowns: u32, rms: f64) -> Evidence {
        Evidence { samples: 200, unknowns, rms }
    }

    #[test]
    fn unknowns_that_fit_noise_are_not_asked_for_and_those_that_explain_something_are() {
        let small = evidence(6, 500.0);
        // Three unknowns that fit noise take 3/194 of the squares.
        let noise = evidence(9, 500.0 * libm::sqrt(191.0 / 194.0));
        assert!(!noise.beats(&small));
        let f = noise.f_statistic(&small).unwrap();
        assert!((f - 1.0).abs() < 1e-9, "{f}");
        assert!(evidence(9, 400.0).beats(&small));
        assert_eq!(small.f_statistic(&noise), None);
    }
}
