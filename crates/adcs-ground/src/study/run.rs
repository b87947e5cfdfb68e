//! One flight through both filters and their bounds.

use adcs_core::attitude::dynamic::{
    DynamicEvent, DynamicFilter, DynamicInputs, DynamicOutput, DynamicParameters, DynamicState,
    Truth as Known,
};
use adcs_core::attitude::mekf::{
    self, FieldNoise, FieldPair, Mekf, MekfParameters, MekfState, SunPair,
};
use adcs_core::frames::{Body, Eci, Rotation, Vector};
use adcs_core::reading::{MissingReason, Reading};
use adcs_sim::noise::Gaussian;
use anyhow::Result;
use nalgebra::{Matrix3, Quaternion, RealField, Unit, Vector3, convert};

use super::figures::Figures;
use super::scene::Scene;
use super::sprout::{self, INERTIA_KG_M2, InertiaError, ORBIT_S};
use super::truth::{Moment, STEP_S, STEPS_A_SECOND, Truth};

/// Statistics begin here, s.
const TRANSIENT_S: f64 = 600.0;
/// When the residual dipole is looked at, s.
const DIPOLE_AT_S: [f64; 2] = [1200.0, 3000.0];
/// Stream of the errors in what the filters are told.
const MISTAKES: u64 = 103;

/// What a flight, or all flights of a scene, come to.
#[derive(Debug, Clone, Copy, Default)]
pub struct Flight {
    /// The MEKF.
    pub mekf: Figures,
    /// The dynamics-aided filter, whether it was believed or not.
    pub dynamic: Figures,
    /// What the satellite would believe.
    pub believed: Figures,
    /// What no filter with the MEKF's states can beat.
    pub mekf_bound: Figures,
    /// What no filter with the dynamics-aided filter's states can beat.
    pub dynamic_bound: Figures,
}

impl Flight {
    /// Takes in another flight.
    pub fn join(&mut self, other: &Self) {
        self.mekf.join(&other.mekf);
        self.dynamic.join(&other.dynamic);
        self.believed.join(&other.believed);
        self.mekf_bound.join(&other.mekf_bound);
        self.dynamic_bound.join(&other.dynamic_bound);
    }
}

/// Flies number `seed` of a scene.
///
/// # Errors
/// When the orbit or the field model ends, which those of the scenes do not.
pub fn fly(scene: &Scene, seed: u64) -> Result<Flight> {
    let mut truth = Truth::new(*scene, seed)?;
    let given = InertiaError::Signs(scene.inertia_error).drawn(&mut Gaussian::new(seed, MISTAKES));
    let mut filters = Filters::<f32>::new(&parameters(&given))?;
    let told_the_truth = knowing(scene, &given);
    let mut bounds = Filters::<f64>::new(&told_the_truth)?;

    let mut flight = Flight::default();
    let steps = (scene.orbits * ORBIT_S / STEP_S).round() as u32;
    for _ in 0..steps {
        let moment = truth.step()?;
        let found = filters.cycle(&moment);
        let bound = bounds.cycle(&moment);
        bounds.linearise_at(&moment, &told_the_truth);
        // The sensors speak once a second; so do the statistics.
        let (Some(mekf), Some(mekf_bound)) = (found.mekf, bound.mekf) else { continue };
        let positive = filters.dynamic_state.covariance_is_positive().unwrap_or(true);
        flight.dynamic.not_positive += u32::from(!positive);
        flight.dynamic.starts += u32::from(found.dynamic.event == Some(DynamicEvent::Started));
        if moment.t_s < TRANSIENT_S {
            continue;
        }
        see_mekf(&mut flight.mekf, &moment, &mekf);
        see_dynamic(&mut flight.dynamic, &moment, &found.dynamic);
        if found.dynamic.estimate.is_some_and(|estimate| estimate.trusted) {
            see_dynamic(&mut flight.believed, &moment, &found.dynamic);
        } else {
            see_mekf(&mut flight.believed, &moment, &mekf);
        }
        see_bounds(&mut flight, &moment, &mekf_bound, &bound.dynamic);
    }
    Ok(flight)
}

fn see_mekf(figures: &mut Figures, moment: &Moment, output: &mekf::Output<f32>) {
    let Some(estimate) = &output.estimate else {
        figures.without += 1;
        return;
    };
    let covariance = estimate.covariance.fixed_view::<3, 3>(0, 0).into_owned();
    figures.see_attitude(&error(moment, estimate.r_bi), &covariance.cast(), moment.lit);
    figures.bias.see((moment.bias - estimate.gyro_bias.xyz.cast()).norm_squared());
    if let Some(omega) = estimate.omega_bi {
        figures.rate.see((moment.omega - omega.xyz.cast()).norm_squared());
    }
}

fn see_dynamic(figures: &mut Figures, moment: &Moment, output: &DynamicOutput<f32>) {
    let Some(estimate) = &output.estimate else {
        figures.without += 1;
        return;
    };
    figures.distrusted += u32::from(!estimate.trusted);
    let covariance = estimate.attitude_covariance.cast();
    figures.see_attitude(&error(moment, estimate.r_bi), &covariance, moment.lit);
    figures.bias.see((moment.bias - estimate.gyro_bias.xyz.cast()).norm_squared());
    figures.rate.see((moment.omega - estimate.omega_bi.xyz.cast()).norm_squared());
    if let Some(at) = DIPOLE_AT_S.iter().position(|&at| at == moment.t_s) {
        figures.see_dipole(at, &(moment.dipole - estimate.residual_dipole.xyz.cast()));
    }
}

fn see_bounds(
    flight: &mut Flight,
    moment: &Moment,
    mekf: &mekf::Output<f64>,
    dynamic: &DynamicOutput<f64>,
) {
    if let Some(estimate) = &mekf.estimate {
        let figures = &mut flight.mekf_bound;
        let p = estimate.covariance.fixed_view::<3, 3>(0, 0).into_owned();
        figures.see_bound(&p, moment.lit);
        figures.bias.see(estimate.gyro_bias_sigma_rad_s.xyz.norm_squared());
    }
    if let Some(estimate) = &dynamic.estimate {
        let figures = &mut flight.dynamic_bound;
        figures.see_bound(&estimate.attitude_covariance, moment.lit);
        figures.rate.see(estimate.rate_covariance.trace());
        figures.bias.see(estimate.gyro_bias_sigma_rad_s.xyz.norm_squared());
        if let Some(at) = DIPOLE_AT_S.iter().position(|&at| at == moment.t_s) {
            figures.see_dipole(at, &estimate.residual_dipole_sigma_am2.xyz);
        }
    }
}

/// How far the satellite is turned from the estimate, Body, rad.
fn error(moment: &Moment, r_bi: Rotation<Body, Eci, f32>) -> Vector3<f64> {
    let estimated: Rotation<Body, Eci, f64> =
        Rotation::from_hamilton(Unit::new_normalize(r_bi.hamilton().into_inner().cast()));
    -(moment.r_bi * estimated.inverse()).hamilton().scaled_axis()
}

/// What the filters are told: the sensors' noise, and an inertia tensor.
fn parameters<T: RealField + Copy>(inertia: &Matrix3<f64>) -> DynamicParameters<T> {
    let sensors = MekfParameters {
        gyro_noise_rad_s: convert(sprout::GYRO_NOISE_RAD_S),
        bias_walk_rad_s_per_sqrt_s: convert(sprout::BIAS_WALK_RAD_S_PER_SQRT_S),
        field_noise: FieldNoise {
            sensor_t: convert(sprout::FIELD_NOISE_T),
            calibration_t: T::zero(),
            model_t: T::zero(),
        },
        sun_noise_rad: convert(sprout::SUN_NOISE_RAD),
        ..MekfParameters::default()
    };
    let row = |r: usize| [0, 1, 2].map(|c| convert(inertia[(r, c)]));
    DynamicParameters { sensors, inertia_kg_m2: [row(0), row(1), row(2)], ..Default::default() }
}

/// The same, and how large the unknown torque and the dipole's jumps really are: for the bounds.
fn knowing(scene: &Scene, inertia: &Matrix3<f64>) -> DynamicParameters<f64> {
    let mut known = parameters(inertia);
    known.torque.smallest_n_m = scene.torque_n_m;
    known.torque.start_n_m = scene.torque_n_m;
    known.torque.largest_n_m = scene.torque_n_m;
    known.torque.correlation_s = scene.correlation_s;
    known.dipole_walk_am2_per_sqrt_s = 0.0;
    known.dipole_step_am2 = scene.dipole_jump_am2;
    known
}

/// What both filters made of a step; the MEKF runs when the sensors speak.
struct Found<T: RealField + Copy> {
    mekf: Option<mekf::Output<T>>,
    dynamic: DynamicOutput<T>,
}

/// Both filters on the same measurements, in the precision `T`.
struct Filters<T: RealField + Copy> {
    mekf: Mekf<T>,
    mekf_state: MekfState<T>,
    dynamic: DynamicFilter<T>,
    dynamic_state: DynamicState<T>,
    started: bool,
}

impl<T: RealField + Copy> Filters<T> {
    fn new(parameters: &DynamicParameters<T>) -> Result<Self> {
        Ok(Self {
            mekf: Mekf::new(&parameters.sensors)?,
            mekf_state: MekfState::default(),
            dynamic: DynamicFilter::new(parameters)?,
            dynamic_state: DynamicState::default(),
            started: false,
        })
    }

    fn cycle(&mut self, moment: &Moment) -> Found<T> {
        let step_s = if self.started { STEP_S } else { 0.0 };
        self.started = true;
        let mekf = moment.gyro.map(|_| {
            let since_last = sensors(moment, step_s * f64::from(STEPS_A_SECOND));
            self.mekf.cycle(&mut self.mekf_state, &since_last)
        });
        let silent = mekf::Output::none(None);
        let inputs = DynamicInputs {
            sensors: sensors(moment, step_s),
            reference_field: Some(vector(moment.field_i)),
            position: Some(vector(moment.position)),
            torquer_dipole: vector(moment.torquers),
            sunlit: Some(moment.lit),
        };
        let beside = mekf.as_ref().unwrap_or(&silent);
        let dynamic = self.dynamic.cycle(&mut self.dynamic_state, &inputs, beside);
        Found { mekf, dynamic }
    }

    fn linearise_at(&mut self, moment: &Moment, parameters: &DynamicParameters<T>) {
        let to = |v: Vector3<f64>| v.map(convert);
        let q = Quaternion::from(moment.r_bi.hamilton().coords.map(convert));
        let r_bi = Rotation::from_hamilton(Unit::new_normalize(q));
        self.mekf_state.linearise_at(r_bi, to(moment.bias));
        let known = Known {
            r_bi,
            omega: to(moment.omega),
            bias: to(moment.bias),
            dipole: to(moment.dipole),
            inertia: Matrix3::from_fn(|r, c| convert(INERTIA_KG_M2[r][c])),
            torque: to(moment.torque),
        };
        self.dynamic_state.linearise_at(&known, parameters);
    }
}

fn vector<F, T: RealField + Copy>(xyz: Vector3<f64>) -> Vector<F, T> {
    Vector::from_xyz(xyz.map(convert))
}

fn sensors<T: RealField + Copy>(moment: &Moment, dt_s: f64) -> mekf::Inputs<T> {
    let silent = Reading::Missing(MissingReason::Bus);
    let gyro = moment.gyro.map_or(silent, |gyro| Reading::Fresh(vector(gyro)));
    let field =
        moment.field_b.map(|body| FieldPair { body: vector(body), eci: vector(moment.field_i) });
    let sun = moment.sun_b.and_then(|body| {
        Some(SunPair {
            body: vector(body).direction()?,
            eci: vector(moment.sun_i).direction()?,
            sigma_rad: None,
        })
    });
    mekf::Inputs { dt_s: convert(dt_s), gyro, field, sun }
}
