//! Why there is no calibration.

use core::fmt;

/// One of the unknowns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Unknown {
    /// Scale of this axis, 0 to 2.
    Scale(u8),
    /// Bias of this axis.
    Bias(u8),
    /// A cross-axis term: 0 for xy, 1 for xz, 2 for yz.
    CrossAxis(u8),
    /// What a current does to an axis.
    Coupling {
        /// The current, from 0.
        current: u8,
        /// Axis 0, 1 or 2.
        axis: u8,
    },
}

impl Unknown {
    /// From its place among the unknowns.
    pub(super) fn at(index: usize) -> Self {
        match index as u8 {
            axis @ 0..=2 => Self::Scale(axis),
            bias @ 3..=5 => Self::Bias(bias - 3),
            pair @ 6..=8 => Self::CrossAxis(pair - 6),
            later => Self::Coupling { current: (later - 9) / 3, axis: later % 3 },
        }
    }
}

/// "the scale of axis 0"
impl fmt::Display for Unknown {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Scale(axis) => write!(f, "the scale of axis {axis}"),
            Self::Bias(axis) => write!(f, "the bias of axis {axis}"),
            Self::CrossAxis(pair) => {
                let axes = match pair {
                    0 => "x and y",
                    1 => "x and z",
                    _ => "y and z",
                };
                write!(f, "the angle between {axes}")
            }
            Self::Coupling { current, axis } => {
                write!(f, "the coupling of current {current} to axis {axis}")
            }
        }
    }
}

/// Why there is no calibration; what was known before should stay in force.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum CalibrationError {
    /// Fewer samples than twice the unknowns.
    TooFew {
        /// How many there are.
        found: u32,
        /// How many it takes.
        needed: u32,
    },
    /// A reading or a strength is not finite.
    NotFinite {
        /// The sample, from 0.
        sample: u32,
    },
    /// A strength is not positive.
    Intensity {
        /// The sample, from 0.
        sample: u32,
        /// What was given.
        found: f32,
    },
    /// An axis shows the same value in all samples.
    Constant {
        /// Axis 0, 1 or 2.
        axis: u8,
        /// What it shows.
        found: f32,
    },
    /// A current shows the same value in all samples: what it does cannot be told from a bias.
    ConstantCurrent {
        /// The current, from 0.
        index: u8,
        /// Its largest value.
        found: f32,
    },
    /// The sensitivity to start from is not finite and positive.
    Sensitivity {
        /// What was given.
        found: f32,
    },
    /// The reading without field is not finite.
    Zero {
        /// What was given.
        found: f32,
    },
    /// The noise that was told is not finite, or negative.
    Noise {
        /// What was given.
        found: f32,
    },
    /// The readings are on no ellipsoid: the linear start has a squared scale that is not positive.
    NoEllipsoid {
        /// Axis 0, 1 or 2.
        axis: u8,
    },
    /// The readings do not point in enough directions to tell the unknowns apart.
    PoorGeometry {
        /// Condition of the scaled normal matrix.
        condition: f32,
        /// The largest that is accepted.
        limit: f32,
        /// The unknown with the largest part in the combination that is known least.
        weakest: Unknown,
    },
    /// The steps did not become small.
    NotConverged {
        /// Walks through the samples.
        passes: u32,
    },
    /// An axis hardly answers to the field: its scale is zero within three sigma.
    NoScale {
        /// Axis 0, 1 or 2.
        axis: u8,
        /// Its scale.
        found: f32,
        /// The standard deviation of that.
        sigma: f32,
    },
    /// The numbers are too large, or too small, for the type.
    OutOfRange,
}

impl fmt::Display for CalibrationError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooFew { found, needed } => {
                write!(f, "{found} samples are too few: it takes {needed}, two for each unknown")
            }
            Self::NotFinite { sample } => write!(f, "sample {sample} is not finite"),
            Self::Intensity { sample, found } => {
                write!(f, "sample {sample}: a field of strength {found}; it must be positive")
            }
            Self::Constant { axis, found } => {
                write!(f, "axis {axis} shows {found} in all samples")
            }
            Self::ConstantCurrent { index, found } => write!(
                f,
                "current {index} is {found} in all samples: what it does cannot be told from a bias"
            ),
            Self::Sensitivity { found } => {
                write!(f, "the sensitivity {found} must be finite and positive")
            }
            Self::Zero { found } => write!(f, "the zero {found} must be finite"),
            Self::Noise { found } => {
                write!(f, "the noise {found} must be finite and not negative")
            }
            Self::NoEllipsoid { axis } => write!(
                f,
                "the readings are on no ellipsoid (the linear start has no scale for axis {axis}): \
                 start from the data sheet"
            ),
            Self::PoorGeometry { condition, limit, weakest } => write!(
                f,
                "the field came from too few directions: condition {condition}, at most {limit}; \
                 known least is {weakest}"
            ),
            Self::NotConverged { passes } => {
                write!(f, "no solution after {passes} passes: is the start too far away?")
            }
            Self::NoScale { axis, found, sigma } => write!(
                f,
                "axis {axis} hardly answers to the field: its scale is {found}, sigma {sigma}"
            ),
            Self::OutOfRange => write!(f, "the numbers are too large or too small to compute with"),
        }
    }
}

impl core::error::Error for CalibrationError {}
