//! `cargo xtask bless`: the golden texts rewritten from what the software does now.

use anyhow::Result;

use crate::{
    process::{Program, cargo, say},
    test,
    toolchain::Wish,
};

/// Tells the tests to write golden texts instead of comparing with them.
const VARIABLE: &str = "ADCS_BLESS";
/// The package whose tests hold them.
const PACKAGE: &str = "adcs-tests";

/// Runs the tests that hold golden texts, letting them rewrite these, and shows what changed.
pub fn run(wish: Wish) -> Result<()> {
    let tests = cargo(["test", "--package", PACKAGE]).env(VARIABLE, "1");
    test::with_image(tests, wish, &[PACKAGE])?.run()?;
    say("what changed (look at it before committing):");
    Program::new("git", ["status", "--short", "--", "tests", "missions", "docs"]).run()
}
