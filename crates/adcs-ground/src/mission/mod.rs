//! Mission files: what a person writes becomes a [`Scenario`].
//!
//! A mission is a TOML file in a person's units, each at the end of its key (`rate_deg_s`,
//! `noise_nt`); `missions/README.md` lists all keys. `base = "other.toml"` takes over whatever the
//! file itself does not say from another. Everything is converted to SI here and nowhere else.
//!
//! Nothing is guessed: an unknown key, a wrong unit or an impossible value is refused with file,
//! line, column, reason and advice, and one run reports all of them ([`MissionError`]). What the
//! flight crates refuse by their own constructors is reported at the key it came from.

mod attitude;
mod commissioning;
mod control;
mod document;
mod guidance;
mod modes;
mod orbit;
mod problem;
mod satellite;
mod section;
mod sensors;
mod sun_sensors;
mod typed;
mod unit;

use std::path::{Path, PathBuf};

use adcs_app::{FlightParameters, FlownParameters};
use adcs_core::frames::Rotation;
use adcs_core::time::MICROS_PER_SECOND;
use adcs_hal::driver_board::DriverBoardConfig;
use adcs_sim::devices::SpiFault;
use adcs_sim::fly::FlightError;
use adcs_sim::scenario::{self, Readings, Scenario, WorldParameters};
use adcs_sim::world::World;
use nalgebra::{UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};

use problem::{Fault, Sources};
pub use problem::{MissionError, Problem};
use section::{Problems, Section};

/// The quaternion of axes that are those of Body.
const NO_ROTATION: [f64; 4] = [0.0, 0.0, 0.0, 1.0];

/// Longest mission: its records are kept in memory for the report.
const MAX_CYCLES: i64 = 1_000_000;
/// Longest duration that is read at all, s.
const MAX_DURATION_S: f64 = 1e7;

/// A mission, checked and in SI units.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Mission {
    /// The file's name without `.toml`.
    pub name: String,
    /// What it is, in a line.
    pub title: String,
    /// What it is for and what to expect, in some sentences.
    pub description: String,
    /// The files it was read from: itself, its base, that one's base.
    pub files: Vec<PathBuf>,
    /// The satellite's mass, kg. Nothing in the flight depends on it.
    pub mass_kg: f64,
    /// Where the inertia comes from: measured, published, or assumed.
    pub inertia_source: String,
    /// The orbit as it was written.
    pub tle: [String; 2],
    /// What is flown.
    pub scenario: Scenario,
}

/// Reads and checks a mission file.
///
/// # Errors
/// [`MissionError`] with everything that is wrong in it and in its base files.
pub fn load(path: impl AsRef<Path>) -> Result<Mission, MissionError> {
    let path = path.as_ref();
    let (sources, table) = document::read(path)?;
    let problems = Problems::new(&sources);
    let mission = mission(&Section::root(&problems, &table), path, &sources);
    match mission {
        Some(mission) if problems.is_empty() => Ok(mission),
        _ => Err(MissionError { problems: problems.into_sorted() }),
    }
}

fn mission(root: &Section, path: &Path, sources: &Sources) -> Option<Mission> {
    // Every part is read before any is missed, so that all problems are found.
    let _ = root.has("base");
    let about = about(root);
    let simulation = simulation(root);
    let cycle_us = about.as_ref().map(|about| about.cycle_us);
    let satellite = satellite::satellite(root);
    let torques = satellite::torques(root);
    let torquers = satellite::torquers(root);
    let converter = sensors::converter(root);
    let magnetometer = sensors::magnetometer(root, converter);
    let gyro = sensors::gyro(root, converter);
    let sun = sun_sensors::sun_sensors(root, converter);
    let attitude = attitude::attitude(root, satellite.as_ref().map(|it| it.inertia_kg_m2));
    let orbit = orbit::orbit(root);
    let start = orbit::start(root, orbit.as_ref());
    let usual = control::Usual {
        inertia_kg_m2: satellite.as_ref().map(|it| it.inertia_kg_m2),
        max_dipole_am2: torquers.as_ref().map(|it| it.parameters.max_dipole_am2),
        rate_noise_rad_s: gyro.as_ref().map(|it| it.truth.noise),
        field_noise_t: magnetometer.as_ref().map(|it| it.truth.noise),
    };
    let law = control::law(root, &usual);
    let schedule = control::schedule(root, cycle_us);
    let beside = modes::Beside {
        pointing: law.map(|(law, steering)| FlownParameters { law, steering }),
        attitude: attitude.flatten(),
        schedule,
        magnetometer: magnetometer.as_ref().map(|it| it.calibration),
    };
    let modes = modes::modes(root, &usual, &beside);
    let counted = about.as_ref().map(|about| (about.cycle_us, about.cycles));
    let commands = modes::commands(root, counted, modes.is_none_or(|modes| modes.is_some()));
    root.finish();

    let (about, simulation) = (about?, simulation?);
    check_step(root, about.cycle_us, simulation.step_us);
    let (satellite, torques, torquers) = (satellite?, torques?, torquers?);
    let (magnetometer, gyro, sun) = (magnetometer?, gyro?, sun?);
    sensors::refuse_shared_channels(root, &magnetometer, &gyro);
    let (orbit, start, (law, steering)) = (orbit?, start?, law?);
    let scenario = Scenario {
        version: scenario::VERSION,
        flight: FlightParameters {
            cycle_us: about.cycle_us,
            schedule: schedule?,
            law,
            steering,
            modes: modes?,
            gyro: gyro.calibration,
            magnetometer: magnetometer.calibration,
            sun_sensors: sun.as_ref().map(|sun| sun.known),
            attitude: attitude?,
            torquers: torquers.parameters,
            elements: Some(orbit.elements),
        },
        board: DriverBoardConfig {
            converter: converter?,
            magnetometer: magnetometer.wiring,
            gyro: gyro.wiring,
            sun: sun.as_ref().map(|sun| sun.wiring),
            max_dipole_am2: [torquers.parameters.max_dipole_am2; 3],
        },
        readings: simulation.readings,
        converter_fault: simulation.converter_fault,
        world: WorldParameters {
            start: start.utc,
            attitude_xyzw: start.attitude_xyzw,
            omega_bi_rad_s: start.rate_rad_s,
            inertia_kg_m2: satellite.inertia_kg_m2,
            residual_dipole_am2: torques.residual_dipole_am2(&satellite),
            gravity_gradient: torques.gravity_gradient,
            drag: torques.drag(&satellite),
            solar_pressure: torques.solar_pressure(&satellite),
            shape: satellite.shape,
            elements: orbit.elements,
            step_us: simulation.step_us,
            gyro: gyro.truth,
            magnetometer: magnetometer.truth,
            magnetometer_offset_m: magnetometer.offset_from_torquers_m,
            sun_sensors: sun.as_ref().map(|sun| sun.truth),
            torquer_alignment_xyzw: torquers.true_alignment_xyzw,
            torquer_full_dipole_am2: torquers.true_dipole_am2,
            torquer_steps: torquers.steps,
            seed: about.seed,
        },
        commands: commands?,
        cycles: about.cycles,
    };
    check_whole(root, &scenario);
    Some(Mission {
        name: path.file_stem()?.to_string_lossy().into_owned(),
        title: about.title,
        description: about.description,
        files: sources.files.iter().map(|(path, _)| path.clone()).collect(),
        mass_kg: satellite.mass_kg,
        inertia_source: satellite.inertia_source,
        tle: orbit.tle,
        scenario,
    })
}

/// Section `mission`.
struct About {
    title: String,
    description: String,
    cycle_us: u32,
    cycles: u32,
    seed: u64,
}

fn about(root: &Section) -> Option<About> {
    let section = root.section("mission")?;
    let title = section.text("title");
    let description = section.text("description");
    let duration_us = section.micros("duration_s", 0.0..=MAX_DURATION_S);
    let cycle_us = section.micros("cycle_s", 0.001..=60.0);
    let seed = section.integer_or("seed", 0..=i64::MAX, 1);
    section.finish();
    for key in ["title", "description"] {
        if section.has(key) && section.place_of(key).file != 0 {
            let fault = Fault::new("that of the base is of another flight: give this one its own");
            section.refuse(key, fault);
        }
    }
    let (duration_us, cycle_us) = (duration_us?, cycle_us?);
    let refuse = |reason: String, advice: &str| {
        section.refuse("duration_s", Fault::advising(reason, advice));
    };
    let cycles = duration_us / cycle_us;
    if duration_us == 0 {
        refuse("impossible: a flight of 0 s".to_owned(), "");
    } else if duration_us % cycle_us != 0 {
        let cycle_s = cycle_us as f64 / MICROS_PER_SECOND as f64;
        refuse(format!("not a whole number of cycles of {cycle_s} s"), "");
    } else if cycles > MAX_CYCLES {
        refuse(
            format!("{cycles} cycles are too many for one flight: at most {MAX_CYCLES}"),
            "fly less, or with a longer cycle",
        );
    }
    Some(About {
        title: title?,
        description: description?,
        cycle_us: u32::try_from(cycle_us).ok()?,
        cycles: u32::try_from(cycles).ok()?,
        seed: u64::try_from(seed?).ok()?,
    })
}

/// Section `simulation`.
struct Simulation {
    step_us: u32,
    readings: Readings,
    converter_fault: Option<SpiFault>,
}

fn simulation(root: &Section) -> Option<Simulation> {
    const STEP_US: i64 = 100_000;
    let section = root.section_or_empty("simulation")?;
    let step_us = section.micros_or("step_s", 0.001..=1.0, STEP_US);
    let readings = [("drivers", Readings::Drivers), ("exact", Readings::Exact)];
    let readings = section.choice_or("readings", &readings, Readings::Drivers);
    let faults = [
        ("none", None),
        ("zeros", Some(SpiFault::Zeros)),
        ("ones", Some(SpiFault::Ones)),
        ("error", Some(SpiFault::Error)),
    ];
    let converter_fault = section.choice_or("converter_fault", &faults, None);
    section.finish();
    let (readings, converter_fault) = (readings?, converter_fault?);
    if readings == Readings::Exact && converter_fault.is_some() {
        let fault = Fault::advising(
            "has no meaning with exact readings: there is no converter then",
            "write readings = \"drivers\", or remove it",
        );
        section.refuse("converter_fault", fault);
    }
    let step_us = u32::try_from(step_us?).ok()?;
    Some(Simulation { step_us, readings, converter_fault })
}

fn check_step(root: &Section, cycle_us: u32, step_us: u32) {
    if cycle_us.is_multiple_of(step_us) {
        return;
    }
    if let Some(section) = root.section("mission") {
        let step_s = f64::from(step_us) / MICROS_PER_SECOND as f64;
        let reason = format!("not a whole number of simulation steps of {step_s} s");
        let fault = Fault::advising(reason, "change it or simulation.step_s");
        section.refuse("cycle_s", fault);
    }
}

/// What only the whole scenario shows: whether the world can begin and end with it.
fn check_whole(root: &Section, scenario: &Scenario) {
    let parameters = &scenario.world;
    let flown_us = i64::from(scenario.cycles) * i64::from(scenario.flight.cycle_us);
    let end = WorldParameters { start: parameters.start.plus_micros(flown_us), ..*parameters };
    let started = [parameters, &end].map(|at| World::new(at, &scenario.board));
    let Some(error) = started.into_iter().find_map(Result::err) else { return };
    let (section, key) = match error {
        FlightError::Orbit(_) => ("orbit", "tle"),
        _ => ("start", "utc"),
    };
    if let Some(section) = root.section(section) {
        section.refuse(key, Fault::new(error.to_string()));
    }
}

/// The small turn by which a unit is mounted wrongly, from its true axes `A` to those it should
/// have; `None` when there is none, or it is switched off. `turn_deg` is a rotation vector along the
/// axes that it should have.
fn misalignment<A>(turn_deg: [f64; 3], switched_off: bool) -> Option<Rotation<A, A, f64>> {
    if switched_off || turn_deg == [0.0; 3] {
        return None;
    }
    let turn_rad = Vector3::from(turn_deg.map(f64::to_radians));
    Some(Rotation::from_hamilton(UnitQuaternion::from_scaled_axis(turn_rad)))
}
