//! The command `adcs`.

mod commands;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

/// Fly satellite attitude-control missions and look at the results.
///
/// A mission is a text file that says everything about a flight: the satellite, its sensors and their
/// errors, its orbit, the control law. Start with:
///
///     adcs fly missions/sprout/despin-calibrated.toml
///
/// and open out/despin-calibrated/report.html.
#[derive(Debug, Parser)]
#[command(version, verbatim_doc_comment, arg_required_else_help = true)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Fly(commands::fly::Args),
    Report(commands::report::Args),
    Mission(commands::mission::Args),
    Propagate(commands::propagate::Args),
    Tle(commands::tle::Args),
    Field(commands::field::Args),
    Sun(commands::sun::Args),
    Frames(commands::frames::Args),
    Eclipse(commands::eclipse::Args),
    Attitude(commands::attitude::Args),
    Estimate(commands::estimate::Args),
    Calibrate(commands::calibrate::Args),
    Identify(commands::identify::Args),
    Certify(commands::certify::Args),
    Study(commands::study::Args),
}

fn main() -> ExitCode {
    let result = match Cli::parse().command {
        Command::Fly(args) => commands::fly::run(&args),
        Command::Report(args) => commands::report::run(&args),
        Command::Mission(args) => commands::mission::run(&args),
        Command::Propagate(args) => Ok(commands::propagate::run(&args)),
        Command::Tle(args) => Ok(commands::tle::run(&args)),
        Command::Field(args) => Ok(commands::field::run(&args)),
        Command::Sun(args) => Ok(commands::sun::run(&args)),
        Command::Frames(args) => Ok(commands::frames::run(&args)),
        Command::Eclipse(args) => Ok(commands::eclipse::run(&args)),
        Command::Attitude(args) => Ok(commands::attitude::run(&args)),
        Command::Estimate(args) => Ok(commands::estimate::run(&args)),
        Command::Calibrate(args) => Ok(commands::calibrate::run(&args)),
        Command::Identify(args) => Ok(commands::identify::run(&args)),
        Command::Certify(args) => commands::certify::run(&args),
        Command::Study(args) => commands::study::run(&args),
    };
    result.unwrap_or_else(|error| {
        eprintln!("error: {error:#}");
        ExitCode::from(2)
    })
}
