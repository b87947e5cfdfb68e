//! The torquers' field at the magnetometer, from one pulse after the other.

use nalgebra::{Matrix3, Vector3};

use super::findings::{CouplingFound, Finding, MagnetometerFound, worst};
use super::ladder::{Judged, Seen};
use super::parameters::CommissioningParameters;
use crate::identification::Noise;
use crate::identification::coupling::{CouplingSample, TorquerCoupling};

/// The estimate.
#[derive(Debug, Clone, Copy)]
pub(super) struct Coupling {
    estimate: TorquerCoupling<f32>,
}

impl Coupling {
    pub fn new(noise: Noise<f32>) -> Self {
        Self { estimate: TorquerCoupling::new(noise) }
    }

    #[inline(never)]
    pub fn see(&mut self, seen: &Seen) {
        let Some((instant, field)) = seen.instant.as_ref().zip(seen.field) else { return };
        self.estimate.add(&CouplingSample {
            dt_s: instant.dt_s,
            rate_rad_s: instant.rate.into(),
            field_t: field.to_array(),
            dipole_am2: instant.carried.into(),
        });
    }

    /// `axes` is the calibration by which the field was read.
    pub fn judged(&self, p: &CommissioningParameters, axes: Option<&MagnetometerFound>) -> Judged {
        let solution = self.estimate.solve().ok()?;
        let t_per_am2 = TorquerCoupling::matrix(&solution.x);
        let own = Matrix3::from(TorquerCoupling::matrix(&solution.sigma()));
        let by_axes = axes.map_or(Matrix3::zeros(), |axes| variance_by_axes(&t_per_am2, axes));
        // Both are filled column by column, as arrays of arrays are.
        let sigma_t_per_am2: [[f32; 3]; 3] =
            own.zip_map(&by_axes, |own, more| libm::sqrtf(own * own + more)).into();
        let sharp = worst(sigma_t_per_am2.as_flattened()) <= p.coupling_sigma_t_per_am2;
        Some((Finding::Coupling(CouplingFound { t_per_am2, sigma_t_per_am2 }), sharp))
    }
}

/// Variances of K's entries by what is wrong with scales and cross-axis terms, in the order of an array of
/// rows: dK = diag(ds / s) K + dC K.
fn variance_by_axes(k: &[[f32; 3]; 3], axes: &MagnetometerFound) -> Matrix3<f32> {
    let k = Matrix3::from(*k).transpose();
    let squares = k.component_mul(&k);
    let value = Vector3::from(axes.scale.value);
    let [x, y, z]: [f32; 3] = Vector3::from(axes.scale.sigma).component_div(&value).into();
    let [xy, xz, yz] = axes.cross_axis.sigma;
    let errors = Matrix3::new(x, xy, xz, xy, y, yz, xz, yz, z);
    (errors.component_mul(&errors) * squares).transpose()
}
