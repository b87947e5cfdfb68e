//! The truth: one satellite, turning in its orbit.

use adcs_core::frames::{Body, GyroAxes, MagnetometerAxes, Rotation, TorquerAxes, Vector};
use adcs_core::time::{MICROS_PER_SECOND, Utc};
use adcs_hal::analog_triad::AnalogTriadConfig;
use adcs_hal::driver_board::DriverBoardConfig;
use adcs_link::TruthRecord;

use crate::devices::{Converter, Plant};
use crate::fly::FlightError;
use crate::noise::Gaussian;
use crate::rigid_body::{Inertia, Motion, Stage};
use crate::scenario::WorldParameters;
use crate::sensor::Sensor;
use crate::sun_sensors::{Currents, SunSensors};
use crate::surroundings::{Nature, Sunlight, Surroundings};
use crate::torques::drag::{self, Drag};
use crate::torques::solar_pressure::SolarPressure;
use crate::torques::{Box3, gravity_gradient, magnetic};

/// Streams of the flight's noise; a new source gets a new number.
const GYRO_STREAM: u64 = 1;
const MAGNETOMETER_STREAM: u64 = 2;
const SUN_DIRECTION_STREAM: u64 = 3;
const SUN_CURRENT_STREAM: u64 = 4;

/// The satellite and everything around it, at one instant.
#[derive(Debug, Clone)]
pub struct World {
    now: Utc,
    step_us: u32,
    nature: Nature,
    surroundings: Surroundings,
    sunlight: Sunlight,
    satellite: Satellite,
    motion: Motion,
    /// Dipole of the three torquers, A·m².
    torquer_dipole: Vector<TorquerAxes, f64>,
    gyro: Sensor<GyroAxes>,
    magnetometer: Sensor<MagnetometerAxes>,
    magnetometer_offset: Option<Vector<Body, f64>>,
    sun_sensors: Option<SunSensors>,
    wiring: DriverBoardConfig,
    full_dipole_am2: [f64; 3],
}

/// What of the satellite does not change in flight.
#[derive(Debug, Clone, Copy)]
struct Satellite {
    inertia: Inertia,
    residual_dipole: Vector<Body, f64>,
    gravity_gradient: bool,
    drag: Option<Drag>,
    solar_pressure: Option<SolarPressure>,
    shape: Box3,
    torquers_to_body: Rotation<Body, TorquerAxes, f64>,
}

impl Satellite {
    /// The sum of all torques on a satellite in this motion and these surroundings, Body, N·m.
    fn torque(
        &self,
        motion: &Motion,
        surroundings: &Surroundings,
        sunlight: &Sunlight,
        torquer_dipole: Vector<TorquerAxes, f64>,
    ) -> Vector<Body, f64> {
        let r_bi = motion.r_bi();
        let dipole = self.residual_dipole + self.torquers_to_body * torquer_dipole;
        let mut torque = magnetic::torque(dipole, r_bi * surroundings.field_t);
        if self.gravity_gradient {
            torque = torque + gravity_gradient::torque(&self.inertia, r_bi * surroundings.position);
        }
        if let Some(drag) = &self.drag {
            let airspeed = drag::airspeed(surroundings.position, surroundings.velocity);
            torque = torque + drag.torque(&self.shape, r_bi * airspeed);
        }
        if let Some(pressure) = &self.solar_pressure {
            torque = torque + pressure.torque(&self.shape, r_bi * sunlight.to_sun, sunlight.lit);
        }
        torque
    }
}

fn vector<F>([x, y, z]: [f64; 3]) -> Vector<F, f64> {
    Vector::new(x, y, z)
}

impl World {
    /// The world at the start of a flight.
    ///
    /// # Errors
    /// [`FlightError`] when the parameters describe no satellite, no orbit or no attitude.
    pub fn new(
        parameters: &WorldParameters,
        wiring: &DriverBoardConfig,
    ) -> Result<Self, FlightError> {
        let p = parameters;
        if p.step_us == 0 {
            return Err(FlightError::Step);
        }
        let satellite = Satellite {
            inertia: Inertia::new(p.inertia_kg_m2).map_err(FlightError::Inertia)?,
            residual_dipole: vector(p.residual_dipole_am2.unwrap_or_default()),
            gravity_gradient: p.gravity_gradient,
            drag: p
                .drag
                .map(|d| Drag { density_kg_m3: d.density_kg_m3, coefficient: d.coefficient }),
            solar_pressure: p.solar_pressure.map(|s| SolarPressure { coefficient: s.coefficient }),
            shape: Box3 {
                sides_m: p.shape.sides_m,
                centre_of_pressure: vector(p.shape.centre_of_pressure_m),
            },
            torquers_to_body: Rotation::from_attitude_quaternion(p.torquer_alignment_xyzw)
                .map(|r: Rotation<TorquerAxes, Body, f64>| r.inverse())
                .ok_or(FlightError::Attitude)?,
        };
        let r_bi = Rotation::from_attitude_quaternion(p.attitude_xyzw);
        let motion = Motion::new(r_bi.ok_or(FlightError::Attitude)?, vector(p.omega_bi_rad_s));
        let mut nature = Nature::new(&p.elements, p.start)?;
        let surroundings = nature.at(p.start)?;
        let sunlight = nature.sunlight(p.start, surroundings.position)?;
        let gyro = Sensor::new(&p.gyro, Gaussian::new(p.seed, GYRO_STREAM));
        let magnetometer = Sensor::new(&p.magnetometer, Gaussian::new(p.seed, MAGNETOMETER_STREAM));
        let sun_sensors = p.sun_sensors.as_ref().map(|truth| {
            let stream = |stream| Gaussian::new(p.seed, stream);
            SunSensors::new(truth, stream(SUN_DIRECTION_STREAM), stream(SUN_CURRENT_STREAM))
                .ok_or(FlightError::Attitude)
        });
        let mut world = Self {
            now: p.start,
            step_us: p.step_us,
            nature,
            surroundings,
            sunlight,
            satellite,
            motion,
            torquer_dipole: Vector::zero(),
            gyro: gyro.ok_or(FlightError::Attitude)?,
            magnetometer: magnetometer.ok_or(FlightError::Attitude)?,
            magnetometer_offset: p.magnetometer_offset_m.map(vector),
            sun_sensors: sun_sensors.transpose()?,
            wiring: *wiring,
            full_dipole_am2: p.torquer_full_dipole_am2,
        };
        world.expose_sun_sensors();
        Ok(world)
    }

    fn expose_sun_sensors(&mut self) {
        if let Some(sensors) = &mut self.sun_sensors {
            sensors.expose(self.motion.r_bi(), &self.sunlight, self.surroundings.position);
        }
    }

    /// The instant at which the world stands.
    pub fn now(&self) -> Utc {
        self.now
    }

    /// Lets `micros` go by, with the torquers as they are. The last step is shortened to end there.
    ///
    /// # Errors
    /// [`FlightError`] when the orbit or the field model ends.
    pub fn advance(&mut self, micros: u32) -> Result<(), FlightError> {
        let mut left_us = micros;
        while left_us > 0 {
            let step_us = self.step_us.min(left_us);
            self.step(step_us)?;
            left_us -= step_us;
        }
        self.sunlight = self.nature.sunlight(self.now, self.surroundings.position)?;
        self.expose_sun_sensors();
        Ok(())
    }

    fn step(&mut self, step_us: u32) -> Result<(), FlightError> {
        let end = self.now.plus_micros(i64::from(step_us));
        let middle = self.nature.at(self.now.plus_micros(i64::from(step_us / 2)))?;
        let last = self.nature.at(end)?;
        let dt_s = f64::from(step_us) / MICROS_PER_SECOND as f64;
        self.motion = self.motion.stepped(&self.satellite.inertia, dt_s, |stage, motion| {
            let surroundings = match stage {
                Stage::Start => &self.surroundings,
                Stage::Middle => &middle,
                Stage::End => &last,
            };
            self.satellite.torque(motion, surroundings, &self.sunlight, self.torquer_dipole)
        });
        self.surroundings = last;
        self.now = end;
        Ok(())
    }

    /// The true state, as the record of cycle `cycle`.
    pub fn truth(&self, cycle: u32) -> TruthRecord {
        TruthRecord {
            cycle,
            attitude_xyzw: self.motion.r_bi().attitude_quaternion(),
            omega_bi_rad_s: self.motion.omega_bi.to_array(),
            position_eci_m: self.surroundings.position.to_array(),
            field_eci_t: self.surroundings.field_t.to_array(),
            kinetic_energy_j: self.satellite.inertia.kinetic_energy_j(self.motion.omega_bi),
            torquer_dipole_body_am2: self.torquer_dipole_body().to_array(),
            sun_eci: self.sunlight.direction().to_array(),
            sunlit: self.sunlight.lit > 0.0,
        }
    }

    /// The true rate along the gyros' axes, rad/s.
    pub fn exact_rate(&self) -> Vector<GyroAxes, f64> {
        self.gyro.exact(self.motion.omega_bi)
    }

    /// The true geomagnetic field along the magnetometer's axes, T, without the torquers'.
    pub fn exact_field(&self) -> Vector<MagnetometerAxes, f64> {
        self.magnetometer.exact(self.motion.r_bi() * self.surroundings.field_t)
    }

    /// The photocurrents of the Sun sensors under the Sun alone, A; `None` without Sun sensors.
    pub fn exact_sun_currents(&self) -> Option<Currents> {
        self.sun_sensors.as_ref().map(SunSensors::exact)
    }

    /// Brings the torquers to this dipole, A·m², at once.
    pub fn set_torquer_dipole(&mut self, dipole: Vector<TorquerAxes, f64>) {
        self.torquer_dipole = dipole;
    }

    fn torquer_dipole_body(&self) -> Vector<Body, f64> {
        self.satellite.torquers_to_body * self.torquer_dipole
    }

    /// The field at the magnetometer, Body, T: the Earth's and the torquers'.
    fn field_at_magnetometer(&self) -> Vector<Body, f64> {
        let earth = self.motion.r_bi() * self.surroundings.field_t;
        match self.magnetometer_offset {
            Some(offset) => earth + magnetic::dipole_field_t(self.torquer_dipole_body(), offset),
            None => earth,
        }
    }
}

/// The axis of a triad that is wired to `channel`.
fn axis_on(triad: &AnalogTriadConfig, channel: u8) -> Option<usize> {
    triad.channels.iter().position(|&wired| wired == channel)
}

/// The voltage by which an analogue sensor says `value` (SI).
fn volts(triad: &AnalogTriadConfig, value: f64) -> f64 {
    f64::from(triad.zero_v) + f64::from(triad.sensitivity_v_per_si) * value
}

impl World {
    /// The voltage of magnetometer or gyro at an input of their converter.
    fn triad_volts(&mut self, channel: u8) -> Option<f64> {
        let DriverBoardConfig { magnetometer, gyro, .. } = self.wiring;
        if let Some(axis) = axis_on(&magnetometer, channel) {
            let field = self.field_at_magnetometer();
            return Some(volts(&magnetometer, self.magnetometer.shown(axis, field)));
        }
        let axis = axis_on(&gyro, channel)?;
        Some(volts(&gyro, self.gyro.shown(axis, self.motion.omega_bi)))
    }

    /// The voltage of a Sun sensor at an input of one of their converters.
    fn sun_volts(&mut self, converter: u8, channel: u8) -> Option<f64> {
        let (faces, sensors) = (self.wiring.sun.as_ref()?, self.sun_sensors.as_mut()?);
        let mut wired = faces.iter().enumerate().filter(|(_, face)| face.converter == converter);
        let (number, face, electrode) = wired.find_map(|(number, face)| {
            let electrode = face.channels.iter().position(|&wired| wired == channel)?;
            Some((number, face, electrode))
        })?;
        let current_a = sensors.shown(number, electrode);
        Some(f64::from(face.dark_v) + f64::from(face.transimpedance_ohm) * current_a)
    }
}

impl Plant for World {
    fn pin_volts(&mut self, converter: Converter, channel: u8) -> f64 {
        let volts = match converter {
            Converter::Main => self.triad_volts(channel),
            Converter::Sun(number) => self.sun_volts(number, channel),
        };
        // An input that nothing is wired to.
        volts.unwrap_or(0.0)
    }

    fn set_winding(&mut self, axis: usize, drive: f64) {
        if let (Some(dipole), Some(full)) =
            (self.torquer_dipole.xyz.get_mut(axis), self.full_dipole_am2.get(axis))
        {
            *dipole = drive * full;
        }
    }
}
