//! `adcs tle`: looking at two-line elements.

use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use adcs_core::time::Utc;
use adcs_ground::table::Tally;
use adcs_ground::tle_file::{self, Checksum, Shown};
use adcs_ground::tle_report::{TleRefusal, TleReport, Use};
use anyhow::Context as _;
use clap::Subcommand;
use serde::Serialize;

use super::files::exit_code;

/// Look at two-line elements
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(subcommand)]
    action: Action,
}

const HELP: &str = "\
Checked are the columns (each of them), the checksums, and the ranges of the
values. The first thing wrong is shown in its place:

  sprout.tle: line 2, column 12: expected a decimal point, found ','
    2 39770  97,8670 184.0112 0011259 108.3774 251.8661 14.83565425 45450
               ^

With --now, elements that are too old, or of an orbit that does not stay above the
ground, are refused too: for a look before an uplink.

Example
  $ adcs tle check sprout.tle
  $ adcs tle check sprout.tle --now 2015-03-28T12:00:00Z --max-days 7
  $ adcs tle check - --json < sprout.tle

With --json, standard output has the elements, each named with its unit, and
\"valid\": true; or \"valid\": false with line, first_column, last_column (from 1)
and message.

Exit code: 0 the TLE is right, 1 it is wrong or not for use at --now, 2 the file
cannot be read.";

#[derive(Debug, Subcommand)]
enum Action {
    /// Check a TLE of two or three lines and show what it says
    #[command(after_help = HELP)]
    Check {
        /// A file with one TLE; - is standard input
        #[arg(value_name = "FILE")]
        file: PathBuf,

        /// Write JSON
        #[arg(long)]
        json: bool,

        /// When the elements are to be used: their age and orbit are checked too
        #[arg(long, value_name = "UTC", value_parser = Utc::parse)]
        now: Option<Utc>,

        /// How far their epoch may be from --now
        #[arg(long, value_name = "DAYS", default_value_t = 14.0, requires = "now")]
        max_days: f64,
    },
}

pub fn run(args: &Args) -> ExitCode {
    let Action::Check { file, json, now, max_days } = &args.action;
    let intended = now.map(|now| Use { now, max_days: *max_days });
    exit_code(check(file, *json, intended))
}

fn check(file: &Path, json: bool, intended: Option<Use>) -> anyhow::Result<Tally> {
    let text = tle_file::read(file)?;
    match tle_file::decode(&text, Checksum::Verify) {
        Ok(elements) => {
            let report = TleReport::new(&text, &elements, intended);
            print(if json { to_json(&report)? } else { report.to_string() })?;
            for warning in report.warnings() {
                warn(&format!("warning: {warning}"));
            }
            if let Some(reason) = report.implausible() {
                warn(&format!("{}: not for this use: {reason}", tle_file::name(file)));
            }
            Ok(Tally { rows: 1, bad: u64::from(report.implausible().is_some()) })
        }
        Err(error) => {
            if json {
                print(to_json(&TleRefusal::from(&error))?)?;
            }
            warn(&format!("{}: {}", tle_file::name(file), Shown(&text, &error)));
            Ok(Tally { rows: 1, bad: 1 })
        }
    }
}

fn to_json(value: &impl Serialize) -> anyhow::Result<String> {
    Ok(serde_json::to_string_pretty(value)? + "\n")
}

fn print(text: String) -> anyhow::Result<()> {
    match io::stdout().write_all(text.as_bytes()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => Err(error),
        _ => Ok(()),
    }
    .context("standard output: cannot be written")
}

fn warn(text: &str) {
    // A standard error that cannot be written is no reason to panic.
    let _ = writeln!(io::stderr(), "{text}");
}
