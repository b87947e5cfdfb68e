//! The paper's identification: torque by differences of the rate, and the residual dipole from that.
//!
//! | symbol | code | meaning |
//! |---|---|---|
//! | T = J ω̇ + ω × J ω | [`central_torque`] | eq. (2), ω̇ by central differences |
//! | T − m × B = M × B | [`DipoleByDifferences`] | eq. (3), three unknowns in all rows |
//!
//! The difference of two readings of a gyro, each with the noise σ, has the noise σ/(√2 Δt): for the
//! paper's 0.163 deg/s and steps of 2 s that is a torque of 5·10⁻⁵ N·m, with nothing acting at all
//! ([`torque_noise`]). Longer steps have less noise and flatten what turns meanwhile;
//! [`momentum`](super::momentum) has neither.

use nalgebra::{Matrix3, RealField, Vector3};

use super::field_track::FieldTrack;
use super::{IdentificationError, Inertia, Normal, Recorded, Solution, number, of_unit_dipoles};

/// Torque on a body, N·m, from its rates (rad/s) at three instants `dt_s` apart: the paper's eq. (2).
///
/// `None` when `dt_s` is not positive.
pub fn central_torque<T: RealField + Copy>(
    inertia_kg_m2: [[T; 3]; 3],
    rates_rad_s: [[T; 3]; 3],
    dt_s: T,
) -> Option<[T; 3]> {
    let usable = dt_s > T::zero();
    usable.then(|| {
        let tensor = Matrix3::from(inertia_kg_m2);
        let [before, now, after] = rates_rad_s.map(Vector3::from);
        let slope = (after - before) / (dt_s * number(2.0));
        (tensor * slope + now.cross(&(tensor * now))).into()
    })
}

/// Standard deviation that gyro noise of `sigma_rad_s` alone gives to each axis of
/// [`central_torque`], N·m: J σ / (√2 Δt), for a tensor near its diagonal and a body that turns slowly
/// against 1/Δt.
pub fn torque_noise<T: RealField + Copy>(
    inertia_kg_m2: [[T; 3]; 3],
    sigma_rad_s: T,
    dt_s: T,
) -> [T; 3] {
    let tensor = Matrix3::from(inertia_kg_m2);
    let rate = sigma_rad_s / (dt_s * number::<T>(2.0).sqrt());
    [0, 1, 2].map(|axis| tensor.column(axis).norm() * rate)
}

/// Residual dipole by eq. (3), from rates at equal steps.
#[derive(Debug, Clone, Copy)]
pub struct DipoleByDifferences<T: RealField + Copy> {
    inertia: Inertia<T>,
    track: FieldTrack<T>,
    /// The two instants before: rate, and torque of the torquers and field there.
    past: [Option<Instant<T>>; 2],
    normal: Normal<T, 3>,
}

#[derive(Debug, Clone, Copy)]
struct Instant<T: RealField + Copy> {
    dt_s: T,
    rate: Vector3<T>,
    field: Vector3<T>,
    /// Of the interval before this instant.
    dipole: Vector3<T>,
}

impl<T: RealField + Copy> DipoleByDifferences<T> {
    /// Begins, for a body with this tensor (Body, kg·m²).
    ///
    /// # Errors
    /// [`IdentificationError::Inertia`].
    pub fn new(inertia_kg_m2: [[T; 3]; 3]) -> Result<Self, IdentificationError> {
        Ok(Self {
            inertia: Inertia::new(inertia_kg_m2)?,
            track: FieldTrack::default(),
            past: [None; 2],
            normal: Normal::default(),
        })
    }

    /// Takes in an instant.
    pub fn add(&mut self, recorded: &Recorded<T>) {
        let tracked = self.track.advance(recorded);
        let now = tracked.and_then(|tracked| {
            Some(Instant {
                dt_s: recorded.dt_s,
                rate: tracked.rate,
                field: tracked.field?,
                dipole: Vector3::from(recorded.dipole_am2),
            })
        });
        let [before, middle] = self.past;
        self.past = [middle, now];
        let (Some(before), Some(middle), Some(after)) = (before, middle, now) else { return };
        let span = middle.dt_s + after.dt_s;
        if span <= T::zero() {
            return;
        }
        // In rates, so that all axes have the noise of a gyro: J⁻¹ T.
        let Inertia { tensor, inverse } = self.inertia;
        let slope = (after.rate - before.rate) / span;
        let dipole = (middle.dipole * middle.dt_s + after.dipole * after.dt_s) / span;
        let gyroscopic = middle.rate.cross(&(tensor * middle.rate));
        let left = slope + inverse * (gyroscopic - dipole.cross(&middle.field));
        // An equation counts by the square of its step.
        self.normal.add(&(inverse * of_unit_dipoles(&middle.field) * span), &(left * span));
    }

    /// M, Body, A·m².
    ///
    /// # Errors
    /// [`IdentificationError`]: what the record does not support.
    pub fn solve(&self) -> Result<Solution<T, 3>, IdentificationError> {
        self.normal.solve()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_constant_spin_about_no_principal_axis_needs_a_torque() {
        let inertia = [[0.05, 0.0, 0.0], [0.0, 0.06, 0.0], [0.0, 0.0, 0.07]];
        let rate = [0.1, 0.2, 0.0_f64];
        let [x, y, z] = central_torque(inertia, [rate; 3], 1.0).unwrap();
        // ω_x ω_y (J_y − J_x)
        assert!(x.abs() < 1e-15 && y.abs() < 1e-15 && (z - 2e-4).abs() < 1e-15, "{x} {y} {z}");
        assert_eq!(central_torque(inertia, [rate; 3], 0.0), None);
    }

    #[test]
    fn the_gyros_noise_alone_makes_the_torque_of_the_papers_table() {
        // 0.163 deg/s, 0.055 kg m², 2 s: the table's 5.0e-5 N m for the residual dipole.
        let inertia = [[0.055, 0.0, 0.0], [0.0, 0.055, 0.0], [0.0, 0.0, 0.055]];
        let [x, ..] = torque_noise(inertia, 0.163_f64.to_radians(), 2.0);
        assert!((x - 5.5e-5).abs() < 0.1e-5, "{x}");
    }
}
