//! Where a table is written.

use std::ffi::OsString;
use std::fs::{self, File, OpenOptions};
use std::io::{self, Stdout, Write};
use std::path::{Path, PathBuf};

/// Standard output, or a file that appears when it is complete.
///
/// A file is written under its name with `.partial` behind, and renamed by [`finish`](Self::finish):
/// so a table that has its name is complete, an older one is there until then, and after an interruption
/// the rows written so far are in the `.partial` file. What is not a file (a pipe, `/dev/null`) is
/// written directly.
#[derive(Debug)]
pub enum Output {
    /// Standard output.
    Stdout(Stdout),
    /// A device or a pipe.
    Direct(File),
    /// A file, not yet under its own name.
    Partial {
        /// It.
        file: File,
        /// Where it is written.
        partial: PathBuf,
        /// Where it will be.
        path: PathBuf,
    },
}

impl Output {
    /// Opens the output; `-` is standard output.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn create(path: &Path) -> io::Result<Self> {
        if is_dash(path) {
            return Ok(Self::Stdout(io::stdout()));
        }
        let permissions = match OpenOptions::new().write(true).open(path) {
            Ok(file) => {
                let metadata = file.metadata()?;
                if !metadata.is_file() {
                    return Ok(Self::Direct(file));
                }
                Some(metadata.permissions())
            }
            Err(error) if error.kind() == io::ErrorKind::NotFound => None,
            Err(error) => return Err(error),
        };
        // Behind a symbolic link, so that the link stays one.
        let path = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
        let partial = partial_path(&path);
        let file = File::create(&partial)?;
        if let Some(permissions) = permissions {
            file.set_permissions(permissions)?;
        }
        Ok(Self::Partial { file, partial, path })
    }

    /// Gives the complete file its name.
    ///
    /// # Errors
    /// When the last bytes cannot be written, or the file cannot be renamed.
    pub fn finish(mut self) -> io::Result<()> {
        self.flush()?;
        match self {
            Self::Stdout(_) | Self::Direct(_) => Ok(()),
            Self::Partial { partial, path, .. } => fs::rename(partial, path),
        }
    }
}

impl Write for Output {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match self {
            Self::Stdout(stdout) => stdout.write(bytes),
            Self::Direct(file) | Self::Partial { file, .. } => file.write(bytes),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        match self {
            Self::Stdout(stdout) => stdout.flush(),
            Self::Direct(file) | Self::Partial { file, .. } => file.flush(),
        }
    }
}

/// The name under which `path` is written until it is complete.
pub(super) fn partial_path(path: &Path) -> PathBuf {
    let mut name = OsString::from(path);
    name.push(".partial");
    PathBuf::from(name)
}

/// Whether a path stands for standard input or output.
pub(crate) fn is_dash(path: &Path) -> bool {
    path.as_os_str() == "-"
}
