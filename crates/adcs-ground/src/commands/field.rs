//! `adcs field`: the geomagnetic field at given dates and places.

use std::process::ExitCode;

use adcs_ground::columns::field::Field;
use adcs_ground::table;
use igrf::HIGHEST_DEGREE;

use super::files::{TableArgs, exit_code, table_help};

const HELP: &str = table_help!(
    "\
Reads the columns
  decimal_year             year + seconds gone by in it / seconds in it
    or utc_iso             UTC instant, as 2015-11-19T02:55:21.392832Z
                           (decimal_year is used where both are there)
  geodetic_lat_deg         geodetic latitude on WGS84, -90 to 90
  lon_east_deg             longitude, positive eastwards
  height_above_wgs84_km    height above the ellipsoid
and writes all columns of the input, and behind them
  B_north_nT, B_east_nT, B_down_nT    field in the local geodetic axes; at the
                           poles north and east are those of the given meridian
  B_total_nT               its strength
  error                    empty, or why the row has no result

IGRF-14, 1900.0 to 2030.0: linear between the nodes every five years, secular
variation after 2025. Other dates are refused.

Example
  $ adcs field places.csv -o field.csv
  $ adcs field places.csv --degree 8 --single    # as a small satellite may do it"
);

/// Geomagnetic field (IGRF-14) for a table of dates and places
#[derive(Debug, clap::Args)]
#[command(after_help = HELP)]
pub struct Args {
    #[command(flatten)]
    table: TableArgs,

    /// Degree up to which the model is summed, 1 to 13 (before 2000 the model ends at 10)
    #[arg(
        long,
        value_name = "N",
        default_value_t = HIGHEST_DEGREE,
        value_parser = clap::value_parser!(u8).range(1..=i64::from(HIGHEST_DEGREE))
    )]
    degree: u8,

    /// Evaluate in single precision (f32), as on a microcontroller: within 3 nT
    #[arg(long)]
    single: bool,
}

pub fn run(args: &Args) -> ExitCode {
    let TableArgs { input, output } = &args.table;
    exit_code(table::run(input, &output.path, |header| {
        Ok(if args.single {
            Box::new(Field::<f32>::bind(header, args.degree)?)
        } else {
            Box::new(Field::<f64>::bind(header, args.degree)?)
        })
    }))
}
