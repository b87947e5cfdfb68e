//! A measurement absorbed into an estimate of N states, one scalar after the other.
//!
//! For z = hᵀx + v, E[v²] = r, innovation ν:
//!
//! | symbol | code | meaning |
//! |---|---|---|
//! | h, ν, r | [`Row`] | one scalar measurement |
//! | s | `innovation_variance` | hᵀP h + r |
//! | k | `gain` | P h / s |
//! | P⁺ | `covariance` | (I − k hᵀ) P (I − k hᵀ)ᵀ + r k kᵀ (Joseph) |
//! | NIS | `nis` | Σ ν² / s, the squared innovation in units of what was expected |
//!
//! Scalars instead of vectors: nothing is inverted, and nothing but s > 0 is divided by. With
//! measurement noise that is uncorrelated between the rows the result is that of the vector update, and
//! the sum of ν²/s is the vector's νᵀ S⁻¹ ν.
//!
//! Joseph's form instead of P − k hᵀ P: the short form is right only for the exact gain, and in f32
//! no gain is exact; after a first measurement that is 1e5 times better than the prior it leaves
//! nothing but rounding. It is computed as two rank-one corrections (Bierman), O(N²).
//! A U-D factorisation would keep P positive by construction, but turns the propagation into a weighted
//! Gram-Schmidt that does not see that Φ₂₂ = I and Φ₂₁ = 0; with P as well conditioned as these
//! sensors leave it (docs/filters) it would pay for nothing.
//!
//! The kernel knows no filter: any that keeps its attitude error in the first three states can use the
//! same measurement models.
//!
//! Source: Bierman (1977), §II.5, §III.4; Markley & Crassidis (2014), §12.3.4.

use nalgebra::{ComplexField, RealField, SMatrix, SVector, Vector3, convert};

/// One scalar measurement, linearised at the estimate.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Row<T: RealField + Copy, const N: usize> {
    /// What a small change of each state does to the measurement.
    pub(crate) h: SVector<T, N>,
    /// Measured minus expected.
    pub(crate) innovation: T,
    /// Variance of the measurement's noise.
    pub(crate) variance: T,
}

impl<T: RealField + Copy, const N: usize> Row<T, N> {
    /// A measurement that sees the attitude error alone: the first three states.
    pub(crate) fn of_attitude(h: Vector3<T>, innovation: T, variance: T) -> Self {
        let mut row = Self { h: SVector::zeros(), innovation, variance };
        for (state, of_attitude) in row.h.iter_mut().zip(h.iter()) {
            *state = *of_attitude;
        }
        row
    }
}

/// What a measurement would make of the estimate.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Correction<T: RealField + Copy, const N: usize> {
    /// To be added to the states.
    pub(crate) states: SVector<T, N>,
    /// The covariance afterwards.
    pub(crate) covariance: SMatrix<T, N, N>,
    /// Normalised innovation squared, M degrees of freedom.
    pub(crate) nis: T,
}

/// Absorbs `rows`, whose noises are uncorrelated, into a copy: the caller looks at the NIS before
/// anything counts.
///
/// `None` when the covariance gives a row a negative or no variance, or a number is not finite.
pub(crate) fn absorb<T: RealField + Copy, const N: usize, const M: usize>(
    covariance: &SMatrix<T, N, N>,
    rows: &[Row<T, N>; M],
) -> Option<Correction<T, N>> {
    let mut correction =
        Correction { states: SVector::zeros(), covariance: *covariance, nis: T::zero() };
    for row in rows {
        correction.absorb(row)?;
    }
    let finite =
        correction.nis.is_finite() && correction.states.iter().all(ComplexField::is_finite);
    finite.then_some(correction)
}

impl<T: RealField + Copy, const N: usize> Correction<T, N> {
    /// One row more.
    fn absorb(&mut self, row: &Row<T, N>) -> Option<()> {
        let Row { h, innovation, variance } = row;
        let ph = self.covariance * h;
        let innovation_variance = h.dot(&ph) + *variance;
        // Also refuses NaN.
        if !(innovation_variance >= *variance && *variance > T::zero()) {
            return None;
        }
        let gain = ph / innovation_variance;
        // Earlier rows of the same measurement have moved the states already.
        let residual = *innovation - h.dot(&self.states);
        self.states += gain * residual;
        self.nis += residual * residual / innovation_variance;

        // (I − k hᵀ) P, then times (I − k hᵀ)ᵀ, plus r k kᵀ.
        let short = self.covariance - gain * ph.transpose();
        let again = short * h;
        let joseph = short + (gain * *variance - again) * gain.transpose();
        let half: T = convert(0.5);
        self.covariance = (joseph + joseph.transpose()) * half;
        Some(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Matrix2, Matrix4, SMatrix, Vector2, Vector4};

    fn prior() -> Matrix4<f64> {
        let root = Matrix4::from_fn(|i, j| libm::cos((5 * i + 3 * j) as f64));
        root * root.transpose() + Matrix4::identity() * 0.1
    }

    #[test]
    fn scalars_one_by_one_are_the_vector_update() {
        let p = prior();
        let h = SMatrix::<f64, 2, 4>::new(0.3, -0.1, 0.9, 0.0, 0.5, 0.4, -0.2, 0.1);
        let r = Matrix2::new(0.02, 0.0, 0.0, 0.07);
        let innovation = Vector2::new(0.4, -0.3);
        let rows = [0, 1].map(|i| Row {
            h: h.row(i).transpose(),
            innovation: innovation[i],
            variance: r[(i, i)],
        });
        let sequential = absorb(&p, &rows).unwrap();

        let s = (h * p * h.transpose() + r).try_inverse().unwrap();
        let gain = p * h.transpose() * s;
        let states: Vector4<f64> = gain * innovation;
        let covariance = (Matrix4::identity() - gain * h) * p;
        let nis = (innovation.transpose() * s * innovation)[0];
        // Rounding of a 2 × 2 inverse of condition 10.
        const ROUNDING: f64 = 1e-14;
        assert!((sequential.states - states).norm() < ROUNDING);
        assert!((sequential.covariance - covariance).norm() < ROUNDING);
        assert!((sequential.nis - nis).abs() < ROUNDING);
    }

    #[test]
    fn a_measurement_a_hundred_thousand_times_better_leaves_its_own_variance_in_f32() {
        // The short form P − k hᵀ P would leave 1e-6 of rounding here.
        let prior = SMatrix::<f32, 3, 3>::identity() * 10.0;
        let variance = 1e-4;
        for h in [Vector3::x(), Vector3::new(0.6, 0.48, 0.64)] {
            let row = Row { h, innovation: 0.0, variance };
            let after = absorb(&prior, &[row]).unwrap().covariance;
            let left = (h.transpose() * after * h)[0];
            assert!((left - variance).abs() < 0.02 * variance, "{left}");
            assert!(after.cholesky().is_some());
        }
    }

    #[test]
    fn what_cannot_be_a_measurement_is_refused() {
        let row = Row { h: Vector2::new(1.0, 0.0), innovation: 0.1, variance: 0.01_f32 };
        let identity = Matrix2::identity();
        assert!(absorb(&identity, &[row]).is_some());
        assert!(absorb(&-identity, &[row]).is_none());
        assert!(absorb(&(identity * f32::NAN), &[row]).is_none());
        for innovation in [f32::NAN, f32::INFINITY] {
            assert!(absorb(&identity, &[Row { innovation, ..row }]).is_none());
        }
        for variance in [0.0, -1.0, f32::NAN] {
            assert!(absorb(&identity, &[Row { variance, ..row }]).is_none());
        }
    }
}
