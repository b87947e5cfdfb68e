//! Debian's packages, for who is root on such a machine.

use anyhow::{Context as _, Result};

use crate::process::{Program, say, which};

/// True if packages can be installed without asking anybody.
pub fn can_install() -> bool {
    which("apt-get").is_some() && is_root()
}

fn is_root() -> bool {
    Program::new("id", ["-u"]).output().is_ok_and(|user| user == "0")
}

/// The command a person types to install `packages`.
pub fn command(packages: &[&str]) -> String {
    format!("sudo apt-get install --no-install-recommends {}", packages.join(" "))
}

/// Installs `packages`. The package lists are fetched only if the packages cannot be had with the
/// lists that are there.
pub fn install(packages: &[&str]) -> Result<()> {
    say(&format!("installing Debian's packages {}", packages.join(", ")));
    if apt_get("install", packages).is_ok() {
        return Ok(());
    }
    say("fetching Debian's package lists first");
    apt_get("update", &[])?;
    apt_get("install", packages).with_context(|| format!("try by hand: {}", command(packages)))
}

fn apt_get(action: &str, packages: &[&str]) -> Result<()> {
    Program::new("apt-get", ["--quiet", "--yes", "--no-install-recommends", action])
        .args(packages)
        .env("DEBIAN_FRONTEND", "noninteractive")
        .run()
}
