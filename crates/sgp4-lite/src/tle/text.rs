//! The raw bytes of one TLE, cut into its lines.

use super::error::{Expected, TleError};

/// Longest name of a satellite above a TLE.
const MAX_NAME_LENGTH: usize = 24;

/// The lines of one TLE, without line ends; their content is not yet checked.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TleText<'a> {
    /// The satellite's name from the line above, without the `0 ` that some catalogues put before
    /// it and without blanks behind it.
    pub name: Option<&'a str>,
    /// Line 1.
    pub line1: &'a [u8],
    /// Line 2.
    pub line2: &'a [u8],
}

impl<'a> TleText<'a> {
    /// Cuts a text of two or three lines at its line ends, LF or CRLF.
    ///
    /// The last line may go without line end; empty lines may follow it. Of three lines, the first
    /// is the name: 1 to 24 printable ASCII characters, with or without `0 ` before them.
    ///
    /// # Errors
    /// [`TleError::Lines`] when there are fewer or more lines; [`TleError::Length`] and
    /// [`TleError::Character`] with line 0 for a name of wrong length or with wrong characters.
    pub fn split(text: &'a [u8]) -> Result<Self, TleError> {
        let text = without_final_line_ends(text);
        let mut lines =
            text.split(|&byte| byte == b'\n').map(|line| line.strip_suffix(b"\r").unwrap_or(line));
        match (lines.next(), lines.next(), lines.next(), lines.count()) {
            (Some(line1), Some(line2), None, 0) => Ok(Self { name: None, line1, line2 }),
            (Some(name), Some(line1), Some(line2), 0) => {
                Ok(Self { name: Some(checked_name(name)?), line1, line2 })
            }
            _ => {
                let found = match text {
                    [] => 0,
                    text => 1 + text.iter().filter(|&&byte| byte == b'\n').count(),
                };
                Err(TleError::Lines { found })
            }
        }
    }
}

fn without_final_line_ends(mut text: &[u8]) -> &[u8] {
    while let [before @ .., b'\r' | b'\n'] = text {
        text = before;
    }
    text
}

fn checked_name(line: &[u8]) -> Result<&str, TleError> {
    for (column, &found) in (1..=u8::MAX).zip(line) {
        if !matches!(found, b' '..=b'~') {
            let expected = Expected::Printable;
            return Err(TleError::Character { line: 0, column, found, expected });
        }
    }
    let length = TleError::Length { line: 0, found: line.len() };
    let name = line.strip_prefix(b"0 ").unwrap_or(line);
    if name.is_empty() || name.len() > MAX_NAME_LENGTH {
        return Err(length);
    }
    str::from_utf8(name.trim_ascii_end()).map_err(|_| length)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_stand_with_or_without_zero_and_blanks() {
        for text in ["SPROUT\na\nb", "0 SPROUT\r\na\r\nb\r\n", "SPROUT                  \na\nb\n\n"]
        {
            let split = TleText::split(text.as_bytes()).unwrap();
            assert_eq!(split, TleText { name: Some("SPROUT"), line1: b"a", line2: b"b" });
        }
        assert_eq!(
            TleText::split(b"a\nb\r\n"),
            Ok(TleText { name: None, line1: b"a", line2: b"b" })
        );
    }

    #[test]
    fn bad_names_are_refused() {
        let length = |found| Err(TleError::Length { line: 0, found });
        assert_eq!(TleText::split(b"\na\nb"), length(0));
        assert_eq!(TleText::split(b"0 \na\nb"), length(2));
        assert_eq!(TleText::split(b"ABCDEFGHIJKLMNOPQRSTUVWXY\na\nb"), length(25));
        assert_eq!(
            TleText::split(b"SPR\xD6UT\na\nb"),
            Err(TleError::Character {
                line: 0,
                column: 4,
                found: 0xD6,
                expected: Expected::Printable
            })
        );
    }

    #[test]
    fn texts_with_other_numbers_of_lines_are_refused() {
        for (text, found) in [(&b""[..], 0), (b"\r\n\n", 0), (b"a", 1), (b"a\nb\nc\nd\n", 4)] {
            assert_eq!(TleText::split(text), Err(TleError::Lines { found }));
        }
    }
}
