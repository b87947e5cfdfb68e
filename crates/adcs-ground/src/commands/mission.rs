//! `adcs mission`: looking at mission files without flying them.

use std::path::PathBuf;
use std::process::ExitCode;

use adcs_ground::mission;
use anyhow::Result;
use clap::Subcommand;

use super::console::{complain, print};

/// Check mission files.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(subcommand)]
    action: Action,
}

#[derive(Debug, Subcommand)]
enum Action {
    /// Load missions and say what is wrong with them, without flying.
    ///
    /// Everything found wrong is listed with file, line, column, reason and advice. The exit code is
    /// 0 only when all of them can fly.
    Check {
        /// Mission files.
        #[arg(required = true, value_name = "MISSION")]
        missions: Vec<PathBuf>,
    },
}

pub fn run(args: &Args) -> Result<ExitCode> {
    let Action::Check { missions } = &args.action;
    let mut refused = 0;
    for path in missions {
        match mission::load(path) {
            Ok(mission) => print(format_args!("{}: can fly ({})", path.display(), mission.title)),
            Err(error) => {
                refused += 1;
                complain(format_args!("{error}\n"));
            }
        }
    }
    if refused > 0 {
        anyhow::bail!("{refused} of {} missions refused", missions.len());
    }
    Ok(ExitCode::SUCCESS)
}
