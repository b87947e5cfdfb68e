//! Coordinated Universal Time as an integer count of microseconds.

use core::fmt;

use serde::{Deserialize, Serialize};

use super::{JulianDate, MICROS_PER_DAY, MICROS_PER_SECOND};

/// An instant of UTC: microseconds since 2000-01-01 00:00:00 in uniform days of 86,400 s.
///
/// An inserted leap second (23:59:60) cannot be written; clocks on board repeat or stretch the
/// second before it. Differences across a leap second are one second short.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Utc(i64);

/// A date and time of day as people write it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CivilDateTime {
    /// Year of the Gregorian calendar.
    pub year: i32,
    /// Month, 1 to 12.
    pub month: u8,
    /// Day of the month, 1 to 31.
    pub day: u8,
    /// Hour, 0 to 23.
    pub hour: u8,
    /// Minute, 0 to 59.
    pub minute: u8,
    /// Second, 0 to 59.
    pub second: u8,
    /// Microsecond, 0 to 999,999.
    pub microsecond: u32,
}

/// Why a text is not an instant of UTC.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum UtcError {
    /// Not of the form `2015-11-19T02:55:21.392832Z`; the byte (from 0) where it departs from it.
    Form {
        /// Position of the first byte that does not fit.
        at: usize,
    },
    /// A field is outside its calendar range.
    Range {
        /// Which field: `"month"`, `"day"`, `"hour"`, `"minute"` or `"second"`.
        field: &'static str,
        /// What it says.
        found: u32,
    },
}

impl fmt::Display for UtcError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Form { at } => write!(
                f,
                "not a UTC instant such as 2015-11-19T02:55:21.392832Z (it departs at character {})",
                at + 1
            ),
            Self::Range { field, found } => write!(f, "the {field} {found} does not exist"),
        }
    }
}

impl core::error::Error for UtcError {}

impl Utc {
    /// Julian day number of the origin, 2000-01-01 00:00:00.
    const ORIGIN_JULIAN_DAY: f64 = 2_451_544.5;

    /// The instant `micros` microseconds after 2000-01-01 00:00:00.
    pub const fn from_micros_since_2000(micros: i64) -> Self {
        Self(micros)
    }

    /// Microseconds since 2000-01-01 00:00:00.
    pub const fn micros_since_2000(self) -> i64 {
        self.0
    }

    /// The instant `micros_of_day` microseconds after the midnight that begins the day
    /// `days_since_2000` (0 is 2000-01-01). Saturates at the ends of the 292,000-year range.
    pub const fn from_day(days_since_2000: i32, micros_of_day: i64) -> Self {
        Self((days_since_2000 as i64).saturating_mul(MICROS_PER_DAY).saturating_add(micros_of_day))
    }

    /// Whole days since 2000-01-01.
    pub const fn days_since_2000(self) -> i64 {
        self.0.div_euclid(MICROS_PER_DAY)
    }

    /// Microseconds since midnight.
    pub const fn micros_of_day(self) -> i64 {
        self.0.rem_euclid(MICROS_PER_DAY)
    }

    /// This instant moved by `micros` microseconds (saturating).
    #[must_use]
    pub const fn plus_micros(self, micros: i64) -> Self {
        Self(self.0.saturating_add(micros))
    }

    /// Microseconds from `earlier` to this instant (negative when it is later; saturating).
    pub const fn micros_since(self, earlier: Self) -> i64 {
        self.0.saturating_sub(earlier.0)
    }

    /// Seconds from `earlier` to this instant.
    pub fn seconds_since(self, earlier: Self) -> f64 {
        self.micros_since(earlier) as f64 / MICROS_PER_SECOND as f64
    }

    /// The UTC Julian date of this instant.
    pub fn julian_date(self) -> JulianDate {
        JulianDate {
            day: Self::ORIGIN_JULIAN_DAY + self.days_since_2000() as f64,
            fraction: self.micros_of_day() as f64 / MICROS_PER_DAY as f64,
        }
    }

    /// From calendar and clock.
    ///
    /// # Errors
    /// [`UtcError::Range`] for a field outside its range; second 60 is refused (see the type).
    pub fn from_civil(civil: CivilDateTime) -> Result<Self, UtcError> {
        let CivilDateTime { year, month, day, hour, minute, second, microsecond } = civil;
        let check = |field, found: u32, low: u32, high: u32| {
            if (low..=high).contains(&found) {
                Ok(())
            } else {
                Err(UtcError::Range { field, found })
            }
        };
        check("year", year.unsigned_abs(), 1, 9_999)?;
        check("month", month.into(), 1, 12)?;
        check("day", day.into(), 1, days_in_month(year, month))?;
        check("hour", hour.into(), 0, 23)?;
        check("minute", minute.into(), 0, 59)?;
        check("second", second.into(), 0, 59)?;
        check("microsecond", microsecond, 0, 999_999)?;
        let seconds = i64::from(hour) * 3_600 + i64::from(minute) * 60 + i64::from(second);
        let days = days_from_civil(year, month, day);
        Ok(Self(days * MICROS_PER_DAY + seconds * MICROS_PER_SECOND + i64::from(microsecond)))
    }

    /// Calendar and clock of this instant (Gregorian, also before 1582).
    pub fn civil(self) -> CivilDateTime {
        let (year, month, day) = civil_from_days(self.days_since_2000());
        let micros = self.micros_of_day();
        let seconds = micros / MICROS_PER_SECOND;
        CivilDateTime {
            year,
            month,
            day,
            hour: (seconds / 3_600) as u8,
            minute: (seconds / 60 % 60) as u8,
            second: (seconds % 60) as u8,
            microsecond: (micros % MICROS_PER_SECOND) as u32,
        }
    }

    /// Reads `2015-11-19T02:55:21Z`, with up to six digits of a fraction (further digits must be
    /// zero).
    ///
    /// # Errors
    /// [`UtcError::Form`] with the place, or [`UtcError::Range`] with the field.
    pub fn parse(text: &str) -> Result<Self, UtcError> {
        let mut rest = Scanner { bytes: text.as_bytes(), at: 0 };
        let year = rest.digits(4)?;
        rest.literal(b'-')?;
        let month = rest.digits(2)? as u8;
        rest.literal(b'-')?;
        let day = rest.digits(2)? as u8;
        rest.literal(b'T')?;
        let hour = rest.digits(2)? as u8;
        rest.literal(b':')?;
        let minute = rest.digits(2)? as u8;
        rest.literal(b':')?;
        let second = rest.digits(2)? as u8;
        let microsecond = rest.fraction()?;
        rest.literal(b'Z')?;
        if rest.at != rest.bytes.len() {
            return Err(UtcError::Form { at: rest.at });
        }
        let year = year as i32;
        Self::from_civil(CivilDateTime { year, month, day, hour, minute, second, microsecond })
    }
}

/// `2015-11-19T02:55:21.392832Z`: always six digits of a fraction, so that columns line up.
impl fmt::Display for Utc {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let CivilDateTime { year, month, day, hour, minute, second, microsecond } = self.civil();
        write!(
            f,
            "{year:04}-{month:02}-{day:02}T{hour:02}:{minute:02}:{second:02}.{microsecond:06}Z"
        )
    }
}

/// Reads a fixed form byte by byte and remembers where it stands.
struct Scanner<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl Scanner<'_> {
    fn peek(&self) -> Option<u8> {
        self.bytes.get(self.at).copied()
    }

    fn literal(&mut self, expected: u8) -> Result<(), UtcError> {
        if self.peek() != Some(expected) {
            return Err(UtcError::Form { at: self.at });
        }
        self.at += 1;
        Ok(())
    }

    fn digit(&mut self) -> Result<u32, UtcError> {
        let byte = self.peek().filter(u8::is_ascii_digit).ok_or(UtcError::Form { at: self.at })?;
        self.at += 1;
        Ok(u32::from(byte - b'0'))
    }

    fn digits(&mut self, count: usize) -> Result<u32, UtcError> {
        (0..count).try_fold(0, |value, _| Ok(value * 10 + self.digit()?))
    }

    /// `.392832` as microseconds; nothing there is zero.
    fn fraction(&mut self) -> Result<u32, UtcError> {
        if self.peek() != Some(b'.') {
            return Ok(0);
        }
        self.at += 1;
        let mut micros = self.digit()? * 100_000;
        let mut weight = 10_000;
        while self.peek().is_some_and(|byte| byte.is_ascii_digit()) {
            let at = self.at;
            let digit = self.digit()?;
            if weight == 0 && digit != 0 {
                return Err(UtcError::Form { at });
            }
            micros += digit * weight;
            weight /= 10;
        }
        Ok(micros)
    }
}

fn is_leap(year: i32) -> bool {
    (year % 4 == 0 && year % 100 != 0) || year % 400 == 0
}

fn days_in_month(year: i32, month: u8) -> u32 {
    match month {
        2 => 28 + u32::from(is_leap(year)),
        4 | 6 | 9 | 11 => 30,
        _ => 31,
    }
}

/// Days from 2000-03-01 to the first day of the calendar's 400-year era is a multiple of 146,097;
/// years are counted from March so that the leap day is the last.
const DAYS_PER_ERA: i64 = 146_097;
/// Days from 2000-01-01 to 2000-03-01.
const JANUARY_AND_FEBRUARY_2000: i64 = 60;

pub(super) fn days_from_civil(year: i32, month: u8, day: u8) -> i64 {
    let year_from_march = i64::from(year) - i64::from(month <= 2) - 2_000;
    let era = year_from_march.div_euclid(400);
    let year_of_era = year_from_march.rem_euclid(400);
    let month_from_march = (i64::from(month) + 9) % 12;
    // 153 days in each five months from March: 31, 30, 31, 30, 31.
    let day_of_year = (153 * month_from_march + 2) / 5 + i64::from(day) - 1;
    let day_of_era = year_of_era * 365 + year_of_era / 4 - year_of_era / 100 + day_of_year;
    era * DAYS_PER_ERA + day_of_era + JANUARY_AND_FEBRUARY_2000
}

fn civil_from_days(days_since_2000: i64) -> (i32, u8, u8) {
    let days = days_since_2000 - JANUARY_AND_FEBRUARY_2000;
    let era = days.div_euclid(DAYS_PER_ERA);
    let day_of_era = days.rem_euclid(DAYS_PER_ERA);
    // Take out the leap days: after each 4, 100 and 400 years.
    let year_of_era =
        (day_of_era - day_of_era / 1_460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let month_from_march = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * month_from_march + 2) / 5 + 1;
    let month = if month_from_march < 10 { month_from_march + 3 } else { month_from_march - 9 };
    let year = 2_000 + era * 400 + year_of_era + i64::from(month <= 2);
    (year as i32, month as u8, day as u8)
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::string::ToString;

    #[test]
    fn the_epoch_of_a_tle_is_exact_to_the_microsecond() {
        let utc = Utc::parse("2015-11-19T02:55:21.392832Z").unwrap();
        assert_eq!(utc.to_string(), "2015-11-19T02:55:21.392832Z");
        let date = utc.julian_date();
        assert_eq!(date.day, 2_457_345.5);
        assert_eq!(date.fraction, 0.121_775_38);
    }

    #[test]
    fn every_day_of_four_centuries_survives_the_calendar_and_back() {
        let mut previous = (0, 0, 0);
        for day in -146_097..146_097_i32 {
            let utc = Utc::from_day(day, 1);
            let civil = utc.civil();
            assert_eq!(Utc::from_civil(civil), Ok(utc));
            let date = (civil.year, civil.month, civil.day);
            assert!(date > previous);
            previous = date;
        }
    }

    #[test]
    fn wrong_text_is_refused_at_its_place() {
        assert_eq!(Utc::parse("2015-11-19 02:55:21Z"), Err(UtcError::Form { at: 10 }));
        assert_eq!(Utc::parse("2015-11-19T02:55:21"), Err(UtcError::Form { at: 19 }));
        assert_eq!(Utc::parse("2015-11-19T02:55:21Zx"), Err(UtcError::Form { at: 20 }));
        assert_eq!(Utc::parse("2015-11-19T02:55:21.1234567Z"), Err(UtcError::Form { at: 26 }));
        assert_eq!(
            Utc::parse("2015-02-29T00:00:00Z"),
            Err(UtcError::Range { field: "day", found: 29 })
        );
        assert_eq!(
            Utc::parse("2016-12-31T23:59:60Z"),
            Err(UtcError::Range { field: "second", found: 60 })
        );
    }
}
