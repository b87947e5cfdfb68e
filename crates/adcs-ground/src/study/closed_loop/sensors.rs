//! What gyro, magnetometer and Sun sensors show.

use adcs_app::parameters::FlightParameters;
use adcs_core::frames::{Body, Rotation};
use adcs_core::reading::{MissingReason, Reading};
use adcs_core::schedule::Phase;
use adcs_core::sensing::sun_faces::FACES;
use adcs_sim::noise::Gaussian;
use adcs_sim::scenario::SunSensorsTruth;
use adcs_sim::sun_sensors::SunSensors;
use adcs_sim::surroundings::Sunlight;
use anyhow::{Context as _, Result};
use nalgebra::{Matrix3, UnitQuaternion, Vector3};

use super::super::random::gaussian;
use super::{Conditions, Device, Fault, Flaws, Sampling, Truth, stream, wiring};

/// What the sensors of one cycle show.
pub(super) struct Shown {
    pub(super) rate_rad_s: [Reading<f32>; 3],
    pub(super) field_t: [Reading<f32>; 3],
    pub(super) sun_a: [Reading<[f32; 4]>; FACES],
}

/// The sensors with their errors.
#[derive(Debug, Clone)]
pub(super) struct Sensors {
    gyro: Matrix3<f64>,
    gyro_noise_rad_s: f64,
    gyro_bias: Vector3<f64>,
    walk: f64,
    sampling: Sampling,
    cycles_a_second: u32,
    since_measuring: u32,
    magnetometer: Matrix3<f64>,
    field_noise_t: f64,
    field_bias: Vector3<f64>,
    flaws: Flaws,
    sun: Option<SunSensors>,
    gyro_stream: Gaussian,
    walk_stream: Gaussian,
    field_stream: Gaussian,
}

impl Sensors {
    pub(super) fn new(
        conditions: &Conditions,
        parameters: &FlightParameters,
        seed: u64,
        (gyro_bias, field_bias): (Vector3<f64>, Vector3<f64>),
        flaws: Flaws,
    ) -> Result<Self> {
        let sun = parameters.sun_sensors.as_ref().map(|known| {
            let Conditions { sun_noise_rad: noise_rad, albedo, .. } = *conditions;
            let mut truth =
                SunSensorsTruth { noise_rad, albedo, ..SunSensorsTruth::perfect(known) };
            let turn: Rotation<Body, Body, f64> =
                Rotation::from_hamilton(UnitQuaternion::from_scaled_axis(flaws.sun_turn));
            for face in &mut truth.faces {
                let told =
                    Rotation::<Body, Body, f64>::from_attitude_quaternion(face.alignment_xyzw);
                let told = told.unwrap_or_else(Rotation::identity);
                face.alignment_xyzw = (turn * told).attitude_quaternion();
            }
            // The currents have no noise: it is all in the direction.
            SunSensors::new(&truth, Gaussian::new(seed, stream::SUN), Gaussian::new(seed, 0))
                .context("Sun sensors without a direction")
        });
        Ok(Self {
            gyro: wiring(conditions.fault, Device::Gyro),
            gyro_noise_rad_s: conditions.gyro.noise_rad_s,
            gyro_bias,
            walk: conditions.gyro.walk_rad_s_per_sqrt_s,
            sampling: conditions.gyro.sampling,
            cycles_a_second: (1_000_000 / parameters.cycle_us.max(1)).max(1),
            since_measuring: 0,
            magnetometer: wiring(conditions.fault, Device::Magnetometer),
            field_noise_t: conditions.magnetometer_noise_t,
            field_bias,
            flaws,
            sun: sun.transpose()?,
            gyro_stream: Gaussian::new(seed, stream::GYRO),
            walk_stream: Gaussian::new(seed, stream::GYRO_BIAS),
            field_stream: Gaussian::new(seed, stream::MAGNETOMETER),
        })
    }

    pub(super) fn rewire(&mut self, fault: Option<Fault>) {
        self.gyro = wiring(fault, Device::Gyro);
        self.magnetometer = wiring(fault, Device::Magnetometer);
    }

    pub(super) fn gyro_bias(&self) -> Vector3<f64> {
        self.gyro_bias
    }

    /// Lets the gyro bias walk for `dt_s`.
    pub(super) fn age(&mut self, dt_s: f64) {
        self.gyro_bias += gaussian(&mut self.walk_stream) * (self.walk * dt_s.sqrt());
    }

    pub(super) fn shown(&mut self, truth: &Truth, phase: Phase, sunlight: &Sunlight) -> Shown {
        // One draw each a cycle, wanted or not, so that flights of one seed share their noise.
        let noise = gaussian(&mut self.gyro_stream) * self.gyro_noise_rad_s;
        let rate = self.gyro * truth.omega_bi + self.gyro_bias + noise;
        let noise = gaussian(&mut self.field_stream) * self.field_noise_t;
        let field = (truth.r_bi * truth.field_i).xyz + self.flaws.coupling * truth.torquers;
        let field = self.magnetometer * self.flaws.shown(field) + self.field_bias + noise;
        self.since_measuring =
            if phase == Phase::Measuring { 0 } else { self.since_measuring.wrapping_add(1) };
        let silent = self.sampling == Sampling::OnceASecond
            && !self.since_measuring.is_multiple_of(self.cycles_a_second);
        Shown {
            rate_rad_s: if silent { [Reading::Missing(MissingReason::Bus); 3] } else { axes(rate) },
            field_t: axes(field),
            sun_a: self.sun_currents(truth, sunlight),
        }
    }

    fn sun_currents(&mut self, truth: &Truth, sunlight: &Sunlight) -> [Reading<[f32; 4]>; FACES] {
        let Some(sun) = &mut self.sun else {
            return [Reading::Missing(MissingReason::NotFitted); FACES];
        };
        sun.expose(truth.r_bi, sunlight, truth.position);
        let mut faces = [Reading::Fresh([0.0; 4]); FACES];
        for (number, face) in faces.iter_mut().enumerate() {
            let shown = [0, 1, 2, 3].map(|electrode| sun.shown(number, electrode) as f32);
            *face = Reading::Fresh(shown);
        }
        faces
    }
}

fn axes(v: Vector3<f64>) -> [Reading<f32>; 3] {
    [v.x, v.y, v.z].map(|value| Reading::Fresh(value as f32))
}
