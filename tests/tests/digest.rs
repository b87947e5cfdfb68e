//! The signature of the project: a flight on the emulated core has the bits of the flight on the
//! host, cycle by cycle. Needs an image in `ADCS_IMAGE`; `cargo xtask test` builds it.

use std::env;
use std::fs;
use std::path::Path;

use adcs_ground::emulator::Emulator;
use adcs_ground::flight::Patient;
use adcs_sim::scenario::Scenario;
use adcs_tests::{fly, mission};

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
    println!("{name}: host {host:016x}, emulated {:016x}", landing.digest);
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
