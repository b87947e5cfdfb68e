//! What a TLE says, for people and for programs.

use std::f64::consts::TAU;
use std::fmt;

use adcs_core::time::{MICROS_PER_DAY, Utc};
use serde::Serialize;
use sgp4_lite::{
    Elements, MinutesSinceEpoch, PlausibilityLimits, Propagator, TleError, TleText,
    check_plausibility,
};

use crate::span::utc_of_epoch;
use crate::tle_file::place;

/// The elements of a TLE and what follows from them at first sight.
///
/// Serialised, the fields have the names they have in [`Elements`], each with its unit.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TleReport {
    valid: bool,
    /// From the line above, if there is one.
    name: Option<String>,
    norad_id: u32,
    classification: char,
    international_designator: String,
    epoch_utc: String,
    mean_motion_dot_over_2_rev_per_day2: f64,
    mean_motion_ddot_over_6_rev_per_day3: f64,
    bstar_per_earth_radius: f64,
    inclination_deg: f64,
    raan_deg: f64,
    eccentricity: f64,
    argument_of_perigee_deg: f64,
    mean_anomaly_deg: f64,
    mean_motion_rev_per_day: f64,
    element_set_number: u16,
    revolution_number: u32,
    period_min: f64,
    perigee_height_km: f64,
    apogee_height_km: f64,
    /// Since the epoch, when it was asked whether the elements can be used now.
    age_days: Option<f64>,
    /// Why they cannot.
    implausible: Option<String>,
    /// What is suspicious about an orbit that is written without fault.
    warnings: Vec<String>,
}

/// When the elements are to be used, and how old they may be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Use {
    /// The instant.
    pub now: Utc,
    /// The greatest distance of the epoch from it.
    pub max_days: f64,
}

impl TleReport {
    /// The report on the elements that were decoded from `text`, and on their use if there is one.
    pub fn new(text: &[u8], elements: &Elements, intended: Option<Use>) -> Self {
        const MINUTES_PER_DAY: f64 = 1440.0;
        let epoch = utc_of_epoch(elements.epoch);
        let name = TleText::split(text).ok().and_then(|text| text.name).map(str::to_owned);
        let [perigee_height_km, apogee_height_km] = heights_km(elements);
        Self {
            valid: true,
            name,
            norad_id: elements.norad_id,
            classification: elements.classification.letter(),
            international_designator: elements.international_designator.to_string(),
            epoch_utc: epoch.to_string(),
            mean_motion_dot_over_2_rev_per_day2: elements.mean_motion_dot_over_2_rev_per_day2,
            mean_motion_ddot_over_6_rev_per_day3: elements.mean_motion_ddot_over_6_rev_per_day3,
            bstar_per_earth_radius: elements.bstar_per_earth_radius,
            inclination_deg: elements.inclination_deg,
            raan_deg: elements.raan_deg,
            eccentricity: elements.eccentricity,
            argument_of_perigee_deg: elements.argument_of_perigee_deg,
            mean_anomaly_deg: elements.mean_anomaly_deg,
            mean_motion_rev_per_day: elements.mean_motion_rev_per_day,
            element_set_number: elements.element_set_number,
            revolution_number: elements.revolution_number,
            period_min: MINUTES_PER_DAY / elements.mean_motion_rev_per_day,
            perigee_height_km,
            apogee_height_km,
            age_days: intended.map(|Use { now, .. }| days(now) - days(epoch)),
            implausible: intended.and_then(|intended| why_implausible(elements, intended)),
            warnings: warnings(elements),
        }
    }

    /// What is suspicious about the orbit.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// Why the elements cannot be used when they are to be.
    pub fn implausible(&self) -> Option<&str> {
        self.implausible.as_deref()
    }
}

/// Days since 2000-01-01 00:00.
fn days(utc: Utc) -> f64 {
    utc.micros_since_2000() as f64 / MICROS_PER_DAY as f64
}

fn why_implausible(elements: &Elements, intended: Use) -> Option<String> {
    let limits = PlausibilityLimits::within_days(intended.max_days);
    let checked = check_plausibility(elements, days(intended.now), &limits);
    checked.err().map(|implausible| implausible.to_string())
}

/// Heights of perigee and apogee over the equatorial radius, from the mean motion by Kepler's third
/// law: good to some kilometres.
fn heights_km(elements: &Elements) -> [f64; 2] {
    /// WGS72, as in SGP4: GM in km³/s², equatorial radius in km.
    const GRAVITATION_KM3_S2: f64 = 398_600.8;
    const EARTH_RADIUS_KM: f64 = 6378.135;
    const SECONDS_PER_DAY: f64 = 86_400.0;
    let rad_per_s = elements.mean_motion_rev_per_day * TAU / SECONDS_PER_DAY;
    let semi_major_axis_km = (GRAVITATION_KM3_S2 / (rad_per_s * rad_per_s)).cbrt();
    let e = elements.eccentricity;
    [1.0 - e, 1.0 + e].map(|part| semi_major_axis_km * part - EARTH_RADIUS_KM)
}

fn warnings(elements: &Elements) -> Vec<String> {
    let at_epoch = Use { now: utc_of_epoch(elements.epoch), max_days: 1.0 };
    let mut warnings: Vec<_> = why_implausible(elements, at_epoch).into_iter().collect();
    let state = Propagator::new(elements)
        .and_then(|propagator| propagator.propagate(MinutesSinceEpoch(0.0)));
    if let Err(error) = state {
        warnings.push(format!("SGP4 has no state at the epoch: {error}"));
    }
    warnings
}

impl fmt::Display for TleReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut line = |label: &str, value: &dyn fmt::Display, unit: &str| {
            writeln!(f, "{}", format!("{label:<34} {value} {unit}").trim_end())
        };
        line("name", &self.name.as_deref().unwrap_or("-"), "")?;
        line("satellite number", &self.norad_id, "")?;
        line("classification", &self.classification, "")?;
        line("international designator", &self.international_designator, "")?;
        line("epoch", &self.epoch_utc, "")?;
        line("half of dn/dt", &self.mean_motion_dot_over_2_rev_per_day2, "rev/day^2")?;
        line("a sixth of d2n/dt2", &self.mean_motion_ddot_over_6_rev_per_day3, "rev/day^3")?;
        line("drag coefficient B*", &self.bstar_per_earth_radius, "1/Earth radius")?;
        line("inclination", &self.inclination_deg, "deg")?;
        line("right ascension of ascending node", &self.raan_deg, "deg")?;
        line("eccentricity", &self.eccentricity, "")?;
        line("argument of perigee", &self.argument_of_perigee_deg, "deg")?;
        line("mean anomaly", &self.mean_anomaly_deg, "deg")?;
        line("mean motion", &self.mean_motion_rev_per_day, "rev/day")?;
        line("element set", &self.element_set_number, "")?;
        line("revolution at epoch", &self.revolution_number, "")?;
        line("period", &format_args!("{:.3}", self.period_min), "min")?;
        line("height of perigee, about", &format_args!("{:.0}", self.perigee_height_km), "km")?;
        line("height of apogee, about", &format_args!("{:.0}", self.apogee_height_km), "km")?;
        match self.age_days {
            Some(age_days) => line("age", &format_args!("{age_days:.3}"), "days"),
            None => Ok(()),
        }
    }
}

/// Why a TLE is wrong, for programs.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TleRefusal {
    valid: bool,
    /// 1 or 2, 0 for the name line; `null` when no line can be named.
    line: Option<u8>,
    /// From 1.
    first_column: Option<usize>,
    last_column: Option<usize>,
    message: String,
}

impl From<&TleError> for TleRefusal {
    fn from(error: &TleError) -> Self {
        let place = place(error);
        Self {
            valid: false,
            line: place.map(|place| place.line),
            first_column: place.map(|place| place.first_column),
            last_column: place.map(|place| place.last_column),
            message: error.to_string(),
        }
    }
}
