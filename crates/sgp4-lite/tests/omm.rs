//! Orbit Mean-Elements Messages: what is read, and what is refused at which line and keyword.

mod common;

use sgp4_lite::{Classification, Elements, Epoch, InternationalDesignator, OmmError};

/// A message with all keywords that are used, some that are not, units and comments.
const MESSAGE: &str = "\
CCSDS_OMM_VERS = 3.0
COMMENT Made for this test.
CREATION_DATE = 2020-04-07T00:00:00
ORIGINATOR = TEST

OBJECT_NAME = ISS (ZARYA)
OBJECT_ID = 1998-067A
CENTER_NAME = EARTH
REF_FRAME = TEME
TIME_SYSTEM = UTC
MEAN_ELEMENT_THEORY = SGP/SGP4
COMMENT
EPOCH = 2020-04-06T19:53:20.932800
MEAN_MOTION = 15.48685836 [rev/day]
ECCENTRICITY = 0.000388
INCLINATION = 51.6465 [deg]
RA_OF_ASC_NODE = 341.5807 [deg]
ARG_OF_PERICENTER = 94.4223 [deg]
MEAN_ANOMALY = 26.1197 [deg]
GM = 398600.8 [km**3/s**2]
EPHEMERIS_TYPE = 0
CLASSIFICATION_TYPE = U
NORAD_CAT_ID = 25544
ELEMENT_SET_NO = 999
REV_AT_EPOCH = 22095
BSTAR = 2.4271e-5 [1/ER]
MEAN_MOTION_DOT = 8.74E-6 [rev/day**2]
MEAN_MOTION_DDOT = 0 [REV/DAY**3]
USER_DEFINED_EARTH_MODEL = WGS-84
";

const REQUIRED: [&str; 13] = [
    "CENTER_NAME",
    "REF_FRAME",
    "TIME_SYSTEM",
    "MEAN_ELEMENT_THEORY",
    "EPOCH",
    "MEAN_MOTION",
    "ECCENTRICITY",
    "INCLINATION",
    "RA_OF_ASC_NODE",
    "ARG_OF_PERICENTER",
    "MEAN_ANOMALY",
    "NORAD_CAT_ID",
    "BSTAR",
];

fn key_of(line: &str) -> &str {
    line.split(" =").next().unwrap_or_default()
}

/// The message with one line replaced, and the number of that line.
fn with_value(key: &str, value: &str) -> (String, u32) {
    let number = MESSAGE.lines().position(|line| key_of(line) == key).expect("a line") + 1;
    let lines = MESSAGE.lines().map(|line| match key_of(line) == key {
        true => format!("{key} = {value}\n"),
        false => format!("{line}\n"),
    });
    (lines.collect(), number as u32)
}

fn expected() -> Elements {
    Elements {
        norad_id: 25544,
        classification: Classification::Unclassified,
        international_designator: InternationalDesignator::from_columns(*b"98067A  ").unwrap(),
        epoch: Epoch::from_calendar(2020, 4, 6, 71_600_932_800).unwrap(),
        mean_motion_dot_over_2_rev_per_day2: 8.74e-6,
        mean_motion_ddot_over_6_rev_per_day3: 0.0,
        bstar_per_earth_radius: 2.4271e-5,
        inclination_deg: 51.6465,
        raan_deg: 341.5807,
        eccentricity: 0.000_388,
        argument_of_perigee_deg: 94.4223,
        mean_anomaly_deg: 26.1197,
        mean_motion_rev_per_day: 15.486_858_36,
        element_set_number: 999,
        revolution_number: 22095,
    }
}

#[test]
fn a_whole_message_is_read() {
    assert_eq!(Elements::from_omm(MESSAGE), Ok(expected()));
    assert_eq!(Elements::from_omm(MESSAGE.replace('\n', "\r\n")), Ok(expected()));
    assert_eq!(Elements::from_omm(MESSAGE.trim_end()), Ok(expected()));
    assert_eq!(Elements::from_omm(MESSAGE.replace(" = ", "=")), Ok(expected()));
    assert_eq!(Elements::from_omm(MESSAGE.replace(" = ", "   =  ")), Ok(expected()));
}

#[test]
fn the_same_elements_come_from_the_tle_and_from_the_omm() {
    let tle = Elements::from_tle(
        "1 25544U 98067A   20097.82871450  .00000874  00000-0  24271-4 0  9992",
        "2 25544  51.6465 341.5807 0003880  94.4223  26.1197 15.48685836220958",
    );
    assert_eq!(tle, Ok(expected()));
}

#[test]
fn keywords_come_in_any_order_after_the_version() {
    let mut lines: Vec<_> = MESSAGE.lines().collect();
    lines[1..].reverse();
    assert_eq!(Elements::from_omm(lines.join("\n")), Ok(expected()));
    lines.swap(0, 1);
    assert_eq!(Elements::from_omm(lines.join("\n")), Err(OmmError::NoVersion { line: 1 }));
}

#[test]
fn what_a_tle_has_besides_the_orbit_may_be_left_out() {
    let kept = |line: &&str| REQUIRED.contains(&key_of(line)) || key_of(line) == "CCSDS_OMM_VERS";
    let short: Vec<_> = MESSAGE.lines().filter(kept).collect();
    let elements = Elements::from_omm(short.join("\n")).unwrap();
    let expected = Elements {
        international_designator: InternationalDesignator::BLANK,
        mean_motion_dot_over_2_rev_per_day2: 0.0,
        element_set_number: 0,
        revolution_number: 0,
        ..expected()
    };
    assert_eq!(elements, expected);
}

#[test]
fn each_required_keyword_is_missed_by_name() {
    for required in REQUIRED {
        let short: Vec<_> = MESSAGE.lines().filter(|line| key_of(line) != required).collect();
        assert_eq!(Elements::from_omm(short.join("\n")), Err(OmmError::Missing { key: required }));
    }
    assert_eq!(Elements::from_omm(""), Err(OmmError::Missing { key: "CCSDS_OMM_VERS" }));
}

#[test]
fn every_keyword_may_stand_once() {
    let last = MESSAGE.lines().count() as u32 + 1;
    for line in MESSAGE.lines() {
        let key = key_of(line);
        if line.contains('=') && !key.starts_with("USER_DEFINED_") {
            let refused = Elements::from_omm(format!("{MESSAGE}{line}"));
            let duplicate = |error| matches!(error, OmmError::Duplicate { line, key: named } if line == last && named == key);
            assert!(refused.is_err_and(duplicate), "{key}");
        }
    }
}

#[test]
fn messages_of_other_kinds_are_refused() {
    for (key, value) in [
        ("CCSDS_OMM_VERS", "1.0"),
        ("CENTER_NAME", "MARS BARYCENTER"),
        ("REF_FRAME", "GCRF"),
        ("REF_FRAME", "TEMEOFDATE"),
        ("TIME_SYSTEM", "TAI"),
        ("MEAN_ELEMENT_THEORY", "SGP4-XP"),
        ("MEAN_ELEMENT_THEORY", "DSST"),
        ("EPHEMERIS_TYPE", "4"),
        ("CLASSIFICATION_TYPE", "X"),
        ("CLASSIFICATION_TYPE", "UU"),
        ("OBJECT_ID", "1998-67A"),
        ("OBJECT_ID", "1956-067A"),
        ("OBJECT_ID", "1998-067ABCD"),
        ("OBJECT_ID", "98067A"),
        ("EPOCH", "2020-04-06"),
        ("EPOCH", "2020-04-31T00:00:00"),
        ("NORAD_CAT_ID", "-5"),
        ("NORAD_CAT_ID", "1000000000"),
        ("NORAD_CAT_ID", "99999999999999999999"),
        ("NORAD_CAT_ID", "T0001"),
        ("NORAD_CAT_ID", ""),
        ("ELEMENT_SET_NO", "10000"),
        ("REV_AT_EPOCH", "1.5"),
        ("ECCENTRICITY", ""),
        ("ECCENTRICITY", "inf"),
        ("ECCENTRICITY", "nan"),
        ("ECCENTRICITY", "0x1"),
        ("ECCENTRICITY", "0.1.2"),
        ("ECCENTRICITY", "0,1"),
        ("ECCENTRICITY", "0.1 0.2"),
    ] {
        let (message, at) = with_value(key, value);
        let named = |error: &OmmError| matches!(*error, OmmError::Value { line, key: named, .. } if line == at && named == key);
        let refused = Elements::from_omm(message);
        assert!(refused.as_ref().is_err_and(named), "{key} = {value}: {refused:?}");
    }
}

#[test]
fn impossible_numbers_are_refused_with_their_value() {
    for (key, text, value) in [
        ("MEAN_MOTION", "0", 0.0),
        ("MEAN_MOTION", "-15", -15.0),
        ("MEAN_MOTION", "18.1", 18.1),
        ("ECCENTRICITY", "1", 1.0),
        ("ECCENTRICITY", "-1E-9", -1e-9),
        ("INCLINATION", "180.1", 180.1),
        ("RA_OF_ASC_NODE", "-0.1", -0.1),
        ("ARG_OF_PERICENTER", "360.1", 360.1),
        ("MEAN_ANOMALY", "1e9999", f64::INFINITY),
        ("BSTAR", "-1e9999", f64::NEG_INFINITY),
        ("MEAN_MOTION_DOT", "1e400", f64::INFINITY),
        ("MEAN_MOTION_DDOT", "-1e400", f64::NEG_INFINITY),
    ] {
        let (message, line) = with_value(key, text);
        let named = |error: &OmmError| matches!(*error, OmmError::Range { line: at, key: named, value: found } if at == line && named == key && found == value);
        let refused = Elements::from_omm(message);
        assert!(refused.as_ref().is_err_and(named), "{key} = {text}: {refused:?}");
    }
}

#[test]
fn wrong_units_are_refused() {
    for (key, value, unit) in [
        ("MEAN_MOTION", "15.5 [deg/s]", "rev/day"),
        ("MEAN_MOTION", "15.5 [rev/day", "rev/day"),
        ("INCLINATION", "51 [rad]", "deg"),
        ("INCLINATION", "51 []", "deg"),
        ("BSTAR", "0 [m**2/kg]", "1/ER"),
        ("ECCENTRICITY", "0 [deg]", ""),
    ] {
        let (message, at) = with_value(key, value);
        let named = |error: &OmmError| matches!(*error, OmmError::Unit { line, key: named, expected } if line == at && named == key && expected == unit);
        let refused = Elements::from_omm(message);
        assert!(refused.as_ref().is_err_and(named), "{key} = {value}: {refused:?}");
    }
}

#[test]
fn lines_that_do_not_belong_are_refused_with_their_number() {
    let line = MESSAGE.lines().count() as u32 + 1;
    for (text, error) in [
        ("META_START", OmmError::NotAnAssignment { line }),
        ("COMMENTARY", OmmError::NotAnAssignment { line }),
        ("MEAN_MOTION_DDDOT = 0", OmmError::UnknownKey { line }),
        ("mass = 5", OmmError::UnknownKey { line }),
        ("= 5", OmmError::UnknownKey { line }),
        ("SEMI_MAJOR_AXIS = 6800 [km]", OmmError::Unsupported { line, key: "SEMI_MAJOR_AXIS" }),
        ("BTERM = 0.1", OmmError::Unsupported { line, key: "BTERM" }),
        ("AGOM = 0.1", OmmError::Unsupported { line, key: "AGOM" }),
        ("MASS = 5 \u{7f}", OmmError::Character { line, column: 10, found: 0x7F }),
        ("COMMENT \u{e4}", OmmError::Character { line, column: 9, found: 0xC3 }),
        ("\tMASS = 5", OmmError::Character { line, column: 1, found: b'\t' }),
    ] {
        assert_eq!(Elements::from_omm(format!("{MESSAGE}{text}\n")), Err(error), "{text}");
    }
    assert_eq!(
        Elements::from_omm(format!("{MESSAGE}MASS = 7.1 [kg]\nCX_X = 1e-3 [km**2]\n")),
        Ok(expected())
    );
}

#[test]
fn messages_say_what_is_wrong_where() {
    let (message, _) = with_value("EPOCH", "yesterday");
    assert_eq!(
        Elements::from_omm(message).unwrap_err().to_string(),
        "line 13: EPOCH has to be an instant like 2020-04-06T19:53:20.9328 or \
         2020-097T19:53:20.9328, in UTC"
    );
    let (message, _) = with_value("REF_FRAME", "ICRF");
    assert_eq!(
        Elements::from_omm(message).unwrap_err().to_string(),
        "line 9: REF_FRAME has to be TEME"
    );
}
