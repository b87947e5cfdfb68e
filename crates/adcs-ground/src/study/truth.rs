//! The satellite as it is: SPROUT's preset A2 in its orbit, with the sensors of the paper, closed loop.
//!
//! | what | value | source |
//! |---|---|---|
//! | gyro | 0.163 deg/s each axis at 1 Hz; bias uniform within ±0.4 deg/s, walk 1e-4 deg/s/√s | the paper; independent study (docs/filters) |
//! | magnetometer | 500 nT each axis, from 0.5 s after the torquers went off | the study |
//! | Sun | 0.664 deg across the line of sight when lit | the paper |
//! | torquers | 10 s on, 2.5 s off, ±0.6 A·m² | the paper |
//! | torques | residual dipole, torquers, gravity gradient, and one that nobody models (Gauss–Markov) | |

use adcs_core::frames::{Body, Eci, Rotation, Vector};
use adcs_core::time::Utc;
use adcs_sim::noise::Gaussian;
use adcs_sim::rigid_body::{Inertia, Motion as RigidMotion};
use adcs_sim::surroundings::{Nature, Surroundings};
use anyhow::Result;
use nalgebra::{UnitQuaternion, Vector3};

use super::random::{GaussMarkov, gaussian, signs, uniform};
use super::satellite::{Satellite, along_orbit, orbit_rate, sunlit_start};
use super::scene::{Motion, PointingGains, Scene};
use super::sprout::{
    self, B_DOT_GAIN, BIAS_WALK_RAD_S_PER_SQRT_S, DEG, FIELD_NOISE_T, GYRO_NOISE_RAD_S,
    INERTIA_KG_M2, LIT, MAX_DIPOLE_AM2, RESIDUAL_DIPOLE_AM2, SUN_NOISE_RAD,
};

/// Step of the integration and grain of the schedule, s.
pub const STEP_S: f64 = 0.5;
/// The sensors speak once a second.
pub const STEPS_A_SECOND: u32 = 2;
/// Steps in which the torquers are off and on.
const OFF_STEPS: u32 = 5;
const ON_STEPS: u32 = 20;
/// The gyro bias at the start is within this, each axis, rad/s.
const BIAS_RAD_S: f64 = 0.4 * DEG;

/// The truth and the measurements at one step.
#[derive(Debug, Clone)]
pub struct Moment {
    /// Since the start, s.
    pub t_s: f64,
    /// The attitude.
    pub r_bi: Rotation<Body, Eci, f64>,
    /// Rate of Body relative to Eci, Body, rad/s.
    pub omega: Vector3<f64>,
    /// Gyro bias, Body, rad/s.
    pub bias: Vector3<f64>,
    /// Residual dipole, Body, A·m².
    pub dipole: Vector3<f64>,
    /// The torque that nobody models, Body, N·m.
    pub torque: Vector3<f64>,
    /// Whether the Sun shines on the satellite.
    pub lit: bool,
    /// Position, Eci, m.
    pub position: Vector3<f64>,
    /// Field, Eci, T.
    pub field_i: Vector3<f64>,
    /// Direction to the Sun, Eci.
    pub sun_i: Vector3<f64>,
    /// What the torquers carried over the step that ended here, Body, A·m².
    pub torquers: Vector3<f64>,
    /// What the gyro shows, once a second, rad/s.
    pub gyro: Option<Vector3<f64>>,
    /// What the magnetometer shows, once a second while the torquers rest, T.
    pub field_b: Option<Vector3<f64>>,
    /// Where the Sun sensor sees the Sun, once a second when lit.
    pub sun_b: Option<Vector3<f64>>,
}

/// A flight in progress.
#[derive(Debug, Clone)]
pub struct Truth {
    scene: Scene,
    satellite: Satellite,
    start: Utc,
    steps: u32,
    bias: Vector3<f64>,
    torque: GaussMarkov,
    jump: Vector3<f64>,
    torquers: Vector3<f64>,
    held: Vector3<f64>,
    noise: Gaussian,
    disturbance: Gaussian,
}

impl Truth {
    /// Flight number `seed` of a scene: somewhere within two days, in sunlight.
    ///
    /// # Errors
    /// When the orbit or the field model ends.
    pub fn new(scene: Scene, seed: u64) -> Result<Self> {
        let elements = sprout::elements()?;
        let mut noise = Gaussian::new(seed, 101);
        let start = sunlit_start(&elements, &mut noise)?;
        let mut nature = Nature::new(&elements, start)?;
        let around = nature.at(start)?;
        let bias = Vector3::from_fn(|_, _| noise.symmetric()) * BIAS_RAD_S;
        let motion = match scene.motion {
            Motion::Tumble => {
                let axis = gaussian(&mut noise).normalize();
                let rate = (5.0 + 4.5 * uniform(&mut noise)) * DEG;
                let attitude = UnitQuaternion::from_scaled_axis(gaussian(&mut noise) * 2.0);
                RigidMotion::new(Rotation::from_hamilton(attitude), Vector::from_xyz(axis * rate))
            }
            Motion::Nadir(_) => along_orbit(&around, 5.0 * DEG, &mut noise)?,
        };
        let jump = signs(&mut noise) * scene.dipole_jump_am2;
        let mut disturbance = Gaussian::new(seed, 102);
        let torque = GaussMarkov::new(scene.torque_n_m, scene.correlation_s, &mut disturbance);
        let inertia = Inertia::new(INERTIA_KG_M2)?;
        Ok(Self {
            scene,
            satellite: Satellite { nature, around, field_error: Vector::zero(), inertia, motion },
            start,
            steps: 0,
            bias,
            torque,
            jump,
            torquers: Vector3::zeros(),
            held: Vector3::zeros(),
            noise,
            disturbance,
        })
    }

    /// What is now and what is measured now; then the next step is flown.
    ///
    /// # Errors
    /// When the orbit or the field model ends.
    pub fn step(&mut self) -> Result<Moment> {
        let t_s = f64::from(self.steps) * STEP_S;
        let now = self.at(t_s);
        let Surroundings { position, field_t: field_i, .. } = self.satellite.around;
        let sunlight = self.satellite.nature.sunlight(now, position)?;
        let lit = sunlight.lit > LIT;
        let sun_i = sunlight.to_sun.xyz.normalize();
        let r_bi = self.satellite.motion.r_bi();
        let omega = self.satellite.motion.omega_bi.xyz;
        let field_b = (r_bi * field_i).xyz;
        let dipole =
            Vector3::from(RESIDUAL_DIPOLE_AM2) + if lit { Vector3::zeros() } else { self.jump };

        // One draw each a step, wanted or not, so that scenes of one seed share their noise.
        let gyro = omega + self.bias + gaussian(&mut self.noise) * GYRO_NOISE_RAD_S;
        let measured = field_b + gaussian(&mut self.noise) * FIELD_NOISE_T;
        let sun_b = blurred((r_bi * Vector::from_xyz(sun_i)).xyz, &mut self.noise);

        let in_round = self.steps % (OFF_STEPS + ON_STEPS);
        // From 0.5 s after the torquers went off to the moment before they go on.
        let settled = (1..=OFF_STEPS).contains(&in_round);
        let full_second = self.steps.is_multiple_of(STEPS_A_SECOND);
        let moment = Moment {
            t_s,
            r_bi,
            omega,
            bias: self.bias,
            dipole,
            torque: self.torque.value,
            lit,
            position: position.xyz,
            field_i: field_i.xyz,
            sun_i,
            torquers: self.torquers,
            gyro: full_second.then_some(gyro),
            field_b: (full_second && settled).then_some(measured),
            sun_b: (full_second && lit).then_some(sun_b),
        };

        if in_round == OFF_STEPS {
            self.held = match self.scene.motion {
                Motion::Tumble => gyro.cross(&measured) * B_DOT_GAIN,
                Motion::Nadir(gains) => self.pointing(gains, r_bi, omega, field_b, dipole),
            }
            .map(|m| m.clamp(-MAX_DIPOLE_AM2, MAX_DIPOLE_AM2));
        }
        self.torquers = if in_round >= OFF_STEPS { self.held } else { Vector3::zeros() };
        self.fly(t_s, dipole)?;
        self.steps += 1;
        Ok(moment)
    }

    /// The law of the nadir scene, on the truth: cross-product law, residual dipole fed forward.
    fn pointing(
        &self,
        gains: PointingGains,
        r_bi: Rotation<Body, Eci, f64>,
        omega: Vector3<f64>,
        field_b: Vector3<f64>,
        dipole: Vector3<f64>,
    ) -> Vector3<f64> {
        let Some(frame) = self.satellite.orbit_frame() else { return Vector3::zeros() };
        let error = (r_bi * frame.r_oi.inverse()).hamilton();
        // q_bo = (1, −θ/2): θ is how far Body is turned from Orbit.
        let theta = error.imag() * (-2.0 * error.w.signum());
        let rate_error = omega - orbit_rate(&frame, r_bi);
        let wanted = -(theta * gains.stiffness + rate_error * gains.damping);
        let duty = f64::from(ON_STEPS) / f64::from(OFF_STEPS + ON_STEPS);
        (field_b.cross(&wanted) / field_b.norm_squared() - dipole) / duty
    }

    fn fly(&mut self, t_s: f64, dipole: Vector3<f64>) -> Result<()> {
        let end = self.at(t_s + STEP_S);
        self.satellite.fly(end, STEP_S, dipole + self.torquers, self.torque.value)?;
        let walk = BIAS_WALK_RAD_S_PER_SQRT_S * STEP_S.sqrt();
        self.bias += gaussian(&mut self.disturbance) * walk;
        self.torque.step(STEP_S, &mut self.disturbance);
        Ok(())
    }

    fn at(&self, t_s: f64) -> Utc {
        self.start.plus_micros((t_s * 1e6).round() as i64)
    }
}

/// A direction with the Sun sensor's noise across it.
fn blurred(direction: Vector3<f64>, noise: &mut Gaussian) -> Vector3<f64> {
    let off = gaussian(noise) * SUN_NOISE_RAD;
    (direction + off - direction * direction.dot(&off)).normalize()
}
