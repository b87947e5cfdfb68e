//! `adcs frames`: from TEME to Earth-fixed axes and to the map.

use std::process::ExitCode;

use adcs_ground::columns::frames::Frames;
use adcs_ground::table;

use super::files::{TableArgs, exit_code, table_help};

const HELP: &str = table_help!(
    "\
Reads the columns
  ut1_jd_day, ut1_jd_fraction    Julian date of UT1 in two parts, e.g. 2453101.5
                        and 0.3274067829525463
    or utc_iso          UTC instant, as 2015-11-19T02:55:21.392832Z, taken for
                        UT1 (at most 0.9 s or 0.004 deg of Earth rotation off);
                        UT1 is used where both are there
  teme_x_km, teme_y_km, teme_z_km             position in TEME
  teme_vx_km_s, teme_vy_km_s, teme_vz_km_s    velocity in TEME
                        (or x_teme_km ... vz_teme_km_s, as adcs propagate
                        writes them)
and writes all columns of the input, and behind them
  gmst82_rad            Greenwich mean sidereal time of 1982, 0 to 2 pi
  pef_x_km, pef_y_km, pef_z_km                position in Earth-fixed axes (PEF:
                        TEME turned by GMST; without polar motion)
  pef_vx_km_s, pef_vy_km_s, pef_vz_km_s       velocity against the Earth
  geodetic_lat_deg      geodetic latitude on WGS84
  lon_east_deg          longitude, -180 to 180, positive eastwards
  height_wgs84_km       height above the ellipsoid
  error                 empty, or why the row has no result

Example: the ground track of a day
  $ adcs propagate --tle sprout.tle --from 2015-11-19T00:00:00Z \\
      --to 2015-11-20T00:00:00Z --step 60 | adcs frames - -o track.csv"
);

/// TEME to Earth-fixed and geodetic coordinates for a table of states
#[derive(Debug, clap::Args)]
#[command(after_help = HELP)]
pub struct Args {
    #[command(flatten)]
    table: TableArgs,
}

pub fn run(args: &Args) -> ExitCode {
    let TableArgs { input, output } = &args.table;
    exit_code(table::run(input, &output.path, |header| Ok(Box::new(Frames::bind(header)?))))
}
