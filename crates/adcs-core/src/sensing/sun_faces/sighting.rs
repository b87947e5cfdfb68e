//! What goes into a sighting of the Sun beside the currents, and what comes out.

use serde::{Deserialize, Serialize};

use super::FACES;
use crate::frames::{Body, Direction};
use crate::reading::{MissingReason, Reading};

/// What became of one face in one cycle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum FaceVerdict {
    /// It sees the Sun, and its direction is in the answer.
    Used,
    /// It gave no currents.
    Missing(MissingReason),
    /// No light.
    Dark,
    /// Its four currents are not those of one diode.
    Broken,
    /// Its light comes from outside its cone.
    OutsideCone,
    /// Too faint for the Sun, and the Earth is in view.
    Earth,
    /// Too faint for the Sun, and nobody knows of an Earth there.
    Faint,
    /// Too bright for the Sun.
    Bright,
    /// As bright as the Sun, but not where it was predicted.
    Unpredicted,
    /// As bright as the Sun, but another face says otherwise.
    Disagrees,
}

/// Where somebody thinks that the Sun is.
#[derive(Debug, Clone, Copy)]
pub struct SunPrediction {
    /// Its direction.
    pub direction: Direction<Body>,
    /// σ of that direction about each axis across it, rad; must be finite.
    pub sigma_rad: f32,
}

/// The Earth in the satellite's sky.
#[derive(Debug, Clone, Copy)]
pub struct EarthDisc {
    /// Its centre.
    pub nadir: Direction<Body>,
    /// Its angular radius, rad.
    pub radius_rad: f32,
}

/// What is known beforehand; [`Default`] is nothing.
///
/// A prediction can be wrong, and then hides the Sun that would correct it: whoever gives one
/// counts answers that are [`MissingReason::Unpredicted`], and after some gives none.
#[derive(Debug, Clone, Copy)]
pub struct Expected {
    /// Where the Sun should be, from an attitude.
    pub sun: Option<SunPrediction>,
    /// Where the Earth is, from an attitude.
    pub earth: Option<EarthDisc>,
    /// Sunlight relative to that at one astronomical unit, (1 au / r)²: 0.967 to 1.034. How much of
    /// the disc is hidden does not belong here: a Sun that is half set is not looked for, and the
    /// sensors rather than the orbit model say when it has risen.
    pub irradiance: f32,
}

impl Default for Expected {
    fn default() -> Self {
        Self { sun: None, earth: None, irradiance: 1.0 }
    }
}

/// The direction of the Sun, measured.
#[derive(Debug, Clone, Copy)]
pub struct SunDirection {
    /// Where it is.
    pub direction: Direction<Body>,
    /// σ about each axis across that direction, rad.
    pub sigma_rad: f32,
    /// The part of it that foreign light makes, rad: no noise, but the same for as long as Sun and Earth
    /// stand the same in the face.
    pub pull_rad: f32,
    /// By how much the face furthest from the answer differs from it, rad; nothing but rounding with one face.
    pub worst_residual_rad: f32,
}

/// What six faces saw in one cycle.
#[derive(Debug, Clone, Copy)]
pub struct SunSighting {
    /// The Sun, or why there is none.
    pub sun: Reading<SunDirection>,
    /// What became of each face.
    pub faces: [FaceVerdict; FACES],
}

impl SunSighting {
    /// That of a satellite without Sun sensors.
    pub const NOT_FITTED: Self = Self {
        sun: Reading::Missing(MissingReason::NotFitted),
        faces: [FaceVerdict::Missing(MissingReason::NotFitted); FACES],
    };

    /// The faces in the answer: bit n is face n.
    pub fn used(&self) -> u8 {
        let bit = |(face, verdict): (u8, &FaceVerdict)| {
            u8::from(*verdict == FaceVerdict::Used).checked_shl(u32::from(face)).unwrap_or(0)
        };
        (0..).zip(&self.faces).map(bit).fold(0, |mask, bit| mask | bit)
    }
}
