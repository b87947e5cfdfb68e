//! `adcs report`: the report of a flight, made again from its records.

use std::path::PathBuf;
use std::process::ExitCode;

use adcs_ground::flight::{Ending, Flown, Folder};
use adcs_ground::report;
use anyhow::Result;

use super::console::print;

/// Make the report of a flight again, from its records.
///
/// Works for a flight that was interrupted or killed as well: the report then goes as far as the
/// records do, and says so.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The folder of the flight: out/NAME, or out/NAME/m4
    folder: PathBuf,
}

pub fn run(args: &Args) -> Result<ExitCode> {
    let folder = Folder::of(&args.folder);
    let flight = folder.read_flight()?;
    let flown = Flown::read(&folder.records())?;
    let summary = report::make_of(&folder, &flight, &flown)?;
    if !flown.is_whole() || flight.ending != Ending::Complete {
        print(format_args!(
            "the records go to {:.1} of {:.1} s ({} cycles, {} frames lost)",
            summary.flown_s, summary.planned_s, summary.cycles, summary.lost_frames
        ));
    }
    print(format_args!("{}", folder.report().display()));
    Ok(ExitCode::SUCCESS)
}
