//! `adcs study pointing`: how well the satellite points with magnets alone.

use std::path::PathBuf;
use std::process::ExitCode;

use adcs_ground::study::campaign;
use adcs_ground::study::pointing::case::Case;
use adcs_ground::study::pointing::figures::Figures;
use adcs_ground::study::pointing::flight::{self, Flown};
use anyhow::{Context as _, Result};

use super::super::console::print;
use super::{flown, named, orbits, table};

const HELP: &str = "\
Each flight starts at any attitude, with up to 1 deg/s on each axis, at any time of two days, and flies
the flight code itself (cycle of 0.5 s, torquers 5 s on and 2.5 s off) with the paper's sensors and
residual dipole, of which nothing is known at the start. Cases:
  plain                no model errors
  actuators            torquers 2 % (1 sigma), inertia 5 %, a constant torque of 5e-9 N m
  shadow               the same, and the dipole 1 % other in the shadow, thermal lag 0 to 600 s
  everything           also 1e-8 N m and 5e-9 random, magnetometer 500 nT, orbit 2 s late, field
                       model 60 nT wrong on each axis
  constant-torque      2e-8 N m in any direction
  random-torque        3e-8 N m on each axis, changing within 300 s; random-torque-known: the same
                       with perfect knowledge
  law-alone, cross-product-alone   perfect knowledge: the laws themselves
  mekf, cross-product-mekf         attitude and rate of the MEKF, the dipole known exactly
  no-feed-forward, dipole-5-percent   what is lost without, or with a wrong dipole

It prints for each case, from the third orbit on and over all flights:
  mean, 95 %           total angle to the Orbit frame, deg
  worst                largest mean of a flight, deg; lost: flights whose mean is above 30 deg
  captured             flights within 10 deg for good after one orbit and after two

Examples
  $ adcs study pointing
  $ adcs study pointing --case plain --flights 20
  $ adcs study pointing --case everything --csv flights.csv";

/// Nadir with magnets alone: laws, filters and worlds, beside perfect knowledge
#[derive(Debug, clap::Args)]
#[command(after_help = HELP)]
pub struct Args {
    /// The case; may be given several times [default: all]
    #[arg(long = "case", value_name = "CASE", value_parser = case)]
    cases: Vec<Case>,

    /// Flights of each case
    #[arg(long, default_value_t = 100, value_parser = clap::value_parser!(u64).range(1..=100_000))]
    flights: u64,

    /// Length of each flight, orbits; figures count from the third on
    #[arg(long, default_value_t = 8.0, value_parser = orbits)]
    orbits: f64,

    /// Also write one row a flight
    #[arg(long, value_name = "OUT.csv")]
    csv: Option<PathBuf>,
}

fn case(name: &str) -> Result<Case, String> {
    named("case", &Case::all(), |case| case.name, name)
}

const COLUMNS: [&str; 4] = ["case", "seed", "mean_deg", "captured_orbits"];

pub fn run(args: &Args) -> Result<ExitCode> {
    let cases = if args.cases.is_empty() { Case::all() } else { args.cases.clone() };
    let mut table = table(args.csv.as_deref(), &COLUMNS)?;
    print("                      mean    95 %   worst   lost   captured after 1, 2 orbits");
    for case in &cases {
        let flights = flown(args.flights, |hear| {
            campaign::fly_all(args.flights, |seed| flight::fly(case, args.orbits, seed), hear)
        })?;
        show(case, &flights)?;
        let Some(table) = &mut table else { continue };
        for (seed, flight) in (1..).zip(&flights) {
            table.write_record(row(case, seed, flight))?;
        }
        table.flush()?;
    }
    if let Some(table) = table {
        table.into_inner().map_err(csv::IntoInnerError::into_error)?.finish()?;
    }
    Ok(ExitCode::SUCCESS)
}

fn show(case: &Case, flights: &[Flown]) -> Result<()> {
    let figures = Figures::of(flights).context("a flight must be longer than two orbits")?;
    let Figures { flights, mean_deg, p95_deg, worst_mean_deg, lost, captured: [one, two] } =
        figures;
    print(format_args!(
        "{:20} {mean_deg:6.2} {p95_deg:7.2} {worst_mean_deg:7.2} {lost:6}   {one}, {two} of \
         {flights}   {}",
        case.name, case.story
    ));
    Ok(())
}

fn row(case: &Case, seed: u64, flight: &Flown) -> [String; 4] {
    let captured = flight.captured_orbits.map_or_else(String::new, |orbits| orbits.to_string());
    [case.name.to_owned(), seed.to_string(), flight.mean_deg().to_string(), captured]
}
