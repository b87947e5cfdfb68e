//! Residual dipole and inertia ratios, from the balance of momentum while the torquers rest.

use super::findings::{Finding, InertiaFound, Rung, Three, worst};
use super::ladder::{Judged, Seen};
use super::parameters::CommissioningParameters;
use crate::identification::momentum::{MomentumFit, RATIO_UNKNOWNS};
use crate::identification::{Noise, Solution};

/// What acts besides, each axis, in the mean square, N·m: half of what the gravity gradient of SPROUT would at rest. In
/// a tumble it goes round with the body, and more would make σ of the residual dipole too large by a third.
const DISTURBANCE_N_M: f32 = 3e-9;

/// The estimate.
#[derive(Debug, Clone, Copy)]
pub(super) struct Momentum {
    estimate: MomentumFit<f32, RATIO_UNKNOWNS>,
    mean_moment: f32,
}

impl Momentum {
    pub fn new(
        inertia_kg_m2: [[f32; 3]; 3],
        noise: Noise<f32>,
        gyro: Option<Three>,
    ) -> Option<Self> {
        let [[xx, ..], [_, yy, _], [.., zz]] = inertia_kg_m2;
        let fresh = MomentumFit::ratios(inertia_kg_m2, noise).ok()?;
        let fresh = fresh.with_disturbance(DISTURBANCE_N_M);
        let estimate = match gyro {
            Some(gyro) => fresh.with_gyro_bias(gyro.value, worst(&gyro.sigma)),
            None => fresh,
        };
        Some(Self { estimate, mean_moment: (xx + yy + zz) / 3.0 })
    }

    #[inline(never)]
    pub fn see(&mut self, seen: &Seen) {
        let Some(instant) = &seen.instant else { return };
        self.estimate.add(&instant.recorded(seen.quiet_field()));
    }

    pub fn judged(&self, p: &CommissioningParameters, rung: Rung) -> Judged {
        let solution = self.estimate.solve().ok()?;
        let dipole = dipole(&solution);
        if rung == Rung::Dipole {
            return Some((Finding::Dipole(dipole), dipole.worst_sigma() <= p.dipole_sigma_am2));
        }
        let tensor_kg_m2 = self.estimate.tensor(&solution);
        let sigma_kg_m2 = tensor_sigma(&solution);
        let sharp = worst(sigma_kg_m2.as_flattened()) <= p.inertia_sigma * self.mean_moment;
        Some((Finding::Inertia(InertiaFound { tensor_kg_m2, sigma_kg_m2 }), sharp))
    }
}

fn dipole(solution: &Solution<f32, RATIO_UNKNOWNS>) -> Three {
    let sigma = solution.sigma();
    let first =
        |v: &nalgebra::SVector<f32, RATIO_UNKNOWNS>| v.fixed_rows::<3>(0).into_owned().into();
    Three { value: first(&solution.x), sigma: first(&sigma) }
}

/// σ of the tensor's entries. The unknowns add a to xx, b to yy and take both from zz.
fn tensor_sigma(solution: &Solution<f32, RATIO_UNKNOWNS>) -> [[f32; 3]; 3] {
    let covariance = &solution.covariance;
    let root = |variance: f32| libm::sqrtf(variance.max(0.0));
    let [_, _, _, xx, yy, xy, xz, yz] = <[f32; RATIO_UNKNOWNS]>::from(solution.sigma());
    let between = covariance[(3, 4)];
    let zz = root(xx * xx + yy * yy + 2.0 * between);
    [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]
}
