//! Stage II in the cycle: what was sensed beside what the models say, and what is believed of it.

use nalgebra::UnitQuaternion;

use crate::attitude::dynamic::DynamicInputs;
use crate::attitude::mekf::{self, FieldPair, SunPair};
use crate::attitude::selection::{Determination, Estimator, EstimatorState};
use crate::environment::sunlight::Sunlight;
use crate::frames::{Body, Eci, Rotation, Vector};
use crate::orbit::OrbitState;
use crate::reading::{MissingReason, Reading};
use crate::sensing::{EarthDisc, Expected, SunDirection, SunPrediction, SunSighting};
use crate::time::Utc;

/// The Sun counts as shining from this fraction of its disc on.
const LIT: f32 = 0.5;
/// After so many Suns in a row that are not where they were predicted, none is predicted: it may be the
/// prediction that is wrong.
const MISTAKEN: u8 = 5;
/// Predictions that are vaguer tell nothing, rad.
const VAGUE_RAD: f32 = 0.35;
/// By how much a satellite turns until the Earth's light falls differently on a face, rad: some part of
/// the Earth's disc (65 deg of radius at 615 km) and of a face's cone (55 deg).
const PULL_TURN_RAD: f32 = 0.5;
/// How long it falls the same way when the satellite does not turn, s: a tenth of the orbit's day side.
const PULL_LASTS_S: f32 = 300.0;
/// Mean radius of the Earth, m (IUGG R₁).
const EARTH_RADIUS_M: f64 = 6_371_009.0;

/// What one cycle leaves for the next. `Default` is power-on.
#[derive(Debug, Clone, Copy, Default)]
pub struct StageState {
    estimator: EstimatorState,
    last: Option<Last>,
    unpredicted: u8,
}

/// When the last cycle was, and what it believed.
#[derive(Debug, Clone, Copy)]
struct Last {
    at: Utc,
    believed: Option<Believed>,
}

/// An attitude that can be carried on for a cycle.
#[derive(Debug, Clone, Copy)]
struct Believed {
    r_bi: Rotation<Body, Eci>,
    attitude_sigma_rad: f32,
    omega_bi: Vector<Body>,
    rate_sigma_rad_s: f32,
}

/// What stage I says, and what the sensors say.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sensed<'a> {
    pub(crate) orbit: Option<&'a OrbitState>,
    pub(crate) reference_field: Option<Vector<Eci>>,
    pub(crate) sunlight: Option<&'a Sunlight>,
    pub(crate) omega_bi: Reading<Vector<Body>>,
    pub(crate) field_b: Reading<Vector<Body>>,
    pub(crate) sun_b: &'a SunSighting,
    /// What the torquers carried since the last cycle, Body, A·m².
    pub(crate) torquer_dipole: Vector<Body>,
}

impl StageState {
    /// What is known of the Sun before the Sun sensors are asked: how bright it is, and, from the
    /// attitude of the last cycle, where it and the Earth should be.
    pub(crate) fn expected(
        &self,
        now: Utc,
        orbit: Option<&OrbitState>,
        sunlight: Option<&Sunlight>,
    ) -> Expected {
        let Some(sunlight) = sunlight else { return Expected::default() };
        let expected = Expected { irradiance: sunlight.irradiance, ..Expected::default() };
        let Some((r_bi, sigma_rad)) = self.carried_to(now) else { return expected };
        let sun = SunPrediction { direction: r_bi * sunlight.direction, sigma_rad };
        let earth = orbit.and_then(|orbit| {
            let distance_m = orbit.position.norm();
            let nadir = (r_bi * (-orbit.position).to_f32()).direction()?;
            let sine = (EARTH_RADIUS_M / distance_m).min(1.0) as f32;
            Some(EarthDisc { nadir, radius_rad: libm::asinf(sine) })
        });
        Expected { sun: Some(sun), earth, ..expected }
    }

    /// The last attitude, carried on with the last rate, and its σ.
    fn carried_to(&self, now: Utc) -> Option<(Rotation<Body, Eci>, f32)> {
        let Last { at, believed } = self.last?;
        let believed = believed.filter(|_| self.unpredicted < MISTAKEN)?;
        let dt_s = now.seconds_since(at) as f32;
        let sigma_rad = believed.attitude_sigma_rad + believed.rate_sigma_rad_s * dt_s;
        // Also refuses a time that runs backwards and whatever is not finite.
        let useful = dt_s >= 0.0 && (0.0..VAGUE_RAD).contains(&sigma_rad);
        let turn = UnitQuaternion::from_scaled_axis(believed.omega_bi.xyz * -dt_s);
        useful.then(|| (Rotation::from_hamilton(turn * believed.r_bi.hamilton()), sigma_rad))
    }

    /// Both filters, and what to believe.
    #[inline]
    pub(crate) fn cycle(
        &mut self,
        estimator: &Estimator,
        now: Utc,
        sensed: &Sensed<'_>,
    ) -> Determination {
        let lit = sensed.sunlight.and_then(|sunlight| sunlight.lit).map(|lit| lit >= LIT);
        let sun = sensed.sun_b.sun.value().zip(sensed.sunlight.filter(|_| lit == Some(true)));
        let field = sensed.field_b.value().zip(sensed.reference_field);
        let dt_s = self.last.map_or(0.0, |last| now.seconds_since(last.at) as f32);
        let inputs = DynamicInputs {
            sensors: mekf::Inputs {
                dt_s,
                gyro: sensed.omega_bi,
                field: field.map(|(body, eci)| FieldPair { body, eci }),
                sun: sun.map(|(seen, sunlight)| SunPair {
                    body: seen.direction,
                    eci: sunlight.direction,
                    sigma_rad: Some(self.sun_sigma_rad(&seen, dt_s)),
                }),
            },
            reference_field: sensed.reference_field,
            position: sensed.orbit.map(|orbit| orbit.position.to_f32()),
            torquer_dipole: sensed.torquer_dipole,
            sunlit: lit,
        };
        let determination = estimator.cycle(&mut self.estimator, &inputs);

        self.unpredicted = match sensed.sun_b.sun {
            Reading::Missing(MissingReason::Unpredicted) => self.unpredicted.saturating_add(1),
            Reading::Missing(_) => self.unpredicted,
            Reading::Fresh(_) => 0,
        };
        self.last = Some(Last { at: now, believed: Believed::of(&determination) });
        determination
    }
}

impl StageState {
    /// σ that a filter may give to a Sun that is seen every `dt_s`, so that it averages out what is noise
    /// and no more: foreign light pulls the spot the same way until the satellite has turned.
    ///
    /// A disturbance of variance p² that is correlated over τ tells over a long time as little as white
    /// noise of variance 2 p² τ / Δt.
    fn sun_sigma_rad(&self, seen: &SunDirection, dt_s: f32) -> f32 {
        let pull = seen.pull_rad * seen.pull_rad;
        let noise = seen.sigma_rad * seen.sigma_rad - pull;
        let rate = self.last.and_then(|last| last.believed).map_or(0.0, |it| it.omega_bi.norm());
        let longest_s = PULL_LASTS_S;
        let lasts_s =
            if rate * longest_s > PULL_TURN_RAD { PULL_TURN_RAD / rate } else { longest_s };
        let alike = if dt_s > 0.0 { (2.0 * lasts_s / dt_s).max(1.0) } else { 1.0 };
        libm::sqrtf(noise + pull * alike)
    }
}

impl Believed {
    fn of(determination: &Determination) -> Option<Self> {
        let (attitude, rate) = determination.attitude.zip(determination.rate)?;
        let variance = attitude.covariance.diagonal().max();
        Some(Self {
            r_bi: attitude.r_bi,
            attitude_sigma_rad: libm::sqrtf(variance),
            omega_bi: rate.omega_bi,
            rate_sigma_rad_s: rate.sigma_rad_s,
        })
    }
}
