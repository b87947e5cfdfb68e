//! Dates as the decimal years that IGRF is tabulated in.

use crate::Error;

/// A date as a decimal year: year + (seconds since 1 January 00:00 UTC) / (seconds in that year).
///
/// The main field changes by up to 220 nT a year (2026), so a second is nothing and the time scale
/// (UTC, TT) does not matter.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct DecimalYear(pub f64);

/// Seconds in a day; decimal years know no leap seconds.
const DAY_S: f64 = 86_400.0;

impl DecimalYear {
    /// The decimal year of a Gregorian calendar date and the seconds since its midnight (UTC).
    ///
    /// A leap second (`seconds_of_day` from 86400 to below 86401) counts into the next day.
    ///
    /// # Errors
    /// [`Error::Calendar`] when there is no such day or time of day.
    pub fn from_calendar(
        year: u16,
        month: u8,
        day: u8,
        seconds_of_day: f64,
    ) -> Result<Self, Error> {
        let refused = Error::Calendar { year, month, day, seconds_of_day };
        let is_leap =
            year.is_multiple_of(4) && (!year.is_multiple_of(100) || year.is_multiple_of(400));
        let february = if is_leap { 29 } else { 28 };
        let month_days = [31, february, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31];
        let Some(month_index) = usize::from(month).checked_sub(1) else { return Err(refused) };
        let Some(&days_in_month) = month_days.get(month_index) else { return Err(refused) };
        if !(1..=days_in_month).contains(&day) || !(0.0..DAY_S + 1.0).contains(&seconds_of_day) {
            return Err(refused);
        }
        let days_before_month: u16 =
            month_days.iter().take(month_index).map(|&days| u16::from(days)).sum();
        let days = f64::from(days_before_month) + f64::from(day) - 1.0;
        let year_s = DAY_S * if is_leap { 366.0 } else { 365.0 };
        Ok(Self(f64::from(year) + (days * DAY_S + seconds_of_day) / year_s))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn new_year_is_the_year_itself() {
        assert_eq!(DecimalYear::from_calendar(2025, 1, 1, 0.0), Ok(DecimalYear(2025.0)));
    }

    #[test]
    fn leap_day_exists_by_the_gregorian_rule() {
        assert!(DecimalYear::from_calendar(2000, 2, 29, 0.0).is_ok());
        assert!(DecimalYear::from_calendar(2024, 2, 29, 0.0).is_ok());
        for year in [1900, 2023, 2100] {
            assert!(DecimalYear::from_calendar(year, 2, 29, 0.0).is_err(), "{year}");
        }
    }

    #[test]
    fn middle_of_a_leap_year_is_a_half() {
        // 2 July is day 184 of 366: 183 days have passed.
        assert_eq!(DecimalYear::from_calendar(2024, 7, 2, 0.0), Ok(DecimalYear(2024.5)));
    }

    #[test]
    fn impossible_dates_and_times_are_refused_with_their_values() {
        for (month, day, seconds) in [
            (0, 1, 0.0),
            (13, 1, 0.0),
            (4, 31, 0.0),
            (1, 0, 0.0),
            (1, 32, 0.0),
            (1, 1, -1.0),
            (1, 1, 86_401.0),
            (1, 1, f64::INFINITY),
        ] {
            assert_eq!(
                DecimalYear::from_calendar(2020, month, day, seconds),
                Err(Error::Calendar { year: 2020, month, day, seconds_of_day: seconds })
            );
        }
        assert!(DecimalYear::from_calendar(2020, 1, 1, f64::NAN).is_err());
    }

    #[test]
    fn a_leap_second_is_the_first_second_of_the_next_day() {
        assert_eq!(
            DecimalYear::from_calendar(2015, 6, 30, 86_400.0),
            DecimalYear::from_calendar(2015, 7, 1, 0.0)
        );
    }
}
