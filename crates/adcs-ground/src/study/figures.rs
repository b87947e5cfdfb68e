//! Errors pooled over flights.

use nalgebra::{Matrix3, Vector3};

/// Mean square of what was seen.
#[derive(Debug, Clone, Copy, Default)]
pub struct MeanSquare {
    sum: f64,
    count: u64,
}

impl MeanSquare {
    pub fn see(&mut self, square: f64) {
        self.sum += square;
        self.count += 1;
    }

    pub fn join(&mut self, other: &Self) {
        self.sum += other.sum;
        self.count += other.count;
    }

    /// Mean of what was seen; NaN when that is nothing.
    pub fn mean(&self) -> f64 {
        self.sum / self.count as f64
    }

    pub fn rms(&self) -> f64 {
        self.mean().sqrt()
    }
}

/// What one filter, or bound, comes to in one flight or in many.
#[derive(Debug, Clone, Copy, Default)]
pub struct Figures {
    /// Total angle, rad, in sunlight and in eclipse.
    pub sunlit: MeanSquare,
    pub eclipse: MeanSquare,
    /// Norm of the error of the rate, rad/s.
    pub rate: MeanSquare,
    /// Norm of the error of the gyro bias, rad/s.
    pub bias: MeanSquare,
    /// θᵀ P⁻¹ θ; 3 on average when the filter is as sure as it may be.
    pub nees: MeanSquare,
    /// Largest error of the residual dipole, any axis, A·m², about 1,200 s, 3,000 s and at the end.
    pub dipole: [f64; 3],
    /// Seconds in which there was no estimate after the start-up time.
    pub without: u32,
    /// Seconds in which the dynamics-aided filter was not believed.
    pub distrusted: u32,
    /// How often the filter was started.
    pub starts: u32,
}

impl Figures {
    /// An error of the attitude (Body, rad) that was promised to have this covariance.
    pub fn see_attitude(&mut self, theta: &Vector3<f64>, covariance: &Matrix3<f64>, lit: bool) {
        let square = theta.norm_squared();
        if lit { &mut self.sunlit } else { &mut self.eclipse }.see(square);
        if let Some(inverse) = covariance.try_inverse() {
            self.nees.see(theta.dot(&(inverse * theta)));
        }
    }

    /// What a bound promises.
    pub fn see_bound(&mut self, covariance: &Matrix3<f64>, lit: bool) {
        if lit { &mut self.sunlit } else { &mut self.eclipse }.see(covariance.trace());
    }

    pub fn join(&mut self, other: &Self) {
        self.sunlit.join(&other.sunlit);
        self.eclipse.join(&other.eclipse);
        self.rate.join(&other.rate);
        self.bias.join(&other.bias);
        self.nees.join(&other.nees);
        for (largest, other) in self.dipole.iter_mut().zip(other.dipole) {
            *largest = largest.max(other);
        }
        self.without += other.without;
        self.distrusted += other.distrusted;
        self.starts += other.starts;
    }
}
