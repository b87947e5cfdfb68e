//! A file with one Orbit Mean-Elements Message (CCSDS 502.0-B-3), and errors in it shown where they
//! are.

use std::fmt;
use std::path::Path;

use anyhow::anyhow;
use sgp4_lite::{Elements, OmmError};

use crate::tle_file::{name, read_at_most};

/// A message with a covariance and every keyword there is takes a tenth.
const MAX_BYTES: u64 = 65_536;

/// The elements in a file with one message in key-value notation; `-` is standard input.
///
/// # Errors
/// When it cannot be read or is wrong; the message then shows the line.
pub fn load(path: &Path) -> anyhow::Result<Elements> {
    let bytes = read_at_most(path, MAX_BYTES, "OMM")?;
    Elements::from_omm(&bytes).map_err(|error| anyhow!("{}: {}", name(path), Shown(&bytes, &error)))
}

/// The line the error is in, from 1; `None` when something is missing.
fn line_of(error: &OmmError) -> Option<u32> {
    match *error {
        OmmError::Character { line, .. }
        | OmmError::NotAnAssignment { line }
        | OmmError::NoVersion { line }
        | OmmError::UnknownKey { line }
        | OmmError::Unsupported { line, .. }
        | OmmError::Duplicate { line, .. }
        | OmmError::Value { line, .. }
        | OmmError::Unit { line, .. }
        | OmmError::Range { line, .. } => Some(line),
        _ => None,
    }
}

/// An error in a message with the line it is in:
///
/// ```text
/// line 17: INCLINATION is out of range: 197.867
///   INCLINATION = 197.867 [deg]
/// ```
#[derive(Debug)]
struct Shown<'a>(&'a [u8], &'a OmmError);

impl fmt::Display for Shown<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(bytes, error) = self;
        write!(f, "{error}")?;
        let lines = &mut bytes.split(|&byte| byte == b'\n');
        let line = line_of(error).and_then(|line| lines.nth(line as usize - 1));
        let Some(line) = line else { return Ok(()) };
        // One character a byte, so that columns can be counted.
        let shown = |&byte: &u8| if matches!(byte, b' '..=b'~') { char::from(byte) } else { '·' };
        let line: String = line.trim_ascii_end().iter().map(shown).collect();
        write!(f, "\n  {line}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn shown(text: &[u8]) -> String {
        Shown(text, &Elements::from_omm(text).unwrap_err()).to_string()
    }

    #[test]
    fn the_wrong_line_is_shown() {
        assert_eq!(
            shown(b"CCSDS_OMM_VERS = 2.0\r\nREF_FRAME = GCRF\r\nTIME_SYSTEM = UTC\r\n"),
            "line 2: REF_FRAME has to be TEME\n  REF_FRAME = GCRF"
        );
        assert_eq!(
            shown(b"CCSDS_OMM_VERS = 2.0\nOBJECT_NAME = \xc3\x89TOILE"),
            "line 2, column 15: byte 0xC3 is not printable ASCII\n  OBJECT_NAME = ··TOILE"
        );
    }

    #[test]
    fn what_is_missing_is_in_no_line() {
        assert_eq!(shown(b"CCSDS_OMM_VERS = 2.0\n"), "CENTER_NAME is missing");
    }

    proptest! {
        #[test]
        fn any_bytes_are_decoded_or_explained(text in prop::collection::vec(any::<u8>(), 0..200)) {
            if let Err(error) = Elements::from_omm(&text) {
                prop_assert!(!Shown(&text, &error).to_string().is_empty());
            }
        }
    }
}
