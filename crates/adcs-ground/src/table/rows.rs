//! The rows of a table, one by one, whatever stands in the file.

use std::collections::VecDeque;
use std::fmt;
use std::io::{self, BufRead, Read as _};

use csv::ByteRecord;

use super::Failure;
use super::fields::{WrongQuote, split, split_at_every_comma};
use super::header::Header;

/// A row longer than this is refused rather than kept in memory. The longest row of numbers has a few
/// thousand bytes.
pub const MAX_ROW_BYTES: usize = 1 << 20;

/// How many lines a quoted field may span before its quotation mark is taken for a slip.
pub const MAX_LINES_OF_ROW: usize = 20;

/// The byte order mark that some programs put before UTF-8.
const BYTE_ORDER_MARK: &[u8] = b"\xEF\xBB\xBF";

/// What keeps a row from being read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Defect {
    FieldCount { found: usize, expected: usize },
    QuoteNotClosed,
    TextBehindQuote,
    TooLong,
}

impl fmt::Display for Defect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::FieldCount { found, expected } => {
                write!(f, "number of fields: {found}, but the header line has {expected}")
            }
            Self::QuoteNotClosed => write!(f, "a quotation mark is not closed"),
            Self::TextBehindQuote => write!(f, "text behind a closing quotation mark"),
            Self::TooLong => write!(f, "longer than {} MiB", MAX_ROW_BYTES >> 20),
        }
    }
}

/// One line of the file, without its end.
struct Line {
    number: u64,
    bytes: Vec<u8>,
    too_long: bool,
}

/// Reads the rows below the header line of a table.
///
/// Lines end with LF or CRLF; empty lines are passed over. A quoted field may hold line ends, as long
/// as the row comes out with the right number of fields within [`MAX_LINES_OF_ROW`] lines. Otherwise
/// the quotation mark is a slip: its line is a bad row, and reading goes on with the next line, so that
/// one slip costs one row and not the rest of the file.
pub struct Rows<R> {
    input: R,
    lines_read: u64,
    /// Lines that were looked at for the end of a quoted field, and are to be read again.
    pending: VecDeque<Line>,
    header: Header,
}

impl<R: BufRead> Rows<R> {
    /// Reads the header line.
    ///
    /// # Errors
    /// [`Failure`] when there is none, or the input cannot be read.
    pub fn new(input: R) -> Result<Self, Failure> {
        let header = Header::new(ByteRecord::new());
        let mut rows = Self { input, lines_read: 0, pending: VecDeque::new(), header };
        let Some(line) = rows.line_with_text().map_err(Failure::Read)? else {
            return Err(Failure::Empty);
        };
        if matches!(line.bytes.as_slice(), [0xFF, 0xFE, ..] | [0xFE, 0xFF, ..]) {
            return Err(Failure::Utf16);
        }
        let text = line.bytes.strip_prefix(BYTE_ORDER_MARK).unwrap_or(&line.bytes);
        let mut names = ByteRecord::new();
        if line.too_long {
            return Err(Failure::WrongHeader {
                line: line.number,
                why: Defect::TooLong.to_string(),
            });
        }
        split(text, &mut names).map_err(|wrong| Failure::WrongHeader {
            line: line.number,
            why: defect_of(wrong).to_string(),
        })?;
        rows.header = Header::new(names);
        Ok(rows)
    }

    /// The names of the columns.
    pub fn header(&self) -> &Header {
        &self.header
    }

    /// Puts the next row into `fields`, with as many fields as the header has, and gives the number of
    /// its first line; `None` at the end of the table.
    pub(super) fn next(
        &mut self,
        fields: &mut ByteRecord,
    ) -> io::Result<Option<(u64, Option<Defect>)>> {
        let Some(line) = self.line_with_text()? else { return Ok(None) };
        let number = line.number;
        let defect = if line.too_long {
            fields.clear();
            Some(Defect::TooLong)
        } else {
            match split(&line.bytes, fields) {
                Ok(()) => None,
                Err(WrongQuote::NotClosed) if self.continue_row(&line, fields)? => None,
                Err(wrong) => {
                    split_at_every_comma(&line.bytes, fields);
                    Some(defect_of(wrong))
                }
            }
        };
        let (found, expected) = (fields.len(), self.header.len());
        let defect = match defect {
            None if found != expected => Some(Defect::FieldCount { found, expected }),
            other => other,
        };
        fields.truncate(expected);
        while fields.len() < expected {
            fields.push_field(b"");
        }
        Ok(Some((number, defect)))
    }

    /// Whether the row that begins with `first` is complete with some of the lines that follow.
    fn continue_row(&mut self, first: &Line, fields: &mut ByteRecord) -> io::Result<bool> {
        let mut row = first.bytes.clone();
        let mut taken = Vec::new();
        while taken.len() + 1 < MAX_LINES_OF_ROW && row.len() <= MAX_ROW_BYTES {
            let Some(next) = self.line()? else { break };
            row.push(b'\n');
            row.extend_from_slice(&next.bytes);
            let too_long = next.too_long;
            taken.push(next);
            match split(&row, fields) {
                _ if too_long => break,
                Ok(()) if fields.len() == self.header.len() => return Ok(true),
                Err(WrongQuote::NotClosed) => {}
                Ok(()) | Err(WrongQuote::TextBehind) => break,
            }
        }
        for line in taken.into_iter().rev() {
            self.pending.push_front(line);
        }
        Ok(false)
    }

    fn line_with_text(&mut self) -> io::Result<Option<Line>> {
        loop {
            match self.line()? {
                Some(line) if line.bytes.is_empty() && !line.too_long => {}
                other => return Ok(other),
            }
        }
    }

    fn line(&mut self) -> io::Result<Option<Line>> {
        if let Some(line) = self.pending.pop_front() {
            return Ok(Some(line));
        }
        let mut bytes = Vec::new();
        let limit = MAX_ROW_BYTES as u64;
        if self.input.by_ref().take(limit).read_until(b'\n', &mut bytes)? == 0 {
            return Ok(None);
        }
        self.lines_read += 1;
        let mut too_long = false;
        if bytes.ends_with(b"\n") {
            bytes.pop();
        } else if bytes.len() == MAX_ROW_BYTES {
            too_long = true;
            bytes.clear();
            self.input.skip_until(b'\n')?;
        }
        if bytes.ends_with(b"\r") {
            bytes.pop();
        }
        Ok(Some(Line { number: self.lines_read, bytes, too_long }))
    }
}

fn defect_of(wrong: WrongQuote) -> Defect {
    match wrong {
        WrongQuote::NotClosed => Defect::QuoteNotClosed,
        WrongQuote::TextBehind => Defect::TextBehindQuote,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    type Read = (u64, Option<Defect>, Vec<String>);

    fn read(text: &[u8]) -> Vec<Read> {
        let mut rows = Rows::new(text).unwrap();
        let mut fields = ByteRecord::new();
        let mut all = Vec::new();
        while let Some((line, defect)) = rows.next(&mut fields).unwrap() {
            let fields = fields.iter().map(|field| String::from_utf8_lossy(field).into_owned());
            all.push((line, defect, fields.collect()));
        }
        all
    }

    fn row(line: u64, defect: Option<Defect>, fields: [&str; 2]) -> Read {
        (line, defect, fields.map(str::to_owned).to_vec())
    }

    #[test]
    fn crlf_empty_lines_a_byte_order_mark_and_a_missing_last_line_end_change_nothing() {
        let expected = [row(3, None, ["1", "2"]), row(5, None, ["3", ""])];
        assert_eq!(read(b"\n\xEF\xBB\xBFa,b\n1,2\n\n3,\n")[..], expected);
        assert_eq!(read(b"\r\n\xEF\xBB\xBFa,b\r\n1,2\r\n\r\n3,")[..], expected);
    }

    #[test]
    fn ragged_rows_are_bad_and_come_out_as_wide_as_the_header() {
        let count = |found| Some(Defect::FieldCount { found, expected: 2 });
        assert_eq!(
            read(b"a,b\n1\n1,2,3\n4,5\n")[..],
            [row(2, count(1), ["1", ""]), row(3, count(3), ["1", "2"]), row(4, None, ["4", "5"])]
        );
    }

    #[test]
    fn a_quoted_field_may_hold_line_ends() {
        assert_eq!(
            read(b"a,b\n\"1\r\n\r\n2\",3\n4,5\n")[..],
            [row(2, None, ["1\n\n2", "3"]), row(5, None, ["4", "5"])]
        );
    }

    #[test]
    fn a_quotation_mark_that_slipped_in_costs_its_own_row_only() {
        let open = Some(Defect::QuoteNotClosed);
        assert_eq!(
            read(b"a,b\n\"1,2\n3,4\n5,\"6\n7,8\n")[..],
            [
                row(2, open, ["\"1", "2"]),
                row(3, None, ["3", "4"]),
                row(4, open, ["5", "\"6"]),
                row(5, None, ["7", "8"])
            ]
        );
        let many = format!("a,b\n\"1,2\n{}", "3,4\n".repeat(3 * MAX_LINES_OF_ROW));
        assert_eq!(read(many.as_bytes()).len(), 1 + 3 * MAX_LINES_OF_ROW);
    }

    #[test]
    fn a_row_beyond_the_limit_is_bad_and_the_next_one_is_read() {
        let mut text = b"a,b\n".to_vec();
        text.extend(vec![b'x'; 3 * MAX_ROW_BYTES]);
        text.extend_from_slice(b"\n1,2\n");
        assert_eq!(
            read(&text)[..],
            [row(2, Some(Defect::TooLong), ["", ""]), row(3, None, ["1", "2"])]
        );
    }

    #[test]
    fn a_table_without_header_line_is_refused() {
        for text in [&b""[..], b"\n\r\n"] {
            assert!(matches!(Rows::new(text), Err(Failure::Empty)));
        }
        assert!(matches!(Rows::new(&b"\xFF\xFEi\0d\0\n\0"[..]), Err(Failure::Utf16)));
        assert!(matches!(
            Rows::new(&b"a,\"b\n1,2\n"[..]),
            Err(Failure::WrongHeader { line: 1, .. })
        ));
    }
}
