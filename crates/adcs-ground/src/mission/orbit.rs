//! Sections `orbit` and `start`: where the satellite is, since when, and how it turns.

use adcs_core::orbit::OrbitModel;
use adcs_core::time::{Utc, UtcError};
use sgp4_lite::{Elements, TleError};

use super::problem::{Fault, Place};
use super::section::Section;
use super::typed::Check;

/// Mean elements older than this do not say where a satellite in low orbit is.
const MAX_AGE_S: f64 = 30.0 * 86_400.0;

/// The simulation's steps follow a turn a second; no satellite in one piece turns faster.
const RATE_DEG_S: Check = Check::new(|x| x.abs() <= 360.0, "within 360 deg/s");

/// The orbit.
pub(super) struct Orbit {
    pub tle: [String; 2],
    pub elements: Elements,
    pub epoch: Utc,
}

pub(super) fn orbit(root: &Section) -> Option<Orbit> {
    let section = root.section("orbit")?;
    let lines = section.two_lines("tle");
    section.finish();
    let [line1, line2] = lines?;
    let elements = match Elements::from_tle(&line1.0, &line2.0) {
        Ok(elements) => elements,
        Err(error) => {
            let place = place_of(&error, [line1.1, line2.1], section.place_of("tle"));
            let advice = match error {
                TleError::Checksum { .. } => "a digit of the line is wrong: copy it again",
                TleError::Length { .. } => "copy both lines whole, without blanks around them",
                _ => "",
            };
            let fault = Fault::advising(format!("not a TLE: {error}"), advice);
            section.refuse_at(place, "tle", fault);
            return None;
        }
    };
    match OrbitModel::new(&elements) {
        Ok(model) => Some(Orbit { tle: [line1.0, line2.0], elements, epoch: model.epoch() }),
        Err(error) => {
            section.refuse("tle", Fault::new(format!("SGP4 cannot start from it: {error}")));
            None
        }
    }
}

/// Where in the file an error of the TLE stands: its line, and in that its columns.
fn place_of(error: &TleError, lines: [Place; 2], both: Place) -> Place {
    let (line, first, last) = match *error {
        TleError::Length { line, .. } => (line, 1, 0),
        TleError::LineNumber { line, .. } => (line, 1, 1),
        TleError::Character { line, column, .. } => (line, column, column),
        TleError::EphemerisType { .. } => (1, 63, 63),
        TleError::Checksum { line, .. } => (line, 69, 69),
        TleError::SatelliteNumber { .. } => (2, 3, 7),
        TleError::DayOfYear { .. } => (1, 21, 23),
        TleError::Range { line, first_column, last_column, .. } => {
            (line, first_column, last_column)
        }
        _ => return both,
    };
    let whole = if line == 2 { lines[1] } else { lines[0] };
    let start = whole.start + usize::from(first) - 1;
    let end = if last == 0 { whole.end - 1 } else { whole.start + usize::from(last) };
    Place { start, end: end.max(start), ..whole }
}

/// The first instant.
pub(super) struct Start {
    pub utc: Utc,
    pub attitude_xyzw: [f64; 4],
    pub rate_rad_s: [f64; 3],
}

pub(super) fn start(root: &Section, orbit: Option<&Orbit>) -> Option<Start> {
    let section = root.section("start")?;
    let utc = instant(&section, orbit);
    let attitude_xyzw = section.quaternion("attitude_xyzw");
    let rate_deg_s = section.vector("rate_deg_s", RATE_DEG_S);
    section.finish();
    Some(Start {
        utc: utc?,
        attitude_xyzw: attitude_xyzw?,
        rate_rad_s: rate_deg_s?.map(f64::to_radians),
    })
}

fn instant(section: &Section, orbit: Option<&Orbit>) -> Option<Utc> {
    let key = section.either("utc", "after_tle_epoch_s")?;
    if key == "after_tle_epoch_s" {
        let micros = section.micros(key, -MAX_AGE_S..=MAX_AGE_S)?;
        return orbit.map(|orbit| orbit.epoch.plus_micros(micros));
    }
    let text = section.time(key)?;
    let utc = match Utc::parse(&text) {
        Ok(utc) => utc,
        Err(error) => {
            let advice = match error {
                UtcError::Form { .. } => {
                    "year-month-day, T, hours:minutes:seconds, and Z for UTC at the end"
                }
                _ => "",
            };
            section.refuse(key, Fault::advising(format!("{text:?}: {error}"), advice));
            return None;
        }
    };
    let epoch = orbit?.epoch;
    let age_s = utc.seconds_since(epoch);
    if age_s.abs() > MAX_AGE_S {
        let reason = format!(
            "{:.1} days from the TLE's epoch, {epoch}: SGP4 does not know the orbit then",
            age_s / 86_400.0
        );
        let advice = format!(
            "start within {:.0} days of the epoch, or give a TLE of that time",
            MAX_AGE_S / 86_400.0
        );
        section.refuse(key, Fault::advising(reason, advice));
        return None;
    }
    Some(utc)
}
