//! What must be known of the six faces, and why it may be refused.

use core::fmt;

use serde::{Deserialize, Serialize};

use crate::sensing::sun_face::{SunFaceError, SunFaceParameters};

/// Number of faces.
pub const FACES: usize = 6;

/// Alignments of faces on the six sides of a cube, boresights along +x, −x, +y, −y, +z, −z: quarter
/// turns about y and x, and a half turn.
pub const CUBE_XYZW: [[f32; 4]; FACES] = {
    const S: f32 = core::f32::consts::FRAC_1_SQRT_2;
    [
        [0.0, -S, 0.0, S],
        [0.0, S, 0.0, S],
        [S, 0.0, 0.0, S],
        [-S, 0.0, 0.0, S],
        [0.0, 0.0, 0.0, 1.0],
        [1.0, 0.0, 0.0, 0.0],
    ]
};

/// All six faces as they are stored, uplinked and written in mission files.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SunFacesParameters {
    /// The faces.
    pub faces: [SunFaceParameters; FACES],
    /// σ₀: noise of a face's direction about each axis across the line of sight, rad.
    pub sigma_rad: f32,
    /// The least light of a spot, as a fraction of what the Sun would give there, 0 to 1.
    pub faintest: f32,
    /// The most light, as such a multiple, above 1.
    pub brightest: f32,
    /// Two directions contradict each other when further apart than this many of their σ. Over two
    /// axes a chance of exp(−gate²/2).
    pub gate: f32,
}

impl SunFacesParameters {
    /// SPROUT's: σ of 0.664 deg is published; the rest assumed. 0.8: the Sun's distance takes 3.4 %,
    /// an ageing diode more, clouds give 0.55 at most. 1.5: the Sun at the edge with half as much
    /// light of the Earth. 5: a chance of 4e-6.
    pub const SPROUT: Self = Self {
        faces: {
            let [a, b, c, d, e, f] = CUBE_XYZW;
            [sprout(a), sprout(b), sprout(c), sprout(d), sprout(e), sprout(f)]
        },
        sigma_rad: 0.011_588_986,
        faintest: 0.8,
        brightest: 1.5,
        gate: 5.0,
    };
}

const fn sprout(alignment_xyzw: [f32; 4]) -> SunFaceParameters {
    SunFaceParameters { alignment_xyzw, ..SunFaceParameters::SPROUT }
}

/// Why parameters of the Sun sensors are refused.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum SunFacesError {
    /// One of the faces.
    Face {
        /// Which one, 0 to 5.
        face: u8,
        /// What is wrong with it.
        error: SunFaceError,
    },
    /// The noise is not between 0 and 1 rad, both excluded.
    Sigma {
        /// What was given, rad.
        found_rad: f32,
    },
    /// The least light is not between 0 and 1.
    Faintest {
        /// What was given.
        found: f32,
    },
    /// The most light is not above 1 and finite.
    Brightest {
        /// What was given.
        found: f32,
    },
    /// The gate is not positive and finite.
    Gate {
        /// What was given, in σ.
        found: f32,
    },
}

impl fmt::Display for SunFacesError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Face { face, error } => write!(f, "face {face}: {error}"),
            Self::Sigma { found_rad } => {
                write!(f, "a noise of {found_rad} rad is not between 0 and 1 rad")
            }
            Self::Faintest { found } => write!(f, "a least light of {found} is not from 0 to 1"),
            Self::Brightest { found } => write!(f, "a most light of {found} is not above 1"),
            Self::Gate { found } => write!(f, "a gate of {found} sigma is not positive"),
        }
    }
}

impl core::error::Error for SunFacesError {}
