//! The ladder itself: from rung to rung.

use nalgebra::{UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};

use super::coupling::Coupling;
use super::findings::{Ended, Finding, Findings, Outcome, Rung, Shortfall, Three, worst};
use super::gyro::Gyro;
use super::magnetometer::Magnetometer;
use super::momentum::Momentum;
use super::parameters::{CommissioningError, CommissioningParameters, Commit, StepTime};
use super::sun::Sun;
use super::track::{Instant, STRONGEST_T, Track, possible};
use super::{Witnessed, track};
use crate::frames::{Body, Direction, Eci, MagnetometerAxes, Rotation, Vector};
use crate::identification::Noise;
use crate::polarity::{ActiveCheck, CheckInputs, CheckReport, CheckState, CheckStep};
use crate::reading::{MissingReason, Reading};
use crate::schedule::Phase;
use crate::sensing::{Triad, TriadParameters};

/// How often a result is looked at, s: solving costs more than a cycle's sums.
const LOOK_S: f32 = 60.0;

/// What the ladder is told of the satellite beside its own parameters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Told {
    /// How the magnetometer is corrected now; its alignment stays.
    pub magnetometer: TriadParameters,
    /// The inertia tensor as well as it is known, Body, kg·m².
    pub inertia_kg_m2: [[f32; 3]; 3],
    /// Noise of gyros and magnetometer.
    pub noise: Noise<f32>,
    /// How long the torquers' field takes to die away, s.
    pub settle_s: f32,
}

/// The ladder with accepted parameters.
#[derive(Debug, Clone, Copy)]
pub struct Ladder {
    parameters: CommissioningParameters,
    told: Told,
}

/// What one cycle leaves for the next. `Default` is the foot of the ladder.
#[derive(Debug, Clone, Copy, Default)]
pub struct LadderState {
    findings: Findings,
    track: Track,
    work: Work,
    /// On this rung, s.
    for_s: f32,
    /// Since its result was last looked at, s.
    unseen_s: f32,
    /// Rounds of the schedule, counted for the pulses.
    rounds: u8,
}

/// What a rung has gathered.
#[derive(Debug, Clone, Copy, Default)]
#[allow(
    clippy::large_enum_variant,
    reason = "there is one, in static memory, and no heap to box into"
)]
enum Work {
    #[default]
    None,
    Magnetometer(Magnetometer),
    Polarity(CheckState),
    Coupling(Coupling),
    Gyro(Gyro),
    Sun(Sun),
    Momentum(Momentum),
}

/// What the ladder says in one cycle.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct LadderReport {
    /// The rung that is being climbed; `None` when all are over.
    pub rung: Option<Rung>,
    /// The rung that ended in this cycle.
    pub ended: Option<Ended>,
}

/// What is to be done in this cycle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LadderStep {
    /// What the torquers should carry until the next cycle, Body, A·m².
    pub pulse: Vector<Body>,
    /// What happened.
    pub report: LadderReport,
}

/// One cycle with what earlier rungs found put to use.
pub(super) struct Seen {
    /// Along the magnetometer's axes, by its data sheet, T.
    pub reading: Option<Vector<MagnetometerAxes>>,
    /// Calibrated, Body, T, the torquers' field included.
    pub field: Option<Vector<Body>>,
    /// Whether the torquers' field has died away.
    pub rests: bool,
    pub instant: Option<Instant>,
    pub reference_field: Option<Vector<Eci>>,
    /// As seen, and as it should be seen.
    pub sun: Option<(Direction<Body>, Direction<Eci>)>,
}

/// A result, and whether its σ passes the gate; `None` while the readings do not support one.
pub(super) type Judged = Option<(Finding, bool)>;

impl Ladder {
    /// Accepts parameters.
    ///
    /// # Errors
    /// [`CommissioningError`] with the parameter, its value and its range.
    pub fn new(
        parameters: &CommissioningParameters,
        told: &Told,
    ) -> Result<Self, CommissioningError> {
        parameters.check()?;
        Ok(Self { parameters: *parameters, told: *told })
    }

    /// Who commits.
    pub fn commit(&self) -> Commit {
        self.parameters.commit
    }

    /// One cycle on the ladder, `check` being what looks after the wiring.
    pub fn cycle(
        &self,
        check: &ActiveCheck,
        state: &mut LadderState,
        witnessed: &Witnessed,
    ) -> LadderStep {
        let passed = state.track.pass(witnessed, self.told.settle_s);
        let Some(rung) = state.findings.next() else {
            return LadderStep::resting(None, None);
        };
        let round_over = witnessed.devices.phase == Phase::Measuring;
        state.rounds = state.rounds.wrapping_add(u8::from(round_over));
        state.for_s += passed.dt_s;
        state.unseen_s += passed.dt_s;
        if let Some(ended) = self.cannot_begin(state, rung) {
            return state.end(ended);
        }
        let reading = possible(witnessed.reading, STRONGEST_T);
        let field = reading.and_then(|reading| self.calibrated(&state.findings, reading));
        if let Work::Polarity(work) = &mut state.work {
            let rests = field.filter(|_| passed.rests);
            let field_b = rests.map_or(Reading::Missing(MissingReason::TorquersOn), Reading::Fresh);
            let inputs = CheckInputs { field_b, ..witnessed.devices };
            return match check.cycle(work, &inputs) {
                CheckStep::Carry(pulse) => {
                    LadderStep { pulse, report: LadderReport { rung: Some(rung), ended: None } }
                }
                CheckStep::Done(report) => {
                    state.end(Ended { rung, outcome: wired(report), finding: None })
                }
            };
        }
        let seen = Seen {
            reading,
            field,
            rests: passed.rests,
            instant: passed.instant,
            reference_field: witnessed
                .reference_field
                .and_then(|field| possible(Reading::Fresh(field), STRONGEST_T)),
            sun: witnessed.sun.map(|sun| turned(sun, &state.findings)).zip(witnessed.reference_sun),
        };
        state.work.see(&seen);
        let StepTime { least_s, most_s } = self.time(rung);
        let late = state.for_s >= most_s;
        let due = state.for_s >= least_s && state.unseen_s >= LOOK_S;
        if due || late {
            state.unseen_s = 0.0;
            let judged = self.judged(&state.work, rung, &state.findings);
            let passed = judged.is_some_and(|(_, passed)| passed);
            if passed || late {
                let outcome = match judged {
                    Some((_, true)) => Outcome::Passed,
                    Some((_, false)) => Outcome::Failed(Shortfall::Uncertain),
                    None => Outcome::Failed(Shortfall::NotSupported),
                };
                let finding = judged.map(|(finding, _)| finding);
                return state.end(Ended { rung, outcome, finding });
            }
        }
        let pulse = match rung {
            Rung::Coupling => check.pulse(state.rounds, witnessed.devices.phase),
            // A tumble that shows the magnetometer too few directions: pulses change it.
            Rung::Magnetometer if state.for_s > least_s => {
                check.pulse(state.rounds, witnessed.devices.phase)
            }
            _ => Vector::zero(),
        };
        LadderStep { pulse, report: LadderReport { rung: Some(rung), ended: None } }
    }

    /// Makes a rung's sums ready; what it ends with when that cannot be.
    fn cannot_begin(&self, state: &mut LadderState, rung: Rung) -> Option<Ended> {
        if state.work.is_of(rung) {
            return None;
        }
        let failed = |why| Some(Ended { rung, outcome: Outcome::Failed(why), finding: None });
        let rests_on: &[Rung] = match rung {
            Rung::Magnetometer => &[],
            Rung::Polarity | Rung::Gyro | Rung::Sun => &[Rung::Magnetometer],
            Rung::Coupling => &[Rung::Magnetometer, Rung::Polarity],
            Rung::Dipole | Rung::Inertia => &[Rung::Magnetometer, Rung::Gyro],
        };
        if rests_on.iter().any(|rung| !state.findings.passed(*rung)) {
            return failed(Shortfall::RestsOnFailed);
        }
        // What the calibration leaves, its own σ says.
        let left = state.findings.magnetometer.map(|found| worst(&found.bias_t.sigma));
        let field_offset_t = left.unwrap_or(self.told.noise.field_offset_t);
        let noise = Noise { field_offset_t, ..self.told.noise };
        let begun = state.work.begin(rung, noise, &self.told, state.findings.gyro);
        if begun.is_none() {
            return failed(Shortfall::NotSupported);
        }
        (state.for_s, state.unseen_s) = (0.0, 0.0);
        None
    }

    /// A reading by the calibration that the ladder found, and until then by the one that flies.
    fn calibrated(
        &self,
        findings: &Findings,
        reading: Vector<MagnetometerAxes>,
    ) -> Option<Vector<Body>> {
        let told = &self.told.magnetometer;
        let found = findings.magnetometer.map(|found| found.correction(told));
        let triad = Triad::<MagnetometerAxes>::new(&found.unwrap_or(*told)).ok()?;
        possible(triad.to_body(reading.to_array().map(Reading::Fresh)), STRONGEST_T)
    }

    fn time(&self, rung: Rung) -> StepTime {
        let p = &self.parameters;
        match rung {
            Rung::Magnetometer => p.magnetometer,
            // The check has its own limits.
            Rung::Polarity | Rung::Coupling => p.coupling,
            Rung::Gyro => p.gyro,
            Rung::Sun => p.sun,
            Rung::Dipole | Rung::Inertia => p.momentum,
        }
    }

    fn judged(&self, work: &Work, rung: Rung, findings: &Findings) -> Judged {
        let p = &self.parameters;
        match work {
            Work::None | Work::Polarity(_) => None,
            Work::Magnetometer(work) => work.judged(p),
            Work::Coupling(work) => work.judged(p, findings.magnetometer.as_ref()),
            Work::Gyro(work) => work.judged(p),
            Work::Sun(work) => work.judged(p),
            Work::Momentum(work) => work.judged(p, rung),
        }
    }
}

impl LadderState {
    /// Goes on where an earlier climb ended: with the first rung that has not.
    pub fn resumed(findings: Findings) -> Self {
        Self { findings, ..Self::default() }
    }

    /// What has been found so far.
    pub fn findings(&self) -> &Findings {
        &self.findings
    }

    fn end(&mut self, ended: Ended) -> LadderStep {
        self.findings.take(&ended);
        // Dipole and inertia are unknowns of the same sums.
        let next = self.findings.next();
        let goes_on = next.is_some_and(|rung| self.work.is_of(rung));
        if !goes_on {
            (self.work, self.for_s) = (Work::None, 0.0);
        }
        LadderStep::resting(next, Some(ended))
    }
}

impl LadderStep {
    fn resting(rung: Option<Rung>, ended: Option<Ended>) -> Self {
        Self { pulse: Vector::zero(), report: LadderReport { rung, ended } }
    }
}

impl Work {
    /// Makes a rung's sums ready; `None` when that cannot be.
    fn begin(
        &mut self,
        rung: Rung,
        noise: Noise<f32>,
        told: &Told,
        gyro: Option<Three>,
    ) -> Option<()> {
        match rung {
            Rung::Magnetometer => self.begin_magnetometer(),
            Rung::Polarity => self.begin_polarity(),
            Rung::Coupling => self.begin_coupling(noise),
            Rung::Gyro => self.begin_gyro(noise),
            Rung::Sun => self.begin_sun(),
            Rung::Dipole | Rung::Inertia => self.begin_momentum(noise, told, gyro),
        }
    }

    // Each in a frame of its own: together they are more of the stack than a cycle.

    #[inline(never)]
    fn begin_magnetometer(&mut self) -> Option<()> {
        *self = Self::Magnetometer(Magnetometer::new()?);
        Some(())
    }

    #[inline(never)]
    fn begin_polarity(&mut self) -> Option<()> {
        *self = Self::Polarity(CheckState::default());
        Some(())
    }

    #[inline(never)]
    fn begin_coupling(&mut self, noise: Noise<f32>) -> Option<()> {
        *self = Self::Coupling(Coupling::new(noise));
        Some(())
    }

    #[inline(never)]
    fn begin_gyro(&mut self, noise: Noise<f32>) -> Option<()> {
        *self = Self::Gyro(Gyro::new(noise));
        Some(())
    }

    #[inline(never)]
    fn begin_sun(&mut self) -> Option<()> {
        *self = Self::Sun(Sun::default());
        Some(())
    }

    #[inline(never)]
    fn begin_momentum(
        &mut self,
        noise: Noise<f32>,
        told: &Told,
        gyro: Option<Three>,
    ) -> Option<()> {
        *self = Self::Momentum(Momentum::new(told.inertia_kg_m2, noise, gyro)?);
        Some(())
    }

    fn is_of(&self, rung: Rung) -> bool {
        match self {
            Self::None => false,
            Self::Magnetometer(_) => rung == Rung::Magnetometer,
            Self::Polarity(_) => rung == Rung::Polarity,
            Self::Coupling(_) => rung == Rung::Coupling,
            Self::Gyro(_) => rung == Rung::Gyro,
            Self::Sun(_) => rung == Rung::Sun,
            Self::Momentum(_) => matches!(rung, Rung::Dipole | Rung::Inertia),
        }
    }

    fn see(&mut self, seen: &Seen) {
        match self {
            Self::None | Self::Polarity(_) => {}
            Self::Magnetometer(work) => work.see(seen),
            Self::Coupling(work) => work.see(seen),
            Self::Gyro(work) => work.see(seen),
            Self::Sun(work) => work.see(seen),
            Self::Momentum(work) => work.see(seen),
        }
    }
}

impl Seen {
    /// The field without the torquers'.
    pub fn quiet_field(&self) -> Option<Vector<Body>> {
        self.field.filter(|_| self.rests)
    }

    /// Coarse attitude from field and Sun.
    pub fn attitude(&self) -> Option<Rotation<Body, Eci>> {
        track::attitude((self.quiet_field()?, self.reference_field?), self.sun?)
    }
}

/// Where the Sun is seen, by the turn that the ladder found.
fn turned(sun: Direction<Body>, findings: &Findings) -> Direction<Body> {
    let turn = findings.sun.filter(|_| findings.passed(Rung::Sun));
    turn.map_or(sun, |turn| {
        let turn = UnitQuaternion::from_scaled_axis(Vector3::from(turn.value));
        Rotation::<Body, Body>::from_hamilton(turn) * sun
    })
}

fn wired(report: CheckReport) -> Outcome {
    match report {
        CheckReport::Sound => Outcome::Passed,
        CheckReport::Wrong(suspect) => Outcome::Failed(Shortfall::Miswired(suspect)),
        CheckReport::Undecided(why) => Outcome::Failed(Shortfall::Undecided(why)),
    }
}
