//! A flight in the emulated image: scenario file in, record file out.

use core::fmt;

use adcs_firmware::remembered;
use adcs_link::{
    frame::{self, FrameError, MAX_FRAME},
    message::{End, Message},
};
use adcs_sim::{
    fly::{self, FlightError, Stopped},
    scenario::{self, Scenario},
};
use semihosting::eprintln;

use crate::host::{self, FileError, Writer};

/// No scenario file is longer, bytes.
const SCENARIO_BYTES: usize = 4096;

/// Why a flight did not begin, or not end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Error<'a> {
    /// The scenario file.
    Scenario(&'a str, FileError),
    /// The scenario file was read, but is none.
    NoScenario(&'a str),
    /// The scenario was written by another version.
    Version(u16),
    /// The record file.
    Records(&'a str, FileError),
    /// A record does not fit its frame, which the layout excludes.
    Frame(FrameError),
    /// The flight itself.
    Flight(FlightError),
    /// One start of the image flies once.
    Again,
}

impl fmt::Display for Error<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Scenario(path, error) => write!(f, "scenario {path}: {error}"),
            Self::NoScenario(path) => write!(f, "scenario {path}: not a scenario"),
            Self::Version(found) => {
                let own = scenario::VERSION;
                write!(f, "the scenario has version {found}, this image flies version {own}")
            }
            Self::Records(path, error) => write!(f, "records {path}: {error}"),
            Self::Frame(error) => write!(f, "record: {error}"),
            Self::Flight(error) => write!(f, "{error}"),
            Self::Again => write!(f, "this image has flown; start it again for another flight"),
        }
    }
}

/// Flies the scenario in the file `scenario` and writes its messages to the file `records` as they
/// come, so that an interrupted flight leaves what was flown.
pub fn fly<'a>(scenario: &'a str, records: &'a str) -> Result<End, Error<'a>> {
    let flight = read(scenario)?;
    defmt::info!("flying {} cycles", flight.cycles);
    let mut writer = Writer::create(records).map_err(|error| Error::Records(records, error))?;
    let mut progress = Progress::new(flight.cycles);
    let Some(state) = remembered::room().map(remembered::power_on) else {
        return Err(Error::Again);
    };
    let outcome = fly::fly_in(state, &flight, &[], |message| {
        let mut buffer = [0; MAX_FRAME];
        let bytes = frame::encode(message, &mut buffer).map_err(Error::Frame)?;
        writer.write(bytes).map_err(|error| Error::Records(records, error))?;
        if progress.is_due(message) {
            writer.flush().map_err(|error| Error::Records(records, error))?;
            progress.print();
        }
        Ok(())
    })
    .map_err(|stopped| match stopped {
        Stopped::Flight(error) => Error::Flight(error),
        Stopped::Sink(error) => error,
    })?;
    writer.flush().map_err(|error| Error::Records(records, error))?;
    defmt::info!("landed: {}", outcome.health);
    Ok(outcome.end)
}

/// In a frame of its own: the file is off the stack when the flight begins.
#[inline(never)]
fn read(path: &str) -> Result<Scenario, Error<'_>> {
    let mut buffer = [0; SCENARIO_BYTES];
    let bytes = host::read_file(path, &mut buffer).map_err(|error| Error::Scenario(path, error))?;
    // The version stands first, so that it can be read whatever follows.
    let (version, _) =
        postcard::take_from_bytes::<u16>(bytes).map_err(|_| Error::NoScenario(path))?;
    if version != scenario::VERSION {
        return Err(Error::Version(version));
    }
    postcard::from_bytes(bytes).map_err(|_| Error::NoScenario(path))
}

/// Says how far the flight is, about every hundredth of the way.
struct Progress {
    cycles: u32,
    cycle: u32,
    next: u32,
}

impl Progress {
    fn new(cycles: u32) -> Self {
        Self { cycles, cycle: 0, next: 0 }
    }

    fn is_due(&mut self, message: &Message) -> bool {
        let Message::Cycle(record) = message else { return false };
        self.cycle = record.cycle;
        let due = self.cycle >= self.next;
        if due {
            self.next = self.cycle + (self.cycles / 100).max(1);
        }
        due
    }

    fn print(&self) {
        eprintln!("progress {} {}", self.cycle, self.cycles);
    }
}
