//! A flight of the ARM image on the emulated core.

use std::env;
use std::path::PathBuf;
use std::time::Instant;

use anyhow::{Context as _, Result};

use super::{Ending, Flight, Flown, Folder, Watcher, World};
use crate::emulator::Emulator;
use crate::mission::Mission;

/// The image as `cargo xtask image` leaves it in the folder that cargo builds into.
const IMAGE: &str = "images/adcs-emulated.elf";
/// The same when Debian's compiler built it.
const DEBIAN_IMAGE: &str = "debian-core/images/adcs-emulated.elf";

/// The image that was built last: in the folder that this program was built into, or in `target`.
///
/// # Errors
/// When there is none; the error says how to get one.
pub fn find() -> Result<PathBuf> {
    // .../target/release/adcs
    let built_into = env::current_exe().ok().and_then(|exe| Some(exe.parent()?.parent()?.into()));
    let folders = built_into.into_iter().chain([PathBuf::from("target")]);
    folders
        .flat_map(|folder| [folder.join(IMAGE), folder.join(DEBIAN_IMAGE)])
        .filter_map(|image| Some((image.metadata().ok()?.modified().ok()?, image)))
        .max()
        .map(|(_, image)| image)
        .context("no image for the emulated core: build it with `cargo xtask image`, or name one with --image")
}

/// Flies `mission` as the image on the emulated core into `folder`; otherwise as
/// [`host::fly`](super::host::fly).
///
/// # Errors
/// When the flight cannot begin, or the folder cannot be written or read.
pub fn fly(
    emulator: &Emulator,
    mission: &Mission,
    folder: &Folder,
    watcher: &mut impl Watcher,
) -> Result<Flight> {
    let mut flight = Flight::beginning(mission.clone(), World::M4);
    folder.write_flight(&flight)?;
    let scenario = postcard::to_stdvec(&mission.scenario)?;
    let start = Instant::now();
    let flown = emulator.fly(&scenario, folder.path(), watcher);
    flight.wall_s = Some(start.elapsed().as_secs_f64());
    flight.ending = match flown {
        Ok(Some(landing)) => {
            let flown = Flown::read(&landing.records)?;
            if flown.is_whole() && flown.digest == landing.digest {
                Ending::Complete
            } else {
                Ending::Failed("its records are not those of the digest it printed".to_owned())
            }
        }
        Ok(None) => Ending::Interrupted,
        // Nothing was flown: there is no flight to look at.
        Err(error) if !folder.records().exists() => return Err(error),
        Err(error) => Ending::Failed(format!("{error:#}")),
    };
    folder.write_flight(&flight)?;
    Ok(flight)
}
