//! The Julian date, in two parts.

/// A Julian date as a whole-or-half day and a fraction, so that both keep their precision.
///
/// The sum of the two is the date; `day` normally ends in `.5` (midnight) and `fraction` lies in
/// 0 to 1. Which time scale it counts is said by whoever hands it out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JulianDate {
    /// Julian day number of the midnight before, days.
    pub day: f64,
    /// Time since then, days.
    pub fraction: f64,
}

impl JulianDate {
    /// 2000-01-01 12:00, the epoch J2000.0.
    pub const J2000_DAY: f64 = 2_451_545.0;
    /// Days in a Julian century.
    pub const DAYS_PER_CENTURY: f64 = 36_525.0;

    /// Julian centuries since J2000.0, in the scale of the date itself.
    pub fn centuries_since_j2000(&self) -> f64 {
        ((self.day - Self::J2000_DAY) + self.fraction) / Self::DAYS_PER_CENTURY
    }
}
