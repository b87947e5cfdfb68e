//! What SPROUT's flight software believes of its satellite in the studies.

use adcs_app::parameters::{FlightParameters, LawParameters};
use adcs_core::attitude::dynamic::DynamicParameters;
use adcs_core::attitude::mekf::{FieldNoise, MekfParameters};
use adcs_core::attitude::selection::{EstimatorParameters, Flies};
use adcs_core::control::allocation::TorquerParameters;
use adcs_core::control::b_dot::BDotGain;
use adcs_core::pipeline::{RateFrom, SteeringParameters};
use adcs_core::schedule::ScheduleParameters;
use adcs_core::sensing::{SunFacesParameters, TriadParameters};
use anyhow::Result;

use super::super::sprout::{self, B_DOT_GAIN, FIELD_NOISE_T, MAX_DIPOLE_AM2};

/// Cycles of 0.5 s, torquers 10 s on and 2.5 s off of which the first half second settles, and `law`;
/// without attitude.
///
/// # Errors
/// None: the elements are good.
pub fn sprout(law: LawParameters) -> Result<FlightParameters> {
    Ok(FlightParameters {
        cycle_us: 500_000,
        schedule: ScheduleParameters { on_us: 10_000_000, off_us: 2_500_000, settle_us: 500_000 },
        law,
        steering: SteeringParameters::default(),
        modes: None,
        gyro: TriadParameters::default(),
        magnetometer: TriadParameters::default(),
        sun_sensors: None,
        attitude: None,
        torquers: TorquerParameters {
            max_dipole_am2: MAX_DIPOLE_AM2 as f32,
            alignment_xyzw: [0.0, 0.0, 0.0, 1.0],
        },
        elements: Some(sprout::elements()?),
    })
}

/// The paper's B-dot.
pub fn b_dot() -> LawParameters {
    LawParameters::BDot(BDotGain::Plain { gain_am2_s_per_t: B_DOT_GAIN as f32 })
}

/// Both filters as they fly, told the noise of the paper's sensors.
pub fn estimator() -> EstimatorParameters {
    let field_noise =
        FieldNoise { sensor_t: FIELD_NOISE_T as f32, ..MekfParameters::default().field_noise };
    let sensors = MekfParameters { field_noise, ..MekfParameters::default() };
    let dynamics = DynamicParameters { sensors, ..DynamicParameters::default() };
    EstimatorParameters { dynamics, flies: Flies::Both }
}

/// The same flight with Sun sensors and both filters, and the residual dipole fed forward from this σ of
/// each axis on, A·m².
pub fn dynamic_filter(flight: &FlightParameters, feed_forward_sigma_am2: f32) -> FlightParameters {
    let steering = SteeringParameters {
        // A sample of the gyro is noise where the filter is not, once the tumble is over.
        rate: RateFrom::Estimate,
        feed_forward_sigma_am2: Some(feed_forward_sigma_am2),
        ..flight.steering
    };
    FlightParameters {
        steering,
        sun_sensors: Some(SunFacesParameters::SPROUT),
        attitude: Some(estimator()),
        ..*flight
    }
}
