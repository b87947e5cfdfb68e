//! Why nothing is identified.

use core::fmt;

/// Why nothing is identified.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum IdentificationError {
    /// Fewer equations, or readings, than three for each unknown.
    TooFew {
        /// How many there are.
        found: u32,
        /// How many it takes.
        needed: u32,
    },
    /// The record does not tell the unknowns apart.
    PoorGeometry {
        /// Condition of the scaled normal matrix.
        condition: f32,
        /// The largest that is accepted.
        limit: f32,
        /// The unknown with the largest part in the combination that is known least, from 0.
        weakest: u8,
    },
    /// The record is too short.
    TooBrief {
        /// How long it is, s.
        found_s: f32,
        /// How long it has to be, s.
        needed_s: f32,
    },
    /// The record adds too little to what was assumed at first.
    NotLearnt {
        /// Of the sigma at first, how much is left of the unknown that was learnt least.
        left: f32,
        /// The largest part that is accepted.
        limit: f32,
        /// Which unknown, from 0.
        weakest: u8,
    },
    /// The tensor is not symmetric and positive.
    Inertia,
    /// The numbers are too large, or too small, for the type.
    OutOfRange,
}

impl fmt::Display for IdentificationError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooFew { found, needed } => {
                write!(
                    f,
                    "{found} equations are too few: it takes {needed}, three for each unknown"
                )
            }
            Self::PoorGeometry { condition, limit, weakest } => write!(
                f,
                "the record does not tell the unknowns apart: condition {condition}, at most {limit}; \
                 known least is unknown {weakest}"
            ),
            Self::TooBrief { found_s, needed_s } => {
                write!(f, "a record of {found_s} s is too short: it takes {needed_s} s")
            }
            Self::NotLearnt { left, limit, weakest } => write!(
                f,
                "the record adds too little: {left} of the sigma at first is left of unknown {weakest}, \
                 at most {limit}"
            ),
            Self::Inertia => write!(f, "the inertia tensor must be symmetric and positive"),
            Self::OutOfRange => write!(f, "the numbers are too large or too small to compute with"),
        }
    }
}

impl core::error::Error for IdentificationError {}
