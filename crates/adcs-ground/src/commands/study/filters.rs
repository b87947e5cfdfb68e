//! `adcs study filters`: how well the filters do.

use std::path::PathBuf;
use std::process::ExitCode;

use adcs_ground::study::campaign::{self, eclipse_ratio, pooled};
use adcs_ground::study::figures::Figures;
use adcs_ground::study::run::Flight;
use adcs_ground::study::scene::Scene;
use anyhow::Result;

use super::super::console::print;
use super::{flown, named, orbits, table};

const HELP: &str = "\
Scenes (SPROUT's preset A2, 2 orbits, sensors of the paper at 1 Hz):
  tumble           B-dot from 5 to 9.5 deg/s
  nadir            nadir pointing by a soft cross-product law that is fed the truth
  nadir-stiff      the same with a stiff law that keeps the body moving
each with an unknown torque of 3e-8 N m (300 s) and inertia told 5 % wrong, and
  tumble-torque    nadir-torque     3e-7 N m instead
  tumble-dipole    nadir-dipole     the residual dipole jumps by 0.03 A m2 an axis in eclipse
  tumble-inertia   nadir-inertia    inertia 10 % wrong instead

For each scene it prints, pooled over all flights from 600 s on:
  sunlit, eclipse  rms of the total angle
  rate, bias       rms of the norm of the error
  NEES             3 when the filter is as sure as it may be
  dipole           largest error of any axis and flight, and rms, after 1200 and 3000 s
  bound            posterior Cramer-Rao bound: what no filter with these states can beat
  believed         what the satellite would use: dynamics-aided where trusted, else MEKF

Examples
  $ adcs study filters
  $ adcs study filters --scene tumble --flights 100 --csv flights.csv
  $ adcs study filters --scene nadir --flights 2 --orbits 445     a month";

/// MEKF and dynamics-aided filter on the same flights, beside the Cramér-Rao bound
#[derive(Debug, clap::Args)]
#[command(after_help = HELP)]
pub struct Args {
    /// The scene; may be given several times [default: all]
    #[arg(long = "scene", value_name = "SCENE", value_parser = scene)]
    scenes: Vec<Scene>,

    /// Flights of each scene
    #[arg(long, default_value_t = 20, value_parser = clap::value_parser!(u64).range(1..=100_000))]
    flights: u64,

    /// Length of each flight, orbits
    #[arg(long, default_value_t = 2.0, value_parser = orbits)]
    orbits: f64,

    /// Also write one row a flight
    #[arg(long, value_name = "OUT.csv")]
    csv: Option<PathBuf>,
}

fn scene(name: &str) -> Result<Scene, String> {
    named("scene", &Scene::ALL, |scene| scene.name, name)
}

pub fn run(args: &Args) -> Result<ExitCode> {
    let scenes = if args.scenes.is_empty() { &Scene::ALL[..] } else { &args.scenes };
    let mut table = table(args.csv.as_deref(), &COLUMNS)?;
    for scene in scenes {
        let scene = Scene { orbits: args.orbits, ..*scene };
        let flights = fly(&scene, args.flights)?;
        show(&scene, &flights);
        if let Some(table) = &mut table {
            for (seed, flight) in (1..).zip(&flights) {
                table.write_record(row(&scene, seed, flight))?;
            }
            table.flush()?;
        }
    }
    if let Some(table) = table {
        table.into_inner().map_err(csv::IntoInnerError::into_error)?.finish()?;
    }
    Ok(ExitCode::SUCCESS)
}

fn fly(scene: &Scene, flights: u64) -> Result<Vec<Flight>> {
    flown(flights, |hear| campaign::fly(scene, flights, hear))
}

fn show(scene: &Scene, flights: &[Flight]) {
    let all = pooled(flights);
    let (ratio, [low, high]) = eclipse_ratio(flights);
    let bound = all.dynamic_bound.eclipse.rms() / all.mekf_bound.eclipse.rms();
    print(format_args!("\n{}: {}; {} flights", scene.name, scene.story(), flights.len()));
    print(format_args!(
        "  eclipse rms, dynamics-aided over MEKF: {ratio:.3} [90 %: {low:.2} to {high:.2}], bounds \
         {bound:.3}"
    ));
    print(format_args!(
        "  eclipse rms over the filter's bound: dynamics-aided {:.3}, MEKF {:.3}",
        all.dynamic.eclipse.rms() / all.dynamic_bound.eclipse.rms(),
        all.mekf.eclipse.rms() / all.mekf_bound.eclipse.rms(),
    ));
    print(
        "                    sunlit  eclipse    rate     bias   NEES   dipole, A m2: 1200 s  3000 s",
    );
    print("                       deg      deg   deg/s    deg/s          largest (rms)");
    line("MEKF", &all.mekf);
    line("  bound", &all.mekf_bound);
    line("dynamics-aided", &all.dynamic);
    line("  bound", &all.dynamic_bound);
    line("believed", &all.believed);
    print(format_args!(
        "  {} s without estimate, {} s not trusted, {} starts in {} flights, covariance not positive in {} s",
        all.believed.without,
        all.dynamic.distrusted,
        all.dynamic.starts,
        flights.len(),
        all.dynamic.not_positive,
    ));
}

fn line(name: &str, figures: &Figures) {
    let number = |value: f64, width: usize, digits: usize| {
        if value.is_finite() {
            format!("{value:width$.digits$}")
        } else {
            format!("{:>width$}", "-")
        }
    };
    let deg = |rms: f64, width, digits| number(rms.to_degrees(), width, digits);
    let [early, late] = figures.dipole.map(|dipole| {
        let rms = dipole.axis.rms();
        if rms.is_finite() {
            format!("{:.4} ({rms:.4})", dipole.largest_am2)
        } else {
            String::new()
        }
    });
    print(format_args!(
        "  {name:16} {} {} {} {} {}   {early:16}{late}",
        deg(figures.sunlit.rms(), 7, 3),
        deg(figures.eclipse.rms(), 8, 3),
        deg(figures.rate.rms(), 8, 4),
        deg(figures.bias.rms(), 8, 4),
        number(figures.nees.mean(), 6, 2),
    ));
}

const COLUMNS: [&str; 14] = [
    "scene",
    "seed",
    "mekf_sunlit_deg",
    "mekf_eclipse_deg",
    "mekf_bound_eclipse_deg",
    "mekf_nees",
    "dynamic_sunlit_deg",
    "dynamic_eclipse_deg",
    "dynamic_bound_eclipse_deg",
    "dynamic_nees",
    "dynamic_rate_deg_s",
    "dipole_error_1200_s_am2",
    "dipole_error_3000_s_am2",
    "not_trusted_s",
];

fn row(scene: &Scene, seed: u64, flight: &Flight) -> [String; 14] {
    let deg = |rms: f64| rms.to_degrees().to_string();
    let [early, late] = flight.dynamic.dipole.map(|dipole| dipole.largest_am2.to_string());
    [
        scene.name.to_owned(),
        seed.to_string(),
        deg(flight.mekf.sunlit.rms()),
        deg(flight.mekf.eclipse.rms()),
        deg(flight.mekf_bound.eclipse.rms()),
        flight.mekf.nees.mean().to_string(),
        deg(flight.dynamic.sunlit.rms()),
        deg(flight.dynamic.eclipse.rms()),
        deg(flight.dynamic_bound.eclipse.rms()),
        flight.dynamic.nees.mean().to_string(),
        deg(flight.dynamic.rate.rms()),
        early,
        late,
        flight.dynamic.distrusted.to_string(),
    ]
}
