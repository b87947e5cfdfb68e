//! `cargo xtask fly`: builds what a flight needs, and flies.

use std::path::PathBuf;

use anyhow::{Context as _, Result};

use crate::{
    image::{self, Kind},
    process::{cargo, is_ci, say},
    qemu,
    toolchain::{self, Wish},
};

/// What to fly, and where.
#[derive(clap::Args)]
pub struct Options {
    /// The mission file.
    #[arg(default_value = "missions/sprout/despin-calibrated.toml")]
    mission: PathBuf,
    /// Where it flies.
    #[arg(long, value_enum, default_value_t)]
    on: World,
    /// Handed to `adcs fly`, for example `-- --out out/again`.
    #[arg(last = true, value_name = "ARGUMENTS")]
    more: Vec<String>,
}

/// Where a mission can fly.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, clap::ValueEnum)]
enum World {
    /// On this computer.
    Host,
    /// As the ARM image on the emulated STM32F405.
    M4,
    /// On both, comparing the digests.
    #[default]
    Both,
}

/// Flies the mission. Without compiler or emulator for the ARM core it flies on the host and says
/// what was left out; where the core was asked for by name, or on CI, that is a failure.
pub fn run(wish: Wish, options: &Options) -> Result<()> {
    let (world, image) = match options.on {
        World::Host => ("host", None),
        World::M4 => ("m4", Some(emulated(wish)?)),
        World::Both => match emulated(wish) {
            Ok(emulated) => ("both", Some(emulated)),
            Err(error) if is_ci() => return Err(error),
            Err(error) => {
                say(&format!("{error:#}"));
                say("left out: the flight on the emulated core, and so the comparison of digests");
                ("host", None)
            }
        },
    };
    let mut program = cargo(["run", "--release", "--package", "adcs-ground"])
        .args(["--bin", "adcs", "--", "fly"])
        .args([&options.mission])
        .args(["--on", world]);
    if let Some((image, emulator)) = image {
        program = program.args(["--image"]).args([image]).env(qemu::VARIABLE, emulator);
    }
    say(&format!("flying {} on {world}", options.mission.display()));
    program.args(&options.more).become_it()
}

/// The image and the emulator to run it.
fn emulated(wish: Wish) -> Result<(PathBuf, PathBuf)> {
    let emulator = qemu::find()?;
    let toolchain = toolchain::find(wish)?;
    let image = image::build(&toolchain, Kind::Emulated).context("building the image")?;
    Ok((image, emulator))
}
