//! What is wrong with a TLE, and where.

use crate::Element;
use core::fmt;

/// Why a TLE was refused.
///
/// `line` is 1 or 2, and 0 for the name line above them. Columns count from 1, as in every
/// description of the format.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum TleError {
    /// The text does not have two lines, or three with the name.
    Lines {
        /// Lines in the text, without empty ones at its end.
        found: usize,
    },
    /// Line 1 or 2 is not 69 columns long, or the name is empty or longer than 24 columns.
    Length {
        /// The line.
        line: u8,
        /// Its length in bytes.
        found: usize,
    },
    /// The line does not begin with its number.
    LineNumber {
        /// The line, and so the number it has to begin with.
        line: u8,
        /// The byte it begins with.
        found: u8,
    },
    /// A character that cannot stand in its column.
    Character {
        /// The line.
        line: u8,
        /// The column, from 1.
        column: u8,
        /// The byte that stands there.
        found: u8,
        /// What may stand there.
        expected: Expected,
    },
    /// The elements are for another theory than SGP4 (type 4 is SGP4-XP).
    EphemerisType {
        /// The digit in column 63 of line 1.
        found: u8,
    },
    /// The last digit of the line is not the checksum of the columns before it.
    Checksum {
        /// The line.
        line: u8,
        /// The checksum of columns 1 to 68.
        expected: u8,
        /// The digit in column 69.
        found: u8,
    },
    /// The two lines are not of the same satellite.
    SatelliteNumber {
        /// The number in line 1.
        line1: u32,
        /// The number in line 2.
        line2: u32,
    },
    /// The year has no such day (line 1, columns 21 to 23).
    DayOfYear {
        /// The year, four digits.
        year: u16,
        /// The day.
        day: u16,
    },
    /// An element has an impossible value.
    Range {
        /// Which one.
        element: Element,
        /// The line it stands in.
        line: u8,
        /// The first of its columns.
        first_column: u8,
        /// The last of its columns.
        last_column: u8,
        /// Its value.
        value: f64,
    },
}

/// What may stand in a column of a TLE.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Expected {
    /// Nothing.
    Blank,
    /// A digit.
    Digit,
    /// A digit, or a blank before the first digit.
    DigitOrLeadingBlank,
    /// A decimal point.
    Point,
    /// A plus, a minus or a blank.
    Sign,
    /// A plus or a minus.
    ExponentSign,
    /// A digit, a blank before the first digit, or a letter but I and O (Alpha-5).
    SatelliteNumber,
    /// One of U, C and S.
    Classification,
    /// Two digits of the launch year, three of the launch, one to three letters of the piece; or
    /// all blank.
    InternationalDesignator,
    /// A printable ASCII character.
    Printable,
}

impl Expected {
    const fn in_words(self) -> &'static str {
        match self {
            Self::Blank => "a blank",
            Self::Digit => "a digit",
            Self::DigitOrLeadingBlank => "a digit, or a blank before the first digit",
            Self::Point => "a decimal point",
            Self::Sign => "'+', '-' or a blank",
            Self::ExponentSign => "'+' or '-'",
            Self::SatelliteNumber => "a digit, a leading blank, or a letter other than I and O",
            Self::Classification => "U, C or S",
            Self::InternationalDesignator => {
                "a designator like 98067A, left-justified, or only blanks"
            }
            Self::Printable => "a printable ASCII character",
        }
    }
}

/// A byte as a person reads it: `'x'`, or `0x9F` when it does not print.
pub(crate) struct ReadableByte(pub u8);

impl fmt::Display for ReadableByte {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            byte @ b' '..=b'~' => write!(f, "'{}'", char::from(byte)),
            byte => write!(f, "0x{byte:02X}"),
        }
    }
}

impl fmt::Display for TleError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Lines { found } => {
                write!(f, "a TLE has two lines, or three with the name; found {found}")
            }
            Self::Length { line: 0, found } => {
                write!(f, "name line: {found} columns instead of 1 to 24")
            }
            Self::Length { line, found } => write!(f, "line {line}: {found} columns instead of 69"),
            Self::LineNumber { line, found } => {
                write!(f, "line {line}, column 1: expected '{line}', found {}", ReadableByte(found))
            }
            Self::Character { line, column, found, expected } => write!(
                f,
                "line {line}, column {column}: expected {}, found {}",
                expected.in_words(),
                ReadableByte(found)
            ),
            Self::EphemerisType { found } => write!(
                f,
                "line 1, column 63: ephemeris type {} is not SGP4 (blank, 0 or 2)",
                ReadableByte(found)
            ),
            Self::Checksum { line, expected, found } => write!(
                f,
                "line {line}, column 69: the checksum is {found}, but the line sums up to {expected}"
            ),
            Self::SatelliteNumber { line1, line2 } => write!(
                f,
                "columns 3 to 7: line 1 is of satellite {line1}, line 2 of satellite {line2}"
            ),
            Self::DayOfYear { year, day } => {
                write!(f, "line 1, columns 21 to 23: the year {year} has no day {day}")
            }
            Self::Range { element, line, first_column, last_column, value } => write!(
                f,
                "line {line}, columns {first_column} to {last_column}: {} is out of range: {value}",
                element.name()
            ),
        }
    }
}

impl core::error::Error for TleError {}
