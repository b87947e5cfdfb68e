//! A rigid body in its orbit: what every flight of the studies moves.

use adcs_core::frames::{Body, Eci, Rotation, Vector};
use adcs_core::orbit::OrbitState;
use adcs_core::orbit::frame::OrbitFrame;
use adcs_core::time::Utc;
use adcs_sim::noise::Gaussian;
use adcs_sim::rigid_body::{Inertia, Motion, Stage};
use adcs_sim::surroundings::{Nature, Surroundings};
use adcs_sim::torques::{gravity_gradient, magnetic};
use anyhow::{Context as _, Result, bail};
use nalgebra::{UnitQuaternion, Vector3};
use sgp4_lite::Elements;

use super::random::{gaussian, uniform};
use super::sprout::LIT;
use crate::span::utc_of_epoch;

/// Body, orbit and field at one instant.
#[derive(Debug, Clone)]
pub struct Satellite {
    /// Orbit and field.
    pub nature: Nature,
    /// What is around it now.
    pub around: Surroundings,
    /// By how much the field differs from the model's, Eci, T.
    pub field_error: Vector<Eci, f64>,
    /// Its inertia.
    pub inertia: Inertia,
    /// Its attitude and rate.
    pub motion: Motion,
}

impl Satellite {
    /// Flies on to `end`, `dt_s` later, under the field's torque on `dipole` (A·m²), gravity gradient,
    /// and `torque` (N·m), all Body.
    ///
    /// # Errors
    /// When the orbit or the field model ends.
    pub fn fly(
        &mut self,
        end: Utc,
        dt_s: f64,
        dipole: Vector3<f64>,
        torque: Vector3<f64>,
    ) -> Result<()> {
        let start = self.around;
        let half_us = (0.5e6 * dt_s).round() as i64;
        let middle = self.at(end.plus_micros(-half_us))?;
        let end = self.at(end)?;
        let total = Vector::<Body, f64>::from_xyz(dipole);
        let torque = Vector::from_xyz(torque);
        let inertia = self.inertia;
        self.motion = self.motion.stepped(&inertia, dt_s, |stage, motion| {
            let around = match stage {
                Stage::Start => &start,
                Stage::Middle => &middle,
                Stage::End => &end,
            };
            let r_bi = motion.r_bi();
            magnetic::torque(total, r_bi * around.field_t)
                + gravity_gradient::torque(&inertia, r_bi * around.position)
                + torque
        });
        self.around = end;
        Ok(())
    }

    fn at(&mut self, now: Utc) -> Result<Surroundings> {
        let around = self.nature.at(now)?;
        Ok(Surroundings { field_t: around.field_t + self.field_error, ..around })
    }

    /// The Orbit frame here.
    pub fn orbit_frame(&self) -> Option<OrbitFrame> {
        orbit_frame(&self.around)
    }
}

/// The Orbit frame there.
pub fn orbit_frame(around: &Surroundings) -> Option<OrbitFrame> {
    let Surroundings { position, velocity, .. } = *around;
    OrbitFrame::of(&OrbitState { position, velocity })
}

/// The rate of the Orbit frame, Body, rad/s.
pub fn orbit_rate(frame: &OrbitFrame, r_bi: Rotation<Body, Eci, f64>) -> Vector3<f64> {
    (r_bi * (frame.r_oi.inverse() * frame.omega_oi)).xyz
}

/// Body along Orbit but for `sigma_rad` about each axis, turning with it.
///
/// # Errors
/// When the orbit has no plane.
pub fn along_orbit(around: &Surroundings, sigma_rad: f64, noise: &mut Gaussian) -> Result<Motion> {
    let frame = orbit_frame(around).context("the orbit has no plane")?;
    let off = UnitQuaternion::from_scaled_axis(gaussian(noise) * sigma_rad);
    let r_bi = Rotation::from_hamilton(off * frame.r_oi.hamilton());
    Ok(Motion::new(r_bi, Vector::from_xyz(orbit_rate(&frame, r_bi))))
}

/// An instant within two days of the epoch, with the satellite in sunlight.
///
/// # Errors
/// When the orbit has no sunlight, or ends.
pub fn sunlit_start(elements: &Elements, noise: &mut Gaussian) -> Result<Utc> {
    let mut nature = Nature::new(elements, utc_of_epoch(elements.epoch))?;
    for _ in 0..1000 {
        let start = some_start(elements, noise);
        let position = nature.at(start)?.position;
        if nature.sunlight(start, position)?.lit > LIT {
            return Ok(start);
        }
    }
    bail!("the orbit has no sunlight")
}

/// An instant within two days of the epoch.
pub fn some_start(elements: &Elements, noise: &mut Gaussian) -> Utc {
    utc_of_epoch(elements.epoch).plus_micros((uniform(noise) * 2.0 * 86_400e6) as i64)
}
