//! The place of an instant in its year.

use super::utc::days_from_civil;
use super::{MICROS_PER_DAY, Utc};

impl Utc {
    /// Day of the year with its fraction: 1.0 is the midnight that begins the first of January.
    pub fn day_of_year(self) -> f64 {
        let whole_days = self.days_since_2000() - days_from_civil(self.civil().year, 1, 1);
        1.0 + (whole_days as f64 + self.micros_of_day() as f64 / MICROS_PER_DAY as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_day_of_a_leap_year_is_day_366() {
        let day = |text| Utc::parse(text).unwrap().day_of_year();
        assert_eq!(day("2024-01-01T00:00:00Z"), 1.0);
        assert_eq!(day("2024-12-31T12:00:00Z"), 366.5);
        assert_eq!(day("2100-12-31T06:00:00Z"), 365.25);
        assert_eq!(day("1969-03-01T00:00:00Z"), 60.0);
    }
}
