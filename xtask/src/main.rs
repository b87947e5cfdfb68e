//! The one entry point for set-up, tests, emulation, budgets and blessing: `cargo xtask --help`.

mod bless;
mod budget;
mod ci;
mod fly;
mod igrf_table;
mod image;
mod packages;
mod process;
mod qemu;
mod test;
mod toolchain;

use std::{path::PathBuf, process::ExitCode};

use anyhow::Result;
use clap::{Parser, Subcommand};

/// Builds, flies, tests and measures the flight software.
///
/// On a fresh machine two commands show everything:
///
///   cargo xtask fly     flies SPROUT's despin experiment on this computer and, as the ARM image,
///                       on an emulated STM32F405; shows that both flights gave the same bits
///
///   cargo xtask test    runs all tests, those on the emulated core included
///
/// Both find or install what they need: the Rust target thumbv7em-none-eabihf (by rustup; as root
/// on Debian by Debian's packages) and QEMU. Where neither is possible they say what to type.
/// Once everything is there, no command needs the network.
#[derive(Parser)]
#[command(name = "cargo xtask", bin_name = "cargo xtask", verbatim_doc_comment)]
struct Arguments {
    /// The compiler for the ARM core.
    #[arg(long, global = true, value_enum, default_value_t, value_name = "WHICH")]
    toolchain: toolchain::Wish,
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Finds or installs the Rust target, QEMU and the crates; afterwards all works offline.
    Setup,
    /// Builds an image and prints its size.
    Image {
        /// What the image runs on.
        #[arg(long = "for", value_enum, default_value_t)]
        kind: image::Kind,
    },
    /// Flies a mission on this computer and on the emulated core, and compares the digests.
    Fly(fly::Options),
    /// Runs all tests, those on the emulated core included.
    Test {
        /// Handed to `cargo test`, for example `-p adcs-core` or `-- --nocapture`.
        #[arg(trailing_var_arg = true, allow_hyphen_values = true, value_name = "ARGUMENTS")]
        arguments: Vec<String>,
    },
    /// Checks all that tests do not: format, lints, docs, no_std builds, tables, budgets.
    Ci,
    /// Measures flash, RAM and instructions, and holds them against `budgets.toml`.
    Budget {
        /// Writes the table as JSON, too.
        #[arg(long, value_name = "FILE")]
        json: Option<PathBuf>,
    },
    /// Rewrites the golden texts after an intended change; look at the diff before committing.
    Bless,
    /// Writes the coefficient table of crate `igrf` from the official file.
    IgrfTable {
        /// Only says whether the table is up to date.
        #[arg(long)]
        check: bool,
    },
}

fn main() -> ExitCode {
    match run(Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            process::say(&format!("error: {error:#}"));
            ExitCode::FAILURE
        }
    }
}

fn run(Arguments { toolchain, command }: Arguments) -> Result<()> {
    match command {
        Command::Setup => setup(toolchain),
        Command::Image { kind } => {
            let image = image::build(&toolchain::find(toolchain)?, kind)?;
            image::print_size(&image)
        }
        Command::Fly(options) => fly::run(toolchain, &options),
        Command::Test { arguments } => test::run(toolchain, &arguments),
        Command::Ci => ci::run(toolchain),
        Command::Budget { json } => budget::run(toolchain, json.as_deref()),
        Command::Bless => bless::run(toolchain),
        Command::IgrfTable { check } => igrf_table::run(check),
    }
}

fn setup(wish: toolchain::Wish) -> Result<()> {
    process::say("fetching the crates that are not here yet");
    let host = format!("--target={}", toolchain::host()?);
    let core = format!("--target={}", toolchain::TARGET);
    process::cargo(["fetch", "--locked", &host, &core]).run()?;
    toolchain::find(wish)?;
    qemu::find()?;
    process::say("everything is there; all commands work offline now");
    Ok(())
}
