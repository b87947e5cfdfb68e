//! `adcs mission`: looking at mission files without flying them.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use adcs_ground::certify::Certificate;
use adcs_ground::mission::{self, Mission};
use anyhow::{Context as _, Result};
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
    /// 0 only when all of them can fly. With a certificate (`adcs certify`) it also warns of a law, a
    /// schedule or an orbit that is not covered by it, which does not change the exit code.
    Check {
        /// A certificate to hold them against.
        #[arg(long, value_name = "certificate.json")]
        certificate: Option<PathBuf>,

        /// Mission files.
        #[arg(required = true, value_name = "MISSION")]
        missions: Vec<PathBuf>,
    },
}

pub fn run(args: &Args) -> Result<ExitCode> {
    let Action::Check { missions, certificate } = &args.action;
    let certificate = certificate.as_deref().map(read).transpose()?;
    let mut refused = 0;
    for path in missions {
        match mission::load(path) {
            Ok(mission) => {
                print(format_args!("{}: can fly ({})", path.display(), mission.title));
                let gaps = certificate.as_ref().map_or_else(Vec::new, |it| gaps(it, &mission));
                for gap in gaps {
                    complain(format_args!("{}: warning: {gap}", path.display()));
                }
            }
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

fn read(path: &Path) -> Result<Certificate> {
    let text = std::fs::read_to_string(path)
        .with_context(|| format!("{} cannot be read", path.display()))?;
    serde_json::from_str(&text).with_context(|| {
        format!("{} is not a certificate: make one with `adcs certify`", path.display())
    })
}

/// What of a mission a certificate does not cover.
fn gaps(certificate: &Certificate, mission: &Mission) -> Vec<String> {
    let flight = &mission.scenario.flight;
    let Some(elements) = &flight.elements else {
        return vec!["the flight has no orbit, and no certificate covers that".to_owned()];
    };
    let round = flight.schedule.round();
    certificate.gaps(&flight.law, [round.on_s, round.off_s], elements)
}
