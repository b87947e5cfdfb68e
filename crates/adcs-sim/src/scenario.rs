//! A mission as data: what the ground makes of a mission file, and what a simulation, on the host or
//! in the image, flies. Everything is in SI units and radians, so that each world starts from the
//! same bits.

use adcs_app::FlightParameters;
use adcs_core::modes::Mode;
use adcs_core::sensing::{SunFaceParameters, SunFacesParameters};
use adcs_core::time::Utc;
use adcs_hal::driver_board::DriverBoardConfig;
use adcs_hal::psd_face::FACES;
use serde::{Deserialize, Serialize};
use sgp4_lite::Elements;

use crate::devices::SpiFault;

/// Version of this data and of the link messages that come back; both sides of an emulated flight
/// check it.
pub const VERSION: u16 = 6;

/// As many commands can be given in a flight.
pub const COMMANDS: usize = 8;

/// One flight: the satellite's own parameters, and the truth it will meet.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Scenario {
    /// [`VERSION`] of the writer.
    pub version: u16,
    /// What the flight software knows.
    pub flight: FlightParameters,
    /// How sensors and torquers are wired, as the drivers know it.
    pub board: DriverBoardConfig,
    /// How the readings reach the flight software.
    pub readings: Readings,
    /// A broken converter bus, for a whole flight; only met with [`Readings::Drivers`].
    pub converter_fault: Option<SpiFault>,
    /// What is really so.
    pub world: WorldParameters,
    /// What the ground tells the satellite on the way, in the order of time.
    pub commands: [Option<TimedCommand>; COMMANDS],
    /// How long to fly, in cycles of `flight.cycle_us`. One more is flown, at the very end.
    pub cycles: u32,
}

/// A command and when it reaches the satellite.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct TimedCommand {
    /// The cycle that follows it.
    pub cycle: u32,
    /// What is asked for.
    pub order: Order,
}

/// What the ground can ask for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Order {
    /// A mode.
    Enter(Mode),
    /// That what commissioning found flies.
    Commit,
}

/// How readings and commands cross the border of the board.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Readings {
    /// Through the real drivers and register-level device models, with all sensor errors.
    Drivers,
    /// Handed over as they truly are, in f32: no converter, no noise, no steps.
    Exact,
}

/// What is really so.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct WorldParameters {
    /// The instant at which the flight starts.
    pub start: Utc,
    /// Attitude quaternion then, Eci to Body, `[q_x, q_y, q_z, q_w]`.
    pub attitude_xyzw: [f64; 4],
    /// Rate of Body relative to Eci then, Body, rad/s.
    pub omega_bi_rad_s: [f64; 3],
    /// Inertia tensor, kg·m².
    pub inertia_kg_m2: [[f64; 3]; 3],
    /// The satellite's own remanent dipole, Body, A·m²; `None` switches its torque off.
    pub residual_dipole_am2: Option<[f64; 3]>,
    /// Whether the gradient of gravity acts.
    pub gravity_gradient: bool,
    /// Drag; `None` switches it off.
    pub drag: Option<DragParameters>,
    /// Solar pressure; `None` switches it off.
    pub solar_pressure: Option<SolarPressureParameters>,
    /// The satellite as a box, for drag and solar pressure.
    pub shape: ShapeParameters,
    /// The orbit really flown.
    pub elements: Elements,
    /// Step of the integration, µs.
    pub step_us: u32,
    /// The gyros as they are; rad/s.
    pub gyro: SensorTruth,
    /// The magnetometer as it is; T.
    pub magnetometer: SensorTruth,
    /// Where the magnetometer sits relative to the torquers, Body, m; `None` keeps their field from
    /// reaching it.
    pub magnetometer_offset_m: Option<[f64; 3]>,
    /// The Sun sensors as they are; `None` on a satellite without.
    pub sun_sensors: Option<SunSensorsTruth>,
    /// Attitude quaternion from Body to the torquers' axes.
    pub torquer_alignment_xyzw: [f64; 4],
    /// Dipole of each torquer at full duty, A·m².
    pub torquer_full_dipole_am2: [f64; 3],
    /// Steps of the torquers' timer per period.
    pub torquer_steps: u16,
    /// Seed of every noise.
    pub seed: u64,
}

/// The air.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct DragParameters {
    /// Density, kg/m³.
    pub density_kg_m3: f64,
    /// Drag coefficient.
    pub coefficient: f64,
}

/// The satellite's surface in sunlight.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SolarPressureParameters {
    /// 1 (black) to 2 (mirror).
    pub coefficient: f64,
}

/// The satellite as a box.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ShapeParameters {
    /// Sides along Body x, y, z, m.
    pub sides_m: [f64; 3],
    /// Centre of pressure relative to the centre of mass, Body, m.
    pub centre_of_pressure_m: [f64; 3],
}

/// A three-axis sensor as it really is: `shown = matrix · (true, in its axes) + bias + noise`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SensorTruth {
    /// Attitude quaternion from the sensor's axes to Body.
    pub alignment_xyzw: [f64; 4],
    /// Scale, cross-axis, sign and axis errors in one matrix, row by row; the identity is none.
    pub matrix: [[f64; 3]; 3],
    /// Shown when the true value is zero, in the sensor's SI unit.
    pub bias: [f64; 3],
    /// Standard deviation of the white noise of each conversion, in the sensor's SI unit.
    pub noise: f64,
}

impl SensorTruth {
    /// A sensor without any error.
    pub const PERFECT: Self = Self {
        alignment_xyzw: [0.0, 0.0, 0.0, 1.0],
        matrix: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        bias: [0.0; 3],
        noise: 0.0,
    };
}

/// The Sun sensors as they really are.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SunSensorsTruth {
    /// The faces.
    pub faces: [SunFaceTruth; FACES],
    /// Standard deviation of the direction in which a face sees the Sun, about each axis across it,
    /// rad.
    pub noise_rad: f64,
    /// Standard deviation of the white noise of each conversion, A.
    pub current_noise_a: f64,
    /// Part of the sunlight that the Earth sends back; 0 switches its light off.
    pub albedo: f64,
}

impl SunSensorsTruth {
    /// Sun sensors that are what the flight software takes them for, without noise, over a black
    /// Earth.
    pub fn perfect(known: &SunFacesParameters) -> Self {
        let face = |face: &SunFaceParameters| SunFaceTruth {
            alignment_xyzw: face.alignment_xyzw.map(f64::from),
            active_length_m: f64::from(face.active_length_m),
            height_m: f64::from(face.height_m),
            full_sun_a: f64::from(face.full_sun_a),
            half_cone_rad: f64::from(face.half_cone_rad),
            fault: None,
        };
        let faces = known.faces.each_ref().map(face);
        Self { faces, noise_rad: 0.0, current_noise_a: 0.0, albedo: 0.0 }
    }
}

/// One Sun sensor as it really is.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SunFaceTruth {
    /// Attitude quaternion from the face's axes to Body.
    pub alignment_xyzw: [f64; 4],
    /// Active length of the diode, m.
    pub active_length_m: f64,
    /// Height of the pinhole above it, m.
    pub height_m: f64,
    /// Photocurrent of the Sun at one astronomical unit, straight ahead, A.
    pub full_sun_a: f64,
    /// Half the angle of the cone in which the face sees, rad.
    pub half_cone_rad: f64,
    /// What is broken.
    pub fault: Option<SunFaceFault>,
}

/// How a Sun sensor fails.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum SunFaceFault {
    /// It shows no light.
    Dark,
    /// It shows the Sun straight ahead for ever.
    Stuck,
}
