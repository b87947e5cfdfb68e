//! The flight that is counted: SPROUT's despin (docs/paper.md), all torques and sensors at work.

use adcs_app::{FlightParameters, LawParameters};
use adcs_core::pipeline::SteeringParameters;
use adcs_core::{
    attitude::dynamic::DynamicParameters,
    attitude::selection::{EstimatorParameters, Flies},
    control::{allocation::TorquerParameters, b_dot::BDotGain},
    schedule::ScheduleParameters,
    sensing::{SunFacesParameters, TriadParameters},
    time::Utc,
};
use adcs_hal::driver_board::DriverBoardConfig;
use adcs_sim::scenario::{
    COMMANDS, DragParameters, Readings, Scenario, SensorTruth, ShapeParameters,
    SolarPressureParameters, SunSensorsTruth, VERSION, WorldParameters,
};
use sgp4_lite::Elements;

/// SPROUT on 2015-11-19 (CelesTrak).
const TLE: [&str; 2] = [
    "1 39770U 14029E   15323.12177538  .00004189  00000-0  50368-3 0  9997",
    "2 39770  97.8736  57.8959 0010514  58.6984 301.5230 14.84437654 80617",
];
const START: &str = "2015-11-19T03:31:21Z";
/// One round of the schedule: 10 s on, 2.5 s off, two cycles a second.
const CYCLES: u32 = 25;

/// No alignment error: the axes are Body's.
const ALIGNED_F32: [f32; 4] = [0.0, 0.0, 0.0, 1.0];
const ALIGNED_F64: [f64; 4] = [0.0, 0.0, 0.0, 1.0];

/// The scenario, with readings that come by `readings`.
pub fn despin(readings: Readings) -> Scenario {
    let [line_1, line_2] = TLE;
    let elements = Elements::from_tle(line_1, line_2).expect("the lines above are a TLE");
    let torquers = TorquerParameters { max_dipole_am2: 0.6, alignment_xyzw: ALIGNED_F32 };
    Scenario {
        version: VERSION,
        flight: FlightParameters {
            cycle_us: 500_000,
            schedule: ScheduleParameters {
                on_us: 10_000_000,
                off_us: 2_500_000,
                settle_us: 500_000,
            },
            law: LawParameters::BDot(BDotGain::Plain { gain_am2_s_per_t: 1e5 }),
            steering: SteeringParameters::default(),
            modes: None,
            gyro: TriadParameters::default(),
            magnetometer: TriadParameters::default(),
            sun_sensors: Some(SunFacesParameters::SPROUT),
            attitude: Some(EstimatorParameters {
                dynamics: DynamicParameters::default(),
                flies: Flies::Both,
            }),
            torquers,
            elements: Some(elements),
        },
        board: DriverBoardConfig::SPROUT,
        readings,
        converter_fault: None,
        world: WorldParameters {
            start: Utc::parse(START).expect("a date"),
            attitude_xyzw: [0.4821, 0.7618, -0.0245, 0.4319],
            omega_bi_rad_s: [0.0624, 0.0326, 0.1427],
            inertia_kg_m2: [
                [0.05184, 0.00058, -0.00077],
                [0.00058, 0.05416, 0.00069],
                [-0.00077, 0.00069, 0.05978],
            ],
            residual_dipole_am2: Some([0.01, 0.01, 0.01]),
            gravity_gradient: true,
            drag: Some(DragParameters { density_kg_m3: 1e-13, coefficient: 2.2 }),
            solar_pressure: Some(SolarPressureParameters { coefficient: 1.5 }),
            shape: ShapeParameters {
                sides_m: [0.214, 0.210, 0.220],
                centre_of_pressure_m: [0.01, 0.01, 0.01],
            },
            elements,
            step_us: 100_000,
            gyro: SensorTruth { noise: 2.8e-3, ..SensorTruth::PERFECT },
            magnetometer: SensorTruth { noise: 6e-10, ..SensorTruth::PERFECT },
            magnetometer_offset_m: Some([0.1, 0.1, 0.1]),
            sun_sensors: Some(sun_sensors()),
            torquer_alignment_xyzw: ALIGNED_F64,
            torquer_full_dipole_am2: [0.6; 3],
            torquer_steps: 8400,
            seed: 1,
        },
        commands: [None; COMMANDS],
        cycles: CYCLES,
    }
}

/// The Sun sensors as the flight software knows them, with the published noise, and the Earth.
fn sun_sensors() -> SunSensorsTruth {
    SunSensorsTruth {
        noise_rad: 0.0116,
        current_noise_a: 2e-8,
        albedo: 0.3,
        ..SunSensorsTruth::perfect(&SunFacesParameters::SPROUT)
    }
}
