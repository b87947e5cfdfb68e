//! `adcs fly`: flies a mission and leaves a report.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use adcs_ground::emulator::Emulator;
use adcs_ground::flight::{
    Counterpart, Ending, Flight, Flown, Folder, World, compare, host, image,
};
use adcs_ground::mission::{self, Mission};
use adcs_ground::report::{self, Summary};
use anyhow::{Context as _, Result};
use clap::ValueEnum;

use super::console::{Console, INTERRUPTED, Stop, complain, print};

/// Fly a mission and write a report
///
/// Flies the mission closed loop, from the orbit to the torquers' currents, and writes into the output
/// folder:
///
///   report.html    the flight to look at, in any browser, offline
///   summary.json   the flight in numbers
///   history.csv    one row a cycle, units in the header
///   plots/*.svg    the plots of the report
///   records.bin    every message of the flight, as it came
///   commissioning.toml  after commissioning: a mission in which the satellite knows what it found out about itself
///
/// Ctrl-C ends the flight; what was flown until then is kept and reported. The exit code is 0 when the
/// mission was flown to its end (and equally, with --on both), 1 when it was not, 2 when it could not
/// begin, 130 when it was interrupted.
#[derive(Debug, clap::Args)]
#[command(verbatim_doc_comment, after_help = EXAMPLES)]
pub struct Args {
    /// The mission file; see missions/README.md for what may stand in it
    mission: PathBuf,

    /// Where to fly it
    #[arg(long, value_enum, default_value_t = On::Host)]
    on: On,

    /// The output folder [default: out/NAME, NAME being that of the mission file]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,

    /// The image for the emulated core [default: the one that `cargo xtask image` built]
    #[arg(long, value_name = "PATH")]
    image: Option<PathBuf>,

    /// Print results and errors only
    #[arg(long, short)]
    quiet: bool,
}

const EXAMPLES: &str = "\
Examples:
  adcs fly missions/sprout/despin-calibrated.toml
      on this computer; then open out/despin-calibrated/report.html
  adcs fly missions/sprout/despin-calibrated.toml --on both
      also as the ARM image on an emulated STM32F405: both must give the same digest
  adcs fly my-mission.toml --out /tmp/try
      into another folder";

/// Where to fly.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum On {
    /// On this computer
    Host,
    /// As the ARM image on an emulated STM32F405, into the subfolder m4
    M4,
    /// On both, and compare them bit by bit
    Both,
}

pub fn run(args: &Args) -> Result<ExitCode> {
    let mission = mission::load(&args.mission)
        .with_context(|| format!("{} cannot be flown", args.mission.display()))?;
    // What an emulated flight needs is looked for before anything is flown.
    let emulator = match args.on {
        On::Host => None,
        On::M4 | On::Both => Some(emulator(args)?),
    };
    let out = args.out.clone().unwrap_or_else(|| Path::new("out").join(&mission.name));
    let stop = Stop::listen()?;
    let mut flights = Vec::new();
    if args.on != On::M4 {
        let folder = Folder::prepare(&out)?;
        flights.push(fly(args, &mission, &folder, None, &stop)?);
    }
    if let Some(emulator) = &emulator
        && !stop.is_wanted()
    {
        let folder = Folder::prepare(out.join("m4"))?;
        flights.push(fly(args, &mission, &folder, Some(emulator), &stop)?);
    }
    let equal = compare(&mut flights)?;
    if stop.is_wanted() {
        return Ok(ExitCode::from(INTERRUPTED));
    }
    let complete = flights.iter().all(|done| done.flight.ending == Ending::Complete);
    Ok(ExitCode::from(u8::from(!(complete && equal))))
}

fn emulator(args: &Args) -> Result<Emulator> {
    let image = match &args.image {
        Some(image) => image.clone(),
        None => image::find()?,
    };
    Emulator::new(&image)
}

/// A flight that is over.
struct Done {
    folder: Folder,
    flight: Flight,
    flown: Flown,
}

fn fly(
    args: &Args,
    mission: &Mission,
    folder: &Folder,
    emulator: Option<&Emulator>,
    stop: &Stop,
) -> Result<Done> {
    let world = if emulator.is_some() { World::M4 } else { World::Host };
    let mut console = Console::new(world, mission.scenario.cycles, args.quiet, stop);
    let flight = match emulator {
        None => host::fly(mission, folder, &mut console),
        Some(emulator) => image::fly(emulator, mission, folder, &mut console),
    };
    console.finish();
    let flight = flight?;
    if let Ending::Failed(reason) = &flight.ending {
        complain(format_args!("error: the flight on {world} ended early: {reason}"));
    }
    let flown = Flown::read(&folder.records())?;
    let summary = report::make_of(folder, &flight, &flown)?;
    print_result(&summary, folder, args.quiet);
    Ok(Done { folder: folder.clone(), flight, flown })
}

fn print_result(summary: &Summary, folder: &Folder, quiet: bool) {
    let world = summary.world.to_string();
    match &summary.digest {
        Some(digest) => print(format_args!("digest {world:<4} {digest}")),
        None => print(format_args!("digest {world:<4} none: the flight is not whole")),
    }
    if quiet {
        return;
    }
    print(format_args!("  flown    {:.1} of {:.1} s", summary.flown_s, summary.planned_s));
    let rates = &summary.rates;
    let ratio = rates.ratio.map_or_else(String::new, |ratio| format!(", ratio {ratio:.3}"));
    print(format_args!(
        "  rate     {:.3} deg/s at the start, {:.3} deg/s at the end{ratio}",
        rates.start_norm_deg_s, rates.end_norm_deg_s
    ));
    if let Some(pointing) = &summary.pointing {
        let captured = pointing.captured_s.map_or_else(
            || "not within 10 deg at the end".to_owned(),
            |captured_s| format!("within 10 deg from {captured_s:.0} s on"),
        );
        print(format_args!(
            "  pointing {:.2} deg mean, {:.2} deg 95 %, {:.2} deg at most from {:.0} s on; {captured}",
            pointing.mean_deg, pointing.p95_deg, pointing.largest_deg, pointing.settled_s
        ));
    }
    for at in &summary.transitions {
        let time_s = at.time_ms as f64 / 1e3;
        print(format_args!("  mode     {time_s:>8.1} s  {} to {}: {}", at.from, at.to, at.cause));
    }
    if let Some(climb) = &summary.commissioning {
        for at in &climb.rungs {
            let time_s = at.time_ms as f64 / 1e3;
            print(format_args!("  rung     {time_s:>8.1} s  {}: {}", at.rung, at.outcome));
            for found in &at.found {
                print(format_args!("                        {found}"));
            }
        }
        for at_ms in &climb.committed_ms {
            print(format_args!("  commit   {:>8.1} s", *at_ms as f64 / 1e3));
        }
        print(format_args!("  found    {}", folder.commissioning().display()));
    }
    if let (Some(wall_s), Some(speed)) = (summary.wall_s, summary.speed_over_real_time) {
        print(format_args!("  speed    {wall_s:.2} s, {speed:.0} times real time"));
    }
    print(format_args!("  report   {}", folder.report().display()));
}

/// Says whether two flights were the same, here and in their reports; true when there is nothing to
/// compare.
fn compare(flights: &mut [Done]) -> Result<bool> {
    let [host, m4] = flights else { return Ok(true) };
    let difference = compare::first_difference(&host.flown, &m4.flown)?;
    let difference = difference.map(|difference| difference.to_string());
    let whole = host.flown.is_whole() && m4.flown.is_whole();
    match &difference {
        Some(difference) => print(format_args!("different: host and m4 part at {difference}")),
        None if whole => print("equal"),
        None => print("equal as far as both were flown"),
    }
    if whole {
        for (done, world) in [(host, World::M4), (m4, World::Host)] {
            done.flight.counterpart = Some(Counterpart { world, difference: difference.clone() });
            done.folder.write_flight(&done.flight)?;
            report::make_of(&done.folder, &done.flight, &done.flown)?;
        }
    }
    Ok(whole && difference.is_none())
}
