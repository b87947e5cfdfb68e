//! `adcs calibrate`: scale and bias of a magnetometer from its history.

use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use adcs_core::calibration::{DataSheet, Start};
use adcs_ground::calibration::{self, Measured, Outcome, Request};
use adcs_ground::table::{self, Output, Tally};
use anyhow::{Context as _, bail};

use super::console::print;
use super::files::exit_code;

const HELP: &str = "\
Reads the columns
  V_x_volt, V_y_volt, V_z_volt   voltages of the magnetometer
  igrf_norm_nT                   strength of the field there by IGRF
  t_s                            (optional) time, s; for --plot
or the history.csv of a flight (adcs fly), of which it takes the rows that were
measured with the torquers at rest. Columns are found by name, in any order; the
order of the rows does not matter. A row that cannot be read is named by line and
column on standard error and left out.

Finds, for each axis, scale and bias of  B = scale V + bias  that minimise
  E = sum (|B|^2 - |IGRF|^2)^2
No attitude is needed, but readings from many directions: half an orbit of a tumble
does well. Refused are fewer than 12 samples, a sensor or a body that does not move
(condition above 10000), and an axis that does not answer to the field.

What it cannot see: the sign of an axis, as E is the same for a scale of the other
sign (the result is positive); what is not scale or bias, such as axes that are not
square or currents nearby: it stays in norm_error_after_nt.

Writes to OUT.json
  scale_nt_per_v, bias_nt        the result, x y z
  scale_sigma_nt_per_v, bias_sigma_nt   how far noise may have moved it (1 sigma)
  cost_nt4                       E
  samples, iterations, condition  1 is best
  norm_error_before_nt, norm_error_after_nt   min, max, rms of |B| - |IGRF|
  correction                     scale, bias_nt for the mission file, section
                                 magnetometer.calibration: the flight software
                                 computes scale * reading - bias, the reading
                                 being sensitivity * (V - zero)

Examples
  $ adcs calibrate voltages.csv -o calibration.json --plot norm.svg
  $ adcs calibrate out/despin/history.csv -o calibration.json --toml calibration.toml

Exit code: 0 calibrated, 1 calibrated from fewer rows (some could not be read),
2 not calibrated.";

/// Scale and bias of the magnetometer from its readings and the strength of the field
#[derive(Debug, clap::Args)]
#[command(after_help = HELP)]
pub struct Args {
    /// Voltages and strengths, or the history of a flight; - is standard input
    #[arg(value_name = "IN.csv")]
    input: PathBuf,

    /// Which errors to look for
    #[arg(long, value_enum, value_name = "MODEL", default_value_t)]
    model: Model,

    /// Where to start
    #[arg(long, value_enum, value_name = "START", default_value_t)]
    start: StartName,

    /// Sensitivity by the data sheet, nT/V: where to start, and what the readings are
    /// worth before the calibration
    #[arg(long, value_name = "NT_PER_V", default_value_t = 50_000.0, value_parser = sensitivity)]
    start_scale: f64,

    /// Voltage without field by the data sheet, V; 0 when the voltages are counted from it
    #[arg(long, value_name = "V", default_value_t = 0.0, value_parser = finite, allow_negative_numbers = true)]
    zero_v: f64,

    /// magnetometer.sensitivity_nt_per_v of the mission, by which the satellite's driver
    /// turns voltages into field [default: that of --start-scale]
    #[arg(long, value_name = "NT_PER_V", value_parser = sensitivity)]
    sensitivity: Option<f64>,

    /// Compute in single precision (f32), as on a microcontroller
    #[arg(long)]
    single: bool,

    /// The result; - is standard output
    #[arg(short = 'o', long = "output", value_name = "OUT.json", default_value = "-")]
    output: PathBuf,

    /// The section for the mission file
    #[arg(long, value_name = "OUT.toml")]
    toml: Option<PathBuf>,

    /// The strength before and after, against IGRF, over time
    #[arg(long, value_name = "OUT.svg")]
    plot: Option<PathBuf>,
}

#[derive(Debug, Clone, Copy, Default, clap::ValueEnum)]
enum Model {
    /// Scale and bias of each axis: six parameters, by Gauss-Newton
    #[default]
    Paper,
}

#[derive(Debug, Clone, Copy, Default, clap::ValueEnum)]
enum StartName {
    /// From each of the two below; the better result is taken
    #[default]
    Both,
    /// From --start-scale and no bias, as in the paper
    DataSheet,
    /// From the ellipsoid that fits best: a linear problem
    Linear,
}

fn finite(text: &str) -> Result<f64, String> {
    let number = text.parse().map_err(|_| format!("'{text}' is not a number"))?;
    if f64::is_finite(number) { Ok(number) } else { Err(format!("{number} is not finite")) }
}

fn sensitivity(text: &str) -> Result<f64, String> {
    match finite(text)? {
        positive if positive > 0.0 => Ok(positive),
        other => Err(format!("{other} is not positive")),
    }
}

pub fn run(args: &Args) -> ExitCode {
    exit_code(calibrate(args))
}

fn calibrate(args: &Args) -> anyhow::Result<Tally> {
    let Model::Paper = args.model;
    let before = DataSheet { sensitivity: args.start_scale, zero: args.zero_v };
    let driver =
        DataSheet { sensitivity: args.sensitivity.unwrap_or(args.start_scale), zero: args.zero_v };
    let both = [Start::DataSheet(before), Start::Linear { zero: args.zero_v }];
    let starts = match args.start {
        StartName::Both => &both[..],
        StartName::DataSheet => &both[..1],
        StartName::Linear => &both[1..],
    };
    let (rows, tally) =
        table::read_beside(&args.input, |header| calibration::bind(header, driver))?;
    let measured: Vec<Measured> = rows.into_iter().flatten().collect();
    let request = Request { starts, before, driver, single: args.single };
    let outcome = calibration::solve(&measured, &request).with_context(|| name(&args.input))?;

    let plot = match &args.plot {
        Some(path) => Some((path, plot(&measured, before, &outcome)?)),
        None => None,
    };
    let json = serde_json::to_string_pretty(&outcome)?;
    write(&args.output, &format!("{json}\n"))?;
    if let Some(path) = &args.toml {
        write(path, &outcome.correction.toml())?;
    }
    if let Some((path, svg)) = &plot {
        write(path, svg)?;
    }
    if args.output != Path::new("-") {
        print(format_args!("{outcome}"));
    }
    Ok(tally)
}

fn name(input: &Path) -> String {
    match input == Path::new("-") {
        true => "standard input".to_owned(),
        false => input.display().to_string(),
    }
}

fn plot(
    measured: &[Measured],
    before: DataSheet<f64>,
    outcome: &Outcome,
) -> anyhow::Result<String> {
    match calibration::chart(measured, before, outcome) {
        Some(chart) => chart.svg(),
        None => bail!("--plot needs the column t_s"),
    }
}

fn write(path: &Path, text: &str) -> anyhow::Result<()> {
    let written = || -> io::Result<()> {
        let mut output = Output::create(path)?;
        output.write_all(text.as_bytes())?;
        output.finish()
    };
    match written() {
        // Whoever reads has had enough.
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        other => other.with_context(|| format!("{} cannot be written", path.display())),
    }
}
