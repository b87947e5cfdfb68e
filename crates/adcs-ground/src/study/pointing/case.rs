//! The worlds, and what the flight knows of them.

use adcs_app::parameters::{FlightParameters, LawParameters};
use adcs_core::attitude::dynamic::{Blocks, DynamicParameters, TorqueNoise};
use adcs_core::attitude::selection::{EstimatorParameters, Flies};
use adcs_core::control::cross_product::CrossProductParameters;
use adcs_core::control::guidance::{AimParameters, GuidanceParameters};
use adcs_core::control::periodic::PeriodicParameters;
use adcs_core::pipeline::SteeringParameters;
use adcs_core::schedule::ScheduleParameters;
use adcs_core::sensing::SunFacesParameters;
use anyhow::Result;

use super::super::closed_loop::{Conditions, DipoleStep, StartingRate, Torque, estimator, sprout};
use super::super::sprout::{DEG, InertiaError};

/// What the law goes by.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Knowledge {
    /// What the flight's own filters say.
    Filters,
    /// The truth.
    Truth,
    /// Attitude and rate of the MEKF, and the residual dipole exactly.
    Mekf,
}

/// Which law points.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Law {
    /// The periodic optimal law.
    Periodic,
    /// The cross-product law.
    CrossProduct,
}

/// What is fed forward against the residual dipole.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FeedForward {
    /// What the flight's own filter finds.
    Estimated,
    /// Nothing.
    None,
    /// This share of the true one; the filter is told the same and does not learn it.
    Fixed {
        /// 1 for the dipole itself.
        dipole_share: f64,
    },
}

/// One set of flights.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Case {
    /// What it is called on the command line.
    pub name: &'static str,
    /// What is special about it.
    pub story: &'static str,
    /// The law.
    pub law: Law,
    /// K_p of the cross-product law, N·m/rad.
    pub stiffness_n_m_per_rad: f32,
    /// What it goes by.
    pub knowledge: Knowledge,
    /// What is fed forward.
    pub feed_forward: FeedForward,
    /// The world.
    pub conditions: Conditions,
}

/// Any attitude, up to a degree per second on each axis, at any time of two days; the paper's sensors and
/// dipole, and no errors beside.
fn nothing_wrong() -> Conditions {
    Conditions {
        rate: StartingRate::Within([DEG; 3]),
        start_in_sunlight: true,
        ..Conditions::default()
    }
}

/// Torquers 2 % (1σ), inertia 5 % in moments and products, 5e-9 N·m.
fn actuators_wrong() -> Conditions {
    Conditions {
        inertia: InertiaError::Signs(0.05),
        torquer_scale_sigma: 0.02,
        torque: Torque { constant_n_m: 5e-9, random_n_m: 0.0, correlation_s: 300.0 },
        ..nothing_wrong()
    }
}

/// The same, and the dipole changing in the shadow by 1 %, with a lag between these.
fn shadow_wrong(lag_s: [f64; 2]) -> Conditions {
    Conditions { eclipse_step: DipoleStep { share: 0.01, lag_s }, ..actuators_wrong() }
}

/// Everything at once.
pub(in super::super) fn everything_wrong() -> Conditions {
    Conditions {
        torque: Torque { constant_n_m: 1e-8, random_n_m: 5e-9, correlation_s: 300.0 },
        magnetometer_bias_t: 500e-9,
        orbit_late_s: 2.0,
        field_model_error_t: 60e-9,
        ..shadow_wrong([600.0; 2])
    }
}

fn constant_torque() -> Conditions {
    Conditions {
        torque: Torque { constant_n_m: 2e-8, random_n_m: 0.0, correlation_s: 300.0 },
        ..nothing_wrong()
    }
}

fn random_torque() -> Conditions {
    Conditions {
        torque: Torque { constant_n_m: 0.0, random_n_m: 3e-8, correlation_s: 300.0 },
        ..nothing_wrong()
    }
}

impl Case {
    fn of(name: &'static str, story: &'static str, conditions: Conditions) -> Self {
        let (law, knowledge) = (Law::Periodic, Knowledge::Filters);
        let (stiffness_n_m_per_rad, feed_forward) = (1.5e-7, FeedForward::Estimated);
        Self { name, story, law, stiffness_n_m_per_rad, knowledge, feed_forward, conditions }
    }

    fn knowing(self, knowledge: Knowledge) -> Self {
        Self { knowledge, ..self }
    }

    fn by(self, law: Law) -> Self {
        Self { law, ..self }
    }

    /// All of them.
    pub fn all() -> Vec<Self> {
        vec![
            Self::of("plain", "no model errors", nothing_wrong()),
            Self::of("actuators", "torquers 2 %, inertia 5 %, 5e-9 N·m", actuators_wrong()),
            Self::of(
                "shadow",
                "the same, dipole 1 % other in the shadow, lag 0 to 600 s",
                shadow_wrong([0.0, 600.0]),
            ),
            Self::of(
                "everything",
                "1e-8 N·m and 5e-9 random, lag 600 s, magnetometer 500 nT, orbit 2 s late, field \
                 model 60 nT",
                everything_wrong(),
            ),
            Self::of("constant-torque", "2e-8 N·m in any direction", constant_torque()),
            Self::of("random-torque", "3e-8 N·m, 300 s", random_torque()),
            Self::of("random-torque-known", "the same, perfect knowledge", random_torque())
                .knowing(Knowledge::Truth),
            Self::of("law-alone", "perfect knowledge", nothing_wrong()).knowing(Knowledge::Truth),
            Self::of("cross-product-alone", "perfect knowledge", nothing_wrong())
                .by(Law::CrossProduct)
                .knowing(Knowledge::Truth),
            Self::of("mekf", "MEKF in the loop, dipole known", nothing_wrong())
                .knowing(Knowledge::Mekf),
            Self::of("cross-product-mekf", "MEKF in the loop, dipole known", nothing_wrong())
                .by(Law::CrossProduct)
                .knowing(Knowledge::Mekf),
            Self {
                feed_forward: FeedForward::None,
                ..Self::of("no-feed-forward", "the dipole is not fed forward", nothing_wrong())
            },
            Self {
                feed_forward: FeedForward::Fixed { dipole_share: 1.05 },
                ..Self::of("dipole-5-percent", "told a dipole 5 % wrong, for good", nothing_wrong())
            },
        ]
    }

    /// The case of this name.
    pub fn named(name: &str) -> Option<Self> {
        Self::all().into_iter().find(|case| case.name == name)
    }

    /// The filters of the flight.
    fn estimator(&self) -> EstimatorParameters {
        let EstimatorParameters { mut dynamics, .. } = pointing_estimator();
        if let FeedForward::Fixed { dipole_share } = self.feed_forward {
            dynamics.dipole_am2 =
                self.conditions.residual_dipole_am2.map(|m| (m * dipole_share) as f32);
            // As sure as a filter can be told to be.
            dynamics.dipole_prior_am2 = 2e-4;
            dynamics.dipole_walk_am2_per_sqrt_s = 0.0;
        }
        let flies = match self.knowledge {
            Knowledge::Mekf => Flies::Mekf,
            Knowledge::Filters | Knowledge::Truth => Flies::Both,
        };
        EstimatorParameters { dynamics, flies }
    }

    /// What the flight software is told.
    ///
    /// # Errors
    /// None: the elements are good.
    pub fn parameters(&self) -> Result<FlightParameters> {
        let unplanned = CrossProductParameters {
            stiffness_n_m_per_rad: self.stiffness_n_m_per_rad,
            damping_n_m_s: 3e-4,
            inertia_kg_m2: PeriodicParameters::<f32>::default().inertia_kg_m2,
            gyroscopic: false,
            gravity_gradient: true,
        };
        let guidance = GuidanceParameters { aim: AimParameters::Nadir, slew_rad_s: None };
        let law = match self.law {
            Law::Periodic => LawParameters::Periodic {
                law: PeriodicParameters { dipole_weight_am2: 0.03, ..Default::default() },
                unplanned,
                guidance,
            },
            Law::CrossProduct => LawParameters::CrossProduct { law: unplanned, guidance },
        };
        let feed_forward_sigma_am2 = (self.feed_forward != FeedForward::None).then_some(0.03);
        Ok(FlightParameters {
            schedule: ScheduleParameters {
                on_us: 5_000_000,
                off_us: 2_500_000,
                settle_us: 2_500_000,
            },
            steering: SteeringParameters { feed_forward_sigma_am2, ..Default::default() },
            sun_sensors: Some(SunFacesParameters::SPROUT),
            attitude: Some(self.estimator()),
            ..sprout(law)?
        })
    }
}

/// The filters as `missions/sprout/nadir.toml` tunes them: every optional state flies, and the torque that
/// nobody told is nearly constant, so that it can be planned with.
fn pointing_estimator() -> EstimatorParameters {
    let EstimatorParameters { mut dynamics, .. } = estimator();
    dynamics.sensors.field_noise.calibration_t = 500e-9;
    EstimatorParameters {
        dynamics: DynamicParameters {
            blocks: Blocks::ALL,
            moment_prior: 0.05,
            product_prior: 0.05,
            dipole_walk_am2_per_sqrt_s: 5e-6,
            dipole_step_am2: 0.004,
            white_torque_n_m_sqrt_s: 2e-8,
            torque: TorqueNoise {
                smallest_n_m: 1e-9,
                start_n_m: 1e-8,
                correlation_s: 5_000.0,
                ..dynamics.torque
            },
            ..dynamics
        },
        flies: Flies::Both,
    }
}
