//! The mode machine and its commands, as missions write them.

use adcs_app::{LawParameters, ModesParameters};
use adcs_core::commissioning::{Commit, CommissioningParameters, StepTime};
use adcs_core::modes::{Mode, ModeParameters, Needs};
use adcs_ground::mission::{self, Problem};
use adcs_sim::scenario::{Order, Scenario, TimedCommand};

use crate::refused::assert_says;
use crate::workshop::Workshop;

const HEAD: &str = "base = \"despin-calibrated.toml\"\n[mission]\ntitle = \"t\"\ndescription = \"d\"\n\
                    [attitude]\nfilter = \"dynamic\"\n";
const POINTING: &str = "[law]\nkind = \"cross-product\"\nstiffness_n_m_per_rad = 1e-7\n\
                        damping_n_m_s = 2e-4\ntarget = \"nadir\"\n";
const DETUMBLE: &str = "[modes.detumble]\nkind = \"b-dot\"\ngain_am2_s_per_t = 1e5\n";

fn load(text: &str) -> Result<Scenario, Vec<Problem>> {
    let workshop = Workshop::new();
    workshop.write("sprout/modes.toml", text);
    let mission = mission::load(workshop.folder.join("sprout/modes.toml"));
    mission.map(|mission| mission.scenario).map_err(|error| error.problems)
}

fn with(modes: &str, more: &str) -> Result<Scenario, Vec<Problem>> {
    load(&format!("{HEAD}{POINTING}[modes]\n{modes}\n{DETUMBLE}{more}"))
}

fn modes(keys: &str, more: &str) -> ModesParameters {
    let scenario = with(keys, more).unwrap_or_else(|problems| panic!("{problems:#?}"));
    scenario.flight.modes.expect("the mission has modes")
}

fn refused(keys: &str, more: &str, key: &str, reason: &str) {
    let problems = with(keys, more).expect_err("the mission was accepted");
    assert_eq!(problems.len(), 1, "{problems:#?}");
    assert_says(&problems[0], key, reason, "");
}

#[test]
fn without_the_section_one_law_flies() {
    assert_eq!(load(&format!("{HEAD}{POINTING}")).unwrap().flight.modes, None);
}

#[test]
fn what_is_not_said_is_as_usual() {
    let modes = modes("", "");
    let usual = ModeParameters::default();
    // Through degrees and back.
    let near = |a: f32, b: f32| (a / b - 1.0).abs() < 1e-6;
    assert!(near(modes.table.despun_rad_s, usual.despun_rad_s));
    assert!(near(modes.table.diverged_rad, usual.diverged_rad));
    assert_eq!(modes.table.dipole_sigma_am2, usual.dipole_sigma_am2);
    assert_eq!((modes.table.start, modes.table.retries), (usual.start, usual.retries));
    assert!(matches!(modes.despin.law, LawParameters::BDot(_)) && modes.experiment.is_none());
}

#[test]
fn every_key_has_its_place() {
    let modes = modes(
        "start = \"safe\"\ndespun_deg_s = 0.8\ntrusted_for_s = 99\nretries = 7\n\
         growing_rounds = 40\ndetumble_needs = []\npointing_needs = [\"sun\"]\n\
         experiment_s = 600\nexperiment_next = \"off\"",
        "[modes.experiment]\nkind = \"bang-bang\"\n",
    );
    let table = modes.table;
    assert_eq!((table.start, table.experiment_next), (Mode::Safe, Mode::Off));
    assert!((table.despun_rad_s.to_degrees() - 0.8).abs() < 1e-6);
    assert_eq!((table.trusted_for_s, table.retries, table.growing_rounds), (99.0, 7, 40));
    assert_eq!(table.despin_needs, Needs { gyro: false, sun: false });
    assert_eq!(table.pointing_needs, Needs { gyro: false, sun: true });
    let experiment = modes.experiment.expect("an experiment");
    assert!(matches!(experiment.law, LawParameters::BangBang(_)));
}

#[test]
fn with_the_mekf_alone_no_dipole_is_asked_for() {
    let text = format!("{HEAD}{POINTING}[modes]\n{DETUMBLE}").replace("\"dynamic\"", "\"mekf\"");
    assert_eq!(load(&text).unwrap().flight.modes.unwrap().table.dipole_sigma_am2, None);
    let asked = text.replace("[modes]\n", "[modes]\ndipole_sigma_am2 = 0.1\n");
    let problems = load(&asked).unwrap_err();
    assert_says(&problems[0], "modes.dipole_sigma_am2", "dynamics-aided filter", "");
}

#[test]
fn numbers_that_make_no_table_are_refused_at_their_key_in_degrees() {
    refused(
        "despun_deg_s = 3",
        "",
        "modes.despun_deg_s",
        "3 is impossible: must be from 0.0006 to 2.2918",
    );
    refused("trusted_for_s = 0", "", "modes.trusted_for_s", "must be from 1 to 1000000");
    refused("captured_deg = 200", "", "modes.captured_deg", "to 180");
    refused(
        "tumbling_deg_s = 0.9",
        "",
        "modes.tumbling_deg_s",
        "must be larger than despun_deg_s, or the modes alternate",
    );
    refused("growing_rounds = 1", "", "modes.growing_rounds", "from 2 to 10000");
    refused("start = \"tumble\"", "", "modes.start", "expected one of \"off\"");
    refused("start = \"experiment\"", "", "modes.start", "there is no law for the experiment");
    refused("experiment_next = \"experiment\"", "", "modes.experiment_next", "followed by itself");
    refused("despun_rad_s = 0.01", "", "modes.despun_rad_s", "wrong unit");
}

#[test]
fn laws_that_cannot_do_what_their_mode_is_for_are_refused() {
    let says = |text: &str, key: &str, reason: &str, advice: &str| {
        let problems = load(text).expect_err("the mission was accepted");
        assert_says(&problems[0], key, reason, advice);
    };
    let pointing = POINTING.replace("[law]", "[modes.detumble]");
    says(
        &format!("{HEAD}{POINTING}[modes]\n{pointing}"),
        "modes.detumble",
        "must be a despin law",
        "",
    );
    says(
        &format!("{HEAD}[modes]\n{DETUMBLE}"),
        "law.kind",
        "must be a pointing law",
        "[law] is what flies in mode point",
    );
    let blind = HEAD.replace("[attitude]\nfilter = \"dynamic\"\n", "");
    says(
        &format!("{blind}{POINTING}[modes]\n{DETUMBLE}"),
        "modes.",
        "needs the filters",
        "add the section [attitude]",
    );
    says(&format!("{HEAD}{POINTING}[modes]\n"), "", "[modes.detumble] is missing", "");
}

#[test]
fn commands_are_modes_at_times() {
    let commands = |text: &str| with("", &format!("[commands]\n{text}"));
    let list = "at_s = [10, 20.5]\nenter = [\"off\", \"detumble\"]\ncommit_at_s = [30]";
    let scenario = commands(list).unwrap();
    let given: Vec<TimedCommand> = scenario.commands.into_iter().flatten().collect();
    let expected =
        [(20, Order::Enter(Mode::Off)), (41, Order::Enter(Mode::Detumble)), (60, Order::Commit)];
    assert_eq!(given, expected.map(|(cycle, order)| TimedCommand { cycle, order }));
    let refused = |text: &str, key: &str, reason: &str| {
        let problems = commands(text).expect_err("the mission was accepted");
        assert_says(&problems[0], key, reason, "");
    };
    refused("at_s = [10]\nenter = []", "commands.enter", "0 commands for 1 times");
    refused("at_s = [10.3]\nenter = [\"off\"]", "commands.at_s", "not the instant of a cycle");
    let late = "at_s = [10]\nenter = [\"off\"]\ncommit_at_s = [1300]";
    refused(late, "commands.commit_at_s", "not the instant of a cycle");
    refused("at_s = [1300]\nenter = [\"off\"]", "commands.at_s", "not the instant of a cycle");
    refused("at_s = [-1]\nenter = [\"off\"]", "commands.at_s", "impossible");
    refused("at_s = [1]\nenter = [\"sleep\"]", "commands.enter", "expected one of");
    let many = "1, ".repeat(9);
    let words = "\"off\", ".repeat(9);
    refused(&format!("at_s = [{many}]\nenter = [{words}]"), "commands.at_s", "more than 8");
    let without = load(&format!("{HEAD}[commands]\nat_s = [1]\nenter = [\"off\"]"));
    assert_says(&without.unwrap_err()[0], "commands.enter", "no modes to enter", "[modes]");
}

#[test]
fn the_ladder_is_what_its_section_says() {
    let ladder = |text: &str| with("", &format!("[modes.commissioning]\n{text}"));
    let of = |text: &str| ladder(text).unwrap().flight.modes.unwrap().commissioning.unwrap();
    // Nothing said: the usual.
    assert_eq!(of(""), CommissioningParameters::default());
    let text = "sun_s = [100, 200.5]\nbias_sigma_nt = 300\ngyro_sigma_deg_s = 0.1\n\
                commit = \"when-passed\"";
    let found = of(text);
    assert_eq!(found.sun, StepTime { least_s: 100.0, most_s: 200.5 });
    assert_eq!((found.bias_sigma_t, found.commit), (300e-9, Commit::WhenPassed));
    assert_eq!(found.gyro_sigma_rad_s, 0.1_f64.to_radians() as f32);
    let refused = |text: &str, key: &str, reason: &str| {
        let problems = ladder(text).expect_err("the mission was accepted");
        assert_says(&problems[0], key, reason, "");
    };
    refused("sun_s = [200, 100]", "modes.commissioning.sun_s", "must be from");
    refused("sun_s = [200]", "modes.commissioning.sun_s", "");
    refused("bias_sigma_nt = -3", "modes.commissioning.bias_sigma_nt", "must be from");
    refused("dipole_sigma_am2 = 1e9", "modes.commissioning.dipole_sigma_am2", "must be from");
    refused("commit = \"later\"", "modes.commissioning.commit", "expected one of");
    refused("wheel_s = [1, 2]", "modes.commissioning.wheel_s", "");
}

#[test]
fn a_ladder_needs_what_looks_after_the_wiring() {
    let problems = with("polarity_guard = false", "[modes.commissioning]\n");
    let problems = problems.expect_err("the mission was accepted");
    assert_says(&problems[0], "modes.polarity_guard", "active check", "");
}
