//! Stage III of the flight code with what a better stage II would say.

use adcs_core::attitude::dynamic::{DynamicEstimate, DynamicOutput};
use adcs_core::attitude::mekf;
use adcs_core::attitude::selection::{
    Attitude, AttitudeSource, Determination, Rate, RateSource, Reason,
};
use adcs_core::frames::{Body, Eci, Rotation, Vector};
use adcs_core::orbit::OrbitState;
use adcs_core::orbit::interpolated::InterpolatedOrbit;
use adcs_core::pipeline::Configuration;
use adcs_core::planning::{Models, PlanningState};
use adcs_core::reading::Reading;
use adcs_core::steering::{Known, SteeringState};
use nalgebra::{Matrix3, Vector3};

use super::super::closed_loop::{Moment, Truth};
use super::super::sprout::INERTIA_KG_M2;
use super::case::Knowledge;

/// Stage III beside that of the flight, and its own look ahead.
#[derive(Default)]
pub(super) struct Knowing {
    planning: PlanningState,
    steering: SteeringState,
}

impl Knowing {
    /// What the torquers are told of this cycle.
    pub(super) fn decide(
        &mut self,
        configuration: &Configuration,
        knowledge: Knowledge,
        moment: &Moment,
    ) -> Vector<adcs_core::frames::TorquerAxes> {
        let Moment { now, phase, truth, thoughts, .. } = moment;
        let models = Models {
            orbit: configuration.orbit.as_ref().map(InterpolatedOrbit::model),
            sun: &configuration.sun,
        };
        let gains = self.planning.cycle(&configuration.law, &models, *now);
        let orbit = OrbitState { position: truth.position, velocity: truth.velocity };
        let omega = vector(truth.omega_bi);
        let determination = match knowledge {
            Knowledge::Filters => return thoughts.command.dipole,
            Knowledge::Truth => {
                let q = truth.r_bi.hamilton().cast();
                Some(believed(truth, Rotation::from_hamilton(q), omega))
            }
            Knowledge::Mekf => thoughts.determination.as_ref().and_then(|it| {
                let (attitude, rate) = (it.attitude?, it.rate?);
                Some(believed(truth, attitude.r_bi, rate.omega_bi))
            }),
        };
        let field_b = match knowledge {
            Knowledge::Mekf => thoughts.field_b,
            _ => Reading::Fresh((truth.r_bi * truth.field_i).to_f32()),
        };
        let known = Known {
            orbit: Some(&orbit),
            sun: truth.sun_i.to_f32().direction(),
            omega_bi: Reading::Fresh(omega),
            field_b,
            determination: determination.as_ref(),
            reference_field: Some(truth.field_i.to_f32()),
            gains,
        };
        let Configuration { law, steering, allocation, .. } = configuration;
        let at = (*now, *phase);
        self.steering.cycle(law, steering, allocation, at, &known).command.dipole
    }
}

fn vector<F>(xyz: Vector3<f64>) -> Vector<F> {
    Vector::from_xyz(xyz.cast())
}

/// A stage II that is sure of this. The residual dipole is the truth's, and the only torque that it does
/// not foresee is one that changes within minutes.
fn believed(truth: &Truth, r_bi: Rotation<Body, Eci>, omega_bi: Vector<Body>) -> Determination {
    const SURE: f32 = 1e-6;
    let covariance = Matrix3::from_diagonal_element(SURE * SURE);
    let estimate = DynamicEstimate {
        r_bi,
        attitude_covariance: covariance,
        omega_bi,
        rate_covariance: covariance,
        gyro_bias: vector(truth.gyro_bias),
        gyro_bias_sigma_rad_s: Vector::zero(),
        residual_dipole: vector(truth.dipole),
        residual_dipole_sigma_am2: Vector::zero(),
        inertia_kg_m2: Matrix3::from_fn(|row, column| INERTIA_KG_M2[row][column] as f32),
        torque: Vector::zero(),
        torque_sigma_n_m: 0.0,
        trusted: true,
        gyro_doubtful: false,
    };
    Determination {
        attitude: Some(Attitude { r_bi, covariance, source: AttitudeSource::Dynamic }),
        rate: Some(Rate { omega_bi, sigma_rad_s: SURE, source: RateSource::Dynamic }),
        reason: Reason::Best,
        mekf: mekf::Output::none(None),
        dynamic: DynamicOutput { estimate: Some(estimate), ..DynamicOutput::none(None) },
    }
}
