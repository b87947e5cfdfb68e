//! The object that flies.

use adcs_core::attitude::selection::{AttitudeSource, Determination};
use adcs_core::commissioning::{Commit, Findings};
use adcs_core::frames::{TorquerAxes, Vector};
use adcs_core::modes::Mode;
use adcs_core::pipeline::{self, Configuration, Inputs, State, Thoughts};
use adcs_core::reading::{MissingReason, Reading};
use adcs_core::schedule::Schedule;
use adcs_core::sensing::FaceVerdict;
use adcs_hal::board::{Board, Samples};
use adcs_link::Digest;
use adcs_link::frame;
use adcs_link::message::{
    AttitudeRecord, CycleRecord, DeterminationRecord, Message, RateRecord, SunRecord, TruthRecord,
};

use crate::parameters::{FlightParameters, ParameterError};

/// What went wrong so far, counted (saturating) since power-on.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Health {
    /// Cycles in which an axis of gyro or magnetometer gave no reading.
    pub cycles_with_missing_readings: u32,
    /// Cycles in which a Sun sensor that is fitted gave no reading, or none that a diode can give.
    pub cycles_with_broken_sun_sensors: u32,
    /// Cycles in which the torquers refused their command.
    pub torquer_faults: u32,
    /// Cycles in which the orbit model gave no position.
    pub cycles_without_orbit: u32,
    /// Results of commissioning that were to be put in force and were refused.
    pub commits_refused: u32,
    /// Records that did not fit their frame, which cannot happen.
    pub records_lost: u32,
}

/// The flight application over the board `B`.
#[derive(Debug)]
pub struct FlightApp<'a, B> {
    board: B,
    /// As uplinked; what commissioning finds is relative to these.
    uploaded: FlightParameters,
    schedule: Schedule,
    configuration: Configuration,
    state: &'a mut State,
    /// What the torquers carry since the last cycle, A·m².
    carried: Vector<TorquerAxes>,
    /// Whether they refused their last command.
    refused: bool,
    commanded: Option<Mode>,
    /// Whether commissioning's results have been put in force since the last cycle.
    committed: bool,
    next_cycle: u32,
    health: Health,
    digest: Digest,
}

impl<'a, B: Board> FlightApp<'a, B> {
    /// Powers on with these parameters. `state` is what the cycles remember: tens of kilobytes, so that
    /// it has a place of its own and is never copied; `State::default()` is power-on.
    ///
    /// # Errors
    /// [`ParameterError`] when the parameters are refused.
    #[inline(never)]
    pub fn new(
        board: B,
        parameters: &FlightParameters,
        state: &'a mut State,
    ) -> Result<Self, ParameterError> {
        let (schedule, configuration) = parameters.accept()?;
        Ok(Self {
            board,
            uploaded: *parameters,
            schedule,
            configuration,
            state,
            carried: Vector::zero(),
            refused: false,
            commanded: None,
            committed: false,
            next_cycle: 0,
            health: Health::default(),
            digest: Digest::default(),
        })
    }

    /// Flies one cycle: clock and sensors in, thoughts, torquers out, and the record of it all.
    pub fn cycle(&mut self) -> CycleRecord {
        let inputs = self.sense();
        let thoughts = self.think(&inputs);
        let driven = self.board.drive(thoughts.command.dipole);
        self.refused = driven.is_err();
        // A board that refuses has switched off.
        self.carried = driven.unwrap_or(Vector::zero());
        let driven_am2 = driven.ok().map(|dipole| dipole.to_array());
        let committed = core::mem::take(&mut self.committed);
        let record =
            CycleRecord { committed, ..record(self.next_cycle, &inputs, &thoughts, driven_am2) };
        self.count(&record);
        self.absorb(&Message::Cycle(record));
        self.next_cycle = self.next_cycle.wrapping_add(1);
        self.follow(&thoughts);
        record
    }

    /// In a frame of its own: thoughts and records do not lie on the stack below each other.
    #[inline(never)]
    fn think(&mut self, inputs: &Inputs) -> Thoughts {
        pipeline::cycle(&self.configuration, self.state, inputs)
    }

    /// What was found is relative to what was uplinked: a climb begins with that, and may end with a commit.
    fn follow(&mut self, thoughts: &Thoughts) {
        let transition = thoughts.mode.and_then(|report| report.transition);
        if transition.is_some_and(|transition| transition.to == Mode::Commissioning) {
            // Accepted before, and so accepted again.
            let _ = self.put_in_force(&{ self.uploaded });
        }
        if thoughts.commissioning.is_some_and(|report| report.rung.is_none()) {
            self.commit_by_policy();
        }
    }

    /// Asks for a mode; the next cycle follows, or says in its record that it cannot.
    pub fn command(&mut self, mode: Mode) {
        self.commanded = Some(mode);
    }

    /// What commissioning has found so far: to be kept where a reset does not reach it.
    pub fn findings(&self) -> &Findings {
        self.state.findings()
    }

    /// Before the first cycle: what had been found before a reset. A climb that was interrupted goes on with the
    /// first rung that had not ended; what had been put in force is put in force again.
    pub fn resume(&mut self, findings: Findings) {
        self.state.resume(findings);
        if findings.committed {
            let _ = self.commit();
        } else if findings.next().is_none() {
            self.commit_by_policy();
        }
    }

    /// Puts in force what commissioning found, as far as it passed its gates. Filters, plans and laws begin
    /// anew with it.
    ///
    /// # Errors
    /// [`ParameterError`] when the parameters are refused with it, which health counts; what was in force
    /// stays.
    pub fn commit(&mut self) -> Result<(), ParameterError> {
        let parameters = self.uploaded.committed(self.state.findings());
        let put = self.put_in_force(&parameters);
        if put.is_err() {
            let refused = &mut self.health.commits_refused;
            *refused = refused.saturating_add(1);
        }
        put?;
        self.state.note_commit();
        self.committed = true;
        Ok(())
    }

    fn put_in_force(&mut self, parameters: &FlightParameters) -> Result<(), ParameterError> {
        (self.schedule, self.configuration) = parameters.accept()?;
        self.state.recalibrated();
        Ok(())
    }

    fn commit_by_policy(&mut self) {
        let ladder = self.configuration.modes.as_ref().and_then(|modes| modes.ladder.as_ref());
        if ladder.is_some_and(|ladder| ladder.commit() == Commit::WhenPassed) {
            // A refusal is counted, and what was in force stays.
            let _ = self.commit();
        }
    }

    /// In simulation: takes the true state of a cycle into the flight's digest.
    pub fn witness(&mut self, truth: &TruthRecord) {
        self.absorb(&Message::Truth(*truth));
    }

    /// The digest over every record, and every true state witnessed, so far.
    pub fn digest(&self) -> u64 {
        self.digest.value()
    }

    /// What went wrong so far.
    pub fn health(&self) -> Health {
        self.health
    }

    fn sense(&mut self) -> Inputs {
        let now = self.board.now();
        let Samples { rate_rad_s, field_t, sun_a } = self.board.sample();
        let phase = self.schedule.phase(self.next_cycle);
        let rate_rad_s = rate_rad_s.map(|axis| finite(axis, |rate| rate.is_finite()));
        let field_t = field_t.map(|axis| finite(axis, |field| field.is_finite()));
        let all_finite = |currents: &[f32; 4]| currents.iter().all(|current| current.is_finite());
        let sun_a = sun_a.map(|face| finite(face, all_finite));
        let (carried, refused, commanded) = (self.carried, self.refused, self.commanded.take());
        Inputs { now, phase, rate_rad_s, field_t, sun_a, carried, refused, commanded }
    }

    fn count(&mut self, record: &CycleRecord) {
        let bump = |counter: &mut u32, happened: bool| {
            *counter = counter.saturating_add(u32::from(happened));
        };
        let missing = |axes: &[Reading<f32>; 3]| axes.iter().any(|axis| axis.missing().is_some());
        let health = &mut self.health;
        bump(
            &mut health.cycles_with_missing_readings,
            missing(&record.gyro_rad_s) || missing(&record.magnetometer_t),
        );
        let broken = record.sun_faces.iter().any(|face| match face {
            FaceVerdict::Missing(reason) => *reason != MissingReason::NotFitted,
            verdict => *verdict == FaceVerdict::Broken,
        });
        bump(&mut health.cycles_with_broken_sun_sensors, broken);
        bump(&mut health.torquer_faults, record.driven_am2.is_none());
        bump(&mut health.cycles_without_orbit, record.position_eci_m.is_none());
    }

    fn absorb(&mut self, message: &Message) {
        if frame::digest(message, &mut self.digest).is_err() {
            self.health.records_lost = self.health.records_lost.saturating_add(1);
        }
    }
}

/// The border at which a NaN of a faulty driver is stopped.
fn finite<T>(reading: Reading<T>, is_finite: impl FnOnce(&T) -> bool) -> Reading<T> {
    match reading {
        Reading::Fresh(value) if !is_finite(&value) => Reading::Missing(MissingReason::NotFinite),
        other => other,
    }
}

fn record(
    cycle: u32,
    inputs: &Inputs,
    thoughts: &Thoughts,
    driven_am2: Option<[f32; 3]>,
) -> CycleRecord {
    CycleRecord {
        cycle,
        utc: inputs.now,
        phase: inputs.phase,
        gyro_rad_s: inputs.rate_rad_s,
        magnetometer_t: inputs.field_t,
        sun_a: inputs.sun_a,
        omega_bi_rad_s: thoughts.omega_bi.map(|v| v.to_array()),
        field_body_t: thoughts.field_b.map(|v| v.to_array()),
        sun: thoughts.sun_b.sun.map(|sun| SunRecord {
            body: sun.direction.vector().to_array(),
            sigma_rad: sun.sigma_rad,
            worst_residual_rad: sun.worst_residual_rad,
        }),
        sun_faces: thoughts.sun_b.faces,
        position_eci_m: thoughts.orbit.map(|orbit| orbit.position.to_array()),
        reference_field_eci_t: thoughts.reference_field.map(|v| v.to_array()),
        reference_sun_eci: thoughts.reference_sun.map(|sun| sun.vector().to_array()),
        sunlit: thoughts.sunlit,
        determination: thoughts.determination.as_ref().map(determination_record),
        mode: thoughts.mode,
        commissioning: thoughts.commissioning,
        committed: false,
        control: thoughts.control,
        pointing_error_rad: thoughts.pointing_error_rad,
        commanded_am2: thoughts.command.dipole.to_array(),
        driven_am2,
        saturated: thoughts.command.saturated,
    }
}

/// What stage II believes, and the rest from the filter it comes from.
fn determination_record(determination: &Determination) -> DeterminationRecord {
    let Determination { attitude, rate, reason, mekf, dynamic } = determination;
    let is_dynamic = attitude.is_some_and(|it| it.source == AttitudeSource::Dynamic);
    let (bias, field, sun) = if is_dynamic {
        (dynamic.estimate.map(|it| it.gyro_bias), dynamic.field, dynamic.sun)
    } else {
        (mekf.estimate.map(|it| it.gyro_bias), mekf.field, mekf.sun)
    };
    DeterminationRecord {
        attitude: attitude.map(|it| AttitudeRecord {
            xyzw: it.r_bi.attitude_quaternion(),
            sigma_rad: it.sigma_rad().to_array(),
            source: it.source,
        }),
        rate: rate.map(|it| RateRecord {
            omega_bi_rad_s: it.omega_bi.to_array(),
            sigma_rad_s: it.sigma_rad_s,
            source: it.source,
        }),
        reason: *reason,
        gyro_bias_rad_s: bias.map(|bias| bias.to_array()),
        residual_dipole_am2: dynamic.estimate.map(|it| it.residual_dipole.to_array()),
        nis_field: field.map(|it| it.nis),
        nis_sun: sun.map(|it| it.nis),
    }
}
