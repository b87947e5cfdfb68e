//! Keys of the pointing laws that say where to point and how to get there.

use adcs_app::ParameterError;
use adcs_core::control::guidance::{
    AimError, AimParameters, BodyAxesParameters, GuidanceParameters, SiteParameters,
    SunAimParameters,
};

use super::section::Section;
use super::typed::{Check, FINITE, POSITIVE};

pub(super) const TARGET: &str = "target";
const ATTITUDE: &str = "target_attitude_xyzw";
const BORESIGHT: &str = "boresight";
const SECOND: &str = "second_axis";
const SPIN: &str = "spin_deg_s";
const LATITUDE: &str = "site_latitude_deg";
const LONGITUDE: &str = "site_longitude_deg";
const HEIGHT: &str = "site_height_m";
const ELEVATION: &str = "least_elevation_deg";
const SLEW: &str = "slew_deg_s";

/// All of them, and which targets understand each; every target when none is named.
const KEYS: [(&str, &[Target]); 10] = [
    (TARGET, &[]),
    (ATTITUDE, &[Target::Inertial]),
    (BORESIGHT, &[Target::Sun, Target::Site]),
    (SECOND, &[Target::Sun, Target::Site]),
    (SPIN, &[Target::Sun]),
    (LATITUDE, &[Target::Site]),
    (LONGITUDE, &[Target::Site]),
    (HEIGHT, &[Target::Site]),
    (ELEVATION, &[Target::Site]),
    (SLEW, &[]),
];

/// The names of all of them.
pub(super) const NAMES: [&str; 10] = {
    let mut names = [""; 10];
    let mut at = 0;
    while at < KEYS.len() {
        names[at] = KEYS[at].0;
        at += 1;
    }
    names
};

#[derive(Clone, Copy, PartialEq)]
enum Target {
    Nadir,
    Inertial,
    Sun,
    Site,
}

const LATITUDE_DEG: Check = Check::new(|x| x.abs() <= 90.0, "within 90 deg");
const LONGITUDE_DEG: Check = Check::new(|x| x.abs() <= 180.0, "within 180 deg");
const ELEVATION_DEG: Check = Check::new(|x| (0.0..90.0).contains(&x), "from 0 to below 90 deg");

pub(super) fn guidance(section: &Section) -> Option<GuidanceParameters> {
    let targets = [
        ("nadir", Target::Nadir),
        ("inertial", Target::Inertial),
        ("sun", Target::Sun),
        ("site", Target::Site),
    ];
    let Some(target) = section.choice(TARGET, &targets) else {
        // Not known which of them are wanted, so none is called unknown.
        for key in NAMES {
            let _ = section.has(key);
        }
        return None;
    };
    for (key, understood) in KEYS {
        if !understood.is_empty() && !understood.contains(&target) {
            section.meaningless(key, TARGET);
        }
    }
    let slew_rad_s = if section.has(SLEW) {
        section.number(SLEW, POSITIVE).map(|rate| Some(rate.to_radians() as f32))
    } else {
        Some(None)
    };
    let aim = match target {
        Target::Nadir => Some(AimParameters::Nadir),
        Target::Inertial => section.quaternion(ATTITUDE).map(|xyzw| AimParameters::Inertial {
            attitude_xyzw: xyzw.map(|component| component as f32),
        }),
        Target::Sun => sun(section).map(AimParameters::Sun),
        Target::Site => site(section).map(AimParameters::Site),
    };
    Some(GuidanceParameters { aim: aim?, slew_rad_s: slew_rad_s? })
}

fn sun(section: &Section) -> Option<SunAimParameters> {
    let axes = axes(section);
    let spin_rad_s = section.number_or(SPIN, FINITE, 0.0)?.to_radians() as f32;
    Some(SunAimParameters { axes: axes?, spin_rad_s })
}

fn site(section: &Section) -> Option<SiteParameters> {
    let axes = axes(section);
    let latitude = section.number(LATITUDE, LATITUDE_DEG);
    let longitude = section.number(LONGITUDE, LONGITUDE_DEG);
    let height_m = section.number_or(HEIGHT, FINITE, 0.0);
    let elevation = section.number_or(ELEVATION, ELEVATION_DEG, 0.0);
    Some(SiteParameters {
        axes: axes?,
        latitude_rad: latitude?.to_radians(),
        longitude_rad: longitude?.to_radians(),
        height_m: height_m?,
        least_elevation_rad: elevation?.to_radians() as f32,
    })
}

fn axes(section: &Section) -> Option<BodyAxesParameters> {
    let usual = BodyAxesParameters::default();
    let boresight = section.vector_or(BORESIGHT, FINITE, usual.boresight.map(f64::from));
    let second = section.vector_or(SECOND, FINITE, usual.second.map(f64::from));
    let single = |axis: [f64; 3]| axis.map(|x| x as f32);
    Some(BodyAxesParameters { boresight: single(boresight?), second: single(second?) })
}

/// The key at which the flight software's refusal of an aim is reported.
pub(super) fn key_of(error: &ParameterError) -> Option<&'static str> {
    let ParameterError::Aim(error) = error else { return None };
    Some(match error {
        AimError::Attitude => ATTITUDE,
        AimError::Axes => SECOND,
        AimError::Spin { .. } => SPIN,
        AimError::Latitude { .. } => LATITUDE,
        AimError::Longitude { .. } => LONGITUDE,
        AimError::Height { .. } => HEIGHT,
        AimError::Elevation { .. } => ELEVATION,
        AimError::Slew { .. } => SLEW,
        _ => TARGET,
    })
}
