//! The folder that a flight leaves.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result};

use super::Flight;

/// Everything that a flight or its report may leave in a folder; removed before the next flight, so
/// that nothing of an older one stands beside it.
const FILES: [&str; 7] = [
    "flight.json",
    "records.bin",
    "scenario.bin",
    "history.csv",
    "summary.json",
    "commissioning.toml",
    "report.html",
];
const PLOTS: &str = "plots";

/// The folder of one flight.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Folder {
    path: PathBuf,
}

impl Folder {
    /// The folder of a flight that has been flown.
    pub fn of(path: impl Into<PathBuf>) -> Self {
        Self { path: path.into() }
    }

    /// Makes the folder for a new flight, or empties it of an older one.
    ///
    /// # Errors
    /// When it cannot be made or written.
    pub fn prepare(path: impl Into<PathBuf>) -> Result<Self> {
        let folder = Self::of(path);
        let shown = folder.path.display();
        fs::create_dir_all(&folder.path)
            .with_context(|| format!("the output folder {shown} cannot be made"))?;
        let removed = FILES
            .iter()
            .map(|name| gone(fs::remove_file(folder.path.join(name))))
            .chain([gone(fs::remove_dir_all(folder.plots()))])
            .collect::<io::Result<()>>();
        removed.with_context(|| format!("the output folder {shown} cannot be emptied"))?;
        Ok(folder)
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// What was flown, where, and how it ended.
    pub fn flight_file(&self) -> PathBuf {
        self.path.join("flight.json")
    }

    /// The messages as they came.
    pub fn records(&self) -> PathBuf {
        self.path.join("records.bin")
    }

    /// One row a cycle.
    pub fn history(&self) -> PathBuf {
        self.path.join("history.csv")
    }

    /// The flight in numbers.
    pub fn summary(&self) -> PathBuf {
        self.path.join("summary.json")
    }

    /// What the satellite found out about itself, as a mission that builds on the one that was flown.
    pub fn commissioning(&self) -> PathBuf {
        self.path.join("commissioning.toml")
    }

    /// The flight to look at.
    pub fn report(&self) -> PathBuf {
        self.path.join("report.html")
    }

    /// The plots of the report, one by one.
    pub fn plots(&self) -> PathBuf {
        self.path.join(PLOTS)
    }

    /// Notes what was flown.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn write_flight(&self, flight: &Flight) -> Result<()> {
        let mut text = serde_json::to_string_pretty(flight)?;
        text.push('\n');
        write(&self.flight_file(), text)
    }

    /// What was flown.
    ///
    /// # Errors
    /// When there is no flight in this folder, or one of another version.
    pub fn read_flight(&self) -> Result<Flight> {
        let path = self.flight_file();
        let text = fs::read_to_string(&path).with_context(|| {
            format!("no flight in {}: {} cannot be read", self.path.display(), path.display())
        })?;
        serde_json::from_str(&text)
            .with_context(|| format!("{} is of another version", path.display()))
    }
}

/// Writes a whole file.
///
/// # Errors
/// When it cannot be written.
pub(crate) fn write(path: &Path, content: impl AsRef<[u8]>) -> Result<()> {
    fs::write(path, content).with_context(|| format!("{} cannot be written", path.display()))
}

fn gone(removed: io::Result<()>) -> io::Result<()> {
    match removed {
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(()),
        other => other,
    }
}
