//! `adcs certify` and the study of pointing: what is stable is stable in the simulator too.

mod support;

use std::fs;
use std::path::Path;

use adcs_app::LawParameters;
use adcs_ground::certify::{Body, Loop, multiplier};
use adcs_ground::study::pointing::case::{Case, Knowledge, Law};
use adcs_ground::study::pointing::flight;
use adcs_ground::study::sprout;
use support::{adcs, errors_of};

/// A case's law and rounds over SPROUT's own orbit.
fn multiplier_of(case: &Case, stiffness: Option<f32>) -> f64 {
    let flight = case.parameters().unwrap();
    let mut law = flight.law;
    if let (LawParameters::CrossProduct { law, .. }, Some(stiffness)) = (&mut law, stiffness) {
        law.stiffness_n_m_per_rad = stiffness;
    }
    let lp = Loop::new(&law, flight.schedule.round()).unwrap();
    multiplier(&lp, &sprout::elements().unwrap(), &Body { moments: [1.0; 3] }).unwrap()
}

/// Largest angle in the last orbit and a half of a flight with perfect knowledge, deg.
fn flown(case: &Case) -> f32 {
    let flown = flight::fly(case, 4.5, 3).unwrap();
    let late = flown.angles_deg.len() * 2 / 5;
    flown.angles_deg[late..].iter().copied().fold(0.0, f32::max)
}

#[test]
fn the_law_that_is_certified_holds_and_the_one_that_is_not_tumbles() {
    let shipped = Case::named("law-alone").unwrap();
    assert_eq!(shipped.law, Law::Periodic);
    assert_eq!(shipped.knowledge, Knowledge::Truth { dipole_share: 1.0 });
    assert!(multiplier_of(&shipped, None) < 0.3);
    assert!(flown(&shipped) < 3.0);

    // Eight times the stiffness that is stable (docs/control).
    let stiff =
        Case { stiffness_n_m_per_rad: 1.2e-6, ..Case::named("cross-product-alone").unwrap() };
    assert!(multiplier_of(&stiff, None) > 3.0);
    assert!(flown(&stiff) > 45.0);
}

/// A mission of this repository.
fn mission(name: &str) -> String {
    format!("{}/../../missions/sprout/{name}.toml", env!("CARGO_MANIFEST_DIR"))
}

#[test]
fn a_certificate_is_written_and_missions_are_held_against_it() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("certify");
    let out = folder.to_str().unwrap();
    let (nadir, certificate) = (mission("nadir"), folder.join("certificate.json"));
    let grid = ["--inclinations", "97,98.5", "--altitudes", "600,640", "--seasons", "0"];
    let made = adcs("certify", &[&[nadir.as_str(), "--out", out], &grid[..]].concat(), "");
    assert!(made.status.success(), "{}", errors_of(&made));
    let said = String::from_utf8(made.stdout).unwrap();
    assert!(said.contains("stable everywhere"), "{said}");
    let svg = fs::read_to_string(folder.join("certificate.svg")).unwrap();
    assert!(svg.contains("<svg") && svg.contains("inclination, deg"));

    let file = certificate.to_str().unwrap();
    let check = |name: &str| adcs("mission", &["check", &mission(name), "--certificate", file], "");
    let same = check("nadir");
    assert!(same.status.success() && !errors_of(&same).contains("warning"), "{}", errors_of(&same));
    let other = check("nadir-cross-product");
    let said = errors_of(&other);
    assert!(other.status.success() && said.contains("not those certified for nadir"), "{said}");
    // What is not a certificate.
    fs::write(&certificate, "{}").unwrap();
    let said = errors_of(&check("nadir"));
    assert!(said.contains("is not a certificate"), "{said}");
}

#[test]
fn a_law_that_does_not_point_has_nothing_to_be_certified() {
    let refused = adcs("certify", &[&mission("despin-calibrated")], "");
    let said = errors_of(&refused);
    assert!(!refused.status.success() && said.contains("does not point"), "{said}");
}

#[test]
fn one_flight_through_the_flight_code_points_within_the_figures_of_the_study() {
    // All cycles of three orbits; the mean of 100 flights is 0.6 deg, the worst 0.9.
    let flown = flight::fly(&Case::named("plain").unwrap(), 5.0, 1).unwrap();
    assert!(flown.mean_deg() < 1.5, "{} deg", flown.mean_deg());
    assert!(flown.captured_orbits.is_some_and(|orbits| orbits < 1.5));
}
