//! The guard of a closed loop: stops what a wrong wiring would drive.
//!
//! It may run before the loop is closed, and should: while it listens it learns the residual dipole and
//! how the inertia differs, sees a wrong gyro or magnetometer before they do harm, and needs a third
//! less time for the torquers afterwards. The energy counts from the first dipole on.

use nalgebra::{Matrix3, Vector3};

use super::answer::{Answer, ResponseEvidence};
use super::parameters::{PolarityError, PolarityParameters};
use super::response::{Estimate, Response, Seen};
use super::turning::{FIELD_TURN_RAD_S, Turning, TurningEvidence};
use super::verdict::{Evidence, GuardVerdict, Suspect};
use crate::frames::{Body, SignedPermutation, Vector};
use crate::reading::Reading;
use crate::schedule::Phase;
use crate::time::Utc;

/// Fastest rate that a gyro reports, each axis, rad/s (as the MEKF's limit).
const FASTEST_RAD_S: f32 = 5.2;
/// Weakest and strongest field in low orbit, with room for a magnetometer that is not calibrated, T.
const WEAKEST_T: f32 = 5e-6;
const STRONGEST_T: f32 = 1e-4;

/// Slower turns of the field tell nothing, rad/s: eight times what it turns in Eci, which is the same from
/// round to round, and twice what the gyro's bias makes of a satellite at rest.
const SLOWEST_RAD_S: f32 = 0.0175;

/// Natural logarithm of the odds of the best wiring over the second best at which it is named: 20.
const NAMED: f32 = 3.0;
/// (P − P̂)ᵀ Σ⁻¹ (P − P̂) beyond which an answer does not explain the estimate: 99.9 % of χ² with nine
/// degrees of freedom.
const EXPLAINED: f32 = 27.9;
/// Growth of the energy at which control stops whatever the reason.
const ENERGY_GROWTH: f32 = 1.2;
/// The energy counts from this rate on, rad/s: below, the residual dipole moves it at will.
const SLOW_RAD_S: f32 = 0.035;
/// By how many σ of rate and residual dipole the energy must have grown.
const ENERGY_SIGMAS: f32 = 4.0;

/// The guard with accepted parameters.
#[derive(Debug, Clone, Copy)]
pub struct Guard {
    parameters: PolarityParameters,
    inertia: Matrix3<f32>,
}

/// What one cycle leaves for the next. `Default` is the moment in which the loop is closed.
#[derive(Debug, Clone, Copy, Default)]
pub struct GuardState {
    pub(super) last: Option<Utc>,
    pub(super) turning: Turning,
    pub(super) response: Response,
    /// Whether the torquers have been on.
    closed: bool,
    start: Option<Balance>,
    turned: Option<TurningEvidence>,
    evidence: Option<Evidence>,
    stopped: Option<Suspect>,
}

/// What energy is counted from.
#[derive(Debug, Clone, Copy)]
struct Balance {
    at: Utc,
    energy_j: f32,
    /// σ of it.
    sigma_j: f32,
    /// Field, Body, T.
    field: Vector3<f32>,
}

/// What the torquers are for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Purpose {
    /// To take energy out: whatever does so is good enough.
    Despin,
    /// To take energy out, and each torquer its part of the residual dipole.
    Acquire,
    /// To point, each of them. A satellite may be spun up for it.
    Point,
}

/// What the devices said and did since the last cycle.
#[derive(Debug, Clone, Copy)]
pub struct GuardInputs {
    /// The satellite's clock.
    pub now: Utc,
    /// What the cycle is for.
    pub phase: Phase,
    /// What the gyro shows, Body, rad/s.
    pub omega_bi: Reading<Vector<Body>>,
    /// The field at rest, Body, T.
    pub field_b: Reading<Vector<Body>>,
    /// What the torquers were told to carry since the last cycle, Body, A·m².
    pub carried: Vector<Body>,
}

impl GuardInputs {
    /// The gyro's rate, if it can be one.
    pub(super) fn rate(&self) -> Option<Vector3<f32>> {
        let possible = |rate: &Vector3<f32>| rate.iter().all(|axis| axis.abs() <= FASTEST_RAD_S);
        self.omega_bi.value().map(|rate| rate.xyz).filter(possible)
    }

    /// The field, if it can be the Earth's.
    pub(super) fn field(&self) -> Option<Vector3<f32>> {
        let possible = |field: &Vector3<f32>| (WEAKEST_T..=STRONGEST_T).contains(&field.norm());
        self.field_b.value().map(|field| field.xyz).filter(possible)
    }

    /// What was carried; nothing when it is not a number.
    pub(super) fn dipole(&self) -> Vector3<f32> {
        if self.carried.is_finite() { self.carried.xyz } else { Vector3::zeros() }
    }
}

impl Guard {
    /// Accepts parameters.
    ///
    /// # Errors
    /// [`PolarityError`] with the parameter, its value and its range.
    pub fn new(parameters: &PolarityParameters) -> Result<Self, PolarityError> {
        let inertia = parameters.check()?;
        Ok(Self { parameters: *parameters, inertia })
    }

    /// One cycle of the closed loop. A stop stays one until the state is made anew.
    pub fn cycle(
        &self,
        state: &mut GuardState,
        inputs: &GuardInputs,
        purpose: Purpose,
    ) -> GuardVerdict {
        let p = &self.parameters;
        let dt_s = state.last.map_or(0.0, |last| inputs.now.seconds_since(last) as f32);
        state.last = Some(inputs.now);
        let (gyro, field) = (inputs.rate(), inputs.field());
        let last_of_rest = inputs.phase == Phase::Measuring;
        let seen = Seen { gyro, field, dipole: inputs.dipole() };
        state.response.cycle(p, &self.inertia, dt_s, &seen);
        let compared = state.turning.cycle(p, dt_s, gyro, field, last_of_rest, SLOWEST_RAD_S);
        if compared {
            state.turned = Some(state.turning.evidence(p));
        }
        state.closed |= seen.dipole != Vector3::zeros();
        if purpose == Purpose::Point {
            state.start = None;
        }
        if field.is_some() && state.stopped.is_none() {
            let turned_wrong = state.response.magnetometer_turned_wrong();
            state.stopped = turned_wrong.map(Suspect::Magnetometer);
        }
        if gyro.is_some() && state.stopped.is_none() {
            state.stopped = self.judge(state, purpose);
        }
        let evidence = state.evidence.unwrap_or(Evidence::NONE);
        match state.stopped {
            Some(suspect) => GuardVerdict::Stop { suspect, evidence },
            None => GuardVerdict::Sound(evidence),
        }
    }

    fn judge(&self, state: &mut GuardState, purpose: Purpose) -> Option<Suspect> {
        let limit = self.parameters.log_odds;
        let turning = state.turned;
        let response = state.response.evidence(purpose == Purpose::Despin);
        let balance = if purpose == Purpose::Point { None } else { self.energy(state) };
        let (energy, grown) = balance.unwrap_or((1.0, false));
        state.evidence = Some(Evidence {
            turning: turning.map_or(0.0, |it| it.wrong),
            response: response.map_or(0.0, |it| it.wrong),
            dead: response.map_or(0.0, |it| it.dead),
            energy,
        });
        if let Some(it) = turning.filter(|it| it.wrong >= limit) {
            let mirrors = !it.best.is_rotation();
            let name = if mirrors { Suspect::Gyro } else { Suspect::GyroOrMagnetometer };
            return Some(name(it.best));
        }
        response.and_then(|it| self.accused(&it, purpose)).or(grown.then_some(Suspect::Unknown))
    }

    /// Whom the answer to the torquers speaks against, when it does.
    ///
    /// Torquers that change in flight leave an estimate between what they were and what they are; where
    /// nothing explains it, it is left open what they are.
    fn accused(&self, it: &ResponseEvidence, purpose: Purpose) -> Option<Suspect> {
        let limit = self.parameters.log_odds;
        let goes_on = match it.best {
            // What is dead does no harm, and a despin has those that are left.
            Answer::Dead(dead) => purpose == Purpose::Despin && dead != [true; 3],
            Answer::Wired(_) => false,
        };
        if goes_on || it.wrong.max(it.dead) < limit {
            return None;
        }
        Some(match it.best {
            _ if it.lead < NAMED || it.misfit > EXPLAINED => {
                Suspect::TorquersOrReversedMagnetometer
            }
            Answer::Wired(SignedPermutation::REVERSED) => Suspect::ReversedTorquersOrMagnetometer,
            Answer::Wired(wiring) => Suspect::Torquers(wiring),
            Answer::Dead(dead) => Suspect::DeadTorquers(dead),
        })
    }

    /// The kinetic energy over that at the start, and whether it has grown, and beyond doubt by more than
    /// the residual dipole has brought in: turning in a field that stands still that gives M · (B − B₀), and
    /// what it gives beside while the field turns in Eci counts as doubt.
    fn energy(&self, state: &mut GuardState) -> Option<(f32, bool)> {
        if !state.closed {
            return None;
        }
        let Estimate { rate, rate_sigma, field, dipole, dipole_sigma } = state.response.motion()?;
        let momentum = self.inertia * rate;
        let energy_j = 0.5 * rate.dot(&momentum);
        let sigma_j = momentum.component_mul(&rate_sigma).norm();
        let at = state.last?;
        let start = *state.start.get_or_insert(Balance { at, energy_j, sigma_j, field });
        let turned = field - start.field;
        let by_dipole = dipole_sigma.component_mul(&turned).norm();
        let square = |x: f32| x * x;
        let sigma_j = libm::sqrtf(square(sigma_j) + square(start.sigma_j) + square(by_dipole));
        let mean = self.inertia.trace() / 3.0;
        let counted = start.energy_j.max(0.5 * mean * SLOW_RAD_S * SLOW_RAD_S);
        let elapsed_s = at.seconds_since(start.at) as f32;
        let carried_along = dipole.norm() * field.norm() * (FIELD_TURN_RAD_S * elapsed_s).min(2.0);
        let doubt = ENERGY_SIGMAS * sigma_j + carried_along;
        let gained = energy_j - counted - dipole.dot(&turned) - doubt;
        let grown = energy_j > counted && gained > (ENERGY_GROWTH - 1.0) * counted;
        let ratio = energy_j / start.energy_j;
        ratio.is_finite().then_some((ratio, grown))
    }
}
