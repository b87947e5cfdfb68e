//! Whether elements that came up from the ground can be those of this satellite now.

use crate::gravity::EARTH_RADIUS_KM;
use crate::mean_orbit::MeanOrbit;
use crate::{Element, Elements};
use core::fmt;

/// What [`check_plausibility`] accepts.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PlausibilityLimits {
    /// Longest time between the epoch and now, either way. SGP4 in low orbit errs by some
    /// kilometres after a few days and is useless after some weeks.
    pub max_days_from_epoch: f64,
    /// Lowest height of the mean perigee over the equatorial radius, 6378.135 km.
    pub min_perigee_height_km: f64,
    /// Slowest mean motion.
    pub min_mean_motion_rev_per_day: f64,
    /// Fastest mean motion.
    pub max_mean_motion_rev_per_day: f64,
}

impl PlausibilityLimits {
    /// Any orbit from the surface to beyond the synchronous one, with an epoch within this many
    /// days of now.
    #[must_use]
    pub const fn within_days(max_days_from_epoch: f64) -> Self {
        Self {
            max_days_from_epoch,
            min_perigee_height_km: 0.0,
            // A period of 20 days, 315,000 km: SGP4 has no place beyond.
            min_mean_motion_rev_per_day: 0.05,
            // A circle at the equatorial radius is 17.04 rev/day.
            max_mean_motion_rev_per_day: 17.04,
        }
    }
}

/// Why elements cannot be those of this satellite now.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Implausible {
    /// An element is not finite or outside its range.
    Element {
        /// Which one.
        element: Element,
        /// Its value.
        value: f64,
    },
    /// The epoch is further from now than allowed, or now is not a number.
    Epoch {
        /// Days from now to the epoch; negative when the epoch has passed.
        days_ahead: f64,
        /// The most allowed.
        limit: f64,
    },
    /// The mean motion is not between the limits.
    MeanMotion {
        /// The mean motion.
        rev_per_day: f64,
    },
    /// The orbit dips below the lowest height allowed.
    Perigee {
        /// Height of the mean perigee over the equatorial radius.
        height_km: f64,
        /// The least allowed.
        limit_km: f64,
    },
}

impl fmt::Display for Implausible {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Element { element, value } => {
                write!(f, "{} is out of range: {value}", element.name())
            }
            Self::Epoch { days_ahead, limit } => write!(
                f,
                "the epoch is {days_ahead:.2} days ahead of the clock; {limit} are allowed either way"
            ),
            Self::MeanMotion { rev_per_day } => {
                write!(f, "mean motion of {rev_per_day} rev/day is not allowed")
            }
            Self::Perigee { height_km, limit_km } => {
                write!(f, "perigee at {height_km:.1} km is below {limit_km} km")
            }
        }
    }
}

impl core::error::Error for Implausible {}

/// Whether these elements can be flown with now, for use before an uplinked set replaces the old.
///
/// Time is given in days since 2000-01-01 00:00 UTC, fractions included:
/// [`Epoch::days_since_j2000_midnight`](crate::Epoch::days_since_j2000_midnight) `+`
/// [`fraction_of_day`](crate::Epoch::fraction_of_day) of an epoch in this measure.
///
/// # Errors
/// The first of these that holds: an element is out of its range, the epoch is too far from now,
/// the mean motion is not between the limits, the perigee is too low.
pub fn check_plausibility(
    elements: &Elements,
    now_days_since_j2000_midnight: f64,
    limits: &PlausibilityLimits,
) -> Result<(), Implausible> {
    if let Some((element, value)) = elements.out_of_range() {
        return Err(Implausible::Element { element, value });
    }
    let epoch = elements.epoch;
    let days_ahead = f64::from(epoch.days_since_j2000_midnight()) + epoch.fraction_of_day()
        - now_days_since_j2000_midnight;
    let limit = limits.max_days_from_epoch;
    // Ranges hold no NaN, neither of the clock nor of the limits.
    if !(-limit..=limit).contains(&days_ahead) {
        return Err(Implausible::Epoch { days_ahead, limit });
    }
    let rev_per_day = elements.mean_motion_rev_per_day;
    let mean_motions = limits.min_mean_motion_rev_per_day..=limits.max_mean_motion_rev_per_day;
    if !mean_motions.contains(&rev_per_day) {
        return Err(Implausible::MeanMotion { rev_per_day });
    }
    let perigee_radius = MeanOrbit::new(elements).perigee_radius();
    let height_km = (perigee_radius - 1.0) * EARTH_RADIUS_KM;
    let limit_km = limits.min_perigee_height_km;
    if !(limit_km..).contains(&height_km) {
        return Err(Implausible::Perigee { height_km, limit_km });
    }
    Ok(())
}
