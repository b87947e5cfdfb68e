//! The keywords of an OMM, and what each is used for.

use crate::Element;

/// A number that becomes an element.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Number {
    /// An element with a range.
    Element(Element),
    /// Half the first derivative of the mean motion.
    MeanMotionDot,
    /// A sixth of the second derivative of the mean motion.
    MeanMotionDdot,
}

/// What the reader does with the value of a keyword.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Use {
    /// It has to be one of these texts, in capitals or not.
    OneOf(&'static [&'static str]),
    /// The instant at which the elements hold.
    Epoch,
    /// A decimal number with this unit.
    Number(Number, &'static str),
    /// The catalogue number.
    NoradId,
    /// The running number of the set.
    ElementSetNumber,
    /// The revolutions at the epoch.
    RevolutionNumber,
    /// The international designator.
    Designator,
    /// The classification.
    Classification,
    /// Nothing: it does not change the orbit.
    Nothing,
    /// It belongs to other theories than SGP4.
    Refuse,
}

/// A keyword.
#[derive(Debug, Clone, Copy)]
pub(super) struct Keyword {
    pub name: &'static str,
    pub required: bool,
    pub used_for: Use,
}

const fn required(name: &'static str, used_for: Use) -> Keyword {
    Keyword { name, required: true, used_for }
}

const fn optional(name: &'static str, used_for: Use) -> Keyword {
    Keyword { name, required: false, used_for }
}

/// Begins every keyword that a user may make up. They are ignored.
pub(super) const USER_DEFINED: &str = "USER_DEFINED_";

/// The keyword that the message begins with.
pub(super) const VERSION: &str = "CCSDS_OMM_VERS";

/// All keywords of CCSDS 502.0-B-3, section 4, but `COMMENT` and the user-defined ones.
///
/// A set of 64 bits holds which were seen, so there may not be more than 64.
pub(super) const KEYWORDS: [Keyword; 58] = [
    required(VERSION, Use::OneOf(&["2.0", "3.0"])),
    optional("CLASSIFICATION", Use::Nothing),
    optional("CREATION_DATE", Use::Nothing),
    optional("ORIGINATOR", Use::Nothing),
    optional("MESSAGE_ID", Use::Nothing),
    optional("OBJECT_NAME", Use::Nothing),
    optional("OBJECT_ID", Use::Designator),
    required("CENTER_NAME", Use::OneOf(&["EARTH"])),
    required("REF_FRAME", Use::OneOf(&["TEME"])),
    // TEME of date needs none; elements in TEME of another epoch are not SGP4's.
    optional("REF_FRAME_EPOCH", Use::Refuse),
    required("TIME_SYSTEM", Use::OneOf(&["UTC"])),
    required("MEAN_ELEMENT_THEORY", Use::OneOf(&["SGP4", "SGP/SGP4"])),
    required("EPOCH", Use::Epoch),
    optional("SEMI_MAJOR_AXIS", Use::Refuse),
    required("MEAN_MOTION", Use::Number(Number::Element(Element::MeanMotion), "rev/day")),
    required("ECCENTRICITY", Use::Number(Number::Element(Element::Eccentricity), "")),
    required("INCLINATION", Use::Number(Number::Element(Element::Inclination), "deg")),
    required("RA_OF_ASC_NODE", Use::Number(Number::Element(Element::Raan), "deg")),
    required("ARG_OF_PERICENTER", Use::Number(Number::Element(Element::ArgumentOfPerigee), "deg")),
    required("MEAN_ANOMALY", Use::Number(Number::Element(Element::MeanAnomaly), "deg")),
    // The mean motion is given, and SGP4 has its own constant.
    optional("GM", Use::Nothing),
    optional("MASS", Use::Nothing),
    optional("SOLAR_RAD_AREA", Use::Nothing),
    optional("SOLAR_RAD_COEFF", Use::Nothing),
    optional("DRAG_AREA", Use::Nothing),
    optional("DRAG_COEFF", Use::Nothing),
    // 0 as distributed, 2 is SGP4 in the numbering of Spacetrack Report No. 3; 4 is SGP4-XP.
    optional("EPHEMERIS_TYPE", Use::OneOf(&["0", "2"])),
    optional("CLASSIFICATION_TYPE", Use::Classification),
    required("NORAD_CAT_ID", Use::NoradId),
    optional("ELEMENT_SET_NO", Use::ElementSetNumber),
    optional("REV_AT_EPOCH", Use::RevolutionNumber),
    required("BSTAR", Use::Number(Number::Element(Element::Bstar), "1/ER")),
    // Instead of BSTAR and MEAN_MOTION_DDOT, in SGP4-XP.
    optional("BTERM", Use::Refuse),
    optional("AGOM", Use::Refuse),
    optional("MEAN_MOTION_DOT", Use::Number(Number::MeanMotionDot, "rev/day**2")),
    optional("MEAN_MOTION_DDOT", Use::Number(Number::MeanMotionDdot, "rev/day**3")),
    optional("COV_REF_FRAME", Use::Nothing),
    optional("CX_X", Use::Nothing),
    optional("CY_X", Use::Nothing),
    optional("CY_Y", Use::Nothing),
    optional("CZ_X", Use::Nothing),
    optional("CZ_Y", Use::Nothing),
    optional("CZ_Z", Use::Nothing),
    optional("CX_DOT_X", Use::Nothing),
    optional("CX_DOT_Y", Use::Nothing),
    optional("CX_DOT_Z", Use::Nothing),
    optional("CX_DOT_X_DOT", Use::Nothing),
    optional("CY_DOT_X", Use::Nothing),
    optional("CY_DOT_Y", Use::Nothing),
    optional("CY_DOT_Z", Use::Nothing),
    optional("CY_DOT_X_DOT", Use::Nothing),
    optional("CY_DOT_Y_DOT", Use::Nothing),
    optional("CZ_DOT_X", Use::Nothing),
    optional("CZ_DOT_Y", Use::Nothing),
    optional("CZ_DOT_Z", Use::Nothing),
    optional("CZ_DOT_X_DOT", Use::Nothing),
    optional("CZ_DOT_Y_DOT", Use::Nothing),
    optional("CZ_DOT_Z_DOT", Use::Nothing),
];

/// Which keywords were seen.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Seen {
    bits: u64,
}

const _: () = assert!(KEYWORDS.len() <= u64::BITS as usize);

impl Seen {
    /// Notes a keyword; `false` when it was there already.
    pub fn insert(&mut self, index: usize) -> bool {
        let bit = 1_u64.rotate_left(index as u32);
        let is_new = self.bits & bit == 0;
        self.bits |= bit;
        is_new
    }

    /// The first required keyword that was not seen.
    pub fn missing(&self) -> Option<&'static str> {
        KEYWORDS
            .iter()
            .enumerate()
            .find(|(index, keyword)| {
                keyword.required && self.bits & 1_u64.rotate_left(*index as u32) == 0
            })
            .map(|(_, keyword)| keyword.name)
    }
}
