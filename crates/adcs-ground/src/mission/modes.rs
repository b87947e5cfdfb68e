//! Sections `modes` and `commands`: the mode machine, and what the ground tells it on the way.

use adcs_app::{FlownParameters, ModesParameters, ParameterError};
use adcs_core::attitude::selection::{EstimatorParameters, Flies};
use adcs_core::modes::{Mode, ModeError, ModeParameters, Needs};
use adcs_core::parameter::OutOfRange;
use adcs_core::polarity::PolarityParameters;
use adcs_core::schedule::ScheduleParameters;
use adcs_core::sensing::TriadParameters;
use adcs_sim::scenario::{COMMANDS, Order, TimedCommand};

use super::commissioning;
use super::control::{self, Usual};
use super::problem::Fault;
use super::section::Section;
use super::typed::FINITE;

/// Every mode by its name.
const MODES: [(&str, Mode); 7] = [
    ("off", Mode::Off),
    ("safe", Mode::Safe),
    ("detumble", Mode::Detumble),
    ("acquire", Mode::Acquire),
    ("point", Mode::Point),
    ("experiment", Mode::Experiment),
    ("commissioning", Mode::Commissioning),
];

const DIPOLE_SIGMA: &str = "dipole_sigma_am2";
const EXPERIMENT: &str = "experiment";
const GUARD: &str = "polarity_guard";

/// The keys of angles, by the names of their fields; of every other number the key is the field's name.
const ANGLES: [(&str, &str); 6] = [
    ("despun_rad_s", "despun_deg_s"),
    ("tumbling_rad_s", "tumbling_deg_s"),
    ("attitude_sigma_rad", "attitude_sigma_deg"),
    ("slow_rad_s", "slow_deg_s"),
    ("captured_rad", "captured_deg"),
    ("diverged_rad", "diverged_deg"),
];

/// The key of a number.
fn key_of(field: &'static str) -> &'static str {
    ANGLES.iter().find(|(angle, _)| *angle == field).map_or(field, |(_, key)| key)
}

/// What the mode machine is held against.
pub(super) struct Beside {
    /// The law that points, and what surrounds it; `None` when it is refused.
    pub pointing: Option<FlownParameters>,
    pub attitude: Option<EstimatorParameters>,
    pub schedule: Option<ScheduleParameters>,
    pub magnetometer: Option<TriadParameters>,
}

/// Section `modes`; `Some(None)` when there is none.
pub(super) fn modes(
    root: &Section,
    usual: &Usual,
    beside: &Beside,
) -> Option<Option<ModesParameters>> {
    let Some(section) = root.section_if_any("modes")? else { return Some(None) };
    let despin = section.section("detumble").and_then(|law| control::flown(&law, usual));
    let experiment = match section.section_if_any(EXPERIMENT)? {
        Some(law) => control::flown(&law, usual).map(Some),
        None => Some(None),
    };
    let commissioning = commissioning::commissioning(&section);
    let table = table(&section, beside.attitude.as_ref());
    let guards = if section.has(GUARD) { section.flag(GUARD) } else { Some(true) };
    section.finish();

    let flown = |(law, steering)| FlownParameters { law, steering };
    let modes = ModesParameters {
        table: table?,
        despin: flown(despin?),
        experiment: experiment?.map(flown),
        polarity: beside.attitude.filter(|_| guards == Some(true)).map(|it| polarity(&it, usual)),
        commissioning: commissioning?,
    };
    let schedule = beside.schedule?;
    let pointing = beside.pointing?.accept(schedule.round()).ok()?;
    let settle_s = schedule.settle_us as f32 * 1e-6;
    let magnetometer = (&beside.magnetometer?, settle_s);
    if let Err(error) = modes.accept(&pointing, beside.attitude.as_ref(), magnetometer) {
        refuse(root, &section, &error);
        return None;
    }
    Some(Some(modes))
}

/// What looks after the wiring knows what stage II is told.
fn polarity(attitude: &EstimatorParameters, usual: &Usual) -> PolarityParameters {
    let pulse_am2 = usual.max_dipole_am2.unwrap_or(PolarityParameters::default().pulse_am2);
    PolarityParameters::of(&attitude.dynamics, pulse_am2)
}

/// Says at its key what the flight software refuses.
fn refuse(root: &Section, section: &Section, error: &ParameterError) {
    let key = match error {
        ParameterError::Modes(ModeError::OutOfRange(number)) => key_of(number.name),
        ParameterError::Modes(ModeError::NoHysteresis { outer, .. }) => key_of(outer),
        ParameterError::Modes(ModeError::ExperimentNext) => "experiment_next",
        ParameterError::Modes(ModeError::NoDipole) => DIPOLE_SIGMA,
        ParameterError::Modes(ModeError::NotDespin) => "detumble",
        ParameterError::Polarity(_) => GUARD,
        ParameterError::Modes(ModeError::NoCheck) if section.has(commissioning::SECTION) => GUARD,
        ParameterError::Commissioning(error) => {
            commissioning::refuse(section, error);
            return;
        }
        ParameterError::Modes(ModeError::NotPointing) => {
            let advice = "with modes [law] is what flies in mode point";
            let fault = Fault::advising(error.to_string(), advice);
            if let Some(law) = root.section("law") {
                law.refuse("kind", fault);
            }
            return;
        }
        ParameterError::Modes(ModeError::NoAttitude) => {
            let fault = Fault::advising(error.to_string(), "add the section [attitude]");
            section.refuse("", fault);
            return;
        }
        _ => "start",
    };
    section.refuse(key, Fault::new(in_degrees(error)));
}

/// What is wrong, with angles in degrees.
fn in_degrees(error: &ParameterError) -> String {
    match *error {
        ParameterError::Modes(ModeError::OutOfRange(OutOfRange { name, found, from, to })) => {
            let is_angle = key_of(name).contains("_deg");
            let shown = |x: f32| {
                let x = f64::from(x);
                // Seven digits are what there is of an f32; four of them are enough here.
                let x = if is_angle { x.to_degrees() } else { x };
                format!("{x:.4}").trim_end_matches('0').trim_end_matches('.').to_owned()
            };
            let (found, from, to) = (shown(found), shown(from), shown(to));
            format!("{found} is impossible: must be from {from} to {to}")
        }
        ParameterError::Modes(ModeError::NoHysteresis { inner, .. }) => {
            format!("must be larger than {}, or the modes alternate", key_of(inner))
        }
        ref other => other.to_string(),
    }
}

fn table(section: &Section, attitude: Option<&EstimatorParameters>) -> Option<ModeParameters> {
    let usual = ModeParameters::default();
    let start = section.choice_or("start", &MODES, usual.start);
    let next = section.choice_or("experiment_next", &MODES, usual.experiment_next);
    let despin_needs = needs(section, "detumble_needs", usual.despin_needs);
    let pointing_needs = needs(section, "pointing_needs", usual.pointing_needs);
    let retries = section.integer_or("retries", 0..=255, i64::from(usual.retries));
    let number = |field: &'static str, default: f32| {
        let key = key_of(field);
        let is_angle = key.contains("_deg");
        let default = f64::from(default);
        let shown = if is_angle { default.to_degrees() } else { default };
        let value = section.number_or(key, FINITE, shown)?;
        Some((if is_angle { value.to_radians() } else { value }) as f32)
    };
    let has_dipole = attitude.is_some_and(|it| it.flies == Flies::Both);
    let dipole = usual.dipole_sigma_am2.unwrap_or_default();
    let dipole = if has_dipole || section.has(DIPOLE_SIGMA) {
        number(DIPOLE_SIGMA, dipole).map(Some)
    } else {
        Some(None)
    };
    let rounds = section.integer_or("growing_rounds", 2..=10_000, usual.growing_rounds.into());
    let mut read = usual;
    // All of them are read, so that each says what is wrong with it.
    let mut are_good = true;
    for (field, value) in [
        ("despun_rad_s", &mut read.despun_rad_s),
        ("despun_for_s", &mut read.despun_for_s),
        ("tumbling_rad_s", &mut read.tumbling_rad_s),
        ("tumbling_for_s", &mut read.tumbling_for_s),
        ("detumble_limit_s", &mut read.detumble_limit_s),
        ("attitude_sigma_rad", &mut read.attitude_sigma_rad),
        ("slow_rad_s", &mut read.slow_rad_s),
        ("trusted_for_s", &mut read.trusted_for_s),
        ("acquire_limit_s", &mut read.acquire_limit_s),
        ("lost_for_s", &mut read.lost_for_s),
        ("captured_rad", &mut read.captured_rad),
        ("captured_for_s", &mut read.captured_for_s),
        ("capture_limit_s", &mut read.capture_limit_s),
        ("experiment_s", &mut read.experiment_s),
        ("sensor_gap_s", &mut read.sensor_gap_s),
        ("sun_gap_s", &mut read.sun_gap_s),
        ("actuator_gap_s", &mut read.actuator_gap_s),
        ("growing_factor", &mut read.growing_factor),
        ("diverged_rad", &mut read.diverged_rad),
        ("recovery_s", &mut read.recovery_s),
    ] {
        match number(field, *value) {
            Some(given) => *value = given,
            None => are_good = false,
        }
    }
    are_good.then_some(())?;
    Some(ModeParameters {
        start: start?,
        dipole_sigma_am2: dipole?,
        experiment_next: next?,
        despin_needs: despin_needs?,
        pointing_needs: pointing_needs?,
        growing_rounds: u16::try_from(rounds?).ok()?,
        retries: u8::try_from(retries?).ok()?,
        ..read
    })
}

fn needs(section: &Section, key: &'static str, usual: Needs) -> Option<Needs> {
    if !section.has(key) {
        return Some(usual);
    }
    let words = section.choices(key, &[("gyro", "gyro"), ("sun", "sun")])?;
    Some(Needs { gyro: words.contains(&"gyro"), sun: words.contains(&"sun") })
}

/// Section `commands`: at which times which modes are asked for, and commits.
pub(super) fn commands(
    root: &Section,
    cycles: Option<(u32, u32)>,
    has_modes: bool,
) -> Option<[Option<TimedCommand>; COMMANDS]> {
    const AT: &str = "at_s";
    const ENTER: &str = "enter";
    const COMMIT: &str = "commit_at_s";
    let none = [None; COMMANDS];
    let Some(section) = root.section_if_any("commands")? else { return Some(none) };
    let list = |key| match section.has(key) {
        true => section.list_of_micros(key, 0.0..=super::MAX_DURATION_S),
        false => Some(Vec::new()),
    };
    let at_us = section.list_of_micros(AT, 0.0..=super::MAX_DURATION_S);
    let words = section.choices(ENTER, &MODES.map(|(name, _)| (name, name)));
    let commit_us = list(COMMIT);
    section.finish();
    let ((cycle_us, cycles), at_us, words, commit_us) = (cycles?, at_us?, words?, commit_us?);
    let refuse = |key, reason: String, advice: &str| {
        section.refuse(key, Fault::advising(reason, advice));
        None
    };
    if !has_modes {
        return refuse(ENTER, "there are no modes to enter".to_owned(), "add the section [modes]");
    }
    if at_us.len() != words.len() {
        let reason = format!("{} commands for {} times", words.len(), at_us.len());
        return refuse(ENTER, reason, "name one mode for each time");
    }
    if at_us.len() + commit_us.len() > COMMANDS {
        return refuse(AT, format!("more than {COMMANDS} commands"), "");
    }
    let modes = words.iter().filter_map(|word| MODES.iter().find(|(name, _)| name == word));
    let enters = at_us.into_iter().zip(modes.map(|(_, mode)| Order::Enter(*mode)));
    let commits = commit_us.into_iter().map(|at_us| (at_us, Order::Commit));
    let told = enters.map(|it| (AT, it)).chain(commits.map(|it| (COMMIT, it)));
    let mut commands = none;
    for (slot, (key, (at_us, order))) in commands.iter_mut().zip(told) {
        let cycle = at_us / i64::from(cycle_us);
        if at_us % i64::from(cycle_us) != 0 || cycle > i64::from(cycles) {
            let reason = format!("{} s is not the instant of a cycle", at_us as f64 / 1e6);
            return refuse(key, reason, "");
        }
        *slot = Some(TimedCommand { cycle: u32::try_from(cycle).ok()?, order });
    }
    Some(commands)
}
