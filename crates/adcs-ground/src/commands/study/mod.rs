//! `adcs study`: how well filters and laws do, over many simulated flights.

mod despin;
mod filters;
mod polarity;

use std::path::Path;
use std::process::ExitCode;
use std::sync::Mutex;

use adcs_ground::table::{Output, Progress};
use anyhow::{Context as _, Result};

/// How well filters, laws and guards do, over many simulated flights
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(subcommand)]
    subject: Subject,
}

#[derive(Debug, clap::Subcommand)]
enum Subject {
    Filters(filters::Args),
    Despin(despin::Args),
    Polarity(polarity::Args),
}

pub fn run(args: &Args) -> Result<ExitCode> {
    match &args.subject {
        Subject::Filters(args) => filters::run(args),
        Subject::Despin(args) => despin::run(args),
        Subject::Polarity(args) => polarity::run(args),
    }
}

/// Flies a campaign under a bar that advances with each flight.
fn watched<T>(flights: u64, fly: impl FnOnce(&(dyn Fn() + Sync)) -> Result<T>) -> Result<T> {
    let progress = Mutex::new(Progress::of_steps(flights, true));
    let result = fly(&|| {
        if let Ok(progress) = progress.lock() {
            progress.advance(1);
        }
    });
    if let Ok(progress) = progress.lock() {
        progress.finish();
    }
    result
}

/// The table with one row a flight, if one is wanted; it appears when it is complete.
struct Csv {
    table: Option<csv::Writer<Output>>,
}

impl Csv {
    fn create(path: Option<&Path>, columns: &[&str]) -> Result<Self> {
        let Some(path) = path else { return Ok(Self { table: None }) };
        let output = Output::create(path);
        let output = output.with_context(|| format!("{} cannot be written", path.display()))?;
        let mut table = csv::Writer::from_writer(output);
        table.write_record(columns)?;
        Ok(Self { table: Some(table) })
    }

    fn write(&mut self, row: &[String]) -> Result<()> {
        if let Some(table) = &mut self.table {
            table.write_record(row)?;
        }
        Ok(())
    }

    fn finish(self) -> Result<()> {
        if let Some(table) = self.table {
            table.into_inner().map_err(csv::IntoInnerError::into_error)?.finish()?;
        }
        Ok(())
    }
}
