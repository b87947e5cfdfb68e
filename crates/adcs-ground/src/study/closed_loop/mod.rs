//! The flight code in a closed loop with a satellite that is not quite what it was told.
//!
//! [`ClosedLoop`] flies [`adcs_core::pipeline::cycle`] itself, with readings that have the sensors'
//! errors but no drivers and converters between, so that thousands of flights take minutes. What is true
//! stands in [`Conditions`], what the flight believes in [`FlightParameters`]; one seed is one flight.
//!
//! | file | what |
//! |---|---|
//! | `conditions` | what is true of the satellite and its surroundings |
//! | `flaws` | what is wrong with sensors that nobody has calibrated |
//! | `sensors` | what gyro, magnetometer and Sun sensors show of it |
//! | `baseline` | what SPROUT's flight software believes |

mod baseline;
mod conditions;
mod flaws;
mod sensors;

use adcs_app::parameters::FlightParameters;
use adcs_core::frames::{Body, Eci, Rotation, TorquerAxes, Vector};
use adcs_core::modes::Mode;
use adcs_core::pipeline::{Configuration, Inputs, State, Thoughts, cycle};
use adcs_core::polarity::SignedPermutation;
use adcs_core::schedule::{Phase, Schedule};
use adcs_core::time::Utc;
use adcs_sim::noise::Gaussian;
use adcs_sim::rigid_body::Motion;
use adcs_sim::surroundings::{Nature, Sunlight};
use anyhow::{Context as _, Result, ensure};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use sgp4_lite::{Elements, Epoch};

pub use baseline::{b_dot, dynamic_filter, estimator, sprout};
pub use conditions::{
    Conditions, Device, DipoleStep, Fault, GyroTruth, Sampling, StartingRate, Torque,
};

pub use flaws::{FlawSizes, Flaws};

use self::sensors::Sensors;
use super::random::{GaussMarkov, gaussian, signs, symmetric, uniform};
use super::satellite::{Satellite, some_start, sunlit_start};
use super::sprout::{LIT, elements};

/// Longest step of the integration, µs.
const STEP_US: u32 = 500_000;
const MICROS_PER_DAY: i64 = 86_400_000_000;

/// Streams of random numbers; each belongs to one seed.
mod stream {
    pub(super) const START: u64 = 201;
    pub(super) const MISTAKES: u64 = 202;
    pub(super) const TORQUE: u64 = 203;
    pub(super) const GYRO: u64 = 204;
    pub(super) const GYRO_BIAS: u64 = 205;
    pub(super) const MAGNETOMETER: u64 = 206;
    pub(super) const SUN: u64 = 207;
    pub(super) const FLAWS: u64 = 208;
}

/// What is true at the start of a cycle.
#[derive(Debug, Clone, Copy)]
pub struct Truth {
    /// Since the start, s.
    pub t_s: f64,
    /// The attitude.
    pub r_bi: Rotation<Body, Eci, f64>,
    /// Rate of Body relative to Eci, Body, rad/s.
    pub omega_bi: Vector3<f64>,
    /// ½ ω · J ω, J (joule).
    pub kinetic_energy_j: f64,
    /// Gyro bias, Body, rad/s.
    pub gyro_bias: Vector3<f64>,
    /// Residual dipole, Body, A·m².
    pub dipole: Vector3<f64>,
    /// Constant and random torque, Body, N·m.
    pub torque: Vector3<f64>,
    /// Dipole of the torquers since the last cycle, Body, A·m².
    pub torquers: Vector3<f64>,
    /// Position, Eci, m.
    pub position: Vector<Eci, f64>,
    /// Velocity, Eci, m/s.
    pub velocity: Vector<Eci, f64>,
    /// Field, Eci, T.
    pub field_i: Vector<Eci, f64>,
    /// Direction to the Sun, Eci.
    pub sun_i: Vector<Eci, f64>,
    /// Whether the Sun shines on the satellite.
    pub lit: bool,
}

/// One cycle: what is true, and what the flight made of what it was shown.
#[derive(Debug, Clone, Copy)]
pub struct Moment {
    /// The satellite's clock.
    pub now: Utc,
    /// What the cycle is for.
    pub phase: Phase,
    /// What is true.
    pub truth: Truth,
    /// What the torquers were last told to carry, A·m².
    pub carried: Vector<TorquerAxes>,
    /// What the flight code thought.
    pub thoughts: Thoughts,
}

/// A flight in progress.
#[derive(Debug, Clone)]
pub struct ClosedLoop {
    cycle_us: u32,
    schedule: Schedule,
    configuration: Configuration,
    state: State,
    satellite: Satellite,
    sensors: Sensors,
    start: Utc,
    cycles: u32,
    constant_torque: Vector3<f64>,
    random_torque: GaussMarkov,
    disturbance: Gaussian,
    dipole: Vector3<f64>,
    step: Vector3<f64>,
    lag_s: f64,
    /// How much of the step there is, 0 in sunlight to 1.
    stepped: Option<f64>,
    /// The torquers' scale errors.
    scale: nalgebra::Matrix3<f64>,
    /// What they do of what they are told: scale and wiring.
    torquers: nalgebra::Matrix3<f64>,
    told: Vector<TorquerAxes>,
    commanded: Option<Mode>,
    flaws: Flaws,
}

impl ClosedLoop {
    /// Flight number `seed` under `conditions`, flown by software with `parameters`. Sensors and torquers
    /// are mounted along Body and the parameters must say so.
    ///
    /// # Errors
    /// Parameters that are refused; an orbit or a field model that ends.
    pub fn new(conditions: &Conditions, parameters: &FlightParameters, seed: u64) -> Result<Self> {
        let aligned = [
            parameters.gyro.alignment_xyzw,
            parameters.magnetometer.alignment_xyzw,
            parameters.torquers.alignment_xyzw,
        ];
        ensure!(aligned == [[0.0, 0.0, 0.0, 1.0]; 3], "the devices are mounted along Body");
        let parameters = FlightParameters {
            elements: match parameters.elements {
                Some(elements) => Some(late(&elements, conditions.orbit_late_s)?),
                None => None,
            },
            ..*parameters
        };
        let (schedule, configuration) = parameters.accept()?;

        let truly = elements()?;
        let mut begin = Gaussian::new(seed, stream::START);
        let start = if conditions.start_in_sunlight {
            sunlit_start(&truly, &mut begin)?
        } else {
            some_start(&truly, &mut begin)
        };
        let attitude = Quaternion::from(nalgebra::Vector4::from_fn(|_, _| begin.sample()));
        let r_bi = Rotation::from_hamilton(UnitQuaternion::new_normalize(attitude));
        let omega = conditions.rate.drawn(&mut begin);

        let mut mistakes = Gaussian::new(seed, stream::MISTAKES);
        let inertia = conditions.inertia.body(&mut mistakes)?;
        let field_error = Vector::from_xyz(signs(&mut mistakes) * conditions.field_model_error_t);
        let direction = gaussian(&mut mistakes).normalize();
        let scale = gaussian(&mut mistakes) * conditions.torquer_scale_sigma;
        let flaws = conditions.flaws.drawn(&mut Gaussian::new(seed, stream::FLAWS));
        let told = Vector3::from(conditions.residual_dipole_am2);
        let dipole = flaws.residual_dipole.unwrap_or(told);
        let DipoleStep { share, lag_s: [shortest_s, longest_s] } = conditions.eclipse_step;
        let step = dipole.component_mul(&signs(&mut mistakes)) * share;
        let lag_s = shortest_s + (longest_s - shortest_s) * uniform(&mut mistakes);
        let gyro_bias = symmetric(&mut mistakes) * conditions.gyro.bias_rad_s;
        let field_bias = signs(&mut mistakes) * conditions.magnetometer_bias_t;

        let mut nature = Nature::new(&truly, start)?;
        let mut around = nature.at(start)?;
        around.field_t = around.field_t + field_error;
        let mut disturbance = Gaussian::new(seed, stream::TORQUE);
        let Torque { constant_n_m, random_n_m, correlation_s } = conditions.torque;
        let scale = nalgebra::Matrix3::from_diagonal(&scale.add_scalar(1.0));
        Ok(Self {
            cycle_us: parameters.cycle_us,
            schedule,
            configuration,
            state: State::default(),
            satellite: Satellite {
                nature,
                around,
                field_error,
                inertia,
                motion: Motion::new(r_bi, Vector::from_xyz(omega)),
            },
            sensors: Sensors::new(conditions, &parameters, seed, (gyro_bias, field_bias), flaws)?,
            start,
            cycles: 0,
            constant_torque: direction * constant_n_m,
            random_torque: GaussMarkov::new(random_n_m, correlation_s, &mut disturbance),
            disturbance,
            dipole,
            step,
            lag_s,
            stepped: None,
            scale,
            torquers: scale * wiring(conditions.fault, Device::Torquers) * alive(conditions.dead),
            told: Vector::zero(),
            commanded: None,
            flaws,
        })
    }

    /// One cycle: the flight code sees, thinks and acts; then the satellite flies on to the next.
    ///
    /// # Errors
    /// When the orbit or the field model ends.
    pub fn step(&mut self) -> Result<Moment> {
        self.step_with(|moment| moment.thoughts.command.dipole)
    }

    /// The same, with the torquers told what `decide` makes of the cycle.
    ///
    /// # Errors
    /// When the orbit or the field model ends.
    pub fn step_with(
        &mut self,
        decide: impl FnOnce(&Moment) -> Vector<TorquerAxes>,
    ) -> Result<Moment> {
        let now = self.now();
        let position = self.satellite.around.position;
        let sunlight = self.satellite.nature.sunlight(now, position)?;
        let lit = sunlight.lit > LIT;
        let stepped = *self.stepped.get_or_insert(if lit { 0.0 } else { 1.0 });
        let dipole = self.dipole + self.step * stepped;
        let truth = self.truth(&sunlight, lit, dipole);
        let phase = self.schedule.phase(self.cycles);
        let shown = self.sensors.shown(&truth, phase, &sunlight);
        let inputs = Inputs {
            now,
            phase,
            rate_rad_s: shown.rate_rad_s,
            field_t: shown.field_t,
            sun_a: shown.sun_a,
            carried: self.told,
            refused: false,
            commanded: self.commanded.take(),
        };
        let thoughts = cycle(&self.configuration, &mut self.state, &inputs);
        let moment = Moment { now, phase, truth, carried: self.told, thoughts };

        self.told = decide(&moment);
        self.fly(dipole, lit, stepped)?;
        Ok(moment)
    }

    /// From now on this is what is wired wrongly, whatever it was before.
    pub fn rewire(&mut self, fault: Option<Fault>) {
        self.torquers = self.scale * wiring(fault, Device::Torquers);
        self.sensors.rewire(fault);
    }

    /// What the ground commands for the next cycle.
    pub fn command(&mut self, mode: Mode) {
        self.commanded = Some(mode);
    }

    /// From now on these torquers obey and do nothing.
    pub fn kill(&mut self, dead: [bool; 3]) {
        self.torquers *= alive(dead);
    }

    /// What is wrong with the sensors of this satellite.
    pub fn flaws(&self) -> &Flaws {
        &self.flaws
    }

    /// Its inertia tensor, Body, kg·m².
    pub fn inertia(&self) -> nalgebra::Matrix3<f64> {
        self.satellite.inertia.matrix()
    }

    /// What a unit dipole told to each torquer becomes, Body.
    pub fn torquers(&self) -> nalgebra::Matrix3<f64> {
        self.torquers
    }

    /// What the flight code remembers.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// Flies on with other parameters, as after a commit.
    ///
    /// # Errors
    /// Parameters that are refused.
    pub fn commit(&mut self, parameters: &FlightParameters) -> Result<()> {
        (self.schedule, self.configuration) = parameters.accept()?;
        self.state.recalibrated();
        Ok(())
    }

    /// What the flight's configuration is.
    pub fn configuration(&self) -> &Configuration {
        &self.configuration
    }

    fn now(&self) -> Utc {
        self.start.plus_micros(i64::from(self.cycles) * i64::from(self.cycle_us))
    }

    fn truth(&self, sunlight: &Sunlight, lit: bool, dipole: Vector3<f64>) -> Truth {
        let Satellite { around, inertia, motion, .. } = &self.satellite;
        Truth {
            t_s: f64::from(self.cycles) * f64::from(self.cycle_us) * 1e-6,
            r_bi: motion.r_bi(),
            omega_bi: motion.omega_bi.xyz,
            kinetic_energy_j: inertia.kinetic_energy_j(motion.omega_bi),
            gyro_bias: self.sensors.gyro_bias(),
            dipole,
            torque: self.constant_torque + self.random_torque.value,
            torquers: self.torquers * self.told.xyz.cast(),
            position: around.position,
            velocity: around.velocity,
            field_i: around.field_t,
            sun_i: sunlight.direction(),
            lit,
        }
    }

    fn fly(&mut self, dipole: Vector3<f64>, lit: bool, stepped: f64) -> Result<()> {
        let now = self.now();
        let total = dipole + self.torquers * self.told.xyz.cast();
        let torque = self.constant_torque + self.random_torque.value;
        let parts = self.cycle_us.div_ceil(STEP_US).max(1);
        let part_us = f64::from(self.cycle_us) / f64::from(parts);
        for part in 1..=parts {
            let end = now.plus_micros((f64::from(part) * part_us).round() as i64);
            self.satellite.fly(end, part_us * 1e-6, total, torque)?;
        }
        let cycle_s = f64::from(self.cycle_us) * 1e-6;
        self.random_torque.step(cycle_s, &mut self.disturbance);
        self.sensors.age(cycle_s);
        let goal = if lit { 0.0 } else { 1.0 };
        let kept = if self.lag_s > 0.0 { (-cycle_s / self.lag_s).exp() } else { 0.0 };
        self.stepped = Some(goal + (stepped - goal) * kept);
        self.cycles += 1;
        Ok(())
    }
}

/// How a device is wired with this fault.
fn wiring(fault: Option<Fault>, device: Device) -> nalgebra::Matrix3<f64> {
    let at_fault = fault.filter(|fault| fault.device == device);
    at_fault.map_or(SignedPermutation::IDENTITY, |fault| fault.wiring).matrix().cast()
}

/// What torquers do of what they are told when these are dead.
fn alive(dead: [bool; 3]) -> nalgebra::Matrix3<f64> {
    nalgebra::Matrix3::from_diagonal(&dead.map(|dead| if dead { 0.0 } else { 1.0 }).into())
}

/// The same orbit with everything `late_s` later.
fn late(elements: &Elements, late_s: f64) -> Result<Elements> {
    let micros = elements.epoch.micros_of_day() + (late_s * 1e6).round() as i64;
    let days = i32::try_from(micros.div_euclid(MICROS_PER_DAY))?;
    let day = elements.epoch.days_since_j2000_midnight() + days;
    let epoch = Epoch::from_days(day, micros.rem_euclid(MICROS_PER_DAY));
    Ok(Elements { epoch: epoch.context("an epoch")?, ..*elements })
}
