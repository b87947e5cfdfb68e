//! Mean elements: what a TLE or an OMM says, and what the propagator starts from.

use crate::Epoch;
use crate::tle::ReadableByte;
use core::fmt;

/// SGP4 mean elements of one satellite, in the units in which they are published.
///
/// From a TLE ([`Elements::from_tle`](Self::from_tle)), from an OMM
/// ([`Elements::from_omm`](Self::from_omm)), or filled in by hand. The fields are public; what they
/// hold is checked by [`Propagator::new`](crate::Propagator::new).
///
/// The orbital elements are mean elements of the SGP4 theory with WGS72 constants, with respect to
/// the true equator and mean equinox of the epoch (TEME). The mean motion is the Kozai mean motion
/// that TLEs carry.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Elements {
    /// Catalogue number of the satellite.
    pub norad_id: u32,
    /// Whether the elements may be spread.
    pub classification: Classification,
    /// Launch year, launch number and piece; may be blank.
    pub international_designator: InternationalDesignator,
    /// The instant (UTC) at which the elements hold.
    pub epoch: Epoch,
    /// *Half* the first derivative of the mean motion, as TLE and OMM give it. SGP4 does not use it.
    pub mean_motion_dot_over_2_rev_per_day2: f64,
    /// A *sixth* of the second derivative of the mean motion, as TLE and OMM give it. SGP4 does not
    /// use it.
    pub mean_motion_ddot_over_6_rev_per_day3: f64,
    /// Drag coefficient B* in inverse Earth radii (6378.135 km). May be negative.
    pub bstar_per_earth_radius: f64,
    /// Inclination to the equator, 0 to 180.
    pub inclination_deg: f64,
    /// Right ascension of the ascending node, 0 to 360.
    pub raan_deg: f64,
    /// Eccentricity, at least 0 and below 1.
    pub eccentricity: f64,
    /// Argument of perigee, 0 to 360.
    pub argument_of_perigee_deg: f64,
    /// Mean anomaly, 0 to 360.
    pub mean_anomaly_deg: f64,
    /// Mean motion after Kozai, above 0 and at most 18.
    pub mean_motion_rev_per_day: f64,
    /// Running number of this set of elements.
    pub element_set_number: u16,
    /// Revolutions since launch at the epoch.
    pub revolution_number: u32,
}

/// Whether elements may be spread.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Classification {
    /// `U`
    Unclassified,
    /// `C`
    Classified,
    /// `S`
    Secret,
}

impl Classification {
    /// The meaning of the letter used in TLE and OMM.
    #[must_use]
    pub const fn from_letter(letter: u8) -> Option<Self> {
        match letter {
            b'U' => Some(Self::Unclassified),
            b'C' => Some(Self::Classified),
            b'S' => Some(Self::Secret),
            _ => None,
        }
    }

    /// The letter used in TLE and OMM.
    #[must_use]
    pub const fn letter(self) -> char {
        match self {
            Self::Unclassified => 'U',
            Self::Classified => 'C',
            Self::Secret => 'S',
        }
    }
}

/// Launch year (two digits), launch number of that year (three digits) and piece (one to three
/// capital letters), as in columns 10 to 17 of a TLE: `98067A`. May be blank.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct InternationalDesignator {
    /// Left-justified, filled up with blanks, checked by the constructors.
    text: [u8; 8],
}

impl InternationalDesignator {
    /// No designator: eight blanks.
    pub const BLANK: Self = Self { text: [b' '; 8] };

    /// The designator written in eight columns, left-justified and filled up with blanks.
    ///
    /// # Errors
    /// The first byte that cannot stand where it does.
    pub fn from_columns(text: [u8; 8]) -> Result<Self, WrongDesignator> {
        if text == Self::BLANK.text {
            return Ok(Self::BLANK);
        }
        let mut piece_has_ended = false;
        for (index, found) in (0..).zip(text) {
            let allowed = match index {
                0..=4 => found.is_ascii_digit(),
                5 => found.is_ascii_uppercase(),
                _ if piece_has_ended => found == b' ',
                _ => found.is_ascii_uppercase() || found == b' ',
            };
            if !allowed {
                return Err(WrongDesignator { index, found });
            }
            piece_has_ended = found == b' ';
        }
        Ok(Self { text })
    }

    /// The designator without the blanks that fill it up; empty when it is blank.
    #[must_use]
    pub fn as_str(&self) -> &str {
        str::from_utf8(self.text.trim_ascii_end()).unwrap_or_default()
    }
}

/// A byte that cannot stand where it does in an international designator.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct WrongDesignator {
    /// Its index, 0 to 7.
    pub index: u8,
    /// The byte.
    pub found: u8,
}

impl fmt::Display for WrongDesignator {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "byte {} of the international designator cannot be {}",
            self.index,
            ReadableByte(self.found)
        )
    }
}

impl core::error::Error for WrongDesignator {}

impl fmt::Debug for InternationalDesignator {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:?}", self.as_str())
    }
}

impl fmt::Display for InternationalDesignator {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.as_str())
    }
}

#[cfg(feature = "defmt")]
impl defmt::Format for InternationalDesignator {
    fn format(&self, f: defmt::Formatter<'_>) {
        defmt::write!(f, "{=str}", self.as_str());
    }
}

#[cfg(feature = "serde")]
impl serde::Serialize for InternationalDesignator {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.as_str())
    }
}

#[cfg(feature = "serde")]
impl<'de> serde::Deserialize<'de> for InternationalDesignator {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Text;

        impl serde::de::Visitor<'_> for Text {
            type Value = InternationalDesignator;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("an international designator such as 98067A, or an empty text")
            }

            fn visit_str<E: serde::de::Error>(self, written: &str) -> Result<Self::Value, E> {
                let mut text = [b' '; 8];
                for (to, from) in text.iter_mut().zip(written.bytes()) {
                    *to = from;
                }
                match InternationalDesignator::from_columns(text) {
                    Ok(designator) if written.len() <= text.len() => Ok(designator),
                    _ => Err(E::invalid_value(serde::de::Unexpected::Str(written), &self)),
                }
            }
        }

        deserializer.deserialize_str(Text)
    }
}

/// An element that has a range of physically meaningful values.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Element {
    /// Drag coefficient B*, per Earth radius.
    Bstar,
    /// Inclination, degrees.
    Inclination,
    /// Right ascension of the ascending node, degrees.
    Raan,
    /// Eccentricity.
    Eccentricity,
    /// Argument of perigee, degrees.
    ArgumentOfPerigee,
    /// Mean anomaly, degrees.
    MeanAnomaly,
    /// Mean motion, revolutions per day.
    MeanMotion,
}

/// Fastest mean motion that is accepted. A circular orbit this fast has a radius of 6150 km: it
/// would run 230 km below the surface.
pub(crate) const MAX_MEAN_MOTION_REV_PER_DAY: f64 = 18.0;

impl Element {
    /// The element in words, with its unit.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Bstar => "B* (1/Earth radius)",
            Self::Inclination => "inclination (deg)",
            Self::Raan => "right ascension of the ascending node (deg)",
            Self::Eccentricity => "eccentricity",
            Self::ArgumentOfPerigee => "argument of perigee (deg)",
            Self::MeanAnomaly => "mean anomaly (deg)",
            Self::MeanMotion => "mean motion (rev/day)",
        }
    }

    /// Whether SGP4 elements may hold this value. Angles may be 360 exactly, because 359.99996
    /// is printed so with four decimals.
    pub(crate) fn allows(self, value: f64) -> bool {
        match self {
            Self::Bstar => value.is_finite(),
            Self::Inclination => (0.0..=180.0).contains(&value),
            Self::Raan | Self::ArgumentOfPerigee | Self::MeanAnomaly => {
                (0.0..=360.0).contains(&value)
            }
            Self::Eccentricity => (0.0..1.0).contains(&value),
            Self::MeanMotion => value > 0.0 && value <= MAX_MEAN_MOTION_REV_PER_DAY,
        }
    }
}

impl Elements {
    /// The first element that has an impossible value, with that value.
    pub(crate) fn out_of_range(&self) -> Option<(Element, f64)> {
        [
            (Element::Bstar, self.bstar_per_earth_radius),
            (Element::Inclination, self.inclination_deg),
            (Element::Raan, self.raan_deg),
            (Element::Eccentricity, self.eccentricity),
            (Element::ArgumentOfPerigee, self.argument_of_perigee_deg),
            (Element::MeanAnomaly, self.mean_anomaly_deg),
            (Element::MeanMotion, self.mean_motion_rev_per_day),
        ]
        .into_iter()
        .find(|&(element, value)| !element.allows(value))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn designators_are_blank_or_digits_then_letters_then_blanks() {
        for good in [b"98067A  ", b"21006AAA", b"58002B  ", b"85108AA ", b"        "] {
            let designator = InternationalDesignator::from_columns(*good).unwrap();
            assert_eq!(designator.as_str().as_bytes(), good.trim_ascii_end());
        }
        for (bad, index) in [
            (b" 8067A  ", 0),
            (b"98 67A  ", 2),
            (b"98067   ", 5),
            (b"98067A B", 7),
            (b"98067a  ", 5),
            (b"98067A\0 ", 6),
            (b"98067\xC3\xA4 ", 5),
        ] {
            let found = bad[usize::from(index)];
            let wrong = WrongDesignator { index, found };
            assert_eq!(InternationalDesignator::from_columns(*bad), Err(wrong));
        }
    }
}
