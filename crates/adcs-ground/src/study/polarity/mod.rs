//! Wrong wirings and dead torquers: how fast the guard stops them, how often it is wrong, and how well the active check
//! names them.

mod figures;
pub mod pointing;

use adcs_app::parameters::LawParameters;
use adcs_core::control::allocation::Allocation;
use adcs_core::frames::Vector;
use adcs_core::polarity::{
    ActiveCheck, CheckReport, CheckState, CheckStep, Evidence, Guard, GuardInputs, GuardState,
    GuardVerdict, PolarityParameters, Purpose, SignedPermutation, Suspect,
};
use anyhow::Result;

use super::closed_loop::{
    ClosedLoop, Conditions, Device, Fault, GyroTruth, Moment, Sampling, StartingRate, b_dot, sprout,
};
use super::pointing::case::everything_wrong;
use super::sprout::{DEG, InertiaError};

pub use figures::{CheckFigures, DeadFigures, GuardFigures};

/// Length of a flight, s: that of the paper's despin.
pub const FLIGHT_S: f64 = 1200.0;

/// What is true in these flights: 5 deg/s about any axis, anywhere within two days, inertia 5 % wrong,
/// nothing else but the paper's sensors and the residual dipole.
pub fn conditions(rate_deg_s: f64, sampling: Sampling, fault: Option<Fault>) -> Conditions {
    Conditions {
        rate: StartingRate::AnyAxis(rate_deg_s * DEG),
        start_in_sunlight: false,
        inertia: InertiaError::Signs(0.05),
        gyro: GyroTruth { sampling, ..GyroTruth::default() },
        fault,
        ..Conditions::default()
    }
}

/// The same with everything wrong that is wrong in the pointing study's case `everything`.
pub fn with_all_errors(plain: &Conditions) -> Conditions {
    let Conditions { rate, start_in_sunlight, gyro, fault, dead, .. } = *plain;
    Conditions { rate, start_in_sunlight, gyro, fault, dead, ..everything_wrong() }
}

/// What guard and check are told then: that the magnetometer's calibration leaves 500 nT.
pub fn told_of_errors(told: &PolarityParameters) -> PolarityParameters {
    PolarityParameters { field_bias_t: everything_wrong().magnetometer_bias_t as f32, ..*told }
}

/// All wrong wirings of all devices.
pub fn faults() -> Vec<Fault> {
    let wirings = || SignedPermutation::all().skip(1);
    let of = |device| wirings().map(move |wiring| Fault { device, wiring });
    Device::ALL.into_iter().flat_map(of).collect()
}

/// One torquer that obeys and does nothing, or all of them.
pub const DEAD: [[bool; 3]; 4] =
    [[true, false, false], [false, true, false], [false, false, true], [true; 3]];

/// What such torquers are called.
pub fn dead_name(dead: [bool; 3]) -> &'static str {
    match dead {
        [true, false, false] => "x dead",
        [false, true, false] => "y dead",
        [false, false, true] => "z dead",
        [true, true, true] => "all dead",
        _ => "some dead",
    }
}

/// A guarded flight of B-dot, and the same without guard.
#[derive(Debug, Clone, Copy)]
pub struct Guarded {
    /// What was wrong.
    pub fault: Option<Fault>,
    /// Torquers that were dead.
    pub dead: [bool; 3],
    /// When control was stopped, s, and who was suspected.
    pub stop: Option<(f64, Suspect)>,
    /// Largest energy with the guard over that at the start.
    pub largest: f64,
    /// The same until control was stopped.
    pub controlled: f64,
    /// Energy at the end without guard over that at the start; `None` when that was not flown.
    pub unguarded: Option<f64>,
    /// Largest evidence of a flight that was not stopped, and at the stop.
    pub evidence: Evidence,
}

impl Guarded {
    /// Whether the energy grows when nobody intervenes.
    pub fn is_harmful(&self) -> bool {
        self.unguarded.is_some_and(|ratio| ratio > 1.0)
    }
}

fn inputs(moment: &Moment, allocation: &Allocation) -> GuardInputs {
    GuardInputs {
        now: moment.now,
        phase: moment.phase,
        omega_bi: moment.thoughts.omega_bi,
        field_b: moment.thoughts.field_b,
        carried: allocation.to_body(moment.carried),
    }
}

/// Flies B-dot with the guard.
///
/// # Errors
/// When the orbit or the field model ends.
pub fn fly_guarded(
    conditions: &Conditions,
    parameters: &PolarityParameters,
    listen_s: f64,
    seed: u64,
    compare: bool,
) -> Result<Guarded> {
    let flight = sprout(b_dot())?;
    let guard = Guard::new(parameters)?;
    let mut state = GuardState::default();
    let mut closed_loop = ClosedLoop::new(conditions, &flight, seed)?;
    let allocation = closed_loop.configuration().allocation;
    let (mut stop, mut largest, mut controlled, mut start) = (None, 0.0_f64, 0.0, None);
    let mut evidence = Evidence::NONE;
    let cycles = ((FLIGHT_S + listen_s) * 1e6 / f64::from(flight.cycle_us)) as u32;
    for _ in 0..cycles {
        let moment = closed_loop.step_with(|moment| {
            let said = inputs(moment, &allocation);
            if stop.is_none() {
                match guard.cycle(&mut state, &said, Purpose::Despin) {
                    GuardVerdict::Stop { suspect, evidence: now } => {
                        stop = Some(((moment.truth.t_s - listen_s).max(0.0), suspect));
                        evidence = now;
                    }
                    GuardVerdict::Sound(now) => {
                        evidence.turning = evidence.turning.max(now.turning);
                        evidence.response = evidence.response.max(now.response);
                        evidence.dead = evidence.dead.max(now.dead);
                        evidence.energy = evidence.energy.max(now.energy);
                    }
                }
            }
            if stop.is_some() || moment.truth.t_s < listen_s {
                Vector::zero()
            } else {
                moment.thoughts.command.dipole
            }
        })?;
        let energy = moment.truth.kinetic_energy_j;
        if moment.truth.t_s >= listen_s {
            largest = largest.max(energy / *start.get_or_insert(energy));
        }
        if stop.is_none() {
            controlled = largest;
        }
    }
    let unguarded = if compare { Some(energy_ratio(conditions, listen_s, seed)?) } else { None };
    let Conditions { fault, dead, .. } = *conditions;
    Ok(Guarded { fault, dead, stop, largest, controlled, unguarded, evidence })
}

/// Energy at the end of a B-dot flight without guard over that at its start.
fn energy_ratio(conditions: &Conditions, listen_s: f64, seed: u64) -> Result<f64> {
    let flight = sprout(b_dot())?;
    let mut closed_loop = ClosedLoop::new(conditions, &flight, seed)?;
    let cycles = ((FLIGHT_S + listen_s) * 1e6 / f64::from(flight.cycle_us)) as u32;
    let (mut start, mut end) = (None, 0.0);
    for _ in 0..cycles {
        let moment = closed_loop.step_with(|moment| {
            let closed = moment.truth.t_s >= listen_s;
            if closed { moment.thoughts.command.dipole } else { Vector::zero() }
        })?;
        end = moment.truth.kinetic_energy_j;
        if moment.truth.t_s >= listen_s {
            start.get_or_insert(end);
        }
    }
    Ok(end / start.unwrap_or(end))
}

/// An active check.
#[derive(Debug, Clone, Copy)]
pub struct Checked {
    /// What was wrong.
    pub fault: Option<Fault>,
    /// Torquers that were dead.
    pub dead: [bool; 3],
    /// What came out.
    pub report: CheckReport,
    /// When, s.
    pub t_s: f64,
    /// Largest energy over that at the start.
    pub largest: f64,
}

/// Flies the active check alone.
///
/// # Errors
/// When the orbit or the field model ends, or the check does not.
pub fn fly_check(
    conditions: &Conditions,
    parameters: &PolarityParameters,
    seed: u64,
) -> Result<Checked> {
    let flight = sprout(LawParameters::Off)?;
    let check = ActiveCheck::new(parameters)?;
    let mut state = CheckState::default();
    let mut closed_loop = ClosedLoop::new(conditions, &flight, seed)?;
    let allocation = closed_loop.configuration().allocation;
    let (mut largest, mut start) = (0.0_f64, None);
    for _ in 0..u32::from(adcs_core::polarity::LONGEST_CYCLES) {
        let mut step = CheckStep::Carry(Vector::zero());
        let moment = closed_loop.step_with(|moment| {
            let said = inputs(moment, &allocation);
            step = check.cycle(&mut state, &said);
            match step {
                CheckStep::Carry(dipole) => allocation.command(dipole).dipole,
                CheckStep::Done(_) => Vector::zero(),
            }
        })?;
        let energy = moment.truth.kinetic_energy_j;
        largest = largest.max(energy / *start.get_or_insert(energy));
        if let CheckStep::Done(report) = step {
            let Conditions { fault, dead, .. } = *conditions;
            return Ok(Checked { fault, dead, report, t_s: moment.truth.t_s, largest });
        }
    }
    anyhow::bail!("the active check did not end")
}
