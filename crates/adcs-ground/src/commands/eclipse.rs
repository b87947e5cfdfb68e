//! `adcs eclipse`: when a satellite enters and leaves the Earth's shadow.

use std::path::PathBuf;
use std::process::ExitCode;

use adcs_core::environment::eclipse::EarthShape;
use adcs_core::orbit::OrbitModel;
use adcs_core::time::Utc;
use adcs_ground::shadow::ShadowSearch;
use adcs_ground::table::Tally;
use anyhow::Context as _;
use clap::{ArgGroup, ValueEnum};

use super::files::{LenientArgs, OutputArgs, elements, exit_code, span};

const HELP: &str = "\
Writes, in order of time,
  shadow             penumbra (part of the Sun is hidden) or umbra (all of it)
  event              entry or exit
  utc_iso            when, to the millisecond
  t_after_start_s    the same, in seconds after --from

A span that begins in the shadow has an exit first. Orbit by SGP4, Sun by the
formula of adcs sun, no atmosphere: the dark line is some seconds longer in
truth.

Example
  $ adcs eclipse --tle sprout.tle --from 2015-11-19T00:00:00Z \\
      --to 2015-11-20T00:00:00Z -o shadow.csv

Exit code: 0 the whole span was searched, 1 the orbit ends before (what was
found until then is written), 2 nothing could be done.";

/// Entries into and exits from the Earth's shadow along an orbit
#[derive(Debug, clap::Args)]
#[command(
    after_help = HELP,
    group = ArgGroup::new("orbit").args(["tle", "omm"]).required(true)
)]
pub struct Args {
    /// A file with one TLE; - is standard input
    #[arg(long, value_name = "FILE")]
    tle: Option<PathBuf>,

    /// Instead of a TLE, a file with one OMM (CCSDS 502.0-B, in KEY = VALUE notation)
    #[arg(long, value_name = "FILE", conflicts_with = "lenient")]
    omm: Option<PathBuf>,

    /// First instant (UTC), as 2015-11-19T03:00:00Z
    #[arg(long, value_name = "UTC", value_parser = Utc::parse)]
    from: Utc,

    /// Last instant (UTC)
    #[arg(long, value_name = "UTC", value_parser = Utc::parse)]
    to: Utc,

    /// What casts the shadow
    #[arg(long, value_enum, default_value_t)]
    earth: Earth,

    #[command(flatten)]
    output: OutputArgs,

    #[command(flatten)]
    lenient: LenientArgs,
}

/// What casts the shadow.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub enum Earth {
    /// A sphere of 6378.137 km
    Sphere,
    /// The ellipsoid WGS84: shadows of polar orbits are up to some seconds shorter
    #[default]
    Ellipsoid,
}

impl From<Earth> for EarthShape {
    fn from(earth: Earth) -> Self {
        match earth {
            Earth::Sphere => Self::Sphere,
            Earth::Ellipsoid => Self::Ellipsoid,
        }
    }
}

pub fn run(args: &Args) -> ExitCode {
    exit_code(work(args))
}

fn work(args: &Args) -> anyhow::Result<Tally> {
    let span = span(args.from, args.to)?;
    let elements = elements(args.tle.as_deref(), args.omm.as_deref(), args.lenient.checksum())?
        .context("neither --tle nor --omm")?;
    let orbit = OrbitModel::new(&elements)?;
    let search = ShadowSearch { orbit: &orbit, span, shape: args.earth.into() };
    search.write(&args.output.path)
}
