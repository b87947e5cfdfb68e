//! Tells the linker where the memories of the STM32F405 are (`memory.x` at the top of the
//! repository) and which scripts lay an image out. Does nothing for host builds.

use std::{env, path::Path};

fn main() {
    println!("cargo::rerun-if-changed=../../memory.x");
    if env::var("CARGO_CFG_TARGET_OS").as_deref() != Ok("none") {
        return;
    }
    let manifest = env::var("CARGO_MANIFEST_DIR").expect("cargo sets CARGO_MANIFEST_DIR");
    let top = Path::new(&manifest).join("../..");
    println!("cargo::rustc-link-search={}", top.display());
    // Exact addresses: no page alignment between the load segments of a flash image.
    println!("cargo::rustc-link-arg-bins=--nmagic");
    println!("cargo::rustc-link-arg-bins=-Tlink.x");
    println!("cargo::rustc-link-arg-bins=-Tdefmt.x");
}
