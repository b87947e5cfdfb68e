//! `adcs estimate`: attitude and gyro bias over time.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use adcs_core::attitude::selection::Flies;
use adcs_ground::columns::attitude::Precision;
use adcs_ground::columns::estimate::{Estimate, Reference};
use adcs_ground::filter_config::FilterConfig;
use adcs_ground::table::{self, Tally};
use anyhow::bail;

use super::files::{OutputArgs, exit_code, table_help};

const HELP: &str = table_help!(
    "\
Reads from M.csv, in order of time,
  t_s                      time, s
  gyro_x_rad_s .. _z_      rate as the gyros show it, body axes
  mag_x_nT .. _z_nT        field, body axes, measured with the torquers at rest
  sun_x .. sun_z           direction to the Sun, body axes
  sun_valid                (optional) 1 where a sensor sees the Sun, else 0
  torquer_x_am2 .. _z_     (optional) dipole of the torquers since the row before, body
                           axes, for --filter dynamic; 0 where it is not there
from R.csv, for the same instants,
  t_s
  B_teme_x_nT .. _z_nT     the field that the model has there
  sun_teme_x .. _z         the direction to the Sun
  r_teme_x_km .. _z_       (optional) position, for the gravity gradient
  eclipse                  (optional) 1 where it is hidden, else 0
and from C.json
  gyro_sigma_rad_s                   noise of one gyro sample
  gyro_bias_rw_rad_s_sqrt_s          walk of the gyro bias
  mag_sigma_nT_per_axis              noise of the magnetometer
  sun_sigma_rad_per_transverse_axis  noise of the Sun's direction
and if they are there (other keys are passed over)
  mag_calibration_sigma_nT_per_axis, field_model_sigma_nT_per_axis (0)
  gyro_sampling                      instant (default) or interval: whether a gyro
                                     sample is a rate or the mean since the last
  reference_filter_initial_q_xyzw    where to start; else from field and Sun
  reference_filter_P0_attitude_sigma_deg (5), reference_filter_P0_bias_sigma_deg_s (0.5)
  inertia_kg_m2 (SPROUT's), residual_dipole_am2 (0, 0, 0), unknown_torque_n_m (8e-8):
                                     where --filter dynamic begins to estimate them

An empty field or nan is a measurement that is missing. Writes t_s, other columns
that M.csv may have, and behind them
  q_x, q_y, q_z, q_w       attitude quaternion, v_body = A(q) v_teme, q_w >= 0
  bias_x_rad_s .. _z_      gyro bias
  sigma_att_x_rad .. _z_   standard deviation of the attitude about each body axis
  nis_mag, nis_sun         innovation squared over its expected variance: 3 and 2
                           on average
  source                   dynamic: from the filter that knows the dynamics; else the
                           MEKF: field+sun, field, sun: what corrected it; gyro,
                           held-rate: what carried it; two-vectors: field and Sun of
                           this instant alone; none: no estimate to be believed
  error                    empty, or why the row was passed over

Example
  $ adcs estimate --measurements measurements.csv \\
      --references reference_vectors.csv --config config.json --single -o est.csv"
);

/// Attitude and gyro bias from gyro, magnetometer and Sun sensor over time
#[derive(Debug, clap::Args)]
#[command(after_help = HELP)]
pub struct Args {
    /// What was measured; - is standard input
    #[arg(long, value_name = "M.csv")]
    measurements: PathBuf,

    /// What the models say for the same instants
    #[arg(long, value_name = "R.csv")]
    references: PathBuf,

    /// What the sensors are, and where to start
    #[arg(long, value_name = "C.json")]
    config: PathBuf,

    /// The filter
    #[arg(long, value_enum, value_name = "FILTER", default_value_t)]
    filter: Filter,

    /// Compute in single precision (f32), as on a microcontroller
    #[arg(long)]
    single: bool,

    #[command(flatten)]
    output: OutputArgs,
}

#[derive(Debug, Clone, Copy, Default, clap::ValueEnum)]
enum Filter {
    /// Multiplicative extended Kalman filter: attitude and gyro bias
    #[default]
    Mekf,
    /// The MEKF, and beside it a filter that knows the satellite's dynamics: rate, residual dipole,
    /// inertia and unknown torque are estimated too, and it is used wherever it is borne out
    Dynamic,
}

pub fn run(args: &Args) -> ExitCode {
    exit_code(match (args.filter, args.single) {
        (Filter::Mekf, false) => estimate::<f64>(args, Flies::Mekf),
        (Filter::Mekf, true) => estimate::<f32>(args, Flies::Mekf),
        (Filter::Dynamic, false) => estimate::<f64>(args, Flies::Both),
        (Filter::Dynamic, true) => estimate::<f32>(args, Flies::Both),
    })
}

fn estimate<T: Precision>(args: &Args, flies: Flies) -> anyhow::Result<Tally> {
    let inputs = [&args.measurements, &args.references, &args.config];
    if inputs.iter().filter(|path| path.as_path() == Path::new("-")).count() > 1 {
        bail!("only one of the inputs can be standard input");
    }
    let config = FilterConfig::read(&args.config)?;
    let filter = config
        .filter::<T>(flies)
        .map_err(|error| error.context(args.config.display().to_string()))?;
    let (references, of_references) = table::read_beside(&args.references, Reference::bind)?;
    let tally = table::run(&args.measurements, &args.output.path, |header| {
        Ok(Box::new(Estimate::bind(header, references, filter)?))
    })?;
    Ok(Tally { bad: tally.bad + of_references.bad, ..tally })
}
