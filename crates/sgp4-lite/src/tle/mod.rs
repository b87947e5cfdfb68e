//! Two-line elements.
//!
//! ```text
//! 1 88888U 98067A   80275.98708465  .00073094  13844-3  66816-4 0    87
//! 2 88888  72.8435 115.9689 0086731  52.6988 110.5714 16.05824518  1058
//! ```
//!
//! What may stand in which column is written at [`Elements::from_tle`].
//!
//! Source: Hoots & Roehrich, Spacetrack Report No. 3, section 2; Space-Track.org, "Basic Description
//! of the Two Line Element (TLE) Format" and "Alpha-5".

mod columns;
mod error;
mod text;

pub(crate) use error::ReadableByte;
pub use error::{Expected, TleError};
pub use text::TleText;

use crate::{Classification, Element, Elements, Epoch, InternationalDesignator, decimal};
use columns::Columns;

/// Microseconds in the last of the eight decimals of a TLE's day.
const MICROS_PER_DAY_UNIT: i64 = 864;

/// First year of the first century of artificial satellites, and so of TLE epochs.
const FIRST_EPOCH_YEAR: u16 = 1957;

/// Whether a wrong checksum is an error.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Checksum {
    Verify,
    Ignore,
}

impl Elements {
    /// Elements from the two lines of a TLE, 69 columns each, without line ends.
    ///
    /// Strict: every column of both lines is checked, then the checksums, then the ranges of the
    /// values. What is accepted where:
    ///
    /// | line 1 | content | accepted |
    /// |---|---|---|
    /// | 3–7 | satellite number | leading blanks and digits, or Alpha-5 (not I, O) |
    /// | 8 | classification | `U`, `C`, `S` |
    /// | 10–17 | international designator | blank, or five digits and one to three capital letters |
    /// | 19–32 | epoch | years 57 to 56 are 1957 to 2056; the year must have the day |
    /// | 34–43 | ½ dn/dt | sign or blank, `.`, eight digits |
    /// | 45–52, 54–61 | ⅙ d²n/dt², B* | sign or blank, five digits, `+` or `-`, digit |
    /// | 63 | ephemeris type | blank, `0`, `2` |
    /// | 65–68 | element set number | leading blanks and digits |
    ///
    /// | line 2 | content | accepted |
    /// |---|---|---|
    /// | 3–7 | satellite number | that of line 1 |
    /// | 9–16 | inclination | `ddd.dddd`, leading blanks, 0 to 180 |
    /// | 18–25, 35–42, 44–51 | node, perigee, anomaly | `ddd.dddd`, leading blanks, 0 to 360 |
    /// | 27–33 | eccentricity | seven digits |
    /// | 53–63 | mean motion | `dd.dddddddd`, leading blank, above 0, at most 18 |
    /// | 64–68 | revolution number | leading blanks and digits |
    ///
    /// Column 1 is the line number, column 69 the checksum; all other columns are blank.
    ///
    /// # Errors
    /// The first thing found wrong, with line and column.
    pub fn from_tle(line1: impl AsRef<[u8]>, line2: impl AsRef<[u8]>) -> Result<Self, TleError> {
        parse(line1.as_ref(), line2.as_ref(), Checksum::Verify)
    }

    /// Like [`from_tle`](Self::from_tle), but a wrong checksum digit is let pass.
    ///
    /// For elements from a source that is trusted in other ways: three records of the SGP4
    /// verification set have wrong checksums. Not for uplinks.
    ///
    /// # Errors
    /// The first thing found wrong, with line and column.
    pub fn from_tle_lenient(
        line1: impl AsRef<[u8]>,
        line2: impl AsRef<[u8]>,
    ) -> Result<Self, TleError> {
        parse(line1.as_ref(), line2.as_ref(), Checksum::Ignore)
    }

    /// Elements from the raw bytes of one TLE: two lines, or three with the name first.
    ///
    /// Lines end with LF or CRLF, see [`TleText::split`]; otherwise like
    /// [`from_tle`](Self::from_tle).
    ///
    /// # Errors
    /// The first thing found wrong, with line and column.
    pub fn from_tle_text(text: impl AsRef<[u8]>) -> Result<Self, TleError> {
        let TleText { line1, line2, .. } = TleText::split(text.as_ref())?;
        parse(line1, line2, Checksum::Verify)
    }
}

/// The fields of line 1.
struct Line1 {
    satellite_number: u32,
    classification: Classification,
    international_designator: InternationalDesignator,
    epoch_year: u16,
    epoch_day: u16,
    epoch_micros: i64,
    mean_motion_dot_over_2: f64,
    mean_motion_ddot_over_6: f64,
    bstar: f64,
    element_set_number: u16,
}

/// The fields of line 2.
struct Line2 {
    satellite_number: u32,
    inclination_deg: f64,
    raan_deg: f64,
    eccentricity: f64,
    argument_of_perigee_deg: f64,
    mean_anomaly_deg: f64,
    mean_motion_rev_per_day: f64,
    revolution_number: u32,
}

fn parse(line1: &[u8], line2: &[u8], checksum: Checksum) -> Result<Elements, TleError> {
    let line1 = parse_line1(line1, checksum)?;
    let line2 = parse_line2(line2, checksum)?;
    if line1.satellite_number != line2.satellite_number {
        return Err(TleError::SatelliteNumber {
            line1: line1.satellite_number,
            line2: line2.satellite_number,
        });
    }
    let (year, day) = (line1.epoch_year, line1.epoch_day);
    let elements = Elements {
        norad_id: line1.satellite_number,
        classification: line1.classification,
        international_designator: line1.international_designator,
        epoch: Epoch::from_day_of_year(year, day, line1.epoch_micros)
            .ok_or(TleError::DayOfYear { year, day })?,
        mean_motion_dot_over_2_rev_per_day2: line1.mean_motion_dot_over_2,
        mean_motion_ddot_over_6_rev_per_day3: line1.mean_motion_ddot_over_6,
        bstar_per_earth_radius: line1.bstar,
        inclination_deg: line2.inclination_deg,
        raan_deg: line2.raan_deg,
        eccentricity: line2.eccentricity,
        argument_of_perigee_deg: line2.argument_of_perigee_deg,
        mean_anomaly_deg: line2.mean_anomaly_deg,
        mean_motion_rev_per_day: line2.mean_motion_rev_per_day,
        element_set_number: line1.element_set_number,
        revolution_number: line2.revolution_number,
    };
    match elements.out_of_range() {
        Some((element, value)) => {
            let (line, first_column, last_column) = place_of(element);
            Err(TleError::Range { element, line, first_column, last_column, value })
        }
        None => Ok(elements),
    }
}

fn parse_line1(text: &[u8], checksum: Checksum) -> Result<Line1, TleError> {
    let mut columns = Columns::of_line(1, text)?;
    columns.blank()?;
    let satellite_number = columns.satellite_number()?;
    let classification = columns.classification()?;
    columns.blank()?;
    let international_designator = columns.international_designator()?;
    columns.blank()?;
    let epoch_year = match columns.digits(2)? as u16 {
        this_century @ 0..57 => 2000 + this_century,
        last_century => FIRST_EPOCH_YEAR - 57 + last_century,
    };
    let epoch_day = columns.right_justified(3)? as u16;
    columns.point()?;
    let epoch_micros = i64::from(columns.digits(8)?) * MICROS_PER_DAY_UNIT;
    columns.blank()?;
    let mean_motion_dot_sign = columns.sign()?;
    columns.point()?;
    let mean_motion_dot_over_2 =
        mean_motion_dot_sign * decimal::scaled(columns.digits(8)?.into(), -8);
    columns.blank()?;
    let mean_motion_ddot_over_6 = columns.exponential()?;
    columns.blank()?;
    let bstar = columns.exponential()?;
    columns.blank()?;
    columns.ephemeris_type()?;
    columns.blank()?;
    let element_set_number = columns.right_justified(4)? as u16;
    columns.checksum(checksum == Checksum::Verify)?;
    Ok(Line1 {
        satellite_number,
        classification,
        international_designator,
        epoch_year,
        epoch_day,
        epoch_micros,
        mean_motion_dot_over_2,
        mean_motion_ddot_over_6,
        bstar,
        element_set_number,
    })
}

fn parse_line2(text: &[u8], checksum: Checksum) -> Result<Line2, TleError> {
    let mut columns = Columns::of_line(2, text)?;
    columns.blank()?;
    let satellite_number = columns.satellite_number()?;
    columns.blank()?;
    let inclination_deg = columns.fixed_point(3, 4)?;
    columns.blank()?;
    let raan_deg = columns.fixed_point(3, 4)?;
    columns.blank()?;
    let eccentricity = decimal::scaled(columns.digits(7)?.into(), -7);
    columns.blank()?;
    let argument_of_perigee_deg = columns.fixed_point(3, 4)?;
    columns.blank()?;
    let mean_anomaly_deg = columns.fixed_point(3, 4)?;
    columns.blank()?;
    let mean_motion_rev_per_day = columns.fixed_point(2, 8)?;
    let revolution_number = columns.right_justified(5)?;
    columns.checksum(checksum == Checksum::Verify)?;
    Ok(Line2 {
        satellite_number,
        inclination_deg,
        raan_deg,
        eccentricity,
        argument_of_perigee_deg,
        mean_anomaly_deg,
        mean_motion_rev_per_day,
        revolution_number,
    })
}

/// Line, first and last column of an element.
const fn place_of(element: Element) -> (u8, u8, u8) {
    match element {
        Element::Bstar => (1, 54, 61),
        Element::Inclination => (2, 9, 16),
        Element::Raan => (2, 18, 25),
        Element::Eccentricity => (2, 27, 33),
        Element::ArgumentOfPerigee => (2, 35, 42),
        Element::MeanAnomaly => (2, 44, 51),
        Element::MeanMotion => (2, 53, 63),
    }
}
