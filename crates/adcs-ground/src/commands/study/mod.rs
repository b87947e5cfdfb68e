//! `adcs study`: how well filters and laws do, over many simulated flights.

mod commissioning;
mod despin;
mod filters;
mod pointing;
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
    Pointing(pointing::Args),
    Despin(despin::Args),
    Polarity(polarity::Args),
    Commissioning(commissioning::Args),
}

pub fn run(args: &Args) -> Result<ExitCode> {
    match &args.subject {
        Subject::Filters(args) => filters::run(args),
        Subject::Pointing(args) => pointing::run(args),
        Subject::Despin(args) => despin::run(args),
        Subject::Polarity(args) => polarity::run(args),
        Subject::Commissioning(args) => commissioning::run(args),
    }
}

fn orbits(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(orbits) if (0.2..=5500.0).contains(&orbits) => Ok(orbits),
        _ => Err("a number from 0.2 to 5500 is wanted".to_owned()),
    }
}

/// The one of this name, or what names there are.
fn named<T: Copy>(
    what: &str,
    all: &[T],
    name_of: impl Fn(T) -> &'static str,
    name: &str,
) -> Result<T, String> {
    let found = all.iter().copied().find(|it| name_of(*it) == name);
    found.ok_or_else(|| {
        let names: Vec<&str> = all.iter().map(|it| name_of(*it)).collect();
        format!("there is no such {what}; there are {}", names.join(", "))
    })
}

/// The table that a study also writes, when it is asked for.
fn table(path: Option<&Path>, columns: &[&str]) -> Result<Option<csv::Writer<Output>>> {
    let Some(path) = path else { return Ok(None) };
    let output = Output::create(path);
    let output = output.with_context(|| format!("{} cannot be written", path.display()))?;
    let mut table = csv::Writer::from_writer(output);
    table.write_record(columns)?;
    Ok(Some(table))
}

/// One row of it.
fn write(table: &mut Option<csv::Writer<Output>>, row: &[String]) -> Result<()> {
    if let Some(table) = table {
        table.write_record(row)?;
    }
    Ok(())
}

/// The table is complete, and appears.
fn finish(table: Option<csv::Writer<Output>>) -> Result<()> {
    if let Some(table) = table {
        table.into_inner().map_err(csv::IntoInnerError::into_error)?.finish()?;
    }
    Ok(())
}

/// Flies with a progress bar that `fly` moves on by calling what it is given.
fn flown<T>(flights: u64, fly: impl FnOnce(&(dyn Fn() + Sync)) -> Result<T>) -> Result<T> {
    let progress = Mutex::new(Progress::of_steps(flights, true));
    let results = fly(&|| {
        if let Ok(progress) = progress.lock() {
            progress.advance(1);
        }
    });
    if let Ok(progress) = progress.lock() {
        progress.finish();
    }
    results
}
