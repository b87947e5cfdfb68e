//! A file with one TLE, and errors in it shown where they are.

use std::fmt::{self, Write as _};
use std::io::Read as _;
use std::path::Path;

use anyhow::{Context as _, anyhow, bail};
use sgp4_lite::{Elements, TleError, TleText};

use crate::table::{name_of, open};

/// More than one TLE of three lines has, with room for empty lines.
const MAX_BYTES: u64 = 4096;

/// Whether a wrong checksum is an error.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Checksum {
    /// It is.
    Verify,
    /// It is let pass.
    Ignore,
}

/// The file as it is called in messages.
pub fn name(path: &Path) -> String {
    name_of(path, "standard input")
}

/// The bytes of a file with one TLE; `-` is standard input.
///
/// # Errors
/// When the file cannot be read, or is far longer than a TLE.
pub fn read(path: &Path) -> anyhow::Result<Vec<u8>> {
    read_at_most(path, MAX_BYTES, "TLE")
}

/// The bytes of a file with one `what`, not longer than `max_bytes`.
pub(crate) fn read_at_most(path: &Path, max_bytes: u64, what: &str) -> anyhow::Result<Vec<u8>> {
    let name = name(path);
    let mut bytes = Vec::new();
    open(path)
        .and_then(|(file, _)| file.take(max_bytes + 1).read_to_end(&mut bytes))
        .with_context(|| format!("{name}: cannot be read"))?;
    if bytes.len() as u64 > max_bytes {
        bail!("{name}: longer than {max_bytes} bytes; a file with one {what} is wanted");
    }
    Ok(bytes)
}

/// The elements of one TLE in two or three lines.
///
/// # Errors
/// The first thing found wrong.
pub fn decode(bytes: &[u8], checksum: Checksum) -> Result<Elements, TleError> {
    match checksum {
        Checksum::Verify => Elements::from_tle_text(bytes),
        Checksum::Ignore => {
            let TleText { line1, line2, .. } = TleText::split(bytes)?;
            Elements::from_tle_lenient(line1, line2)
        }
    }
}

/// The elements in a file with one TLE.
///
/// # Errors
/// When it cannot be read or is wrong; the message then shows the place.
pub fn load(path: &Path, checksum: Checksum) -> anyhow::Result<Elements> {
    let bytes = read(path)?;
    decode(&bytes, checksum).map_err(|error| anyhow!("{}: {}", name(path), Shown(&bytes, &error)))
}

/// Columns of a line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Place {
    /// 1 or 2; 0 is the name line.
    pub line: u8,
    /// The first column, from 1.
    pub first_column: usize,
    /// The last column.
    pub last_column: usize,
}

/// Where the error is; `None` when it is not in certain columns of one line.
pub fn place(error: &TleError) -> Option<Place> {
    const LINE_LENGTH: usize = 69;
    const MAX_NAME_LENGTH: usize = 24;
    let (line, first_column, last_column) = match *error {
        TleError::Length { line: 0, found } => (0, MAX_NAME_LENGTH + 1, found),
        // Behind the last column, or what stands behind column 69.
        TleError::Length { line, found } if found < LINE_LENGTH => (line, found + 1, found + 1),
        TleError::Length { line, found } => (line, LINE_LENGTH + 1, found),
        TleError::LineNumber { line, .. } => (line, 1, 1),
        TleError::Character { line, column, .. } => (line, column.into(), column.into()),
        TleError::EphemerisType { .. } => (1, 63, 63),
        TleError::Checksum { line, .. } => (line, LINE_LENGTH, LINE_LENGTH),
        TleError::SatelliteNumber { .. } => (2, 3, 7),
        TleError::DayOfYear { .. } => (1, 21, 23),
        TleError::Range { line, first_column, last_column, .. } => {
            (line, first_column.into(), last_column.into())
        }
        _ => return None,
    };
    Some(Place { line, first_column, last_column: last_column.max(first_column) })
}

/// An error in a TLE with the line it is in, and its columns marked:
///
/// ```text
/// line 1, column 69: the checksum is 8, but the line sums up to 7
///   1 88888U 98067A   80275.98708465  .00073094  13844-3  66816-4 0    88
///                                                                       ^
/// ```
#[derive(Debug)]
pub struct Shown<'a>(pub &'a [u8], pub &'a TleError);

impl fmt::Display for Shown<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(bytes, error) = self;
        write!(f, "{error}")?;
        let Some(place) = place(error) else { return Ok(()) };
        let Some(line) = line_of(bytes, place.line) else { return Ok(()) };
        let marks = place.last_column.min(line.len() + 1).saturating_sub(place.first_column) + 1;
        f.write_str("\n  ")?;
        for &byte in line {
            // One character a byte, so that the marks stand below.
            f.write_char(if matches!(byte, b' '..=b'~') { char::from(byte) } else { '·' })?;
        }
        write!(f, "\n  {:before$}{:^>marks$}", "", "", before = place.first_column - 1)
    }
}

/// Line 1 or 2 of a TLE, or its name line (0), as it stands in the file.
fn line_of(bytes: &[u8], line: u8) -> Option<&[u8]> {
    let lines = bytes.trim_ascii_end().split(|&byte| byte == b'\n');
    let with_name = lines.clone().count() == 3;
    let index = usize::from(line).checked_sub(usize::from(!with_name))?;
    lines.into_iter().nth(index).map(|line| line.strip_suffix(b"\r").unwrap_or(line))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const LINE1: &str = "1 88888U 98067A   80275.98708465  .00073094  13844-3  66816-4 0    87";
    const LINE2: &str = "2 88888  72.8435 115.9689 0086731  52.6988 110.5714 16.05824518  1058";

    fn shown(text: &[u8]) -> String {
        let error = decode(text, Checksum::Verify).unwrap_err();
        Shown(text, &error).to_string()
    }

    #[test]
    fn the_wrong_column_is_marked() {
        let text = format!("SPROUT\r\n{LINE1}\r\n{}\r\n", LINE2.replace("72.8435", "72,8435"));
        assert_eq!(
            shown(text.as_bytes()).lines().collect::<Vec<_>>(),
            [
                "line 2, column 12: expected a decimal point, found ','",
                "  2 88888  72,8435 115.9689 0086731  52.6988 110.5714 16.05824518  1058",
                "             ^",
            ]
        );
    }

    #[test]
    fn a_line_too_short_or_too_long_is_marked_where_it_should_end() {
        let short = shown(format!("{}\n{LINE2}", &LINE1[..60]).as_bytes());
        assert_eq!(short.lines().last().map(str::len), Some(2 + 61));
        let long = shown(format!("{LINE1}  0\n{LINE2}").as_bytes());
        assert!(long.ends_with(&format!("\n{:71}^^^", "")), "{long}");
    }

    proptest! {
        #[test]
        fn any_bytes_are_decoded_or_explained(text in prop::collection::vec(any::<u8>(), 0..200)) {
            if let Err(error) = decode(&text, Checksum::Verify) {
                prop_assert!(!Shown(&text, &error).to_string().is_empty());
            }
        }

        #[test]
        fn a_changed_byte_is_marked_in_its_line(at in 0..139_usize, byte: u8) {
            let mut text = format!("{LINE1}\n{LINE2}").into_bytes();
            text[at] = byte;
            if let Err(error) = decode(&text, Checksum::Verify) {
                prop_assert!(!Shown(&text, &error).to_string().is_empty());
            }
        }
    }
}
