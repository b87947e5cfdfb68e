//! Orbit Mean-Elements Messages in key-value notation (KVN).
//!
//! Source: CCSDS 502.0-B-3, "Orbit Data Messages" (2023), sections 4 and 7.

mod date;
mod error;
mod keys;

pub use error::OmmError;

use crate::{Classification, Element, Elements, Epoch, InternationalDesignator, decimal};
use date::{parse_epoch, split_at_byte};
use keys::{KEYWORDS, Keyword, Number, Seen, USER_DEFINED, Use, VERSION};

/// Largest catalogue number: nine digits.
const MAX_NORAD_ID: u32 = 999_999_999;
/// Year of the first launch, and so the first of the hundred that two digits tell apart.
const FIRST_LAUNCH_YEAR: u32 = 1957;
/// Largest running number of a set of elements: four digits.
const MAX_ELEMENT_SET_NUMBER: u32 = 9999;

impl Elements {
    /// Elements from the text of one Orbit Mean-Elements Message in key-value notation.
    ///
    /// ```
    /// # use sgp4_lite::{Elements, OmmError};
    /// let elements = Elements::from_omm(
    ///     "CCSDS_OMM_VERS = 2.0
    ///     COMMENT any order, units optional
    ///     OBJECT_ID = 1998-067A
    ///     CENTER_NAME = EARTH
    ///     REF_FRAME = TEME
    ///     TIME_SYSTEM = UTC
    ///     MEAN_ELEMENT_THEORY = SGP4
    ///     EPOCH = 2020-04-06T19:53:20.932800
    ///     MEAN_MOTION = 15.48685836 [rev/day]
    ///     ECCENTRICITY = .000388
    ///     INCLINATION = 51.6465 [deg]
    ///     RA_OF_ASC_NODE = 341.5807
    ///     ARG_OF_PERICENTER = 94.4223
    ///     MEAN_ANOMALY = 26.1197
    ///     NORAD_CAT_ID = 25544
    ///     BSTAR = 2.4271E-5 [1/ER]",
    /// )?;
    /// assert_eq!(elements.norad_id, 25544);
    /// # Ok::<(), OmmError>(())
    /// ```
    ///
    /// - The first keyword is `CCSDS_OMM_VERS`, 2.0 or 3.0; the others may come in any order, each
    ///   once. Lines end with LF or CRLF; empty lines and `COMMENT` lines are skipped.
    /// - Required are the keywords of the example but `OBJECT_ID`. `CENTER_NAME`, `REF_FRAME`,
    ///   `TIME_SYSTEM` and `MEAN_ELEMENT_THEORY` have to be as there (or `SGP/SGP4`).
    /// - Read when present: `OBJECT_ID` (else blank; `UNKNOWN` is blank), `CLASSIFICATION_TYPE`
    ///   (else `U`), `EPHEMERIS_TYPE` (0 or 2), `ELEMENT_SET_NO`, `REV_AT_EPOCH`,
    ///   `MEAN_MOTION_DOT`, `MEAN_MOTION_DDOT` (else 0).
    /// - Skipped: header and object names, `GM`, spacecraft parameters, covariance, `USER_DEFINED_…`.
    /// - Refused: `SEMI_MAJOR_AXIS`, `REF_FRAME_EPOCH`, `BTERM`, `AGOM`, and unknown keywords.
    /// - Numbers are decimal, with or without exponent; a unit in brackets may follow and has to be
    ///   the standard's. The epoch is a calendar date or a day of the year, rounded to the
    ///   microsecond.
    ///
    /// # Errors
    /// The first thing found wrong, with line and keyword.
    pub fn from_omm(text: impl AsRef<[u8]>) -> Result<Self, OmmError> {
        parse(text.as_ref())
    }
}

/// The elements as far as they have been read.
struct Draft {
    elements: Elements,
    seen: Seen,
}

/// A keyword at its line, for errors.
#[derive(Clone, Copy)]
struct Place {
    line: u32,
    key: &'static str,
}

impl Place {
    fn value(self, expected: &'static str) -> OmmError {
        OmmError::Value { line: self.line, key: self.key, expected }
    }
}

fn parse(text: &[u8]) -> Result<Elements, OmmError> {
    let mut draft = Draft::new();
    let mut version_seen = false;
    for (line, text) in (1..).zip(text.split(|&byte| byte == b'\n')) {
        let text = text.strip_suffix(b"\r").unwrap_or(text);
        check_characters(line, text)?;
        let text = text.trim_ascii();
        if text.is_empty() || is_comment(text) {
            continue;
        }
        let (key, value) = split_at_byte(text, b'=').ok_or(OmmError::NotAnAssignment { line })?;
        let (key, value) = (key.trim_ascii_end(), value.trim_ascii_start());
        if !version_seen && key != VERSION.as_bytes() {
            return Err(OmmError::NoVersion { line });
        }
        version_seen = true;
        if !key.starts_with(USER_DEFINED.as_bytes()) {
            draft.assign(line, key, value)?;
        }
    }
    match draft.seen.missing() {
        Some(key) => Err(OmmError::Missing { key }),
        None => Ok(draft.elements),
    }
}

fn check_characters(line: u32, text: &[u8]) -> Result<(), OmmError> {
    match (1..).zip(text).find(|(_, byte)| !matches!(byte, b' '..=b'~')) {
        Some((column, &found)) => Err(OmmError::Character { line, column, found }),
        None => Ok(()),
    }
}

fn is_comment(text: &[u8]) -> bool {
    text.strip_prefix(b"COMMENT").is_some_and(|rest| matches!(rest, [] | [b' ', ..]))
}

impl Draft {
    fn new() -> Self {
        Self {
            elements: Elements {
                norad_id: 0,
                classification: Classification::Unclassified,
                international_designator: InternationalDesignator::BLANK,
                epoch: Epoch::J2000_MIDNIGHT,
                mean_motion_dot_over_2_rev_per_day2: 0.0,
                mean_motion_ddot_over_6_rev_per_day3: 0.0,
                bstar_per_earth_radius: 0.0,
                inclination_deg: 0.0,
                raan_deg: 0.0,
                eccentricity: 0.0,
                argument_of_perigee_deg: 0.0,
                mean_anomaly_deg: 0.0,
                mean_motion_rev_per_day: 0.0,
                element_set_number: 0,
                revolution_number: 0,
            },
            seen: Seen::default(),
        }
    }

    fn assign(&mut self, line: u32, key: &[u8], value: &[u8]) -> Result<(), OmmError> {
        let (index, keyword) = KEYWORDS
            .iter()
            .enumerate()
            .find(|(_, keyword)| keyword.name.as_bytes() == key)
            .ok_or(OmmError::UnknownKey { line })?;
        let place = Place { line, key: keyword.name };
        if !self.seen.insert(index) {
            return Err(OmmError::Duplicate { line, key: place.key });
        }
        self.interpret(keyword, place, value)
    }

    fn interpret(&mut self, keyword: &Keyword, place: Place, value: &[u8]) -> Result<(), OmmError> {
        let elements = &mut self.elements;
        match keyword.used_for {
            Use::Nothing => {}
            Use::Refuse => {
                return Err(OmmError::Unsupported { line: place.line, key: place.key });
            }
            Use::OneOf(allowed) => {
                if !allowed.iter().any(|text| text.as_bytes().eq_ignore_ascii_case(value)) {
                    return Err(place.value(allowed.first().copied().unwrap_or_default()));
                }
            }
            Use::Epoch => {
                elements.epoch = parse_epoch(value).ok_or(place.value(date::EXPECTED))?;
            }
            Use::Designator => elements.international_designator = designator(place, value)?,
            Use::Classification => {
                elements.classification = match value {
                    [letter] => Classification::from_letter(*letter),
                    _ => None,
                }
                .ok_or(place.value("U, C or S"))?;
            }
            Use::NoradId => elements.norad_id = integer(place, value, MAX_NORAD_ID)?,
            Use::ElementSetNumber => {
                elements.element_set_number = integer(place, value, MAX_ELEMENT_SET_NUMBER)? as u16;
            }
            Use::RevolutionNumber => {
                elements.revolution_number = integer(place, value, u32::MAX)?;
            }
            Use::Number(quantity, unit) => {
                self.assign_number(place, quantity, number(place, value, unit)?)?;
            }
        }
        Ok(())
    }

    fn assign_number(
        &mut self,
        place: Place,
        quantity: Number,
        value: f64,
    ) -> Result<(), OmmError> {
        let in_range = match quantity {
            Number::Element(element) => element.allows(value),
            Number::MeanMotionDot | Number::MeanMotionDdot => value.is_finite(),
        };
        if !in_range {
            return Err(OmmError::Range { line: place.line, key: place.key, value });
        }
        let elements = &mut self.elements;
        *match quantity {
            Number::MeanMotionDot => &mut elements.mean_motion_dot_over_2_rev_per_day2,
            Number::MeanMotionDdot => &mut elements.mean_motion_ddot_over_6_rev_per_day3,
            Number::Element(Element::Bstar) => &mut elements.bstar_per_earth_radius,
            Number::Element(Element::Inclination) => &mut elements.inclination_deg,
            Number::Element(Element::Raan) => &mut elements.raan_deg,
            Number::Element(Element::Eccentricity) => &mut elements.eccentricity,
            Number::Element(Element::ArgumentOfPerigee) => &mut elements.argument_of_perigee_deg,
            Number::Element(Element::MeanAnomaly) => &mut elements.mean_anomaly_deg,
            Number::Element(Element::MeanMotion) => &mut elements.mean_motion_rev_per_day,
        } = value;
        Ok(())
    }
}

/// A decimal number, with its unit or without.
fn number(place: Place, value: &[u8], unit: &'static str) -> Result<f64, OmmError> {
    decimal::parse(without_unit(place, value, unit)?).ok_or(place.value("a decimal number"))
}

fn without_unit<'a>(
    place: Place,
    value: &'a [u8],
    unit: &'static str,
) -> Result<&'a [u8], OmmError> {
    let Some((number, bracketed)) = split_at_byte(value, b'[') else { return Ok(value) };
    let found = bracketed.strip_suffix(b"]").map(<[u8]>::trim_ascii);
    match found {
        Some(found) if !unit.is_empty() && found.eq_ignore_ascii_case(unit.as_bytes()) => {
            Ok(number.trim_ascii_end())
        }
        _ => Err(OmmError::Unit { line: place.line, key: place.key, expected: unit }),
    }
}

/// An integer of digits only, at most `max`.
fn integer(place: Place, value: &[u8], max: u32) -> Result<u32, OmmError> {
    if value.is_empty() || !value.iter().all(u8::is_ascii_digit) {
        return Err(place.value("an integer that is not negative"));
    }
    value
        .iter()
        .try_fold(0_u32, |number, digit| {
            number.checked_mul(10)?.checked_add(u32::from(digit - b'0'))
        })
        .filter(|number| *number <= max)
        .ok_or(place.value("a smaller integer"))
}

/// `1998-067A` as the eight columns `98067A  `; blank when empty or `UNKNOWN`.
fn designator(place: Place, value: &[u8]) -> Result<InternationalDesignator, OmmError> {
    if value.is_empty() || value.eq_ignore_ascii_case(b"UNKNOWN") {
        return Ok(InternationalDesignator::BLANK);
    }
    let expected = place.value("an international designator like 1998-067A, or UNKNOWN");
    let (year, launch) = split_at_byte(value, b'-').ok_or(expected)?;
    let known_year = FIRST_LAUNCH_YEAR..=FIRST_LAUNCH_YEAR + 99;
    let mut columns = [b' '; 8];
    if !known_year.contains(&integer(place, year, 9999)?) || launch.len() > columns.len() - 2 {
        return Err(expected);
    }
    // The century is dropped: columns hold the year's last two digits, then launch and piece.
    for (column, &byte) in columns.iter_mut().zip(year.iter().skip(2).chain(launch)) {
        *column = byte;
    }
    InternationalDesignator::from_columns(columns).map_err(|_| expected)
}
