//! `adcs certify`: whether a pointing loop is stable, over a grid of orbits and bodies.

use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Mutex;

use adcs_core::schedule::Round;
use adcs_ground::certify::{Certificate, Entry, Grid, Loop, multiplier, svg};
use adcs_ground::mission;
use adcs_ground::study::campaign;
use adcs_ground::table::Progress;
use anyhow::{Context as _, Result, ensure};

use super::console::print;

const HELP: &str = "\
On target the loop is linear with coefficients that follow the field. A day of it, round by round with
the flight's own law and its own plan, is one matrix; its largest eigenvalue, for each orbit, is what
an error is multiplied by: below 1 it dies out. This is done for every inclination, altitude and season,
with the inertia as the law is told and with each moment larger and smaller.

It prints the largest multiplier at each inclination and altitude, and writes into the output folder
  certificate.json   the law and all multipliers; `adcs mission check --certificate` holds missions
                     against it
  certificate.svg    the picture
The exit code is 1 when a multiplier reaches the limit.

Examples
  $ adcs certify missions/sprout/nadir.toml
  $ adcs certify missions/sprout/nadir.toml --inclinations 51.6 --altitudes 400,420 --inertia 0.3";

/// Stability of the pointing loop over orbits, seasons and inertia: multipliers, table and plot
#[derive(Debug, clap::Args)]
#[command(after_help = HELP)]
pub struct Args {
    /// The mission whose law is certified
    #[arg(value_name = "MISSION")]
    mission: PathBuf,

    /// Inclinations, deg
    #[arg(long, value_delimiter = ',', default_values_t = [30.0, 45.0, 51.6, 70.0, 85.0, 97.9])]
    inclinations: Vec<f64>,

    /// Heights above the equator, km
    #[arg(long, value_delimiter = ',', default_values_t = [400.0, 600.0, 800.0])]
    altitudes: Vec<f64>,

    /// Quarters of a year after the mission's epoch
    #[arg(long, value_delimiter = ',', default_values_t = [0, 1])]
    seasons: Vec<u8>,

    /// How much larger and smaller each moment of inertia may be, as a share of itself
    #[arg(long, default_value_t = 0.2)]
    inertia: f64,

    /// The largest multiplier that passes
    #[arg(long, default_value_t = 0.9)]
    limit: f64,

    /// The output folder [default: out/NAME, NAME being that of the mission file]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

pub fn run(args: &Args) -> Result<ExitCode> {
    ensure!((0.0..0.9).contains(&args.inertia), "--inertia must be from 0 to below 0.9");
    for inclination in &args.inclinations {
        let possible = (0.0..=180.0).contains(inclination);
        ensure!(possible, "--inclinations: {inclination} deg is none; 0 to 180 are");
    }
    for altitude in &args.altitudes {
        let possible = (150.0..=5000.0).contains(altitude);
        ensure!(possible, "--altitudes: {altitude} km is none of a low orbit; 150 to 5000 are");
    }
    let mission = mission::load(&args.mission)?;
    let flight = &mission.scenario.flight;
    let elements = flight.elements.context("the mission's flight has no orbit")?;
    let round = flight.schedule.round();
    let lp = Loop::new(&flight.law, round)?;
    let grid = Grid {
        inclinations_deg: args.inclinations.clone(),
        altitudes_km: args.altitudes.clone(),
        seasons: args.seasons.clone(),
        inertia: args.inertia,
    };
    let mut points = Vec::new();
    for place in grid.places() {
        let elements = place.elements(&elements).context("a season that is no date")?;
        points.extend(grid.bodies().into_iter().map(|body| (place, elements, body)));
    }
    ensure!(!points.is_empty(), "there is nothing to certify: the grid is empty");

    let progress = Mutex::new(Progress::of_steps(points.len() as u64, true));
    let entries = campaign::fly_all(
        points.len() as u64,
        |number| {
            let (place, elements, body) = points
                .get(number as usize - 1)
                .context("a point beyond the grid, which cannot be")?;
            Ok(Entry::new(place, body, multiplier(&lp, elements, body)?))
        },
        || {
            if let Ok(progress) = progress.lock() {
                progress.advance(1);
            }
        },
    );
    if let Ok(progress) = progress.lock() {
        progress.finish();
    }
    let Round { on_s, off_s } = round;
    let certificate = Certificate {
        mission: mission.name.clone(),
        law: flight.law,
        on_off_s: [on_s, off_s],
        limit: args.limit,
        entries: entries?,
    };
    let out = args.out.clone().unwrap_or_else(|| PathBuf::from("out").join(&mission.name));
    std::fs::create_dir_all(&out)
        .with_context(|| format!("the folder {} cannot be made", out.display()))?;
    for (name, text) in [
        ("certificate.json", serde_json::to_string_pretty(&certificate)?),
        ("certificate.svg", svg(&certificate)?),
    ] {
        let path = out.join(name);
        std::fs::write(&path, text)
            .with_context(|| format!("{} cannot be written", path.display()))?;
    }
    show(&certificate, args);
    print(format_args!("{}", out.join("certificate.json").display()));
    Ok(if certificate.holds() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

fn show(certificate: &Certificate, args: &Args) {
    print(format_args!("largest multiplier of an orbit, limit {}", certificate.limit));
    let heads: String = args.altitudes.iter().map(|km| format!("{km:>9} km")).collect();
    print(format_args!("inclination{heads}"));
    for inclination in &args.inclinations {
        let cells: String =
            args.altitudes
                .iter()
                .map(|altitude| {
                    let here = certificate.entries.iter().filter(|it| {
                        it.inclination_deg == *inclination && it.altitude_km == *altitude
                    });
                    format!("{:12.4}", here.map(|it| it.multiplier).fold(0.0, f64::max))
                })
                .collect();
        print(format_args!("{inclination:7.1} deg{cells}"));
    }
    if let Some(worst) = certificate.worst() {
        let verdict = if certificate.holds() { "stable everywhere" } else { "NOT CERTIFIED" };
        print(format_args!(
            "{verdict}: worst {:.4} at {} deg, {} km, season {}, moments {:?}",
            worst.multiplier, worst.inclination_deg, worst.altitude_km, worst.season, worst.moments
        ));
    }
}
