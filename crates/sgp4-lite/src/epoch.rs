//! The instant at which a set of elements holds.

/// Julian date of 2000-01-01 00:00, the origin of [`Epoch::days_since_j2000_midnight`].
const J2000_MIDNIGHT_JULIAN_DATE: f64 = 2_451_544.5;

/// Microseconds in a UTC day without a leap second.
const MICROS_PER_DAY: i64 = 86_400_000_000;

/// Days from 0001-01-01 to 2000-01-01 in the proleptic Gregorian calendar: 1999 years with
/// 499 - 19 + 4 leap days.
const DAYS_FROM_YEAR_1_TO_2000: i32 = 1999 * 365 + 484;

/// An instant in UTC, exact to the microsecond: a whole day and the microseconds gone by in it.
///
/// Days have 86,400 s, as everywhere in SGP4: an epoch inside an inserted leap second cannot be
/// written. The day fractions of a TLE (8 decimals, steps of 864 µs) are represented exactly.
///
/// Ordering is by time.
///
/// ```
/// # use sgp4_lite::Epoch;
/// // Day 323.5 of 2015 is noon on 19 November.
/// let epoch = Epoch::from_day_of_year(2015, 323, 43_200_000_000).unwrap();
/// assert_eq!(epoch, Epoch::from_calendar(2015, 11, 19, 43_200_000_000).unwrap());
/// assert_eq!(epoch.julian_date(), (2_457_345.5, 0.5));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(try_from = "Parts", into = "Parts"))]
pub struct Epoch {
    days_since_j2000_midnight: i32,
    micros_of_day: i64,
}

impl Epoch {
    /// First year that can be written.
    pub const FIRST_YEAR: u16 = 1900;
    /// Last year that can be written.
    pub const LAST_YEAR: u16 = 2199;

    /// 2000-01-01 00:00 UTC.
    pub const J2000_MIDNIGHT: Self = Self { days_since_j2000_midnight: 0, micros_of_day: 0 };

    /// An instant from the year, the day in it (1 January is day 1) and the time of that day.
    ///
    /// `None` when the year is outside [`FIRST_YEAR`](Self::FIRST_YEAR) to
    /// [`LAST_YEAR`](Self::LAST_YEAR), has no such day, or the time is not within a day.
    #[must_use]
    pub fn from_day_of_year(year: u16, day_of_year: u16, micros_of_day: i64) -> Option<Self> {
        let in_year = (1..=days_in_year(year)).contains(&day_of_year);
        if !in_year || !(Self::FIRST_YEAR..=Self::LAST_YEAR).contains(&year) {
            return None;
        }
        let days = days_to_new_year(year) + i32::from(day_of_year) - 1;
        Self::from_days(days, micros_of_day)
    }

    /// An instant from the calendar date (January is month 1) and the time of that day.
    ///
    /// `None` when the year is outside [`FIRST_YEAR`](Self::FIRST_YEAR) to
    /// [`LAST_YEAR`](Self::LAST_YEAR), there is no such date, or the time is not within a day.
    #[must_use]
    pub fn from_calendar(year: u16, month: u8, day: u8, micros_of_day: i64) -> Option<Self> {
        if day == 0 || day > days_in_month(year, month)? {
            return None;
        }
        let before: u16 =
            (1..month).filter_map(|earlier| days_in_month(year, earlier)).map(u16::from).sum();
        Self::from_day_of_year(year, before + u16::from(day), micros_of_day)
    }

    /// An instant from whole days since 2000-01-01 00:00 UTC and the time of that day.
    ///
    /// `None` when the year would be outside [`FIRST_YEAR`](Self::FIRST_YEAR) to
    /// [`LAST_YEAR`](Self::LAST_YEAR), or the time is not within a day.
    #[must_use]
    pub fn from_days(days_since_j2000_midnight: i32, micros_of_day: i64) -> Option<Self> {
        let first = days_to_new_year(Self::FIRST_YEAR);
        let end = days_to_new_year(Self::LAST_YEAR + 1);
        let in_range = (first..end).contains(&days_since_j2000_midnight)
            && (0..MICROS_PER_DAY).contains(&micros_of_day);
        in_range.then_some(Self { days_since_j2000_midnight, micros_of_day })
    }

    /// Whole days from 2000-01-01 00:00 UTC to the midnight that begins this epoch's day.
    #[must_use]
    pub const fn days_since_j2000_midnight(&self) -> i32 {
        self.days_since_j2000_midnight
    }

    /// Microseconds since midnight UTC, 0 to 86,399,999,999.
    #[must_use]
    pub const fn micros_of_day(&self) -> i64 {
        self.micros_of_day
    }

    /// Part of the day gone by, 0 to 1.
    #[must_use]
    pub fn fraction_of_day(&self) -> f64 {
        // Both integers are below 2^53, so the quotient is the double nearest to the true value.
        self.micros_of_day as f64 / MICROS_PER_DAY as f64
    }

    /// Julian date (UTC) in two parts: midnight, which ends in .5, and the fraction of the day.
    ///
    /// Kept apart they hold the microsecond; added into one `f64` they are good to 40 µs.
    #[must_use]
    pub fn julian_date(&self) -> (f64, f64) {
        let midnight = J2000_MIDNIGHT_JULIAN_DATE + f64::from(self.days_since_j2000_midnight);
        (midnight, self.fraction_of_day())
    }

    /// Minutes from `earlier` to `self`; negative when `self` comes first.
    #[must_use]
    pub fn minutes_since(&self, earlier: Self) -> f64 {
        let days = i64::from(self.days_since_j2000_midnight)
            - i64::from(earlier.days_since_j2000_midnight);
        let micros = days * MICROS_PER_DAY + (self.micros_of_day - earlier.micros_of_day);
        micros as f64 / 60e6
    }

    /// Year of the Gregorian calendar.
    #[must_use]
    pub fn year(&self) -> u16 {
        self.year_and_day().0
    }

    /// Day of the year; 1 January is day 1.
    #[must_use]
    pub fn day_of_year(&self) -> u16 {
        self.year_and_day().1
    }

    fn year_and_day(&self) -> (u16, u16) {
        // The mean year is 365.2425 days, so this guess is at most one year off.
        let guess = 2000 + self.days_since_j2000_midnight.div_euclid(365);
        let mut year = u16::try_from(guess).unwrap_or(Self::LAST_YEAR).min(Self::LAST_YEAR);
        while year > Self::FIRST_YEAR && days_to_new_year(year) > self.days_since_j2000_midnight {
            year -= 1;
        }
        while year < Self::LAST_YEAR && days_to_new_year(year + 1) <= self.days_since_j2000_midnight
        {
            year += 1;
        }
        let day = self.days_since_j2000_midnight - days_to_new_year(year) + 1;
        (year, u16::try_from(day).unwrap_or(1))
    }
}

/// Days in a year of the Gregorian calendar.
fn days_in_year(year: u16) -> u16 {
    if is_leap(year) { 366 } else { 365 }
}

fn is_leap(year: u16) -> bool {
    year.is_multiple_of(4) && (!year.is_multiple_of(100) || year.is_multiple_of(400))
}

/// Days in a month, January being 1. `None` when there is no such month.
fn days_in_month(year: u16, month: u8) -> Option<u8> {
    match month {
        1 | 3 | 5 | 7 | 8 | 10 | 12 => Some(31),
        4 | 6 | 9 | 11 => Some(30),
        2 => Some(if is_leap(year) { 29 } else { 28 }),
        _ => None,
    }
}

/// Days from 2000-01-01 to 1 January of `year`.
fn days_to_new_year(year: u16) -> i32 {
    let years = i32::from(year) - 1;
    let leap_days = years.div_euclid(4) - years.div_euclid(100) + years.div_euclid(400);
    365 * years + leap_days - DAYS_FROM_YEAR_1_TO_2000
}

/// What [`Epoch`] looks like in `serde` formats.
#[cfg(feature = "serde")]
#[derive(serde::Serialize, serde::Deserialize)]
struct Parts {
    days_since_j2000_midnight: i32,
    micros_of_day: i64,
}

#[cfg(feature = "serde")]
impl From<Epoch> for Parts {
    fn from(epoch: Epoch) -> Self {
        let Epoch { days_since_j2000_midnight, micros_of_day } = epoch;
        Self { days_since_j2000_midnight, micros_of_day }
    }
}

#[cfg(feature = "serde")]
impl TryFrom<Parts> for Epoch {
    type Error = &'static str;

    fn try_from(parts: Parts) -> Result<Self, Self::Error> {
        Self::from_days(parts.days_since_j2000_midnight, parts.micros_of_day)
            .ok_or("epoch outside 1900 to 2199, or time of day outside 0 to 86,399,999,999 µs")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_dates_have_their_julian_dates() {
        // Meeus, Astronomical Algorithms, table 7.A and examples; midnight values.
        for ((year, month, day), jd) in [
            ((2000, 1, 1), 2_451_544.5),
            ((1999, 1, 1), 2_451_179.5),
            ((1987, 1, 27), 2_446_822.5),
            ((1988, 6, 19), 2_447_331.5),
            ((1900, 1, 1), 2_415_020.5),
            ((1957, 10, 4), 2_436_115.5),
        ] {
            let epoch = Epoch::from_calendar(year, month, day, 0).unwrap();
            assert_eq!(epoch.julian_date(), (jd, 0.0), "{year}-{month}-{day}");
        }
    }

    #[test]
    fn every_day_of_three_centuries_reads_back_as_itself() {
        let mut expected_days = days_to_new_year(Epoch::FIRST_YEAR);
        for year in Epoch::FIRST_YEAR..=Epoch::LAST_YEAR {
            let mut day_of_year = 0;
            for month in 1..=12 {
                for day in 1..=days_in_month(year, month).unwrap() {
                    day_of_year += 1;
                    let epoch = Epoch::from_calendar(year, month, day, 1).unwrap();
                    assert_eq!(epoch.days_since_j2000_midnight(), expected_days);
                    assert_eq!((epoch.year(), epoch.day_of_year()), (year, day_of_year));
                    assert_eq!(Epoch::from_day_of_year(year, day_of_year, 1), Some(epoch));
                    expected_days += 1;
                }
            }
            assert_eq!(day_of_year, days_in_year(year));
        }
    }

    #[test]
    fn dates_that_do_not_exist_are_refused() {
        assert_eq!(Epoch::from_calendar(2023, 2, 29, 0), None);
        assert_eq!(Epoch::from_calendar(2100, 2, 29, 0), None);
        assert_eq!(Epoch::from_calendar(2024, 13, 1, 0), None);
        assert_eq!(Epoch::from_calendar(2024, 0, 1, 0), None);
        assert_eq!(Epoch::from_calendar(2024, 1, 0, 0), None);
        assert_eq!(Epoch::from_calendar(1899, 12, 31, 0), None);
        assert_eq!(Epoch::from_calendar(2200, 1, 1, 0), None);
        assert_eq!(Epoch::from_day_of_year(2023, 366, 0), None);
        assert_eq!(Epoch::from_day_of_year(2024, 367, 0), None);
        assert_eq!(Epoch::from_day_of_year(2024, 0, 0), None);
        assert_eq!(Epoch::from_day_of_year(2024, 1, MICROS_PER_DAY), None);
        assert_eq!(Epoch::from_day_of_year(2024, 1, -1), None);
        assert_eq!(Epoch::from_days(i32::MAX, 0), None);
        assert_eq!(Epoch::from_days(i32::MIN, 0), None);
    }

    #[test]
    fn minutes_are_counted_across_midnight_and_leap_days() {
        let before = Epoch::from_calendar(2024, 2, 28, MICROS_PER_DAY - 30_000_000).unwrap();
        let after = Epoch::from_calendar(2024, 3, 1, 30_000_000).unwrap();
        assert_eq!(after.minutes_since(before), 1441.0);
        assert_eq!(before.minutes_since(after), -1441.0);
    }
}
