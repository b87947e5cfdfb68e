//! `adcs study commissioning`: random satellites on the ladder.

use std::path::PathBuf;
use std::process::ExitCode;

use adcs_core::commissioning::Rung;
use adcs_ground::study::campaign::fly_all;
use adcs_ground::study::commissioning::{Quantity, Summary, World, fly};
use anyhow::Result;

use super::super::console::print;
use super::{finish, flown, named, table, write};

const HELP: &str = "\
Satellites like SPROUT of which nobody knows anything: magnetometer scales within 20 %, cross-axis terms
within 5 %, biases within 20 µT, torquers 8 to 20 cm from it, Sun sensors turned by up to 3 deg, gyro bias
to 0.3 deg/s, residual dipole within 0.3 A·m² on each axis, inertia within 10 %, tumbling at 3 to 8 deg/s. The
flight code itself climbs the commissioning ladder, commits what passed its gates, detumbles and points to
nadir.
  plain   nothing else is wrong
  wrong   torquers 2 %, constant torque 5e-9 N·m, dipole 1 % other in the shadow, orbit 2 s late, field model
          60 nT, an Earth that shines into the Sun sensors

It prints
  passed        share of satellites whose result passed its gate, and when that rung ended (median)
  inside 2σ     share of truths inside the reported 2σ: 95 % when σ is honest
  error/σ       root mean square and mean
  error         root mean square and largest
  afterwards    rates after the commit, and the angle to the Orbit frame from the fifth orbit on

Examples
  $ adcs study commissioning --flights 200
  $ adcs study commissioning --world plain --flights 20 --climb-only --csv climb.csv";

/// Random satellites on the commissioning ladder: is what they report of themselves true?
#[derive(Debug, clap::Args)]
#[command(after_help = HELP)]
pub struct Args {
    /// Which world; may be given several times [default: all]
    #[arg(long = "world", value_name = "WORLD", value_parser = world)]
    worlds: Vec<World>,

    /// Satellites in each
    #[arg(long, default_value_t = 200, value_parser = clap::value_parser!(u64).range(1..=100_000))]
    flights: u64,

    /// End with the ladder, without despin and pointing
    #[arg(long)]
    climb_only: bool,

    /// Also write one row a number that was found
    #[arg(long, value_name = "OUT.csv")]
    csv: Option<PathBuf>,
}

fn world(name: &str) -> Result<World, String> {
    named("world", &World::ALL, World::name, name)
}

pub fn run(args: &Args) -> Result<ExitCode> {
    let worlds = if args.worlds.is_empty() { &World::ALL[..] } else { &args.worlds };
    let mut table = table(args.csv.as_deref(), &COLUMNS)?;
    for world in worlds {
        let satellites = flown(args.flights, |hear| {
            fly_all(args.flights, |seed| fly(*world, !args.climb_only, seed), hear)
        })?;
        for (seed, satellite) in (1_u64..).zip(&satellites) {
            for found in &satellite.found {
                let (name, unit, si) = found.quantity.shown();
                let number = |x: f64| (x / si).to_string();
                let row = [
                    world.name().to_owned(),
                    seed.to_string(),
                    name.to_owned(),
                    unit.to_owned(),
                    number(found.error),
                    number(found.sigma),
                ];
                write(&mut table, &row)?;
            }
        }
        show(*world, args, &Summary::new(satellites));
    }
    finish(table)?;
    Ok(ExitCode::SUCCESS)
}

const COLUMNS: [&str; 6] = ["world", "seed", "quantity", "unit", "error", "sigma"];

fn show(world: World, args: &Args, of: &Summary) {
    print(format_args!("{}: {} satellites", world.name(), of.satellites().len()));
    print("  rung               passed   ended at");
    for rung in Rung::ALL {
        let (passed, at_s) = of.rung(rung);
        let name = rung.to_string();
        print(format_args!("  {name:16} {:7.1} %  {at_s:6.0} s", 100.0 * passed));
    }
    print("  quantity                  numbers  inside 2σ  error/σ     mean      error  largest");
    for quantity in Quantity::ALL {
        let (name, unit, si) = quantity.shown();
        let it = of.coverage(quantity);
        let gap = 24_usize.saturating_sub(name.chars().count());
        print(format_args!(
            "  {name}{:gap$} {:8}  {:7.1} %  {:7.2}  {:7.2}  {:9.4} {:8.4} {unit}",
            "",
            it.count,
            100.0 * it.inside,
            it.ratio,
            it.mean,
            it.rms / si,
            it.worst / si,
        ));
    }
    if args.climb_only {
        return;
    }
    let below = |deg_s: f64, orbits| 100.0 * of.below(deg_s.to_radians(), orbits);
    print(format_args!(
        "  afterwards: below 0.5 deg/s after 2 orbits {:.1} %, below 0.3 deg/s after 3 orbits {:.1} %",
        below(0.5, 2),
        below(0.3, 3),
    ));
    let (mean, p95, worst) = of.pointing_deg();
    print(format_args!(
        "  pointing from the fifth orbit on: {mean:.2} deg mean, {p95:.2} deg 95 %, worst satellite's mean \
         {worst:.2} deg, {} lost",
        of.lost(),
    ));
}
