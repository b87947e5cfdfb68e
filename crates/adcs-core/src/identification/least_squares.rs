//! Linear least squares over sums, with the covariance that the residuals show.

use nalgebra::{RealField, SMatrix, SVector};

use super::error::IdentificationError;
use super::{number, shown};
use crate::calibration::{Spectrum, sigmas};

/// Above this condition of the scaled normal matrix the combination of unknowns known least is uncertain
/// by 100 times what the best one is.
pub const MAX_CONDITION: f64 = 1e4;
/// Equations for each unknown.
const PER_UNKNOWN: u32 = 3;

/// Sums of equations aᵀx = y, of errors that are alike.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Normal<T: RealField + Copy, const N: usize> {
    /// Σ a aᵀ
    normal: SMatrix<T, N, N>,
    /// Σ a y
    right: SVector<T, N>,
    /// Σ y²
    squares: T,
    equations: u32,
}

/// Unknowns, and how well they are known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Solution<T: RealField + Copy, const N: usize> {
    /// The unknowns.
    pub x: SVector<T, N>,
    /// Their covariance, in proportion to the residuals.
    pub covariance: SMatrix<T, N, N>,
    /// Root mean square of what is left of an equation.
    pub residual_rms: T,
    /// Condition of the normal matrix, or of the covariance, with its diagonal scaled to ones.
    pub condition: T,
    /// How many equations there were.
    pub equations: u32,
}

impl<T: RealField + Copy, const N: usize> Solution<T, N> {
    /// Standard deviations of the unknowns.
    pub fn sigma(&self) -> SVector<T, N> {
        sigmas(&self.covariance)
    }
}

impl<T: RealField + Copy, const N: usize> Default for Normal<T, N> {
    fn default() -> Self {
        Self { normal: SMatrix::zeros(), right: SVector::zeros(), squares: T::zero(), equations: 0 }
    }
}

impl<T: RealField + Copy, const N: usize> Normal<T, N> {
    /// Adds three equations, the rows of `a`.
    pub fn add(&mut self, a: &SMatrix<T, 3, N>, y: &SVector<T, 3>) {
        self.normal += a.tr_mul(a);
        self.right += a.tr_mul(y);
        self.squares += y.norm_squared();
        self.equations = self.equations.saturating_add(3);
    }

    /// Adds one equation.
    pub fn add_one(&mut self, a: &SVector<T, N>, y: T) {
        self.normal += a * a.transpose();
        self.right += a * y;
        self.squares += y * y;
        self.equations = self.equations.saturating_add(1);
    }

    /// Solves.
    ///
    /// # Errors
    /// [`IdentificationError`]: too few equations, or unknowns that they do not tell apart.
    pub fn solve(&self) -> Result<Solution<T, N>, IdentificationError> {
        let needed = PER_UNKNOWN * N as u32;
        let found = self.equations;
        if found < needed {
            return Err(IdentificationError::TooFew { found, needed });
        }
        let spectrum = Spectrum::of(&self.normal);
        let (condition, limit) = (spectrum.condition(), number(MAX_CONDITION));
        // A NaN fails the comparison.
        let supported = condition <= limit;
        if !supported {
            return Err(IdentificationError::PoorGeometry {
                condition: shown(condition),
                limit: shown(limit),
                weakest: spectrum.weakest() as u8,
            });
        }
        let x = spectrum.step(&-self.right, T::zero());
        let left = (self.squares - x.dot(&self.right)).max(T::zero());
        let freedom = number::<T>(f64::from(found) - N as f64);
        let covariance = spectrum.inverse() * (left / freedom);
        let finite = x.iter().chain(covariance.iter()).all(nalgebra::ComplexField::is_finite);
        if !finite {
            return Err(IdentificationError::OutOfRange);
        }
        let residual_rms = (left / freedom).sqrt();
        Ok(Solution { x, covariance, residual_rms, condition, equations: found })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector2;

    #[test]
    fn what_is_not_told_apart_is_named() {
        let mut normal = Normal::<f32, 2>::default();
        assert_eq!(normal.solve(), Err(IdentificationError::TooFew { found: 0, needed: 6 }));
        (0..10).for_each(|_| normal.add_one(&Vector2::new(1.0, 0.0), 1.0));
        let error = normal.solve().unwrap_err();
        assert!(matches!(error, IdentificationError::PoorGeometry { weakest: 1, .. }), "{error}");
    }
}
