//! The signature of the project: a flight on the emulated core has the bits of the flight on the
//! host, cycle by cycle. Needs an image in `ADCS_IMAGE`; `cargo xtask test` builds it.

use std::env;
use std::fs;
use std::path::Path;

use adcs_app::{FlownParameters, LawParameters};
use adcs_core::control::guidance::{
    AimParameters, BodyAxesParameters, GuidanceParameters, SiteParameters, SunAimParameters,
};
use adcs_core::modes::Mode;
use adcs_core::pipeline::ControlStatus;
use adcs_ground::emulator::Emulator;
use adcs_ground::flight::Patient;
use adcs_sim::scenario::{Order, Scenario, TimedCommand};
use adcs_tests::{brief_commissioning, fly, mission};

fn digests(name: &str) -> (u64, u64) {
    digests_of(name, mission(name).scenario)
}

fn digests_of(name: &str, scenario: Scenario) -> (u64, u64) {
    let image =
        env::var_os("ADCS_IMAGE").expect("ADCS_IMAGE names no image: use `cargo xtask test`");
    let host = fly(&scenario).outcome.end.digest;
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name.replace('/', "-"));
    fs::create_dir_all(&folder).expect("a folder for the emulated flight");
    let mut buffer = [0; 4096];
    let bytes = postcard::to_slice(&scenario, &mut buffer).expect("a scenario has bytes");
    let emulator = Emulator::new(Path::new(&image)).unwrap_or_else(|error| panic!("{error:#}"));
    let landing = emulator
        .fly(bytes, &folder, &mut Patient)
        .unwrap_or_else(|error| panic!("{name}: {error:#}"))
        .expect("a patient watcher stops no flight");
    let emulated = landing.digest;
    println!("{name}: host {host:016x}, emulated {emulated:016x}, stack {}", landing.stack_bytes);
    (host, landing.digest)
}

#[test]
fn the_whole_despin_has_the_same_bits_on_the_emulated_core() {
    let (host, emulated) = digests("sprout/despin-calibrated");
    assert_eq!(host, emulated);
}

#[test]
fn a_reference_flight_has_the_same_bits_on_the_emulated_core() {
    let (host, emulated) = digests("reference/p3");
    assert_eq!(host, emulated);
}

#[test]
fn ten_minutes_of_both_filters_have_the_same_bits_on_the_emulated_core() {
    // The tumble at its fastest, the start of both filters, the learning of dipole and inertia.
    let name = "sprout/attitude";
    let scenario = Scenario { cycles: 1200, ..mission(name).scenario };
    let (host, emulated) = digests_of(name, scenario);
    assert_eq!(host, emulated);
}

#[test]
fn twenty_minutes_of_the_law_that_plans_have_the_same_bits_on_the_emulated_core() {
    // The sweep, the filter with all its states, and the first turn towards nadir. The same over two
    // orbits: `adcs fly missions/sprout/nadir-two-orbits.toml --on both`.
    let name = "sprout/nadir";
    let scenario = Scenario { cycles: 2400, ..mission(name).scenario };
    let flown = fly(&scenario);
    let planned = flown.records.iter().filter(|it| it.control == ControlStatus::Acting).count();
    assert!(planned > 500, "the plan is used in {planned} cycles");
    let (host, emulated) = digests_of(name, scenario);
    assert_eq!(host, emulated);
}

#[test]
fn ten_minutes_of_all_modes_and_targets_have_the_same_bits_on_the_emulated_core() {
    // A slow turn and short times, so that the satellite goes its way within minutes: to the Sun with a
    // spin, led by a slew; and by command an experiment that tracks a place on the ground.
    let name = "sprout/separation-to-nadir";
    let mut scenario = Scenario { cycles: 1200, ..mission(name).scenario };
    scenario.world.omega_bi_rad_s = [0.004, -0.003, 0.002];
    let axes = BodyAxesParameters { boresight: [-1.0, 0.0, 0.0], second: [0.0, 1.0, 0.0] };
    let towards = |law: LawParameters, aim, slew_rad_s| match law {
        LawParameters::CrossProduct { law, .. }
        | LawParameters::Periodic { unplanned: law, .. } => {
            LawParameters::CrossProduct { law, guidance: GuidanceParameters { aim, slew_rad_s } }
        }
        other => panic!("{other:?} does not point"),
    };
    let place = SiteParameters {
        axes,
        latitude_rad: 0.62,
        longitude_rad: 2.44,
        height_m: 50.0,
        least_elevation_rad: 0.0,
    };
    let flight = &mut scenario.flight;
    let tracks = towards(flight.law, AimParameters::Site(place), None);
    let spins = SunAimParameters { axes, spin_rad_s: 2e-3 };
    flight.law = towards(flight.law, AimParameters::Sun(spins), Some(1e-3));
    let modes = flight.modes.as_mut().expect("the mission has modes");
    modes.experiment = Some(FlownParameters { law: tracks, steering: flight.steering });
    let table = &mut modes.table;
    (table.despun_for_s, table.trusted_for_s, table.experiment_s) = (20.0, 20.0, 100.0);
    (table.attitude_sigma_rad, table.dipole_sigma_am2) = (0.2, None);
    table.experiment_next = Mode::Detumble;
    let entered = TimedCommand { cycle: 600, order: Order::Enter(Mode::Experiment) };
    scenario.commands[0] = Some(entered);
    let entered = fly(&scenario).records.iter().filter_map(|it| it.mode?.transition).count();
    assert!(entered >= 5, "only {entered} transitions");
    let (host, emulated) = digests_of("all-modes", scenario);
    assert_eq!(host, emulated);
}

#[test]
fn twenty_minutes_of_commissioning_have_the_same_bits_on_the_emulated_core() {
    // Every rung, the commit, and the filters that begin anew with it.
    let scenario = brief_commissioning();
    let flown = fly(&scenario);
    let rungs =
        flown.records.iter().filter(|it| it.commissioning.is_some_and(|it| it.ended.is_some()));
    assert_eq!(rungs.count(), adcs_core::commissioning::RUNGS);
    assert!(flown.records.iter().any(|it| it.committed));
    let (host, emulated) = digests_of("commissioning", scenario);
    assert_eq!(host, emulated);
}
