//! A flight on this computer.

use std::time::Instant;

use adcs_link::Message;
use adcs_sim::fly::{self, Stopped};
use anyhow::Result;

use super::records::Writer;
use super::{Ending, Flight, Folder, Watcher, World};
use crate::mission::Mission;

/// Why the messages are no longer taken.
enum Refusal {
    Stop,
    File(anyhow::Error),
}

/// Flies `mission` into `folder`. A flight that cannot go on, or is stopped, is no error: its
/// records are there, and [`Flight::ending`] says what happened.
///
/// # Errors
/// When the folder cannot be written.
pub fn fly(mission: &Mission, folder: &Folder, watcher: &mut impl Watcher) -> Result<Flight> {
    let mut flight = Flight::beginning(mission.clone(), World::Host);
    folder.write_flight(&flight)?;
    let mut records = Writer::create(&folder.records())?;
    let start = Instant::now();
    let flown = fly::fly(&mission.scenario, |message| {
        records.write(message).map_err(Refusal::File)?;
        if let Message::Cycle(record) = message {
            watcher.cycle(record.cycle);
            if watcher.wants_to_stop() {
                return Err(Refusal::Stop);
            }
        }
        Ok(())
    });
    flight.wall_s = Some(start.elapsed().as_secs_f64());
    records.finish()?;
    flight.ending = match flown {
        Ok(_) => Ending::Complete,
        Err(Stopped::Sink(Refusal::Stop)) => Ending::Interrupted,
        Err(Stopped::Sink(Refusal::File(error))) => return Err(error),
        Err(Stopped::Flight(error)) => Ending::Failed(error.to_string()),
    };
    folder.write_flight(&flight)?;
    Ok(flight)
}
