//! Where to point, as missions write it.

use adcs_app::LawParameters;
use adcs_core::control::guidance::{AimParameters, GuidanceParameters};

use crate::refused::assert_says;
use crate::workshop::{MISSION, Workshop};

const LAW: &str =
    "kind = \"b-dot\"                        # m = k (ω × B)\ngain_am2_s_per_t = 100_000 ";
const POINTING: &str =
    "kind = \"cross-product\"\nstiffness_n_m_per_rad = 1e-7\ndamping_n_m_s = 2e-4\n";

/// The mission, pointing by these keys.
fn pointing(keys: &str) -> Workshop {
    let workshop = Workshop::new();
    workshop.change(MISSION, LAW, &format!("{POINTING}{keys} "));
    workshop
}

fn guidance(keys: &str) -> GuidanceParameters {
    let mission = pointing(keys).load().unwrap_or_else(|problems| panic!("{problems:#?}"));
    match mission.scenario.flight.law {
        LawParameters::CrossProduct { guidance, .. } => guidance,
        other => panic!("{other:?}"),
    }
}

#[test]
fn each_target_has_its_keys() {
    let nadir = guidance("target = \"nadir\"\nslew_deg_s = 0.1");
    assert_eq!(nadir.aim, AimParameters::Nadir);
    assert!((nadir.slew_rad_s.unwrap().to_degrees() - 0.1).abs() < 1e-6);

    let held = guidance("target = \"inertial\"\ntarget_attitude_xyzw = [0, 0, 0.6, 0.8]");
    let attitude_xyzw = [0.0, 0.0, 0.6, 0.8];
    assert_eq!(held.aim, AimParameters::Inertial { attitude_xyzw });
    assert_eq!(held.slew_rad_s, None);

    let sun = guidance(
        "target = \"sun\"\nboresight = [0, -1, 0]\nsecond_axis = [1, 0, 0]\nspin_deg_s = 0.5",
    );
    let AimParameters::Sun(sun) = sun.aim else { panic!("{sun:?}") };
    assert!((sun.spin_rad_s.to_degrees() - 0.5).abs() < 1e-6);
    assert_eq!((sun.axes.boresight, sun.axes.second), ([0.0, -1.0, 0.0], [1.0, 0.0, 0.0]));
}

#[test]
fn a_site_is_given_in_degrees_and_looked_at_along_z() {
    let site = guidance("target = \"site\"\nsite_latitude_deg = 35.7\nsite_longitude_deg = 140.02");
    let AimParameters::Site(site) = site.aim else { panic!("{site:?}") };
    assert!((site.latitude_rad.to_degrees() - 35.7).abs() < 1e-12);
    assert!((site.longitude_rad.to_degrees() - 140.02).abs() < 1e-12);
    assert_eq!((site.height_m, site.least_elevation_rad), (0.0, 0.0));
    assert_eq!((site.axes.boresight, site.axes.second), ([0.0, 0.0, 1.0], [0.0, 1.0, 0.0]));
}

#[test]
fn what_is_no_target_is_refused_at_its_key() {
    let site = "target = \"site\"\nsite_latitude_deg = 35\nsite_longitude_deg = 140\n";
    let with_site = |more: &str| format!("{site}{more}");
    let cases = [
        ("target = \"moon\"".to_owned(), "law.target", "expected one of \"nadir\""),
        (String::new(), "law.target", "is missing"),
        (
            "target = \"nadir\"\nslew_deg_s = 0".to_owned(),
            "law.slew_deg_s",
            "must be positive and finite",
        ),
        (
            "target = \"nadir\"\nspin_deg_s = 1".to_owned(),
            "law.spin_deg_s",
            "has no meaning with this target",
        ),
        ("target = \"inertial\"".to_owned(), "law.target_attitude_xyzw", "is missing"),
        (
            "target = \"sun\"\nspin_deg_s = 10".to_owned(),
            "law.spin_deg_s",
            "must be within 0.157 rad/s",
        ),
        (
            "target = \"sun\"\nboresight = [0, 1, 0]\nsecond_axis = [0, 2, 0.1]".to_owned(),
            "law.second_axis",
            "at least 5.7 deg apart",
        ),
        (
            "target = \"site\"\nsite_latitude_deg = 91\nsite_longitude_deg = 0".to_owned(),
            "law.site_latitude_deg",
            "within 90 deg",
        ),
        (
            "target = \"site\"\nsite_latitude_deg = 0\nsite_longitude_deg = 361".to_owned(),
            "law.site_longitude_deg",
            "within 180 deg",
        ),
        (with_site("site_height_m = 615_000"), "law.site_height_m", "from -1000 to 10000 m"),
        (
            with_site("least_elevation_deg = 90"),
            "law.least_elevation_deg",
            "from 0 to below 90 deg",
        ),
        (with_site("site_height_km = 0.1"), "law.site_height_km", "wrong unit"),
    ];
    for (keys, key, reason) in cases {
        assert_says(&pointing(&keys).problem(), key, reason, "");
    }
}

#[test]
fn a_despin_law_has_no_target() {
    let workshop = Workshop::new();
    workshop.change(MISSION, LAW, &format!("{LAW}\ntarget = \"nadir\" "));
    assert_says(&workshop.problem(), "law.target", "has no meaning with this kind", "remove it");
}
