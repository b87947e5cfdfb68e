//! Flying a mission: on this computer, or as the image on an emulated core; and what is left of it
//! in a folder.
//!
//! ```text
//! Mission ─► host  ─┐
//!         └► image ─┴─► FOLDER/records.bin (as the messages come) ─► Flown ─► report, comparison
//!                       FOLDER/flight.json (what was flown, where, and how it ended)
//! ```
//!
//! The records reach the file while the flight goes on, so that one that was interrupted, or died,
//! is readable up to where it came.

pub mod compare;
pub mod folder;
pub mod host;
pub mod image;
pub mod records;

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::mission::Mission;

pub use folder::Folder;
pub use records::Flown;

/// Where a mission flies.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum World {
    /// This computer.
    Host,
    /// The ARM image on an emulated STM32F405 (Cortex-M4F).
    M4,
}

impl fmt::Display for World {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Host => "host",
            Self::M4 => "m4",
        })
    }
}

/// How a flight ended.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Ending {
    /// It has not, or whoever flew it was killed.
    Unfinished,
    /// At the mission's end.
    Complete,
    /// By the person who started it.
    Interrupted,
    /// It could not go on.
    Failed(String),
}

/// What was flown, where, and how it ended: `flight.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Flight {
    /// What was flown.
    pub mission: Mission,
    /// Where.
    pub world: World,
    /// How it ended.
    pub ending: Ending,
    /// How long it took, seconds of this computer's time; `None` while it is unfinished.
    pub wall_s: Option<f64>,
    /// The same mission in the other world, when both were flown together.
    pub counterpart: Option<Counterpart>,
}

/// The same mission in the other world.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Counterpart {
    /// Which.
    pub world: World,
    /// Where the two part for the first time; `None` when they were the same to the bit.
    pub difference: Option<String>,
}

impl Flight {
    /// One that is about to begin.
    pub fn beginning(mission: Mission, world: World) -> Self {
        Self { mission, world, ending: Ending::Unfinished, wall_s: None, counterpart: None }
    }
}

/// What a flight is watched and stopped by.
pub trait Watcher {
    /// It has come to this cycle.
    fn cycle(&mut self, cycle: u32);
    /// The image has logged a line.
    fn log(&mut self, line: &str);
    /// Whether it should end now.
    fn wants_to_stop(&self) -> bool;
}

/// Watches nothing and never stops.
#[derive(Debug, Clone, Copy, Default)]
pub struct Patient;

impl Watcher for Patient {
    fn cycle(&mut self, _: u32) {}
    fn log(&mut self, _: &str) {}
    fn wants_to_stop(&self) -> bool {
        false
    }
}
