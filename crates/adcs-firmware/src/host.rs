//! What the emulated image asks of the computer it runs on, through semihosting.
//!
//! Standard output carries defmt frames only (`defmt-print -e IMAGE` reads them); lines for
//! people and programs go to standard error.

use core::ffi::CStr;

use semihosting::{
    fs::File,
    io::{self, Read, Write},
};

/// Why the host's files could not be used.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum FileError {
    /// The path is longer than this image can hold.
    PathTooLong,
    /// The file could not be opened.
    Open,
    /// The file could not be read or written.
    Transfer,
    /// The file holds more bytes than fit.
    TooLong {
        /// Bytes that fit.
        limit: usize,
    },
}

impl core::fmt::Display for FileError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::PathTooLong => write!(f, "path longer than {PATH_BYTES} bytes"),
            Self::Open => f.write_str("cannot be opened"),
            Self::Transfer => f.write_str("cannot be read or written"),
            Self::TooLong { limit } => write!(f, "longer than {limit} bytes"),
        }
    }
}

/// Longest path, bytes.
const PATH_BYTES: usize = 255;

fn with_path<T>(path: &str, open: impl FnOnce(&CStr) -> io::Result<T>) -> Result<T, FileError> {
    let mut bytes = [0; PATH_BYTES + 1];
    bytes
        .get_mut(..path.len())
        .filter(|_| path.len() <= PATH_BYTES)
        .ok_or(FileError::PathTooLong)?
        .copy_from_slice(path.as_bytes());
    let path = CStr::from_bytes_until_nul(&bytes).map_err(|_| FileError::PathTooLong)?;
    open(path).map_err(|_| FileError::Open)
}

/// Reads a whole file into `buffer`.
pub fn read_file<'a>(path: &str, buffer: &'a mut [u8]) -> Result<&'a [u8], FileError> {
    let mut file = with_path(path, |path| File::open(path))?;
    let limit = buffer.len();
    let mut used = 0;
    while let Some(rest) = buffer.get_mut(used..).filter(|rest| !rest.is_empty()) {
        match file.read(rest).map_err(|_| FileError::Transfer)? {
            0 => return buffer.get(..used).ok_or(FileError::Transfer),
            count => used += count,
        }
    }
    Err(FileError::TooLong { limit })
}

/// A file written in blocks: each call to the host costs far more than the bytes.
#[allow(missing_debug_implementations)]
pub struct Writer {
    file: File,
    buffer: heapless::Vec<u8, 4096>,
}

impl Writer {
    /// Creates the file, or empties it.
    pub fn create(path: &str) -> Result<Self, FileError> {
        let file = with_path(path, |path| File::create(path))?;
        Ok(Self { file, buffer: heapless::Vec::new() })
    }

    /// Appends `bytes`.
    pub fn write(&mut self, bytes: &[u8]) -> Result<(), FileError> {
        if self.buffer.extend_from_slice(bytes).is_ok() {
            return Ok(());
        }
        self.flush()?;
        self.file.write_all(bytes).map_err(|_| FileError::Transfer)
    }

    /// Hands what is buffered to the host.
    pub fn flush(&mut self) -> Result<(), FileError> {
        self.file.write_all(&self.buffer).map_err(|_| FileError::Transfer)?;
        self.buffer.clear();
        Ok(())
    }
}
