//! `adcs propagate`: where satellites are, by SGP4.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use adcs_core::time::Utc;
use adcs_ground::columns::propagate::Propagate;
use adcs_ground::ephemeris::Ephemeris;
use adcs_ground::span::step_micros;
use adcs_ground::table::{self, Tally};
use clap::ArgGroup;

use super::files::{LenientArgs, OutputArgs, elements, exit_code, span, table_help};

const HELP: &str = table_help!(
    "\
With a table, reads the columns
  line1, line2      the two lines of a TLE, 69 columns each
  tsince_min        minutes since its epoch, may be negative
and writes the other columns of the input (id, tsince_min, ...), and behind them
  error             0, or why there is no state (codes below)
  x_teme_km, y_teme_km, z_teme_km             position in TEME, nan with an error
  vx_teme_km_s, vy_teme_km_s, vz_teme_km_s    velocity in TEME, nan with an error
  message           the error in words

With --tle or --omm, writes one row every --step seconds from --from to --to:
  utc_iso, tsince_min, error, x_teme_km ... vz_teme_km_s, message

Error codes
   1  mean eccentricity out of range          4  semi-latus rectum negative
   2  mean motion not positive                6  decayed
   3  perturbed eccentricity out of range        (1 to 6: those of SGP4)
  10  the row cannot be read                 12  elements no orbit belongs to
  11  the TLE is wrong                       13  too far from the epoch (resonance)

SGP4 and SDP4 with WGS72 constants, mode \"improved\".

Examples
  $ adcs propagate catalogue.csv -o states.csv
  $ adcs propagate --tle sprout.tle --from 2015-11-19T03:00:00Z \\
      --to 2015-11-19T05:00:00Z --step 30 -o orbit.csv
  $ adcs propagate --omm iss.omm --from 2020-04-06T20:00:00Z \\
      --to 2020-04-06T22:00:00Z --step 30 -o orbit.csv"
);

/// Position and velocity (SGP4) for a table of TLEs and times, or along one orbit
#[derive(Debug, clap::Args)]
#[command(after_help = HELP, group = ArgGroup::new("orbit").args(["tle", "omm"]))]
pub struct Args {
    /// The table to read: comma-separated values under a header line; - is standard input
    #[arg(value_name = "IN.csv", required_unless_present = "orbit", conflicts_with = "orbit")]
    input: Option<PathBuf>,

    /// Instead of a table, a file with one TLE
    #[arg(long, value_name = "FILE", requires_all = ["from", "to", "step"])]
    tle: Option<PathBuf>,

    /// Instead of a table, a file with one OMM (CCSDS 502.0-B, in KEY = VALUE notation)
    #[arg(
        long,
        value_name = "FILE",
        requires_all = ["from", "to", "step"],
        conflicts_with = "lenient"
    )]
    omm: Option<PathBuf>,

    /// First instant (UTC), as 2015-11-19T03:00:00Z
    #[arg(long, value_name = "UTC", value_parser = Utc::parse, requires = "orbit")]
    from: Option<Utc>,

    /// Last instant (UTC)
    #[arg(long, value_name = "UTC", value_parser = Utc::parse, requires = "orbit")]
    to: Option<Utc>,

    /// Seconds from one state to the next
    #[arg(long, value_name = "SECONDS", value_parser = step_micros, requires = "orbit")]
    step: Option<i64>,

    #[command(flatten)]
    output: OutputArgs,

    #[command(flatten)]
    lenient: LenientArgs,
}

pub fn run(args: &Args) -> ExitCode {
    exit_code(work(args))
}

fn work(args: &Args) -> anyhow::Result<Tally> {
    let (output, checksum) = (&args.output.path, args.lenient.checksum());
    let elements = elements(args.tle.as_deref(), args.omm.as_deref(), checksum)?;
    match (elements, args.from, args.to, args.step) {
        (Some(elements), Some(from), Some(to), Some(step_us)) => {
            let span = span(from, to)?;
            Ephemeris::new(&elements)?.write(span, step_us, output)
        }
        _ => {
            let input = args.input.as_deref().unwrap_or(Path::new("-"));
            table::run(input, output, |header| Ok(Box::new(Propagate::bind(header, checksum)?)))
        }
    }
}
