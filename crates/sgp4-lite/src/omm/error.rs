//! What is wrong with an OMM, and where.

use core::fmt;

/// Why an OMM was refused. Lines count from 1.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum OmmError {
    /// A byte that is neither printable ASCII nor a line end.
    Character {
        /// The line.
        line: u32,
        /// The column, from 1.
        column: u32,
        /// The byte.
        found: u8,
    },
    /// A line without `=` that is not a comment.
    NotAnAssignment {
        /// The line.
        line: u32,
    },
    /// The message does not begin with its version.
    NoVersion {
        /// The first line that is neither empty nor a comment.
        line: u32,
    },
    /// A keyword that an OMM does not have.
    UnknownKey {
        /// The line.
        line: u32,
    },
    /// A keyword that an OMM may have, but one with SGP4 elements may not.
    Unsupported {
        /// The line.
        line: u32,
        /// The keyword.
        key: &'static str,
    },
    /// A keyword for the second time.
    Duplicate {
        /// The line of the second time.
        line: u32,
        /// The keyword.
        key: &'static str,
    },
    /// A keyword that has to be there is not.
    Missing {
        /// The keyword.
        key: &'static str,
    },
    /// A value that cannot be read, or is not the one that SGP4 elements need.
    Value {
        /// The line.
        line: u32,
        /// The keyword.
        key: &'static str,
        /// What the value has to be.
        expected: &'static str,
    },
    /// A unit other than the one the keyword has.
    Unit {
        /// The line.
        line: u32,
        /// The keyword.
        key: &'static str,
        /// The unit it has; empty when it has none.
        expected: &'static str,
    },
    /// A number that can be read but is impossible.
    Range {
        /// The line.
        line: u32,
        /// The keyword.
        key: &'static str,
        /// The number.
        value: f64,
    },
}

impl fmt::Display for OmmError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Character { line, column, found } => {
                write!(f, "line {line}, column {column}: byte 0x{found:02X} is not printable ASCII")
            }
            Self::NotAnAssignment { line } => {
                write!(f, "line {line}: neither KEY = VALUE nor a comment")
            }
            Self::NoVersion { line } => {
                write!(f, "line {line}: the message has to begin with CCSDS_OMM_VERS")
            }
            Self::UnknownKey { line } => write!(f, "line {line}: not a keyword of an OMM"),
            Self::Unsupported { line, key } => {
                write!(f, "line {line}: {key} does not belong to SGP4 elements")
            }
            Self::Duplicate { line, key } => write!(f, "line {line}: {key} for the second time"),
            Self::Missing { key } => write!(f, "{key} is missing"),
            Self::Value { line, key, expected } => {
                write!(f, "line {line}: {key} has to be {expected}")
            }
            Self::Unit { line, key, expected: "" } => write!(f, "line {line}: {key} has no unit"),
            Self::Unit { line, key, expected } => {
                write!(f, "line {line}: the unit of {key} is {expected}")
            }
            Self::Range { line, key, value } => {
                write!(f, "line {line}: {key} is out of range: {value}")
            }
        }
    }
}

impl core::error::Error for OmmError {}
