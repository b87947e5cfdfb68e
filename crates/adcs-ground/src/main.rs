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
}

fn main() -> ExitCode {
    let result = match Cli::parse().command {
        Command::Fly(args) => commands::fly::run(&args),
        Command::Report(args) => commands::report::run(&args),
        Command::Mission(args) => commands::mission::run(&args),
    };
    result.unwrap_or_else(|error| {
        eprintln!("error: {error:#}");
        ExitCode::from(2)
    })
}
