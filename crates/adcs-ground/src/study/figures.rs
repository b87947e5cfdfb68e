//! Errors pooled over flights.

use nalgebra::{Matrix3, Vector3};

/// Mean of what was seen.
#[derive(Debug, Clone, Copy, Default)]
pub struct Mean {
    sum: f64,
    count: u64,
}

impl Mean {
    /// Takes in one value (for an rms its square).
    pub fn see(&mut self, value: f64) {
        self.sum += value;
        self.count += 1;
    }

    /// Takes in what another has seen.
    pub fn join(&mut self, other: &Self) {
        self.sum += other.sum;
        self.count += other.count;
    }

    /// NaN when nothing was seen.
    pub fn mean(&self) -> f64 {
        self.sum / self.count as f64
    }

    /// Root of the mean.
    pub fn rms(&self) -> f64 {
        self.mean().sqrt()
    }
}

/// Errors of the residual dipole at one time into the flights.
#[derive(Debug, Clone, Copy, Default)]
pub struct DipoleError {
    /// Largest of any axis and flight, A·m².
    pub largest_am2: f64,
    /// Mean square of an axis, (A·m²)².
    pub axis: Mean,
}

/// What one filter, or bound, comes to in one flight or in many.
#[derive(Debug, Clone, Copy, Default)]
pub struct Figures {
    /// Squared total angle in sunlight, rad².
    pub sunlit: Mean,
    /// Squared total angle in eclipse, rad².
    pub eclipse: Mean,
    /// Squared norm of the error of the rate, (rad/s)².
    pub rate: Mean,
    /// Squared norm of the error of the gyro bias, (rad/s)².
    pub bias: Mean,
    /// θᵀ P⁻¹ θ; 3 on average when the filter is as sure as it may be.
    pub nees: Mean,
    /// Errors of the residual dipole 1,200 s and 3,000 s into the flight.
    pub dipole: [DipoleError; 2],
    /// Seconds without an estimate after the start-up time.
    pub without: u32,
    /// Seconds in which the estimate was not trusted.
    pub distrusted: u32,
    /// How often the filter was started.
    pub starts: u32,
    /// Seconds in which the covariance had no Cholesky factor.
    pub not_positive: u32,
}

impl Figures {
    /// Takes in an error of the attitude (Body, rad) that was promised to have this covariance.
    pub fn see_attitude(&mut self, theta: &Vector3<f64>, covariance: &Matrix3<f64>, lit: bool) {
        let square = theta.norm_squared();
        if lit { &mut self.sunlit } else { &mut self.eclipse }.see(square);
        if let Some(inverse) = covariance.try_inverse() {
            self.nees.see(theta.dot(&(inverse * theta)));
        }
    }

    /// Takes in what a bound promises.
    pub fn see_bound(&mut self, covariance: &Matrix3<f64>, lit: bool) {
        if lit { &mut self.sunlit } else { &mut self.eclipse }.see(covariance.trace());
    }

    /// Takes in an error of the residual dipole, A·m², at time number `at`.
    pub fn see_dipole(&mut self, at: usize, error: &Vector3<f64>) {
        if let Some(dipole) = self.dipole.get_mut(at) {
            dipole.largest_am2 = dipole.largest_am2.max(error.amax());
            error.iter().for_each(|axis| dipole.axis.see(axis * axis));
        }
    }

    /// Takes in another flight.
    pub fn join(&mut self, other: &Self) {
        self.sunlit.join(&other.sunlit);
        self.eclipse.join(&other.eclipse);
        self.rate.join(&other.rate);
        self.bias.join(&other.bias);
        self.nees.join(&other.nees);
        for (dipole, other) in self.dipole.iter_mut().zip(&other.dipole) {
            dipole.largest_am2 = dipole.largest_am2.max(other.largest_am2);
            dipole.axis.join(&other.axis);
        }
        self.without += other.without;
        self.distrusted += other.distrusted;
        self.starts += other.starts;
        self.not_positive += other.not_positive;
    }
}
