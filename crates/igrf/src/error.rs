//! Why the field could not be given.

use core::fmt;

/// Why no field was computed. Each variant carries what was wrong with the request.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Error {
    /// The date (decimal year) is NaN or outside the years the coefficients are valid for.
    Date {
        /// What was asked for.
        decimal_year: f64,
        /// First valid decimal year.
        first: f64,
        /// Last valid decimal year.
        last: f64,
    },
    /// No such day in the calendar, or a time of day outside 0 ≤ s < 86401.
    Calendar {
        /// Year.
        year: u16,
        /// Month, 1 to 12.
        month: u8,
        /// Day of the month, from 1.
        day: u8,
        /// Seconds since 00:00.
        seconds_of_day: f64,
    },
    /// The degree is zero, or higher than the coefficients reach.
    Degree {
        /// What was asked for.
        requested: u8,
        /// The highest degree there is.
        highest: u8,
    },
    /// A coordinate is infinite or NaN.
    NotFinite,
    /// The distance from the Earth's centre is below [`MIN_RADIUS_KM`](crate::MIN_RADIUS_KM)
    /// or above [`MAX_RADIUS_KM`](crate::MAX_RADIUS_KM).
    Radius {
        /// What was asked for, km.
        radius_km: f64,
    },
    /// The geodetic latitude is beyond a pole.
    Latitude {
        /// What was asked for, rad.
        latitude_rad: f64,
    },
    /// The colatitude is outside 0 … π.
    Colatitude {
        /// What was asked for, rad.
        colatitude_rad: f64,
    },
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Date { decimal_year, first, last } => {
                write!(f, "decimal year {decimal_year} is outside {first} to {last}")
            }
            Self::Calendar { year, month, day, seconds_of_day } => {
                write!(f, "no such instant: {year}-{month:02}-{day:02} and {seconds_of_day} s")
            }
            Self::Degree { requested, highest } => {
                write!(f, "degree {requested} is outside 1 to {highest}")
            }
            Self::NotFinite => write!(f, "a coordinate is infinite or not a number"),
            Self::Radius { radius_km } => write!(
                f,
                "{radius_km} km from the Earth's centre is outside {} to {} km",
                crate::MIN_RADIUS_KM,
                crate::MAX_RADIUS_KM
            ),
            Self::Latitude { latitude_rad } => {
                write!(f, "latitude {latitude_rad} rad is beyond a pole")
            }
            Self::Colatitude { colatitude_rad } => {
                write!(f, "colatitude {colatitude_rad} rad is outside 0 to pi")
            }
        }
    }
}

impl core::error::Error for Error {}
