//! One flight through both filters and their bounds.

use adcs_core::attitude::dynamic::{
    DynamicEvent, DynamicFilter, DynamicInputs, DynamicParameters, DynamicState, Truth as At,
};
use adcs_core::attitude::mekf::{
    self, FieldNoise, FieldPair, Mekf, MekfParameters, MekfState, SunPair,
};
use adcs_core::frames::{Body, Eci, Rotation, Vector};
use adcs_core::reading::{MissingReason, Reading};
use adcs_sim::noise::Gaussian;
use anyhow::Result;
use nalgebra::{Matrix3, RealField, Vector3, convert};

use super::figures::Figures;
use super::scene::Scene;
use super::truth::{self, INERTIA_KG_M2, Moment, ORBIT_S, STEP_S, Truth};

/// Statistics begin here, s.
const TRANSIENT_S: f64 = 600.0;
/// Errors of the residual dipole are looked at from here on, for a minute.
const DIPOLE_AT_S: [f64; 2] = [1200.0, 3000.0];

/// What a flight, or all flights of a scene, come to.
#[derive(Debug, Clone, Copy, Default)]
pub struct Flight {
    pub mekf: Figures,
    pub dynamic: Figures,
    /// What the satellite would use: the dynamics-aided filter while it is believed, else the MEKF.
    pub chosen: Figures,
    pub mekf_bound: Figures,
    pub dynamic_bound: Figures,
}

impl Flight {
    pub fn join(&mut self, other: &Self) {
        self.mekf.join(&other.mekf);
        self.dynamic.join(&other.dynamic);
        self.chosen.join(&other.chosen);
        self.mekf_bound.join(&other.mekf_bound);
        self.dynamic_bound.join(&other.dynamic_bound);
    }
}

/// Flies number `seed` of a scene.
pub fn fly(scene: &Scene, seed: u64) -> Result<Flight> {
    let mut truth = Truth::new(*scene, seed)?;
    let given = given_inertia(scene.inertia_error, seed);
    let mut filters = Filters::<f32>::new(&parameters(&given))?;
    let mut bound_parameters = parameters::<f64>(&given);
    let sigma = scene.torque_n_m;
    bound_parameters.torque.smallest_n_m = sigma;
    bound_parameters.torque.start_n_m = sigma;
    bound_parameters.torque.largest_n_m = sigma;
    bound_parameters.torque.correlation_s = scene.correlation_s;
    bound_parameters.dipole_walk_am2_per_sqrt_s = 0.0;
    bound_parameters.dipole_step_am2 = scene.dipole_jump_am2;
    let mut bounds = Filters::<f64>::new(&bound_parameters)?;

    let mut flight = Flight::default();
    let steps = (scene.orbits * ORBIT_S / STEP_S).round() as u32;
    for _ in 0..steps {
        let moment = truth.next()?;
        let (mekf, dynamic) = filters.cycle(&moment);
        let (mekf_bound, dynamic_bound) = bounds.cycle(&moment);
        bounds.linearise_at(&moment, &bound_parameters);
        let Some(mekf) = mekf else { continue };
        if matches!(dynamic.event, Some(DynamicEvent::Started)) {
            flight.dynamic.starts += 1;
        }
        if moment.t_s < TRANSIENT_S {
            continue;
        }
        see_mekf(&mut flight.mekf, &moment, &mekf);
        see_dynamic(&mut flight.dynamic, &moment, &dynamic);
        if dynamic.estimate.is_some_and(|it| it.trusted) {
            see_dynamic(&mut flight.chosen, &moment, &dynamic);
        } else {
            see_mekf(&mut flight.chosen, &moment, &mekf);
        }
        if let Some(estimate) = mekf_bound.and_then(|it| it.estimate) {
            let p = estimate.covariance.fixed_view::<3, 3>(0, 0).into_owned();
            flight.mekf_bound.see_bound(&p, moment.lit);
            flight.mekf_bound.bias.see(estimate.gyro_bias_sigma_rad_s.xyz.norm_squared());
        }
        if let Some(estimate) = dynamic_bound.estimate {
            flight.dynamic_bound.see_bound(&estimate.attitude_covariance, moment.lit);
            flight.dynamic_bound.rate.see(estimate.rate_covariance.trace());
            flight.dynamic_bound.bias.see(estimate.gyro_bias_sigma_rad_s.xyz.norm_squared());
        }
    }
    Ok(flight)
}

fn see_mekf(figures: &mut Figures, moment: &Moment, output: &mekf::Output<f32>) {
    let Some(estimate) = &output.estimate else {
        figures.without += 1;
        return;
    };
    let covariance = estimate.covariance.fixed_view::<3, 3>(0, 0).into_owned();
    let theta = error(moment, estimate.r_bi);
    figures.see_attitude(&theta, &covariance.cast(), moment.lit);
    figures.bias.see((moment.bias - estimate.gyro_bias.xyz.cast()).norm_squared());
    if let Some(omega) = estimate.omega_bi {
        figures.rate.see((moment.omega - omega.xyz.cast()).norm_squared());
    }
}

fn see_dynamic(
    figures: &mut Figures,
    moment: &Moment,
    output: &adcs_core::attitude::dynamic::DynamicOutput<f32>,
) {
    let Some(estimate) = &output.estimate else {
        figures.without += 1;
        return;
    };
    figures.distrusted += u32::from(!estimate.trusted);
    let theta = error(moment, estimate.r_bi);
    figures.see_attitude(&theta, &estimate.attitude_covariance.cast(), moment.lit);
    figures.bias.see((moment.bias - estimate.gyro_bias.xyz.cast()).norm_squared());
    figures.rate.see((moment.omega - estimate.omega_bi.xyz.cast()).norm_squared());
    let off = (moment.dipole - estimate.residual_dipole.xyz.cast()).amax();
    let [early, late, end] = &mut figures.dipole;
    for (largest, at) in [early, late].into_iter().zip(DIPOLE_AT_S) {
        if moment.t_s == at {
            *largest = largest.max(off);
        }
    }
    *end = off;
}

fn error(moment: &Moment, r_bi: Rotation<Body, Eci, f32>) -> Vector3<f64> {
    let estimated = Rotation::<Body, Eci, f64>::from_hamilton(nalgebra::Unit::new_normalize(
        r_bi.hamilton().into_inner().cast(),
    ));
    -(moment.r_bi * estimated.inverse()).hamilton().scaled_axis()
}

/// What the filters are told.
fn parameters<T: RealField + Copy>(inertia: &Matrix3<f64>) -> DynamicParameters<T> {
    let sensors = MekfParameters {
        gyro_noise_rad_s: convert(truth::GYRO_NOISE_RAD_S),
        bias_walk_rad_s_per_sqrt_s: convert(truth::BIAS_WALK_RAD_S_PER_SQRT_S),
        field_noise: FieldNoise {
            sensor_t: convert(truth::FIELD_NOISE_T),
            calibration_t: T::zero(),
            model_t: T::zero(),
        },
        sun_noise_rad: convert(truth::SUN_NOISE_RAD),
        ..MekfParameters::default()
    };
    let row = |r: usize| [0, 1, 2].map(|c| convert(inertia[(r, c)]));
    DynamicParameters { sensors, inertia_kg_m2: [row(0), row(1), row(2)], ..Default::default() }
}

/// The true tensor with errors of this relative size, signs at random.
fn given_inertia(share: f64, seed: u64) -> Matrix3<f64> {
    let truth = Matrix3::from_fn(|r, c| INERTIA_KG_M2[r][c]);
    let mut noise = Gaussian::new(seed, 103);
    let mean = truth.trace() / 3.0;
    let mut given = truth;
    for (r, c) in [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)] {
        let size = if r == c { truth[(r, c)] } else { mean };
        given[(r, c)] += share * size * noise.sample().signum();
        given[(c, r)] = given[(r, c)];
    }
    given
}

/// MEKF and dynamics-aided filter on the same measurements.
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

    /// The MEKF runs when the sensors speak, once a second; the other at every step.
    fn cycle(
        &mut self,
        moment: &Moment,
    ) -> (Option<mekf::Output<T>>, adcs_core::attitude::dynamic::DynamicOutput<T>) {
        let step_s = if self.started { STEP_S } else { 0.0 };
        let second = moment.gyro.is_some();
        let mut sensors = inputs(moment, step_s);
        let kinematic = second.then(|| {
            let at_one_hertz = mekf::Inputs { dt_s: sensors.dt_s * convert(2.0), ..sensors };
            self.mekf.cycle(&mut self.mekf_state, &at_one_hertz)
        });
        sensors.dt_s = convert(step_s);
        self.started = true;
        let dynamic = DynamicInputs {
            sensors,
            reference_field: Some(vector(moment.field_i)),
            position: Some(vector(moment.position)),
            torquer_dipole: vector(moment.torquers),
            sunlit: Some(moment.lit),
        };
        let silent = mekf::Output { estimate: None, field: None, sun: None, event: None };
        let beside = kinematic.as_ref().unwrap_or(&silent);
        let output = self.dynamic.cycle(&mut self.dynamic_state, &dynamic, beside);
        (kinematic, output)
    }

    fn linearise_at(&mut self, moment: &Moment, parameters: &DynamicParameters<T>) {
        let to = |v: Vector3<f64>| v.map(convert);
        let q = nalgebra::Quaternion::from(moment.r_bi.hamilton().coords.map(convert));
        let r_bi = Rotation::from_hamilton(nalgebra::Unit::new_normalize(q));
        self.mekf_state.linearise_at(r_bi, to(moment.bias));
        let at = At {
            r_bi,
            omega: to(moment.omega),
            bias: to(moment.bias),
            dipole: to(moment.dipole),
            inertia: Matrix3::from_fn(|r, c| convert(INERTIA_KG_M2[r][c])),
            torque: to(moment.torque),
        };
        self.dynamic_state.linearise_at(&at, parameters);
    }
}

fn vector<F, T: RealField + Copy>(xyz: Vector3<f64>) -> Vector<F, T> {
    Vector::from_xyz(xyz.map(convert))
}

fn inputs<T: RealField + Copy>(moment: &Moment, dt_s: f64) -> mekf::Inputs<T> {
    let silent = Reading::Missing(MissingReason::Bus);
    let gyro = moment.gyro.map_or(silent, |gyro| Reading::Fresh(vector(gyro)));
    let field = moment
        .field_b
        .map(|body| FieldPair { body: vector(body), eci: vector(moment.field_i) });
    let sun = moment.sun_b.and_then(|body| {
        Some(SunPair {
            body: vector(body).direction()?,
            eci: vector(moment.sun_i).direction()?,
        })
    });
    mekf::Inputs { dt_s: convert(dt_s), gyro, field, sun }
}
