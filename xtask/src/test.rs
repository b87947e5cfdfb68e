//! `cargo xtask test`: all tests, those on the emulated core included.

use std::path::PathBuf;

use anyhow::Result;

use crate::{
    image::{self, Kind},
    process::{Program, cargo, is_ci, say},
    qemu,
    toolchain::{self, Wish},
};

/// Tells the tests which image to run on the emulated core; without it they leave that out.
const IMAGE_VARIABLE: &str = "ADCS_IMAGE";

/// Runs `cargo test --workspace` with the image at hand.
pub fn run(wish: Wish, arguments: &[String]) -> Result<()> {
    let whole = if selects_packages(arguments) { None } else { Some("--workspace") };
    with_image(cargo(["test"]).args(is_ci().then_some("--locked")).args(whole), wish)?
        .args(arguments)
        .run()
}

/// Adds the image and the emulator to the environment of `program`. A machine that has none runs
/// the other tests, unless it is a CI machine.
pub fn with_image(program: Program, wish: Wish) -> Result<Program> {
    match emulated(wish) {
        Ok((image, emulator)) => {
            Ok(program.env(IMAGE_VARIABLE, image).env(qemu::VARIABLE, emulator))
        }
        Err(error) if is_ci() => Err(error),
        Err(error) => {
            say(&format!("{error:#}"));
            say("left out: the tests on the emulated core");
            Ok(program)
        }
    }
}

fn emulated(wish: Wish) -> Result<(PathBuf, PathBuf)> {
    let emulator = qemu::find()?;
    let image = image::build(&toolchain::find(wish)?, Kind::Emulated)?;
    Ok((image, emulator))
}

/// True if `cargo test`'s own arguments choose packages; what stands after `--` is the tests'.
fn selects_packages(arguments: &[String]) -> bool {
    let own = arguments.iter().take_while(|argument| *argument != "--");
    own.into_iter().any(|a| a == "-p" || a.starts_with("--package") || a == "--workspace")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chosen_packages_replace_the_whole_workspace() {
        let chosen =
            |line: &str| selects_packages(&line.split(' ').map(str::to_owned).collect::<Vec<_>>());
        assert!(chosen("-p adcs-core") && chosen("--package=igrf"));
        assert!(!chosen("--release some_test") && !chosen("-- -p"));
    }
}
