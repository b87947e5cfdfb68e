//! What is true of the satellites, and what their software is told.

use adcs_app::parameters::{FlightParameters, FlownParameters, ModesParameters};
use adcs_core::commissioning::{CommissioningParameters, Commit};
use adcs_core::modes::{Mode, ModeParameters};
use adcs_core::pipeline::{RateFrom, SteeringParameters};
use adcs_core::polarity::PolarityParameters;
use anyhow::{Context as _, Result};

use super::super::closed_loop::{
    Conditions, DipoleStep, FlawSizes, GyroTruth, Sampling, StartingRate, Torque, b_dot,
};
use super::super::pointing::case::Case;
use super::super::sprout::{DEG, InertiaError, MAX_DIPOLE_AM2};

/// What is wrong beside what is found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum World {
    /// Nothing but noise: what the σ promise.
    Plain,
    /// Torquers 2 %, a constant torque of 5e-9 N·m, dipole 1 % other in the shadow, orbit 2 s late, field
    /// model 60 nT wrong on each axis, and an Earth that shines into the Sun sensors.
    Wrong,
}

impl World {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Plain, Self::Wrong];

    /// What it is called on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Plain => "plain",
            Self::Wrong => "wrong",
        }
    }

    /// What is true: tumbles of 3 to 8 deg/s about any axis, anywhere within two days; moments and products of
    /// inertia within 10 % of the drawing's; and everything that can be calibrated off by much.
    pub(super) fn conditions(self) -> Conditions {
        let plain = Conditions {
            rate: StartingRate::Between([3.0 * DEG, 8.0 * DEG]),
            start_in_sunlight: false,
            inertia: InertiaError::Within(0.10),
            gyro: GyroTruth {
                bias_rad_s: 0.3 * DEG,
                sampling: Sampling::OnceASecond,
                ..GyroTruth::default()
            },
            flaws: FlawSizes {
                scale: 0.2,
                cross_axis: 0.05,
                bias_t: 20e-6,
                torquers_at_m: Some([0.08, 0.20]),
                sun_turn_rad: 3.0 * DEG,
                // Against 0.4 the torquers' whole dipole is fed forward in two thirds of the time.
                residual_dipole_am2: 0.3,
            },
            ..Conditions::default()
        };
        match self {
            Self::Plain => plain,
            Self::Wrong => Conditions {
                torquer_scale_sigma: 0.02,
                torque: Torque { constant_n_m: 5e-9, random_n_m: 0.0, correlation_s: 300.0 },
                eclipse_step: DipoleStep { share: 0.01, lag_s: [0.0, 600.0] },
                orbit_late_s: 2.0,
                field_model_error_t: 60e-9,
                albedo: 0.3,
                ..plain
            },
        }
    }
}

/// What the software is told: the drawing, the data sheets, and how wrong both may be. It commits by
/// itself.
///
/// # Errors
/// None: the elements are good.
pub(super) fn parameters() -> Result<FlightParameters> {
    let case = Case::named("everything").context("the pointing study's case")?;
    let mut flight = case.parameters()?;
    let attitude = flight.attitude.as_mut().context("filters")?;
    let dynamics = &mut attitude.dynamics;
    dynamics.moment_prior = 0.08;
    // Not all of it as the filters are told, which would make 500 nT of noise, a bias of 600 nT and a tensor known
    // to 6 %: the check comes after the ladder's calibration, which leaves less, and the tensor is as uncertain
    // as the filters take it to be.
    let usual = PolarityParameters::default();
    let polarity = PolarityParameters {
        inertia_prior: dynamics.moment_prior,
        field_noise_t: usual.field_noise_t,
        field_bias_t: usual.field_bias_t,
        ..PolarityParameters::of(dynamics, MAX_DIPOLE_AM2 as f32)
    };
    let despin = FlownParameters {
        law: b_dot(),
        steering: SteeringParameters {
            rate: RateFrom::Estimate,
            cut_hold: true,
            feed_forward_sigma_am2: flight.steering.feed_forward_sigma_am2,
        },
    };
    flight.modes = Some(ModesParameters {
        table: ModeParameters { start: Mode::Commissioning, ..ModeParameters::default() },
        despin,
        experiment: None,
        polarity: Some(polarity),
        commissioning: Some(CommissioningParameters {
            commit: Commit::WhenPassed,
            ..CommissioningParameters::default()
        }),
    });
    Ok(flight)
}
