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

/// The packages that have tests for the emulated core, behind a feature of this name.
const EMULATED_TESTS: [&str; 2] = ["adcs-firmware", "adcs-tests"];
const FEATURE: &str = "emulated";

/// Runs `cargo test`, on the whole workspace unless `arguments` choose packages.
pub fn run(wish: Wish, arguments: &[String]) -> Result<()> {
    let chosen = chosen_packages(arguments);
    let program = cargo(["test"]).args(is_ci().then_some("--locked"));
    let program = if chosen.is_empty() { program.args(["--workspace"]) } else { program };
    let with_tests = |package: &&str| chosen.is_empty() || chosen.contains(package);
    let packages: Vec<&str> = EMULATED_TESTS.into_iter().filter(with_tests).collect();
    if packages.is_empty() {
        return program.args(arguments).run();
    }
    with_image(program, wish, &packages)?.args(arguments).run()
}

/// Adds the tests of `packages` that run the image, and the image. A machine that cannot run it
/// runs the other tests, unless it is a CI machine.
pub fn with_image(program: Program, wish: Wish, packages: &[&str]) -> Result<Program> {
    match emulated(wish) {
        Ok((image, emulator)) => Ok(program
            .args(packages.iter().map(|package| format!("--features={package}/{FEATURE}")))
            .env(IMAGE_VARIABLE, image)
            .env(qemu::VARIABLE, emulator)),
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

/// The packages that `cargo test`'s own arguments choose; what stands after `--` is the tests'.
fn chosen_packages(arguments: &[String]) -> Vec<&str> {
    let mut own = arguments.iter().map(String::as_str).take_while(|&argument| argument != "--");
    let mut packages = Vec::new();
    while let Some(argument) = own.next() {
        match argument {
            "-p" | "--package" => packages.extend(own.next()),
            _ => packages.extend(argument.strip_prefix("--package=")),
        }
    }
    packages
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chosen_packages_are_recognised_in_every_spelling() {
        let line = "-p igrf --release --package=adcs-core --package adcs-tests despin -- -p no";
        let arguments: Vec<String> = line.split(' ').map(str::to_owned).collect();
        assert_eq!(chosen_packages(&arguments), ["igrf", "adcs-core", "adcs-tests"]);
    }

    #[test]
    fn without_a_choice_nothing_is_chosen() {
        assert_eq!(chosen_packages(&["--release".into(), "--".into(), "-p".into()]), [""; 0]);
    }
}
