//! The cycle as a sentence: what the satellite thinks, in the order in which it thinks it.
//!
//! Time, sensors in; dipole for the torquers out; and everything in between in one value, which is
//! telemetry, history and golden trace at once. Nothing here talks to a bus or asks a clock.

use crate::attitude::selection::{Determination, Estimator};
use crate::commissioning::{Findings, LadderReport};
use crate::control::allocation::{Allocation, Command};
use crate::determination::{Sensed, StageState};
use crate::environment::field::FieldModel;
use crate::environment::sun_track::{SunNodes, SunTrack};
use crate::environment::sunlight::Sunlight;
use crate::frames::{Body, Direction, Eci, GyroAxes, MagnetometerAxes, TorquerAxes, Vector};
use crate::modes::{Mode, ModeReport, Modes, ModesState, Sight, sight::Heard};
use crate::orbit::OrbitState;
use crate::orbit::interpolated::{InterpolatedOrbit, OrbitNodes};
use crate::planning::{Models, PlanningState};
use crate::reading::{MissingReason, Reading};
use crate::schedule::Phase;
use crate::sensing::sun_faces::FACES;
use crate::sensing::{Expected, Frozen, SunFaces, SunSighting, Triad};
pub use crate::steering::{ControlStatus, Law, Pointing, RateFrom, Steering, SteeringParameters};
use crate::steering::{Decision, Known, SteeringState};
use crate::time::Utc;

/// Everything that was decided before the cycle: accepted configuration, never changed by it.
#[derive(Debug, Clone)]
pub struct Configuration {
    /// Orbit model; `None` while no elements have been given. Despin does not need it.
    pub orbit: Option<InterpolatedOrbit>,
    /// Where the Sun is.
    pub sun: SunTrack,
    /// From the gyros' axes to Body.
    pub gyro: Triad<GyroAxes>,
    /// From the magnetometer's axes to Body.
    pub magnetometer: Triad<MagnetometerAxes>,
    /// From the currents of the Sun sensors to one direction in Body; `None` without Sun sensors.
    pub sun_faces: Option<SunFaces>,
    /// Stage II; `None` while attitude is not needed.
    pub estimator: Option<Estimator>,
    /// The law of stage III; with modes, that of [`Mode::Point`].
    pub law: Law,
    /// What surrounds the law.
    pub steering: Steering,
    /// The mode machine; `None` to fly the one law.
    pub modes: Option<Modes>,
    /// From the wanted dipole to the torquers.
    pub allocation: Allocation,
}

/// What one cycle leaves for the next. `Default` is power-on.
#[derive(Debug, Clone, Default)]
pub struct State {
    orbit_nodes: OrbitNodes,
    sun_nodes: SunNodes,
    field_model: Option<FieldModel<f32>>,
    frozen_gyro: Frozen,
    frozen_magnetometer: Frozen,
    determination: StageState,
    modes: ModesState,
    planning: PlanningState,
    steering: SteeringState,
}

/// What the world says at the start of a cycle.
#[derive(Debug, Clone, Copy)]
pub struct Inputs {
    /// The satellite's clock.
    pub now: Utc,
    /// What the cycle is for.
    pub phase: Phase,
    /// Rate along the gyros' axes, rad/s.
    pub rate_rad_s: [Reading<f32>; 3],
    /// Field along the magnetometer's axes, T.
    pub field_t: [Reading<f32>; 3],
    /// Photocurrents X1, X2, Y1, Y2 of each Sun sensor, A.
    pub sun_a: [Reading<[f32; 4]>; FACES],
    /// What the torquers carried since the last cycle, A·m².
    pub carried: Vector<TorquerAxes>,
    /// Whether the torquers refused what they were told then; they are off when they do.
    pub refused: bool,
    /// A mode that the ground asks for.
    pub commanded: Option<Mode>,
}

/// What one cycle thought.
#[derive(Debug, Clone, Copy)]
pub struct Thoughts {
    /// Position and velocity; `None` when there is no orbit model or it fails.
    pub orbit: Option<OrbitState>,
    /// The model's field at the satellite, Eci, T.
    pub reference_field: Option<Vector<Eci>>,
    /// Where the Sun should be; `None` when the clock is before 1972.
    pub reference_sun: Option<Direction<Eci>>,
    /// Fraction of the Sun's disc that the Earth should leave free, 0 in eclipse to 1; `None`
    /// without an orbit.
    pub sunlit: Option<f32>,
    /// Rate of Body relative to Eci, Body, rad/s.
    pub omega_bi: Reading<Vector<Body>>,
    /// Field, Body, T; missing unless the torquers had been at rest long enough.
    pub field_b: Reading<Vector<Body>>,
    /// The Sun, Body, or why there is none; and what became of each Sun sensor.
    pub sun_b: SunSighting,
    /// Attitude and rate, and where they come from; `None` when stage II does not fly.
    pub determination: Option<Determination>,
    /// What the mode machine says; `None` without modes.
    pub mode: Option<ModeReport>,
    /// What the commissioning ladder says; `None` unless it is being climbed.
    pub commissioning: Option<LadderReport>,
    /// What stage III did.
    pub control: ControlStatus,
    /// Angle from Body to the target, rad, as believed when this round was decided; `None` in a rest, and
    /// when no attitude is aimed at.
    pub pointing_error_rad: Option<f32>,
    /// What the torquers are asked for.
    pub command: Command,
}

/// One cycle.
// Inline, as the filters' and the field's functions that it calls: so they are compiled for whoever flies them, and
// at that crate's level. The image has adcs-core made small, and these fast (Cargo.toml).
#[inline]
pub fn cycle(configuration: &Configuration, state: &mut State, inputs: &Inputs) -> Thoughts {
    // Stage I: where the satellite is, and which field and which Sun it should see there.
    let orbit = state.orbit(configuration, inputs.now);
    let reference_field = orbit.and_then(|orbit| state.reference_field(inputs.now, &orbit));
    let sunlight = state.sunlight(configuration, inputs.now, orbit.as_ref());

    // What it does see, in Body.
    let (rate_rad_s, field_t) = state.still_measured(configuration, inputs);
    let omega_bi = configuration.gyro.to_body(rate_rad_s);
    let field_b = match inputs.phase {
        Phase::Settled | Phase::Measuring => configuration.magnetometer.to_body(field_t),
        Phase::Settling | Phase::Acting => Reading::Missing(MissingReason::TorquersOn),
    };
    let expected = state.determination.expected(inputs.now, orbit.as_ref(), sunlight.as_ref());
    let sun_b = sighting(configuration, &inputs.sun_a, &expected);

    // Stage II: what to believe of it.
    let sensed = Sensed {
        orbit: orbit.as_ref(),
        reference_field,
        sunlight: sunlight.as_ref(),
        omega_bi,
        field_b,
        sun_b: &sun_b,
        torquer_dipole: configuration.allocation.to_body(inputs.carried),
    };
    let determination = configuration
        .estimator
        .as_ref()
        .map(|estimator| state.determination.cycle(estimator, inputs.now, &sensed));

    // What the satellite is at.
    let at = (inputs.now, inputs.phase);
    let lit = sunlight.and_then(|sunlight| sunlight.lit);
    let carried = configuration.allocation.to_body(inputs.carried);
    let reference_sun = sunlight.map(|sunlight| sunlight.direction);
    let reading = Reading::from_axes(field_t).map(|[x, y, z]| Vector::new(x, y, z));
    let heard = Heard {
        omega_bi,
        field_b,
        sun_b: &sun_b,
        lit,
        reading,
        reference_field,
        reference_sun,
        carried,
        obey: !inputs.refused,
    };
    let mode = configuration.modes.as_ref().map(|modes| {
        let error = state.steering.error_rad();
        let sight = Sight::of(at, inputs.commanded, &heard, determination.as_ref(), error);
        report(modes, &mut state.modes, &sight)
    });
    if mode.is_some_and(|report| report.transition.is_some()) {
        state.steering.interrupt();
    }

    // Stage III: what to do about it.
    let models = Models {
        orbit: configuration.orbit.as_ref().map(InterpolatedOrbit::model),
        sun: &configuration.sun,
    };
    let known = Known {
        reference_field,
        gains: state.planning.cycle(&configuration.law, &models, inputs.now),
        orbit: orbit.as_ref(),
        sun: reference_sun,
        omega_bi,
        field_b,
        determination: determination.as_ref(),
    };
    let (law, steering) = configuration.flown(mode);
    let decision = match state.modes.pulse() {
        Some(pulse) => Decision::acting(configuration.allocation.command(pulse)),
        None => decision(&mut state.steering, (law, steering), configuration, at, &known),
    };
    Thoughts {
        orbit,
        reference_field,
        reference_sun,
        sunlit: lit,
        omega_bi,
        field_b,
        sun_b,
        determination,
        mode,
        commissioning: state.modes.climbed(),
        control: decision.control,
        pointing_error_rad: decision.error_rad,
        command: decision.command,
    }
}

/// What the mode machine makes of it.
#[inline(never)]
fn report(modes: &Modes, state: &mut ModesState, sight: &Sight) -> ModeReport {
    modes.cycle(state, sight)
}

/// What stage III makes of it.
#[inline(never)]
fn decision(
    state: &mut SteeringState,
    (law, steering): (&Law, &Steering),
    configuration: &Configuration,
    at: (Utc, Phase),
    known: &Known<'_>,
) -> Decision {
    state.cycle(law, steering, &configuration.allocation, at, known)
}

impl Configuration {
    /// The law that flies, and what surrounds it.
    fn flown(&self, mode: Option<ModeReport>) -> (&Law, &Steering) {
        let pointing = (&self.law, &self.steering);
        match (&self.modes, mode) {
            (Some(modes), Some(report)) => modes.flown(report.mode, pointing),
            _ => pointing,
        }
    }
}

/// Where the Sun sensors see the Sun.
#[inline(never)]
fn sighting(
    configuration: &Configuration,
    sun_a: &[Reading<[f32; 4]>; FACES],
    expected: &Expected,
) -> SunSighting {
    match &configuration.sun_faces {
        Some(faces) => faces.sight(sun_a, expected),
        None => SunSighting::NOT_FITTED,
    }
}

impl State {
    /// What commissioning has found so far: all that has to be kept over a reset.
    pub fn findings(&self) -> &Findings {
        self.modes.findings()
    }

    /// Before the first cycle: what had been found before a reset.
    pub fn resume(&mut self, findings: Findings) {
        self.modes.resume(findings);
    }

    /// Remembers that what was found has been put in force; another climb forgets it.
    pub fn note_commit(&mut self) {
        self.modes.note_commit();
    }

    /// Forgets what was concluded from readings that were corrected otherwise: filters, plans, commands.
    pub fn recalibrated(&mut self) {
        self.determination = StageState::default();
        self.planning.forget();
        self.steering = SteeringState::default();
    }

    /// What gyro and magnetometer say, unless they have frozen. Without stage II nobody could take
    /// over, and despin flies on what there is.
    fn still_measured(
        &mut self,
        configuration: &Configuration,
        inputs: &Inputs,
    ) -> ([Reading<f32>; 3], [Reading<f32>; 3]) {
        match configuration.estimator {
            Some(_) => (
                self.frozen_gyro.screen(inputs.rate_rad_s),
                self.frozen_magnetometer.screen(inputs.field_t),
            ),
            None => (inputs.rate_rad_s, inputs.field_t),
        }
    }

    /// Where the satellite is, from SGP4 at the nodes around `now`.
    fn orbit(&mut self, configuration: &Configuration, now: Utc) -> Option<OrbitState> {
        configuration.orbit.as_ref()?.state(&mut self.orbit_nodes, now).ok()
    }

    /// The model's field at the satellite, with the coefficients of the hour kept from cycle to
    /// cycle.
    #[inline]
    fn reference_field(&mut self, now: Utc, orbit: &OrbitState) -> Option<Vector<Eci>> {
        if self.field_model.is_none() {
            self.field_model = FieldModel::new(now).ok();
        }
        self.field_model.as_mut()?.eci_t(now, orbit.position).ok()
    }

    /// The Sun as it should be seen, from the formula at the hours around `now`.
    fn sunlight(
        &mut self,
        configuration: &Configuration,
        now: Utc,
        orbit: Option<&OrbitState>,
    ) -> Option<Sunlight> {
        let sun = configuration.sun.position_m(&mut self.sun_nodes, now).ok()?;
        Sunlight::seen(sun, orbit.map(|orbit| orbit.position))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::allocation::TorquerParameters;
    use crate::control::b_dot::{BDot, BDotGain};
    use crate::control::cross_product::{CrossProduct, CrossProductParameters};
    use crate::control::guidance::{Aim, Guidance};
    use crate::schedule::Round;
    use crate::sensing::{SunFacesParameters, TriadParameters};
    use crate::time::LeapSeconds;

    const RATE_RAD_S: [Reading<f32>; 3] =
        [Reading::Fresh(0.05), Reading::Fresh(-0.02), Reading::Fresh(0.1)];
    const FIELD_T: [Reading<f32>; 3] =
        [Reading::Fresh(2e-5), Reading::Fresh(-1e-5), Reading::Fresh(3e-5)];
    const BUS: Reading<f32> = Reading::Missing(MissingReason::Bus);

    fn despin(law: Law) -> Configuration {
        let alignment_xyzw = [0.0, 0.0, 0.0, 1.0];
        Configuration {
            orbit: None,
            sun: SunTrack::new(LeapSeconds::BUILT_IN),
            gyro: Triad::new(&TriadParameters::default()).unwrap(),
            magnetometer: Triad::new(&TriadParameters::default()).unwrap(),
            sun_faces: Some(SunFaces::new(&SunFacesParameters::SPROUT).unwrap()),
            estimator: None,
            law,
            steering: Steering {
                rate: RateFrom::Gyro,
                cut_hold: false,
                feed_forward: None,
                round: Round { on_s: 10.0, off_s: 2.5 },
            },
            modes: None,
            allocation: Allocation::new(&TorquerParameters { max_dipole_am2: 0.6, alignment_xyzw })
                .unwrap(),
        }
    }

    fn b_dot() -> Configuration {
        despin(Law::BDot(BDot::new(BDotGain::Plain { gain_am2_s_per_t: 1e5 }).unwrap()))
    }

    fn inputs(phase: Phase) -> Inputs {
        let now = Utc::from_micros_since_2000(0);
        let mut sun_a = [Reading::Fresh([0.0; 4]); FACES];
        sun_a[2] = Reading::Fresh([40e-6; 4]);
        let (carried, refused, commanded) = (Vector::zero(), false, None);
        let (rate_rad_s, field_t) = (RATE_RAD_S, FIELD_T);
        Inputs { now, phase, rate_rad_s, field_t, sun_a, carried, refused, commanded }
    }

    #[test]
    fn a_command_is_measured_once_held_while_acting_and_dropped_at_rest() {
        let (configuration, mut state) = (b_dot(), State::default());
        let rest = cycle(&configuration, &mut state, &inputs(Phase::Settling));
        assert_eq!((rest.control, rest.command), (ControlStatus::Resting, Command::off()));
        let measured = cycle(&configuration, &mut state, &inputs(Phase::Measuring));
        assert_eq!(measured.control, ControlStatus::Acting);
        // m = k (ω × B), first component: 1e5 (−0.02 · 3e-5 + 0.1 · 1e-5).
        assert!((measured.command.dipole.xyz.x - 0.04).abs() < 1e-6);
        // Other readings while acting change nothing.
        let mut later = inputs(Phase::Acting);
        later.rate_rad_s = [BUS; 3];
        let held = cycle(&configuration, &mut state, &later);
        assert_eq!(held.command, measured.command);
        let next = cycle(&configuration, &mut state, &inputs(Phase::Settling));
        assert_eq!(next.command, Command::off());
    }

    #[test]
    fn a_missing_sensor_switches_the_round_off_and_says_which() {
        let (configuration, mut state) = (b_dot(), State::default());
        let mut blind = inputs(Phase::Measuring);
        blind.field_t = [FIELD_T[0], BUS, FIELD_T[2]];
        let measured = cycle(&configuration, &mut state, &blind);
        assert_eq!(measured.control, ControlStatus::NoField(MissingReason::Bus));
        assert_eq!(measured.command, Command::off());
        let acting = cycle(&configuration, &mut state, &inputs(Phase::Acting));
        assert_eq!(acting.command, Command::off());
        blind.rate_rad_s = [BUS; 3];
        let measured = cycle(&configuration, &mut state, &blind);
        assert_eq!(measured.control, ControlStatus::NoRate(MissingReason::Bus));
    }

    #[test]
    fn a_command_that_would_drive_the_spin_is_cut_for_the_rest_of_the_round() {
        let (mut configuration, mut state) = (b_dot(), State::default());
        configuration.steering.cut_hold = true;
        // 0.11 rad/s: a quarter turn takes 13.8 s.
        let at = |phase, seconds: i64| {
            let now = Utc::from_micros_since_2000(seconds * 1_000_000);
            Inputs { now, ..inputs(phase) }
        };
        let measured = cycle(&configuration, &mut state, &at(Phase::Measuring, 0));
        assert_eq!(measured.control, ControlStatus::Acting);
        let held = cycle(&configuration, &mut state, &at(Phase::Acting, 13));
        assert_eq!((held.control, held.command), (ControlStatus::Acting, measured.command));
        for seconds in [14, 15] {
            let spent = cycle(&configuration, &mut state, &at(Phase::Acting, seconds));
            assert_eq!((spent.control, spent.command), (ControlStatus::Spent, Command::off()));
        }
        let next = cycle(&configuration, &mut state, &at(Phase::Measuring, 20));
        assert_eq!(next.control, ControlStatus::Acting);
    }

    #[test]
    fn without_gyros_the_rate_comes_from_the_fields_turning_during_the_rest() {
        let (mut configuration, mut state) = (b_dot(), State::default());
        configuration.steering.rate = RateFrom::Field;
        let seen = |phase, half_seconds: i64, y: f32| Inputs {
            now: Utc::from_micros_since_2000(half_seconds * 500_000),
            rate_rad_s: [BUS; 3],
            field_t: [Reading::Fresh(3e-5), Reading::Fresh(y), Reading::Fresh(0.0)],
            ..inputs(phase)
        };
        let alone = cycle(&configuration, &mut state, &seen(Phase::Measuring, 0, 0.0));
        assert_eq!(alone.control, ControlStatus::NoRate(MissingReason::TorquersOn));
        cycle(&configuration, &mut state, &seen(Phase::Settling, 1, 0.0));
        for k in 2..5 {
            cycle(&configuration, &mut state, &seen(Phase::Settled, k, 3e-7 * k as f32));
        }
        let measured = cycle(&configuration, &mut state, &seen(Phase::Measuring, 5, 1.5e-6));
        assert_eq!(measured.control, ControlStatus::Acting);
        // m = −k Ḃ, Ḃ along y: 3e-7 T in half a second. To first order in the turn of 2 deg.
        assert!((measured.command.dipole.xyz.y + 0.06).abs() < 1e-3, "{:?}", measured.command);
    }

    #[test]
    fn pointing_without_an_attitude_switches_the_round_off_and_says_so() {
        let law = CrossProductParameters {
            stiffness_n_m_per_rad: 1.5e-7,
            damping_n_m_s: 3e-4,
            inertia_kg_m2: [[0.05, 0.0, 0.0], [0.0, 0.05, 0.0], [0.0, 0.0, 0.06]],
            gyroscopic: false,
            gravity_gradient: false,
        };
        let law = CrossProduct::new(&law).unwrap();
        let (guidance, periodic) = (Guidance { aim: Aim::Nadir, slew: None }, None);
        let (configuration, mut state) =
            (despin(Law::Pointing(Pointing { law, periodic, guidance })), State::default());
        let measured = cycle(&configuration, &mut state, &inputs(Phase::Measuring));
        assert_eq!(measured.control, ControlStatus::NoAttitude);
        assert_eq!(measured.command, Command::off());
    }

    #[test]
    fn without_a_law_the_torquers_stay_off() {
        let (configuration, mut state) = (despin(Law::Off), State::default());
        let measured = cycle(&configuration, &mut state, &inputs(Phase::Measuring));
        assert_eq!((measured.control, measured.command), (ControlStatus::Off, Command::off()));
    }

    #[test]
    fn the_field_counts_only_when_the_torquers_have_rested() {
        let (configuration, mut state) = (b_dot(), State::default());
        for phase in [Phase::Settling, Phase::Acting] {
            let thoughts = cycle(&configuration, &mut state, &inputs(phase));
            assert_eq!(thoughts.field_b.missing(), Some(MissingReason::TorquersOn));
        }
    }

    #[test]
    fn the_sun_is_seen_in_every_phase_and_known_without_an_orbit() {
        let (configuration, mut state) = (b_dot(), State::default());
        for phase in [Phase::Settling, Phase::Measuring, Phase::Acting] {
            let thoughts = cycle(&configuration, &mut state, &inputs(phase));
            let sun = thoughts.sun_b.sun.value().unwrap().direction.vector();
            assert!((sun - Vector::new(0.0, 1.0, 0.0)).norm() < 1e-6);
            // Noon on 1 January: the Sun stands 23 deg south.
            let reference = thoughts.reference_sun.unwrap().vector();
            assert!((reference.xyz.z + 0.391).abs() < 0.002, "{reference:?}");
            assert_eq!(thoughts.sunlit, None);
        }
    }

    #[test]
    fn without_sun_sensors_the_rest_flies() {
        let (mut configuration, mut state) = (b_dot(), State::default());
        configuration.sun_faces = None;
        let thoughts = cycle(&configuration, &mut state, &inputs(Phase::Measuring));
        assert_eq!(thoughts.sun_b.sun.missing(), Some(MissingReason::NotFitted));
        assert_eq!(thoughts.control, ControlStatus::Acting);
    }
}
