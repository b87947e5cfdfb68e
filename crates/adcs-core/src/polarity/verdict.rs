//! Who is suspected, and on what evidence.

use core::fmt;

use serde::{Deserialize, Serialize};

use crate::frames::SignedPermutation;

/// The device that is wired wrongly: it shows, or does, P times what it should; or torquers that do nothing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Suspect {
    /// The gyro.
    Gyro(SignedPermutation),
    /// The magnetometer.
    Magnetometer(SignedPermutation),
    /// The torquers.
    Torquers(SignedPermutation),
    /// The gyro wired so; or the magnetometer wired as the inverse of it, or as its negative.
    GyroOrMagnetometer(SignedPermutation),
    /// Torquers or magnetometer, reversed as a whole: their torques are the same.
    ReversedTorquersOrMagnetometer,
    /// The torquers in some way, dead ones included, or the magnetometer reversed as a whole.
    TorquersOrReversedMagnetometer,
    /// Somebody: the energy grows.
    Unknown,
    /// The torquers along these axes of Body obey and do nothing.
    DeadTorquers([bool; 3]),
}

/// What the guard goes by.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Evidence {
    /// Natural logarithm of the odds that gyro or magnetometer is wired wrongly.
    pub turning: f32,
    /// Natural logarithm of the odds that torquers, or a reversed magnetometer, are.
    pub response: f32,
    /// Natural logarithm of the odds that some of the torquers do nothing.
    pub dead: f32,
    /// Kinetic energy over that at the start.
    pub energy: f32,
}

impl Evidence {
    /// None yet.
    pub const NONE: Self = Self { turning: 0.0, response: 0.0, dead: 0.0, energy: 1.0 };
}

/// What the guard says while a loop is closed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum GuardVerdict {
    /// Nothing speaks against the wiring.
    Sound(Evidence),
    /// Control must stop.
    Stop {
        /// Who did it.
        suspect: Suspect,
        /// On what evidence.
        evidence: Evidence,
    },
}

impl fmt::Display for Suspect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Gyro(wiring) => write!(f, "gyro wired {wiring}"),
            Self::Magnetometer(wiring) => write!(f, "magnetometer wired {wiring}"),
            Self::Torquers(wiring) => write!(f, "torquers wired {wiring}"),
            Self::GyroOrMagnetometer(wiring) => {
                let other = wiring.inverse();
                write!(f, "gyro wired {wiring}, or magnetometer {other} or {}", other.negated())
            }
            Self::ReversedTorquersOrMagnetometer => write!(f, "torquers or magnetometer reversed"),
            Self::TorquersOrReversedMagnetometer => {
                write!(f, "torquers wired wrongly or dead, or magnetometer reversed")
            }
            Self::Unknown => {
                write!(f, "the energy grows")
            }
            Self::DeadTorquers([true, true, true]) => write!(f, "all torquers dead"),
            Self::DeadTorquers(dead) => {
                write!(f, "torquer dead:")?;
                let mut names = dead.iter().zip(["x", "y", "z"]).filter(|(dead, _)| **dead);
                names.try_for_each(|(_, name)| write!(f, " {name}"))
            }
        }
    }
}
