//! Images: built, and weighed.

use std::{fs, path::PathBuf};

use anyhow::{Context as _, Result};
use object::{Object as _, ObjectSection as _, SectionFlags, SectionKind, elf};

use crate::{
    process::say,
    toolchain::{TARGET, Toolchain},
};

/// Which image.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, clap::ValueEnum)]
pub enum Kind {
    /// The emulated STM32F405: orders, files and logs go through semihosting.
    #[default]
    Emulated,
    /// The board: logs go through RTT.
    Flight,
    /// The emulated STM32F405, counting instructions instead of flying.
    Bench,
}

impl Kind {
    const fn binary(self) -> &'static str {
        match self {
            Self::Emulated | Self::Flight => "adcs-firmware",
            Self::Bench => "bench",
        }
    }

    const fn feature(self) -> &'static str {
        match self {
            Self::Emulated | Self::Bench => "emulated",
            Self::Flight => "flight",
        }
    }

    const fn file(self) -> &'static str {
        match self {
            Self::Emulated => "adcs-emulated.elf",
            Self::Flight => "adcs-flight.elf",
            Self::Bench => "bench.elf",
        }
    }
}

/// Builds an image and gives its path.
pub fn build(toolchain: &Toolchain, kind: Kind) -> Result<PathBuf> {
    say(&format!("building image {}", kind.file()));
    toolchain
        .cargo("build")
        .args(["--package", "adcs-firmware", "--profile", "flight"])
        .args(["--bin", kind.binary(), "--features", kind.feature()])
        .run()?;
    // Cargo builds both kinds of `adcs-firmware` to the same place, so each gets its own copy.
    let built = toolchain.target_dir().join(TARGET).join("flight").join(kind.binary());
    let folder = toolchain.target_dir().join("images");
    let image = folder.join(kind.file());
    fs::create_dir_all(&folder)?;
    fs::copy(&built, &image).with_context(|| format!("copying {}", built.display()))?;
    Ok(image)
}

/// Bytes of memory an image takes before it runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Size {
    /// Code, constants and initial values.
    pub flash: u64,
    /// Variables, not counting the stack.
    pub ram: u64,
}

/// Adds up the sections of an ELF file that take memory on the chip.
pub fn size(file: &[u8]) -> Result<Size> {
    let image = object::File::parse(file).context("not an ELF file")?;
    let mut size = Size::default();
    for section in image.sections() {
        let SectionFlags::Elf { sh_flags } = section.flags() else { continue };
        let allocated = sh_flags & u64::from(elf::SHF_ALLOC) != 0;
        let writable = sh_flags & u64::from(elf::SHF_WRITE) != 0;
        let has_contents = section.kind() != SectionKind::UninitializedData;
        if allocated && has_contents {
            size.flash += section.size();
        }
        if allocated && writable {
            size.ram += section.size();
        }
    }
    Ok(size)
}

/// Prints what an image takes of the chip.
pub fn print_size(image: &PathBuf) -> Result<()> {
    let Size { flash, ram } = size(&fs::read(image)?)?;
    println!("{}", image.display());
    println!("flash {flash:>8} bytes");
    println!("RAM   {ram:>8} bytes without stack");
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn something_else_than_an_image_is_refused() {
        assert!(size(b"not an image").is_err());
    }

    #[test]
    fn this_test_itself_has_code_and_variables() {
        let own = fs::read(std::env::current_exe().unwrap()).unwrap();
        let Size { flash, ram } = size(&own).unwrap();
        assert!(flash > ram && ram > 0, "{flash} {ram}");
        assert!(flash < own.len() as u64, "debug information is not loaded");
    }
}
