//! `cargo xtask ci`: what tests do not check.

use anyhow::{Result, bail};

use crate::{
    budget, igrf_table,
    process::{Program, cargo, is_ci, say},
    toolchain::{self, Toolchain, Wish},
};

/// The crates that fly. Each must build for a core without operating system.
const FLIGHT_CRATES: [&str; 7] =
    ["sgp4-lite", "igrf", "adcs-core", "adcs-hal", "adcs-link", "adcs-app", "adcs-sim"];

/// Runs all checks, one after the other; the first that fails ends it.
pub fn run(wish: Wish) -> Result<()> {
    step("format");
    cargo(["fmt", "--all", "--check"]).run()?;

    step("lints");
    clippy(cargo(["clippy", "--workspace", "--all-targets", "--all-features"]))?;

    step("documentation");
    cargo(["doc", "--workspace", "--no-deps"])
        .args(locked())
        .env("RUSTDOCFLAGS", "-D warnings")
        .run()?;

    let toolchain = toolchain::find(wish)?;
    step("flight crates without std");
    let packages = FLIGHT_CRATES.iter().flat_map(|name| ["--package", name]);
    toolchain.cargo("check").args(packages).run()?;
    // Debian's compiler comes without clippy.
    if toolchain == Toolchain::Installed {
        step("lints of the images");
        let package = ["--package", "adcs-firmware"];
        let flight = ["--bin", "adcs-firmware", "--features", "flight"];
        let emulated = ["--bins", "--features", "emulated"];
        clippy(toolchain.cargo("clippy").args(package).args(flight))?;
        clippy(toolchain.cargo("clippy").args(package).args(emulated))?;
    }

    step("nalgebra without std");
    let tree = ["tree", "--workspace", "--edges", "all", "--prefix", "none", "--format", "{p} {f}"];
    let tree = cargo(tree).output()?;
    let culprits = host_dependent_kernels(&tree);
    if !culprits.is_empty() {
        bail!("host and target would compute differently with: {}", culprits.join(", "));
    }

    step("generated tables");
    igrf_table::run(true)?;

    step("budgets");
    budget::run(wish, None)?;
    say("all checks passed");
    Ok(())
}

fn step(name: &str) {
    say(&format!("checking: {name}"));
}

fn locked() -> Option<&'static str> {
    is_ci().then_some("--locked")
}

fn clippy(program: Program) -> Result<()> {
    program.args(["--", "-D", "warnings"]).run()
}

/// Lines of `cargo tree` that bring matrix kernels which depend on the host's processor: the crate
/// `matrixmultiply`, and nalgebra's feature `std`, which pulls it in.
fn host_dependent_kernels(tree: &str) -> Vec<&str> {
    let brings = |line: &&str| {
        let mut words = line.split_whitespace();
        let name = words.next().unwrap_or_default();
        // `{p} {f}` is "name version [(place)] features", the features joined by commas.
        let features = words.next_back().unwrap_or_default();
        name == "matrixmultiply" || name == "nalgebra" && features.split(',').any(|f| f == "std")
    };
    let mut lines: Vec<&str> = tree.lines().filter(brings).collect();
    lines.dedup();
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nalgebra_with_std_and_matrixmultiply_are_found() {
        let tree = "adcs-core v0.1.0 (/adcs-core) \n\
                    nalgebra v0.35.0 default,macros,std\n\
                    matrixmultiply v0.3.9 std\n";
        assert_eq!(host_dependent_kernels(tree).len(), 2);
    }

    #[test]
    fn nalgebra_without_std_is_fine_and_so_is_std_elsewhere() {
        let tree = "nalgebra v0.35.0 libm,libm-force,macros\nserde v1.0.0 default,std\nlibm v0.2\n";
        assert_eq!(host_dependent_kernels(tree), Vec::<&str>::new());
    }
}
