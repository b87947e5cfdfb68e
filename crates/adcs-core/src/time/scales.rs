//! The uniform time scales beside UTC: TAI, TT and GPS.
//!
//! ```text
//!            leap seconds           + 32.184 s
//!  Utc ◄──────────────────► Tai ◄──────────────► Tt
//!                            ▲      − 19 s
//!                            └─────────────────► Gps
//! ```
//!
//! Each is its own type over an integer count of microseconds; an instant of one scale cannot be
//! given where another is wanted.
//!
//! Sources: TT − TAI = 32.184 s, IAU 1991 Resolution A4, Recommendation IV; TAI − GPS = 19 s and
//! the origin of GPS time, IS-GPS-200, section 3.3.4.

use core::fmt;

use super::{JulianDate, LeapSeconds, MICROS_PER_DAY, MICROS_PER_SECOND, Utc};

const TT_MINUS_TAI_MICROS: i64 = 32_184_000;
const TAI_MINUS_GPS_MICROS: i64 = 19 * MICROS_PER_SECOND;
/// Days from 1980-01-06, the origin of GPS time, to 2000-01-01.
const DAYS_FROM_GPS_ORIGIN_TO_2000: i64 = 7_300;
/// Days from 1970-01-01, the origin of Unix time, to 2000-01-01.
const DAYS_FROM_UNIX_ORIGIN_TO_2000: i64 = 10_957;
const MICROS_PER_WEEK: i64 = 7 * MICROS_PER_DAY;

/// Why an instant has no counterpart in another scale.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum TimeScaleError {
    /// Before 1972 UTC was not a whole number of seconds from TAI, and ran at another rate.
    UtcBefore1972 {
        /// The instant.
        utc: Utc,
    },
    /// The same, coming from TAI.
    TaiBefore1972 {
        /// The instant.
        tai: Tai,
    },
}

impl fmt::Display for TimeScaleError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::UtcBefore1972 { utc } => {
                write!(f, "{utc} is before 1972, where the leap seconds begin")
            }
            Self::TaiBefore1972 { tai } => write!(
                f,
                "TAI {} µs since 2000 is before 1972, where the leap seconds begin",
                tai.micros_since_2000()
            ),
        }
    }
}

impl core::error::Error for TimeScaleError {}

macro_rules! uniform_scales {
    ($($(#[$doc:meta])* $name:ident),* $(,)?) => {
        $(
            $(#[$doc])*
            #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
            #[cfg_attr(feature = "defmt", derive(defmt::Format))]
            pub struct $name(i64);

            impl $name {
                /// The instant `micros` microseconds after 2000-01-01 00:00:00 of this scale.
                pub const fn from_micros_since_2000(micros: i64) -> Self {
                    Self(micros)
                }

                /// Microseconds since 2000-01-01 00:00:00 of this scale.
                pub const fn micros_since_2000(self) -> i64 {
                    self.0
                }

                /// This instant moved by `micros` microseconds (saturating).
                #[must_use]
                pub const fn plus_micros(self, micros: i64) -> Self {
                    Self(self.0.saturating_add(micros))
                }

                /// Seconds from `earlier` to this instant: true elapsed time.
                pub fn seconds_since(self, earlier: Self) -> f64 {
                    self.0.saturating_sub(earlier.0) as f64 / MICROS_PER_SECOND as f64
                }

                /// The Julian date of this instant, in this scale.
                pub fn julian_date(self) -> JulianDate {
                    // The same calendar as UTC, read on another clock.
                    Utc::from_micros_since_2000(self.0).julian_date()
                }
            }
        )*
    };
}

uniform_scales! {
    /// An instant of International Atomic Time.
    Tai,
    /// An instant of Terrestrial Time, the argument of the Sun and Moon formulas (once called ET
    /// and TDT; TDB differs by less than 2 ms).
    Tt,
    /// An instant of GPS time, as a receiver gives it.
    Gps,
}

impl Utc {
    /// The same instant of TAI.
    ///
    /// # Errors
    /// [`TimeScaleError::UtcBefore1972`].
    pub fn to_tai(self, leap_seconds: &LeapSeconds) -> Result<Tai, TimeScaleError> {
        let seconds = leap_seconds
            .tai_minus_utc_s(self)
            .ok_or(TimeScaleError::UtcBefore1972 { utc: self })?;
        Ok(Tai(self.micros_since_2000()).plus_micros(i64::from(seconds) * MICROS_PER_SECOND))
    }

    /// The same instant of Terrestrial Time.
    ///
    /// # Errors
    /// [`TimeScaleError::UtcBefore1972`].
    pub fn to_tt(self, leap_seconds: &LeapSeconds) -> Result<Tt, TimeScaleError> {
        self.to_tai(leap_seconds).map(Tai::to_tt)
    }

    /// The same instant of GPS time (negative before 1980-01-06).
    ///
    /// # Errors
    /// [`TimeScaleError::UtcBefore1972`].
    pub fn to_gps(self, leap_seconds: &LeapSeconds) -> Result<Gps, TimeScaleError> {
        self.to_tai(leap_seconds).map(Tai::to_gps)
    }

    /// The instant of this Unix time, µs since 1970-01-01 00:00:00 UTC without leap seconds.
    pub const fn from_unix_micros(micros: i64) -> Self {
        Self::from_micros_since_2000(
            micros.saturating_sub(DAYS_FROM_UNIX_ORIGIN_TO_2000 * MICROS_PER_DAY),
        )
    }

    /// Unix time, µs since 1970-01-01 00:00:00 UTC without leap seconds.
    pub const fn unix_micros(self) -> i64 {
        self.micros_since_2000().saturating_add(DAYS_FROM_UNIX_ORIGIN_TO_2000 * MICROS_PER_DAY)
    }
}

impl Tai {
    /// The same instant of UTC. During an inserted leap second, which [`Utc`] cannot write, UTC
    /// stands at the last microsecond before it, so that it never runs backwards.
    ///
    /// # Errors
    /// [`TimeScaleError::TaiBefore1972`].
    pub fn to_utc(self, leap_seconds: &LeapSeconds) -> Result<Utc, TimeScaleError> {
        let mut ends_before: Option<Utc> = None;
        for entry in leap_seconds.entries().iter().rev() {
            let offset_micros = i64::from(entry.tai_minus_utc_s) * MICROS_PER_SECOND;
            let utc = Utc::from_micros_since_2000(self.plus_micros(-offset_micros).0);
            if utc >= entry.begins() {
                return Ok(ends_before.map_or(utc, |end| utc.min(end.plus_micros(-1))));
            }
            ends_before = Some(entry.begins());
        }
        Err(TimeScaleError::TaiBefore1972 { tai: self })
    }

    /// The same instant of Terrestrial Time.
    pub const fn to_tt(self) -> Tt {
        Tt(self.0).plus_micros(TT_MINUS_TAI_MICROS)
    }

    /// The same instant of GPS time.
    pub const fn to_gps(self) -> Gps {
        Gps(self.0).plus_micros(-TAI_MINUS_GPS_MICROS)
    }
}

impl Tt {
    /// The same instant of TAI.
    pub const fn to_tai(self) -> Tai {
        Tai(self.0).plus_micros(-TT_MINUS_TAI_MICROS)
    }
}

impl Gps {
    /// The same instant of TAI.
    pub const fn to_tai(self) -> Tai {
        Tai(self.0).plus_micros(TAI_MINUS_GPS_MICROS)
    }

    /// Microseconds since 1980-01-06 00:00:00, the origin of GPS time.
    pub const fn micros_since_1980(self) -> i64 {
        self.0.saturating_add(DAYS_FROM_GPS_ORIGIN_TO_2000 * MICROS_PER_DAY)
    }

    /// From the full week number (without the roll-over of 1024 weeks that older messages have) and
    /// the time of week, µs.
    pub const fn from_week(week: u16, micros_of_week: i64) -> Self {
        let since_1980 = (week as i64 * MICROS_PER_WEEK).saturating_add(micros_of_week);
        Self(since_1980.saturating_sub(DAYS_FROM_GPS_ORIGIN_TO_2000 * MICROS_PER_DAY))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const TABLE: LeapSeconds = LeapSeconds::BUILT_IN;

    fn utc(text: &str) -> Utc {
        Utc::parse(text).unwrap()
    }

    #[test]
    fn tt_of_2026_is_69_184_s_ahead_of_utc() {
        let noon = utc("2026-11-21T12:00:00Z");
        let tt = noon.to_tt(&TABLE).unwrap();
        assert_eq!(tt.micros_since_2000() - noon.micros_since_2000(), 69_184_000);
        assert_eq!(tt.to_tai().to_utc(&TABLE), Ok(noon));
    }

    #[test]
    fn gps_time_starts_at_its_origin_and_counts_weeks() {
        let origin = utc("1980-01-06T00:00:00Z").to_gps(&TABLE).unwrap();
        assert_eq!(origin.micros_since_1980(), 0);
        assert_eq!(Gps::from_week(0, 0), origin);
        // The second roll-over of the ten-bit week number: week 2048 began 2019-04-07 in GPS time,
        // which was 18 s ahead of UTC.
        let rollover = Gps::from_week(2048, 0).to_tai().to_utc(&TABLE);
        assert_eq!(rollover, Ok(utc("2019-04-06T23:59:42Z")));
    }

    #[test]
    fn before_1972_is_a_named_error() {
        let early = utc("1971-12-31T23:59:59.999999Z");
        assert_eq!(early.to_tt(&TABLE), Err(TimeScaleError::UtcBefore1972 { utc: early }));
        let first = utc("1972-01-01T00:00:00Z").to_tai(&TABLE).unwrap();
        assert_eq!(first.to_utc(&TABLE), Ok(utc("1972-01-01T00:00:00Z")));
        let tai = first.plus_micros(-1);
        assert_eq!(tai.to_utc(&TABLE), Err(TimeScaleError::TaiBefore1972 { tai }));
    }

    #[test]
    fn utc_stands_still_during_an_inserted_second_and_never_runs_backwards() {
        let last = utc("2016-12-31T23:59:59.999999Z");
        let tai = last.to_tai(&TABLE).unwrap();
        for micros in [0, 1, 500_000, 1_000_000] {
            assert_eq!(tai.plus_micros(micros).to_utc(&TABLE), Ok(last), "{micros} µs");
        }
        assert_eq!(tai.plus_micros(1_000_001).to_utc(&TABLE), Ok(last.plus_micros(1)));
    }

    proptest! {
        #[test]
        fn utc_survives_the_way_to_tai_and_back(
            seconds in -883_612_800_i64..3_000_000_000,
            micros in 0_i64..MICROS_PER_SECOND,
        ) {
            let utc = Utc::from_micros_since_2000(seconds * MICROS_PER_SECOND + micros);
            prop_assert_eq!(utc.to_tai(&TABLE).unwrap().to_utc(&TABLE), Ok(utc));
        }

        #[test]
        fn no_instant_overflows(micros in any::<i64>()) {
            let _ = Tai::from_micros_since_2000(micros).to_utc(&TABLE);
            let _ = Utc::from_micros_since_2000(micros).to_gps(&TABLE);
            let _ = Tai::from_micros_since_2000(micros).to_tt().julian_date();
        }
    }
}
