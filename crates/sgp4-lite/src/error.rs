//! Why a satellite cannot be propagated.

use crate::Element;
use core::fmt;

/// Why a propagator cannot be built, or why there is no state at the time asked for.
///
/// | variant | classic code | from | meaning |
/// |---|---|---|---|
/// | `Element` | – | `new` | an element is not finite or outside its range |
/// | `DeepSpace` | – | `new` | period of 225 min or more, and feature `deep-space` is off |
/// | `DragModel` | – | `new` | the orbit makes the drag model divide by zero |
/// | `Time` | – | `propagate` | the time is not finite |
/// | `ResonanceTime` | – | `propagate` | resonant orbit, more than 20 years from the epoch |
/// | `MeanEccentricity` | 1 | `propagate` | mean eccentricity is 1 or more, or below -0.001 |
/// | `MeanMotion` | 2 | `propagate` | mean motion is not positive |
/// | `PerturbedEccentricity` | 3 | `propagate` | eccentricity after Moon and Sun is not in 0 to 1 |
/// | `SemiLatusRectum` | 4 | `propagate` | semi-latus rectum is negative |
/// | `Decayed` | 6 | `propagate` | the satellite is below the Earth's equatorial radius |
///
/// A number that is not a number counts as out of range in every one of these checks.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Error {
    /// An element is not finite or outside its range.
    Element {
        /// Which one.
        element: Element,
        /// Its value.
        value: f64,
    },
    /// The orbit needs SDP4, and this build lacks the feature `deep-space`.
    DeepSpace {
        /// Period of the orbit; SGP4 proper ends at 225 minutes.
        period_min: f64,
    },
    /// The elements make the drag model divide by zero.
    DragModel {
        /// Mean perigee radius above the equatorial radius.
        perigee_height_km: f64,
    },
    /// The time since the epoch is not finite.
    Time {
        /// The time asked for.
        minutes_since_epoch: f64,
    },
    /// The orbit is in resonance with the Earth's rotation, which is integrated step by step, and
    /// the time is further from the epoch than the integration goes.
    ResonanceTime {
        /// The time asked for.
        minutes_since_epoch: f64,
    },
    /// Mean eccentricity out of range.
    MeanEccentricity {
        /// The mean eccentricity after drag.
        eccentricity: f64,
        /// The time asked for.
        minutes_since_epoch: f64,
    },
    /// Mean motion not positive.
    MeanMotion {
        /// The mean motion after resonance.
        rad_per_min: f64,
        /// The time asked for.
        minutes_since_epoch: f64,
    },
    /// Eccentricity after the lunar and solar periodic terms out of range.
    PerturbedEccentricity {
        /// The perturbed eccentricity.
        eccentricity: f64,
        /// The time asked for.
        minutes_since_epoch: f64,
    },
    /// Semi-latus rectum negative.
    SemiLatusRectum {
        /// The semi-latus rectum.
        earth_radii: f64,
        /// The time asked for.
        minutes_since_epoch: f64,
    },
    /// The satellite has decayed.
    Decayed {
        /// The distance from the centre of the Earth, below 1.
        radius_earth_radii: f64,
        /// The time asked for.
        minutes_since_epoch: f64,
    },
}

impl Error {
    /// The number that the reference implementation of SGP4 (Vallado et al., AIAA 2006-6753) gives
    /// to this condition; `None` for conditions which it does not check.
    #[must_use]
    pub const fn code(&self) -> Option<u8> {
        match self {
            Self::MeanEccentricity { .. } => Some(1),
            Self::MeanMotion { .. } => Some(2),
            Self::PerturbedEccentricity { .. } => Some(3),
            Self::SemiLatusRectum { .. } => Some(4),
            Self::Decayed { .. } => Some(6),
            Self::Element { .. }
            | Self::DeepSpace { .. }
            | Self::DragModel { .. }
            | Self::Time { .. }
            | Self::ResonanceTime { .. } => None,
        }
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Element { element, value } => {
                write!(f, "{} is out of range: {value}", element.name())
            }
            Self::DeepSpace { period_min } => write!(
                f,
                "the period is {period_min:.1} min; orbits of 225 min and more need the feature \
                 deep-space"
            ),
            Self::DragModel { perigee_height_km } => {
                write!(f, "no drag model for a perigee height of {perigee_height_km:.3} km")
            }
            Self::Time { minutes_since_epoch } => {
                write!(f, "time since the epoch is not finite: {minutes_since_epoch}")
            }
            Self::ResonanceTime { minutes_since_epoch } => write!(
                f,
                "resonant orbit: {minutes_since_epoch} min is more than 20 years from the epoch"
            ),
            Self::MeanEccentricity { eccentricity, minutes_since_epoch } => write!(
                f,
                "mean eccentricity out of range: {eccentricity} at {minutes_since_epoch} min"
            ),
            Self::MeanMotion { rad_per_min, minutes_since_epoch } => write!(
                f,
                "mean motion not positive: {rad_per_min} rad/min at {minutes_since_epoch} min"
            ),
            Self::PerturbedEccentricity { eccentricity, minutes_since_epoch } => write!(
                f,
                "perturbed eccentricity out of range: {eccentricity} at {minutes_since_epoch} min"
            ),
            Self::SemiLatusRectum { earth_radii, minutes_since_epoch } => write!(
                f,
                "semi-latus rectum negative: {earth_radii} Earth radii at {minutes_since_epoch} min"
            ),
            Self::Decayed { radius_earth_radii, minutes_since_epoch } => write!(
                f,
                "decayed: {radius_earth_radii} Earth radii from the centre at \
                 {minutes_since_epoch} min"
            ),
        }
    }
}

impl core::error::Error for Error {}
