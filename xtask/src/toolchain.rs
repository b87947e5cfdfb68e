//! A compiler for the Cortex-M4F: found, or installed.
//!
//! The usual one is rustup's, with `core` ready-made for the target. Where rustup cannot fetch
//! that, Debian's compiler builds `core` from Debian's source package; the linker is then the
//! `rust-lld` of the installed Rust, or Debian's.

use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result, bail};

use crate::{
    packages,
    process::{self, Program, is_ci, say, which},
};

/// The Rust name of a Cortex-M4F without operating system, floats in registers.
pub const TARGET: &str = "thumbv7em-none-eabihf";

/// Debian's compiler new enough for this repository, and its source.
const DEBIAN_PACKAGES: [&str; 2] = ["rustc-web", "rust-web-src"];
const DEBIAN_RUSTC: &str = "/usr/bin/rustc";
const DEBIAN_CORE: &str = "/usr/lib/rustlib/src/rust/library/core/Cargo.toml";
/// Debian's linker, for a Rust that came without one.
const DEBIAN_LINKER_PACKAGE: &str = "lld-22";
const DEBIAN_LINKER: &str = "/usr/lib/llvm-22/bin/ld.lld";
/// The oldest compiler for this repository, as in the workspace manifest.
const OLDEST_RUSTC: &str = env!("CARGO_PKG_RUST_VERSION");

/// Which compiler the caller wants.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, clap::ValueEnum)]
pub enum Wish {
    /// Whatever is there; else whatever can be installed.
    #[default]
    Auto,
    /// The installed Rust with its ready-made target.
    Rustup,
    /// Debian's compiler, building `core` from source.
    Debian,
}

/// A compiler that is there.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Toolchain {
    /// The installed Rust knows the target.
    Installed,
    /// Debian's compiler, which builds `core` itself.
    Debian {
        /// Full path of the linker.
        linker: PathBuf,
    },
}

impl Toolchain {
    /// Where images are built: apart from each other, so that both can be kept and compared.
    pub fn target_dir(&self) -> PathBuf {
        match self {
            Self::Installed => process::target_dir(),
            Self::Debian { .. } => process::target_dir().join("debian-core"),
        }
    }

    /// `cargo ACTION` for the target.
    pub fn cargo(&self, action: &str) -> Program {
        let target_dir = self.target_dir();
        let program = process::cargo([action, "--target", TARGET, "--target-dir"])
            .args([target_dir])
            .args(is_ci().then_some("--locked"));
        match self {
            Self::Installed => program,
            Self::Debian { linker } => program
                .args(["-Zbuild-std=core"])
                .env("RUSTC", DEBIAN_RUSTC)
                .env("RUSTC_BOOTSTRAP", "1")
                .env(LINKER_VARIABLE, linker),
        }
    }
}

const LINKER_VARIABLE: &str = "CARGO_TARGET_THUMBV7EM_NONE_EABIHF_LINKER";

/// What the machine has.
#[derive(Debug, Clone, Copy, Default)]
struct Facts {
    target_installed: bool,
    debian_compiler: bool,
    rustup: bool,
    can_install_packages: bool,
}

/// Something that may end in a working compiler.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Step {
    UseInstalled,
    UseDebian,
    AddWithRustup,
    InstallDebian,
}

/// What to try, in this order: first what needs no network.
fn steps(wish: Wish, facts: Facts) -> Vec<Step> {
    let all = [
        (Step::UseInstalled, facts.target_installed, wish != Wish::Debian),
        (Step::UseDebian, facts.debian_compiler, wish != Wish::Rustup),
        (Step::AddWithRustup, facts.rustup, wish != Wish::Debian),
        (Step::InstallDebian, facts.can_install_packages, wish != Wish::Rustup),
    ];
    let possible = all.into_iter().filter(|&(_, possible, wanted)| possible && wanted);
    let steps: Vec<Step> = possible.map(|(step, ..)| step).collect();
    // What is there needs no alternative.
    match steps.first() {
        Some(&found @ (Step::UseInstalled | Step::UseDebian)) => vec![found],
        _ => steps,
    }
}

/// Finds a compiler for the target, or installs one, or says how to.
pub fn find(wish: Wish) -> Result<Toolchain> {
    let sysroot = sysroot();
    let facts = Facts {
        target_installed: sysroot.as_deref().is_ok_and(has_target),
        debian_compiler: debian_compiler_is_there(),
        rustup: which("rustup").is_some(),
        can_install_packages: packages::can_install(),
    };
    for step in steps(wish, facts) {
        match take(step, sysroot.as_deref().ok()) {
            Ok(toolchain) => return Ok(toolchain),
            Err(error) => say(&format!("{error:#}")),
        }
    }
    bail!(
        "no compiler for {TARGET}. Install its `core` with one of\n  \
         rustup target add {TARGET}\n  {} {DEBIAN_LINKER_PACKAGE}",
        packages::command(&DEBIAN_PACKAGES)
    )
}

fn take(step: Step, sysroot: Option<&Path>) -> Result<Toolchain> {
    match step {
        Step::UseInstalled => Ok(Toolchain::Installed),
        Step::UseDebian => debian(sysroot),
        Step::AddWithRustup => {
            say(&format!("adding target {TARGET} with rustup"));
            Program::new("rustup", ["target", "add", TARGET]).run()?;
            if !sysroot.is_some_and(has_target) {
                bail!("rustup added {TARGET} to another toolchain than the one in use");
            }
            Ok(Toolchain::Installed)
        }
        Step::InstallDebian => {
            packages::install(&DEBIAN_PACKAGES)?;
            if !debian_compiler_is_there() {
                bail!("Debian's compiler is older than {OLDEST_RUSTC} or lacks its source");
            }
            debian(sysroot)
        }
    }
}

fn debian(sysroot: Option<&Path>) -> Result<Toolchain> {
    say("using Debian's compiler, which builds `core` for the target itself");
    if let Some(linker) = sysroot.and_then(rust_lld) {
        return Ok(Toolchain::Debian { linker });
    }
    let linker = PathBuf::from(DEBIAN_LINKER);
    if !linker.is_file() {
        if !packages::can_install() {
            bail!("a linker is missing: {}", packages::command(&[DEBIAN_LINKER_PACKAGE]));
        }
        packages::install(&[DEBIAN_LINKER_PACKAGE])?;
    }
    Ok(Toolchain::Debian { linker })
}

/// The Rust name of this computer.
pub fn host() -> Result<String> {
    let version = Program::new("rustc", ["--version", "--verbose"]).output()?;
    let host = version.lines().find_map(|line| line.strip_prefix("host: "));
    host.map(str::to_owned).context("rustc does not say what it runs on")
}

fn sysroot() -> Result<PathBuf> {
    Program::new("rustc", ["--print", "sysroot"]).output().map(PathBuf::from)
}

fn has_target(sysroot: &Path) -> bool {
    let libraries = sysroot.join("lib/rustlib").join(TARGET).join("lib").read_dir();
    libraries.is_ok_and(|files| {
        files.flatten().any(|file| file.file_name().to_string_lossy().starts_with("libcore-"))
    })
}

/// The linker that comes with a Rust installation, wherever its host's folder is.
fn rust_lld(sysroot: &Path) -> Option<PathBuf> {
    let hosts = sysroot.join("lib/rustlib").read_dir().ok()?;
    hosts.flatten().map(|host| host.path().join("bin/rust-lld")).find(|path| path.is_file())
}

fn debian_compiler_is_there() -> bool {
    Path::new(DEBIAN_CORE).is_file()
        && Program::new(DEBIAN_RUSTC, ["--version"])
            .output()
            .and_then(|line| is_new_enough(&line))
            .unwrap_or(false)
}

/// True if `rustc --version` printed a version this repository can be built with.
fn is_new_enough(version_line: &str) -> Result<bool> {
    let found = version_line.split_whitespace().nth(1).context("no version")?;
    Ok(version(found)? >= version(OLDEST_RUSTC)?)
}

fn version(text: &str) -> Result<(u32, u32)> {
    let mut numbers = text.split('.');
    let mut next = || numbers.next().context("not a version")?.parse().context(text.to_owned());
    Ok((next()?, next()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    const BARE: Facts = Facts {
        target_installed: false,
        debian_compiler: false,
        rustup: false,
        can_install_packages: false,
    };

    #[test]
    fn a_target_that_is_there_is_used_and_nothing_is_installed() {
        let facts =
            Facts { target_installed: true, rustup: true, can_install_packages: true, ..BARE };
        assert_eq!(steps(Wish::Auto, facts), [Step::UseInstalled]);
    }

    #[test]
    fn what_is_there_is_preferred_to_what_needs_the_network() {
        let facts =
            Facts { debian_compiler: true, rustup: true, can_install_packages: true, ..BARE };
        assert_eq!(steps(Wish::Auto, facts), [Step::UseDebian]);
    }

    #[test]
    fn rustup_is_tried_before_packages() {
        let facts = Facts { rustup: true, can_install_packages: true, ..BARE };
        assert_eq!(steps(Wish::Auto, facts), [Step::AddWithRustup, Step::InstallDebian]);
    }

    #[test]
    fn a_wish_excludes_the_other_compiler() {
        let facts = Facts {
            target_installed: true,
            debian_compiler: true,
            rustup: true,
            can_install_packages: true,
        };
        assert_eq!(steps(Wish::Debian, facts), [Step::UseDebian]);
        assert_eq!(steps(Wish::Rustup, facts), [Step::UseInstalled]);
        let absent = Facts { target_installed: false, debian_compiler: false, ..facts };
        assert_eq!(steps(Wish::Debian, absent), [Step::InstallDebian]);
        assert_eq!(steps(Wish::Rustup, absent), [Step::AddWithRustup]);
    }

    #[test]
    fn a_bare_machine_leaves_nothing_to_try() {
        assert_eq!(steps(Wish::Auto, BARE), []);
    }

    #[test]
    fn versions_are_compared_as_numbers() {
        assert!(is_new_enough("rustc 1.100.0 (abc 2030-01-01)").unwrap());
        assert!(!is_new_enough("rustc 1.63.0").unwrap());
        assert!(is_new_enough("rustc").is_err());
    }
}
