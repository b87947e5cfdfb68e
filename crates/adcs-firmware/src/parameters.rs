//! What the satellite flies with until the ground says otherwise.

use adcs_app::{FlightParameters, LawParameters};
use adcs_core::pipeline::SteeringParameters;
use adcs_core::{
    attitude::dynamic::DynamicParameters,
    attitude::selection::{EstimatorParameters, Flies},
    control::{allocation::TorquerParameters, b_dot::BDotGain},
    schedule::ScheduleParameters,
    sensing::{SunFacesParameters, TriadParameters},
};
use adcs_hal::driver_board::DriverBoardConfig;

/// Neither scale, bias nor turn: the data sheet is right until a calibration says otherwise.
const UNCALIBRATED: TriadParameters = TriadParameters {
    scale: [1.0; 3],
    cross_axis: [0.0; 3],
    bias: [0.0; 3],
    alignment_xyzw: [0.0, 0.0, 0.0, 1.0],
};

/// Despin as in the paper: gain 100000, torquers of ±0.6 A·m² on for 10 s, off for 2.5 s. Elements
/// are not known after power-on; despin does without.
///
/// Both filters fly; they wait for the elements, without which there is nothing to hold field and Sun
/// against.
pub fn flight() -> FlightParameters {
    FlightParameters {
        cycle_us: 500_000,
        schedule: ScheduleParameters { on_us: 10_000_000, off_us: 2_500_000, settle_us: 500_000 },
        law: LawParameters::BDot(BDotGain::Plain { gain_am2_s_per_t: 1e5 }),
        steering: SteeringParameters::default(),
        modes: None,
        gyro: UNCALIBRATED,
        magnetometer: UNCALIBRATED,
        sun_sensors: Some(SunFacesParameters::SPROUT),
        attitude: Some(EstimatorParameters {
            dynamics: DynamicParameters::default(),
            flies: Flies::Both,
        }),
        torquers: TorquerParameters { max_dipole_am2: 0.6, alignment_xyzw: [0.0, 0.0, 0.0, 1.0] },
        elements: None,
    }
}

/// How the board is wired.
pub const BOARD: DriverBoardConfig = DriverBoardConfig::SPROUT;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_built_in_parameters_are_accepted() {
        assert!(flight().accept().is_ok());
    }
}
