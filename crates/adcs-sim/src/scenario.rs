//! A mission as data: what the ground makes of a mission file, and what a simulation, on the host or
//! in the image, flies. Everything is in SI units and radians, so that each world starts from the
//! same bits.

use adcs_app::FlightParameters;
use adcs_core::time::Utc;
use adcs_hal::driver_board::DriverBoardConfig;
use serde::{Deserialize, Serialize};
use sgp4_lite::Elements;

use crate::devices::SpiFault;

/// Version of this data and of the link messages that come back; both sides of an emulated flight
/// check it.
pub const VERSION: u16 = 1;

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
    /// How long to fly, in cycles of `flight.cycle_us`. One more is flown, at the very end.
    pub cycles: u32,
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
