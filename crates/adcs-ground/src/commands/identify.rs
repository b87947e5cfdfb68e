//! `adcs identify`: what a record says of the satellite itself.

use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use adcs_core::identification::Noise;
use adcs_ground::identification::{self, Columns, Line, Settings, Tensor};
use adcs_ground::table::{self, Output, Tally};
use anyhow::Context as _;

use super::console::print;
use super::files::exit_code;

const HELP: &str = "\
Reads the columns
  t_s                            time, s, rising
  gyro_x_deg_s, _y_, _z_         rates
  field_x_nt, _y_, _z_           calibrated field, Body; empty where not measured
  dipole_x_am2, _y_, _z_         (optional) torquers, from this row to the next
  temperature_c                  (optional) of the gyros
  sun_x, sun_y, sun_z, sun_field_cosine   (optional) Sun as measured, Body; cosine
                                 of the angle between Sun and field by the models
or the history.csv of a flight (adcs fly), whose true Sun and field stand for the
models. Between two fields the gyros turn the last one on. A record is taken up anew
after a gap of 60 s.

Finds, each with its sigma, or says why not
  torque_eq_2           by the paper's eq. (2), beside what gyro noise alone makes
  residual_dipole_eq_3  by the paper's eq. (3)
  residual_dipole       by Euler's equations, followed through time
  sensitivity           change of that for 1 % of a moment and for 1000 nT of bias
  inertia               tensor with the trace of --inertia
  torquer_gains         true over commanded dipole, whatever the tensor: needs torquers that work
  gyro_bias             from how the field turns: needs a tumble
  sun_alignment         turn of the Sun sensors against the magnetometer
  table_5_1             rows of the paper's table 5.1 beside what follows from this

Sigma knows of noise, gyro bias, the field's own turning, gravity gradient and drag. An
error of the tensor that is told, or of the field, is not in it: look at sensitivity.

Example
  $ adcs identify out/no-control/history.csv -o identified.json \\
      --inertia 0.05184,0.05416,0.05978,0.00058,-0.00077,0.00069

Exit code: 0 done, 1 done from fewer rows (some could not be read), 2 not done.";

/// Residual dipole, inertia, torquer gains, gyro bias, Sun sensors from a record
#[derive(Debug, clap::Args)]
#[command(after_help = HELP)]
pub struct Args {
    /// The record, or the history of a flight; - is standard input
    #[arg(value_name = "IN.csv")]
    input: PathBuf,

    /// Inertia tensor, xx,yy,zz or xx,yy,zz,xy,xz,yz, kg m^2; products as in the tensor,
    /// with their negative sign
    #[arg(long, value_name = "KG_M2")]
    inertia: Tensor,

    /// Step of the differences of eq. (2), s
    #[arg(long, value_name = "S", default_value_t = 2.0)]
    difference_s: f64,

    /// Noise of a gyro's reading, deg/s
    #[arg(long, value_name = "DEG_S", default_value_t = 0.163)]
    gyro_noise_deg_s: f64,

    /// Noise of the magnetometer, each axis, nT
    #[arg(long, value_name = "NT", default_value_t = 586.0)]
    field_noise_nt: f64,

    /// The result; - is standard output
    #[arg(short = 'o', long = "output", value_name = "OUT.json", default_value = "-")]
    output: PathBuf,
}

pub fn run(args: &Args) -> ExitCode {
    exit_code(identify(args))
}

fn identify(args: &Args) -> anyhow::Result<Tally> {
    let (rows, tally) =
        table::read_beside(&args.input, |header| Ok(Columns::find(header)?.reader()))?;
    let lines: Vec<Line> = rows.into_iter().flatten().collect();
    let settings = Settings {
        inertia_kg_m2: args.inertia.rows(),
        difference_s: args.difference_s,
        noise: Noise {
            rate_rad_s: args.gyro_noise_deg_s.to_radians(),
            field_t: args.field_noise_nt * 1e-9,
            ..Noise::default()
        },
    };
    let found = identification::identify(&lines, &settings)?;
    let json = serde_json::to_string_pretty(&found)?;
    let written = || -> io::Result<()> {
        let mut output = Output::create(&args.output)?;
        output.write_all(format!("{json}\n").as_bytes())?;
        output.finish()
    };
    match written() {
        // Whoever reads has had enough.
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => {}
        other => {
            other.with_context(|| format!("{} cannot be written", args.output.display()))?;
        }
    }
    if args.output != Path::new("-") {
        print(format_args!("{found}"));
    }
    Ok(tally)
}
