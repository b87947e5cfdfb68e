//! `adcs sun`: where the Sun stands at given instants.

use std::process::ExitCode;

use adcs_ground::columns::sun::Sun;
use adcs_ground::table;

use super::files::{TableArgs, exit_code, table_help};

const HELP: &str = table_help!(
    "\
Reads the column
  utc_iso        UTC instant, as 2015-11-19T02:55:21.392832Z (1972 and later)
and writes all columns of the input, and behind them
  sun_tod_x      unit vector from the Earth's centre to the apparent Sun,
  sun_tod_y        axes of the true equator and true equinox of date
  sun_tod_z
  sun_teme_x     the same in TEME, the axes of SGP4
  sun_teme_y
  sun_teme_z
  distance_au    distance of the centres
  error          empty, or why the row has no result

Within 0.0022 deg and 3.5e-5 au of JPL DE421 over 2000-2050; dates far outside
become slowly worse.

Example
  $ printf 'utc_iso\\n2015-03-27T02:00:00Z\\n' | adcs sun -"
);

/// Direction and distance of the Sun for a table of instants
#[derive(Debug, clap::Args)]
#[command(after_help = HELP)]
pub struct Args {
    #[command(flatten)]
    table: TableArgs,
}

pub fn run(args: &Args) -> ExitCode {
    let TableArgs { input, output } = &args.table;
    exit_code(table::run(input, &output.path, |header| Ok(Box::new(Sun::bind(header)?))))
}
