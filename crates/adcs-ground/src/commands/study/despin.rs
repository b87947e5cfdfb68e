//! `adcs study despin`: despin from random starts.

use std::path::PathBuf;
use std::process::ExitCode;

use adcs_ground::study::campaign::fly_all;
use adcs_ground::study::despin::{Despin, Outcome, Summary, fly};
use anyhow::Result;

use super::super::console::print;
use super::{finish, flown, named, table, write};

const HELP: &str = "\
SPROUT's preset A2 with the paper's sensors (gyro once a second), from rates to (8, 8, 12) deg/s, inertia
within 20 %, anywhere within two days. The flight code itself flies: torquers 10 s on, 2.5 s off.
  off           torquers off, 1200 s
  uncorrected   the paper's B-dot, three orbits; the residual dipole is not known
  estimated     the same with the dynamics-aided filter, which finds the residual dipole on the way, and
                its feed-forward

It prints
  ratio         rate after 1200 s over that at the start, median
  energy fell   share of flights with less energy after 1200 s than at the start
  below         share of flights below this rate after 1, 2 and 3 orbits
  rate          median and 95 % after 3 orbits

Examples
  $ adcs study despin
  $ adcs study despin --flights 500 --csv despin.csv
  $ adcs study despin --case uncorrected --flights 20";

/// Despin from random starts: how far, how fast, how many
#[derive(Debug, clap::Args)]
#[command(after_help = HELP)]
pub struct Args {
    /// What is flown; may be given several times [default: all]
    #[arg(long = "case", value_name = "CASE", value_parser = case)]
    cases: Vec<Despin>,

    /// Flights of each case
    #[arg(long, default_value_t = 100, value_parser = clap::value_parser!(u64).range(1..=100_000))]
    flights: u64,

    /// Also write one row a flight
    #[arg(long, value_name = "OUT.csv")]
    csv: Option<PathBuf>,
}

fn case(name: &str) -> Result<Despin, String> {
    named("case", &Despin::ALL, Despin::name, name)
}

pub fn run(args: &Args) -> Result<ExitCode> {
    let cases = if args.cases.is_empty() { &Despin::ALL[..] } else { &args.cases };
    let mut table = table(args.csv.as_deref(), &COLUMNS)?;
    print(format_args!("{} flights each", args.flights));
    print(
        "                ratio   energy   below 1 deg/s after    below 0.5 deg/s after   rate after 3 orbits",
    );
    print(
        "               median     fell     1      2      3 orb.   1      2      3 orb.  median    95 %",
    );
    for case in cases {
        let flights =
            flown(args.flights, |hear| fly_all(args.flights, |seed| fly(*case, seed), hear))?;
        for (seed, flight) in (1_u64..).zip(&flights) {
            write(&mut table, &row(*case, seed, flight))?;
        }
        show(*case, &Summary::new(flights));
    }
    finish(table)?;
    Ok(ExitCode::SUCCESS)
}

fn show(case: Despin, of: &Summary) {
    let percent = |share: f64| match share {
        share if share.is_nan() => format!("{:>7}", "-"),
        share => format!("{:7.1}", 100.0 * share),
    };
    let below = |rate| [1, 2, 3].map(|orbits| percent(of.below(rate, orbits))).concat();
    let rate = |share| match of.rate_deg_s(share, 3) {
        rate if rate.is_nan() => format!("{:>8}", "-"),
        rate => format!("{rate:8.3}"),
    };
    print(format_args!(
        "  {:12} {:6.4} {} {}  {} {}{} deg/s",
        case.name(),
        of.median_ratio(),
        percent(of.energy_fell()),
        below(1.0),
        below(0.5),
        rate(0.5),
        rate(0.95),
    ));
}

const COLUMNS: [&str; 8] = [
    "case",
    "seed",
    "start_deg_s",
    "ratio_1200_s",
    "energy_ratio_1200_s",
    "after_1_orbit_deg_s",
    "after_2_orbits_deg_s",
    "after_3_orbits_deg_s",
];

fn row(case: Despin, seed: u64, flight: &Outcome) -> [String; 8] {
    let deg = |rate: Option<f64>| rate.map_or(String::new(), |rate| rate.to_degrees().to_string());
    let [one, two, three] = flight.after_orbits_rad_s.map(deg);
    [
        case.name().to_owned(),
        seed.to_string(),
        deg(Some(flight.start_rad_s)),
        flight.ratio.to_string(),
        flight.energy.to_string(),
        one,
        two,
        three,
    ]
}
