//! `adcs calibrate`: scale and bias of a magnetometer from its history.

use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use adcs_core::calibration::{DataSheet, Start};
use adcs_ground::calibration::{self, Columns, Measured, Model, Naming, Outcome, Request};
use adcs_ground::identification::Tensor;
use adcs_ground::report::chart::Chart;
use adcs_ground::table::{self, Output, Tally};
use anyhow::{Context as _, bail};

use super::console::print;
use super::files::exit_code;

const HELP: &str = "\
Reads the columns
  V_x_volt, V_y_volt, V_z_volt   voltages of the magnetometer
  igrf_norm_nT                   strength of the field there by IGRF
  t_s                            (optional) time, s; for the plots and the axes
  current_1_a ... current_6_a    (optional) currents nearby, of panels or torquers
  gyro_x_deg_s, _y_, _z_         (optional) rates; for the axes
or the history.csv of a flight (adcs fly). Of that it takes the rows that were
measured with the torquers at rest, and with --model coupled all, the torquers'
dipoles being the currents. Columns are found by name, in any order. A row that
cannot be read is named by line and column on standard error and left out.

Models, B being the field and V the voltages:
  paper    B = scale V + bias, by Gauss-Newton on  E = sum (|B|^2 - |IGRF|^2)^2
  nine     B = C (scale V) + bias, C symmetric with ones on its diagonal: axes
           that are not square
  twostep  the same nine by TWOSTEP (Alonso & Shuster), which needs no start; always
           without the shift by noise
  coupled  nine, and for each current the field that it makes (Springmann & Cutler)
  auto     the smallest of paper, nine and (for a table with currents) coupled
           that the data ask for, by Schwarz' criterion
No attitude is needed, but readings from many directions: half an orbit of a tumble
does well. Refused are fewer samples than two for each unknown, a sensor or a body
that does not move (condition above 10000), and an axis that does not answer.

What the strength cannot see: the signs of the axes, and which is which. Where the
table has gyros, they and the torquers' work tell, and the answer is in axes.

Writes to OUT.json
  scale_nt_per_v, bias_nt, cross_axis (xy xz yz), couplings   the result, x y z
  ..._sigma...                   how far noise may have moved it (1 sigma)
  cost_nt4                       E
  samples, iterations, condition  1 is best
  norm_error_before_nt, norm_error_after_nt   min, max, rms of |B| - |IGRF|
  turned_deg                     angle between the field before and after
  evidence                       of the models tried: unknowns, rms_nt, bic
  axes                           Body's x y z along the sensor's, as +x +y +z
  correction                     scale, cross_axis, bias_nt for the mission file,
                                 section magnetometer.calibration: the flight
                                 software computes C (scale * reading) - bias,
                                 the reading being sensitivity * (V - zero);
                                 alignment_xyzw, where --apply-signs exchanges axes

Examples
  $ adcs calibrate voltages.csv -o calibration.json --plot norm.svg
  $ adcs calibrate out/despin/history.csv --model auto --toml calibration.toml

Exit code: 0 calibrated, 1 calibrated from fewer rows (some could not be read),
2 not calibrated.";

/// What is wrong with the magnetometer, from its readings and the strength of the field
#[derive(Debug, clap::Args)]
#[command(after_help = HELP)]
pub struct Args {
    /// Voltages and strengths, or the history of a flight; - is standard input
    #[arg(value_name = "IN.csv")]
    input: PathBuf,

    /// Which errors to look for
    #[arg(long, value_enum, value_name = "MODEL", default_value_t)]
    model: ModelName,

    /// Take out the shift that noise makes in |B|^2 (some tenths of a percent of scale)
    #[arg(long)]
    unbiased: bool,

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

    /// Turn round and exchange, in the section for the mission file, the axes that gyros
    /// and torquers find wired so
    #[arg(long)]
    apply_signs: bool,

    /// Compute in single precision (f32), as on a microcontroller
    #[arg(long)]
    single: bool,

    /// The result; - is standard output
    #[arg(short = 'o', long = "output", value_name = "OUT.json", default_value = "-")]
    output: PathBuf,

    /// The section for the mission file
    #[arg(long, value_name = "OUT.toml")]
    toml: Option<PathBuf>,

    /// The strength before and after, against IGRF, over time (the paper's fig. 5.2)
    #[arg(long, value_name = "OUT.svg")]
    plot: Option<PathBuf>,

    /// The angle between the field before and after, over time (the paper's fig. 5.3)
    #[arg(long, value_name = "OUT.svg")]
    angle_plot: Option<PathBuf>,

    /// The satellite's inertia tensor, xx,yy,zz or xx,yy,zz,xy,xz,yz, kg m^2; for the axes,
    /// to a fifth
    #[arg(long, value_name = "KG_M2", default_value = "0.055,0.055,0.055")]
    inertia: Tensor,
}

#[derive(Debug, Clone, Copy, Default, clap::ValueEnum)]
enum ModelName {
    /// Scale and bias of each axis: six unknowns, by Gauss-Newton
    #[default]
    Paper,
    /// Angles between the axes too: nine
    Nine,
    /// The same nine by TWOSTEP
    Twostep,
    /// Nine, and three for each current nearby
    Coupled,
    /// What the data ask for
    Auto,
}

impl From<ModelName> for Model {
    fn from(name: ModelName) -> Self {
        match name {
            ModelName::Paper => Self::Paper,
            ModelName::Nine => Self::Nine,
            ModelName::Twostep => Self::TwoStep,
            ModelName::Coupled => Self::Coupled,
            ModelName::Auto => Self::Auto,
        }
    }
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
    let before = DataSheet { sensitivity: args.start_scale, zero: args.zero_v };
    let driver =
        DataSheet { sensitivity: args.sensitivity.unwrap_or(args.start_scale), zero: args.zero_v };
    let both = [Start::DataSheet(before), Start::Linear { zero: args.zero_v }];
    let starts = match args.start {
        StartName::Both => &both[..],
        StartName::DataSheet => &both[..1],
        StartName::Linear => &both[1..],
    };
    let mut currents = None;
    let (rows, tally) = table::read_beside(&args.input, |header| {
        let columns = Columns::find(header)?;
        currents = Some(columns.currents());
        Ok(columns.reader(driver))
    })?;
    let measured: Vec<Measured> = rows.into_iter().flatten().collect();
    let request = Request {
        model: args.model.into(),
        starts,
        before,
        driver,
        single: args.single,
        unbiased: args.unbiased,
        currents: currents.context("no header")?,
        apply_signs: args.apply_signs,
        inertia_kg_m2: args.inertia.rows(),
    };
    let outcome = calibration::solve(&measured, &request).with_context(|| name(&args.input))?;
    if args.apply_signs {
        must_be_named(outcome.axes.as_ref())?;
    }

    let mut plots = Vec::new();
    type Draw = fn(&[Measured], DataSheet<f64>, &Outcome) -> Option<Chart>;
    let wanted: [(_, Draw); 2] =
        [(&args.plot, calibration::chart), (&args.angle_plot, calibration::angle_chart)];
    for (path, draw) in wanted {
        if let Some(path) = path {
            let Some(chart) = draw(&measured, before, &outcome) else {
                bail!("a plot needs the column t_s");
            };
            plots.push((path, chart.svg()?));
        }
    }
    let json = serde_json::to_string_pretty(&outcome)?;
    write(&args.output, &format!("{json}\n"))?;
    if let Some(path) = &args.toml {
        write(path, &outcome.correction.toml())?;
    }
    for (path, svg) in &plots {
        write(path, svg)?;
    }
    if args.output != Path::new("-") {
        print(format_args!("{outcome}"));
    }
    Ok(tally)
}

/// Refuses to go on with axes that nobody could name.
fn must_be_named(axes: Option<&Naming>) -> anyhow::Result<()> {
    match axes {
        None => bail!("--apply-signs needs the columns t_s and gyro_x_deg_s, _y_, _z_"),
        Some(Naming { open: Some(open), .. }) => bail!("--apply-signs: {open}"),
        Some(_) => Ok(()),
    }
}

fn name(input: &Path) -> String {
    match input == Path::new("-") {
        true => "standard input".to_owned(),
        false => input.display().to_string(),
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
