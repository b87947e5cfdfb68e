//! Copies of the repository's missions, to be changed and broken.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};

use adcs_ground::mission::{self, Mission, Problem};

/// The mission.
pub const MISSION: &str = "sprout/despin-calibrated.toml";
/// Its satellite.
pub const SATELLITE: &str = "satellites/sprout-a2.toml";

/// The repository's missions.
pub fn missions() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../missions")
}

/// A copy of a mission and its satellite, to be changed.
pub struct Workshop {
    /// Where it is.
    pub folder: PathBuf,
}

impl Workshop {
    /// Fresh copies.
    pub fn new() -> Self {
        static NEXT: AtomicU32 = AtomicU32::new(0);
        let number = NEXT.fetch_add(1, Ordering::Relaxed);
        let name = format!("mission-{}-{number}", std::process::id());
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
        for file in [MISSION, SATELLITE] {
            let path = folder.join(file);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::copy(missions().join(file), path).unwrap();
        }
        Self { folder }
    }

    /// Replaces the one place of `file` that reads `old`.
    pub fn change(&self, file: &str, old: &str, new: &str) {
        let path = self.folder.join(file);
        let text = fs::read_to_string(&path).unwrap();
        assert_eq!(text.matches(old).count(), 1, "{old:?} in {file}");
        fs::write(path, text.replace(old, new)).unwrap();
    }

    /// Writes a whole file.
    pub fn write(&self, file: &str, text: impl AsRef<[u8]>) {
        fs::write(self.folder.join(file), text).unwrap();
    }

    /// Loads the mission.
    pub fn load(&self) -> Result<Mission, Vec<Problem>> {
        mission::load(self.folder.join(MISSION)).map_err(|error| error.problems)
    }

    /// The only problem; there must be one.
    pub fn problem(&self) -> Problem {
        let problems = self.load().expect_err("the mission was accepted");
        assert_eq!(problems.len(), 1, "{problems:#?}");
        problems.into_iter().next().unwrap()
    }
}

impl Drop for Workshop {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.folder);
    }
}
