//! Tables of comma-separated values, in and out.
//!
//! ```text
//! bytes ─► rows ─► a row's values ─► RowCommand ─► cells ─► the output
//!          Rows     Row, Column                     Cells    Output
//! ```
//!
//! Columns are found by name, in any order. Every column of the input is carried over to the output,
//! with the computed columns behind. A row that cannot be read or computed stays in its place, with
//! `nan` in the computed columns and the reason in the last; it is reported by line and column, and the
//! rows after it are computed all the same. Nothing is held in memory but the row at hand.

mod beside;
mod convert;
mod fields;
mod header;
mod job;
mod output;
mod progress;
mod row;
mod rows;

use std::fmt;
use std::io;

use row::shown;

pub use beside::read as read_beside;
pub use convert::{BadRow, Cells, RowCommand, Tally, convert};
pub use header::{Column, Header};
pub(crate) use job::{name_of, open};
pub use job::{run, run_without_input};
pub use output::Output;
pub use progress::Progress;
pub use row::{Problem, Row};
pub use rows::{MAX_LINES_OF_ROW, MAX_ROW_BYTES, Rows};

/// How many columns a message lists.
const SHOWN_COLUMNS: usize = 40;

/// Why a table cannot be worked on at all.
#[derive(Debug)]
pub enum Failure {
    /// No line with text.
    Empty,
    /// The file begins with a byte order mark of UTF-16.
    Utf16,
    /// The header line cannot be cut into names.
    WrongHeader {
        /// The line, from 1.
        line: u64,
        /// What is wrong.
        why: String,
    },
    /// A column that the command needs is not there.
    MissingColumn {
        /// Its name, or the choice there is.
        wanted: String,
        /// The columns of the table.
        found: Vec<String>,
    },
    /// A column that the command needs is there twice.
    ColumnTwice {
        /// Its name.
        name: &'static str,
        /// Where it stands first, from 1.
        first: usize,
        /// Where it stands again.
        second: usize,
    },
    /// The input cannot be read.
    Read(io::Error),
    /// The output cannot be written.
    Write(io::Error),
}

impl Failure {
    fn of_writer(error: csv::Error) -> Self {
        match error.into_kind() {
            csv::ErrorKind::Io(error) => Self::Write(error),
            other => Self::Write(io::Error::other(format!("{other:?}"))),
        }
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Empty => write!(f, "the table is empty: not even a header line"),
            Self::Utf16 => write!(f, "the text is UTF-16; save it as UTF-8"),
            Self::WrongHeader { line, why } => write!(f, "header line (line {line}): {why}"),
            Self::MissingColumn { wanted, found } => {
                let more = if found.len() > SHOWN_COLUMNS { ", …" } else { "" };
                let found: Vec<_> =
                    found.iter().take(SHOWN_COLUMNS).map(|name| shown(name)).collect();
                let hint = separator_hint(&found);
                write!(f, "no column {wanted}; the columns are: {}{more}{hint}", found.join(", "))
            }
            Self::ColumnTwice { name, first, second } => {
                write!(f, "column {name} stands twice, at {first} and at {second}")
            }
            Self::Read(error) => write!(f, "cannot be read: {error}"),
            Self::Write(error) => write!(f, "cannot be written: {error}"),
        }
    }
}

impl std::error::Error for Failure {}

/// Spreadsheets of many countries write other separators than commas.
fn separator_hint(columns: &[String]) -> &'static str {
    match columns {
        [only] if only.contains(';') => " (they are separated by semicolons, not by commas)",
        [only] if only.contains("\\t") => " (they are separated by tabs, not by commas)",
        _ => "",
    }
}
