//! A table through a command, row by row.

use std::fmt::{self, Write as _};
use std::io::{BufRead, Write};

use csv::ByteRecord;

use super::Failure;
use super::header::Column;
use super::row::{Problem, Row};
use super::rows::Rows;

/// What a command does with one row.
pub trait RowCommand {
    /// The names of the columns it computes, in order.
    fn computed(&self) -> &'static [&'static str];

    /// Columns of the input that are not carried over to the output.
    fn left_out(&self) -> Vec<Column> {
        Vec::new()
    }

    /// What the user should know about how the columns are read; said once.
    fn note(&self) -> Option<&'static str> {
        None
    }

    /// Computes the cells of a row.
    ///
    /// # Errors
    /// Why there is no result; [`bad_row`](Self::bad_row) then fills the cells.
    fn compute(&mut self, row: Row<'_>, cells: &mut Cells) -> Result<(), Problem>;

    /// The cells of a row without result: `nan`, and the problem in the last column.
    fn bad_row(&self, problem: &Problem, cells: &mut Cells) {
        for _ in 1..self.computed().len() {
            cells.nan();
        }
        cells.text(&problem.to_string());
    }
}

/// The computed cells of one row.
#[derive(Debug, Default)]
pub struct Cells {
    cells: ByteRecord,
    scratch: String,
    overflow: bool,
}

impl Cells {
    /// A number, with as many digits as it takes to read it back exactly.
    pub fn number(&mut self, value: f64) {
        self.finite(value.is_finite(), value);
    }

    /// A number of single precision.
    pub fn single(&mut self, value: f32) {
        self.finite(value.is_finite(), value);
    }

    /// Some numbers.
    pub fn numbers(&mut self, values: impl IntoIterator<Item = f64>) {
        for value in values {
            self.number(value);
        }
    }

    /// No number.
    pub fn nan(&mut self) {
        self.cells.push_field(b"nan");
    }

    /// A text.
    pub fn text(&mut self, text: &str) {
        self.cells.push_field(text.as_bytes());
    }

    fn finite(&mut self, is_finite: bool, value: impl fmt::Debug) {
        self.overflow |= !is_finite;
        self.scratch.clear();
        // The shortest text that reads back as the same number; `1e-30` and not thirty zeros. Writing
        // to a String does not fail.
        let _ = write!(self.scratch, "{value:?}");
        self.cells.push_field(self.scratch.as_bytes());
    }

    /// Empties the row.
    pub fn clear(&mut self) {
        self.cells.clear();
        self.overflow = false;
    }

    /// The cells written so far, as fields.
    pub fn fields(&self) -> &ByteRecord {
        &self.cells
    }
}

/// A row without result, as it is reported.
#[derive(Debug)]
pub struct BadRow<'a> {
    /// The line of the file in which the row begins, from 1.
    pub line: u64,
    /// What is wrong with it.
    pub problem: &'a Problem,
}

/// `line 7, column utc_iso: nothing stands here`
impl fmt::Display for BadRow<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let separator = if self.problem.column.is_some() { ", " } else { ": " };
        write!(f, "line {}{separator}{}", self.line, self.problem)
    }
}

/// How many rows there were.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Tally {
    /// All rows.
    pub rows: u64,
    /// Those without result.
    pub bad: u64,
}

/// Writes the table that `command` makes of `rows`: the columns of the input, then the computed ones.
///
/// A row without result is written too, and given to `on_bad_row`.
///
/// # Errors
/// [`Failure::Read`] and [`Failure::Write`]; rows before that are written.
pub fn convert<R: BufRead, W: Write>(
    rows: &mut Rows<R>,
    command: &mut dyn RowCommand,
    output: W,
    on_bad_row: &mut dyn FnMut(&BadRow<'_>),
) -> Result<Tally, Failure> {
    let left_out = command.left_out();
    let is_carried = |index: &usize| left_out.iter().all(|column| column.index != *index);
    let carried: Vec<usize> = (0..rows.header().len()).filter(is_carried).collect();
    let mut writer = csv::Writer::from_writer(output);
    let header = rows.header().of_output(&carried, command.computed());
    writer.write_byte_record(&header).map_err(Failure::of_writer)?;

    let mut tally = Tally::default();
    let mut fields = ByteRecord::new();
    let mut output_row = ByteRecord::new();
    let mut cells = Cells::default();
    while let Some((line, defect)) = rows.next(&mut fields).map_err(Failure::Read)? {
        tally.rows += 1;
        cells.clear();
        let result = match defect {
            Some(defect) => Err(Problem::of_row(defect)),
            None => compute(command, Row { fields: &fields }, &mut cells),
        };
        if let Err(problem) = result {
            tally.bad += 1;
            cells.clear();
            command.bad_row(&problem, &mut cells);
            on_bad_row(&BadRow { line, problem: &problem });
        }
        output_row.clear();
        output_row.extend(carried.iter().filter_map(|&index| fields.get(index)));
        output_row.extend(cells.fields());
        writer.write_byte_record(&output_row).map_err(Failure::of_writer)?;
    }
    writer.flush().map_err(Failure::Write)?;
    Ok(tally)
}

fn compute(command: &mut dyn RowCommand, row: Row<'_>, cells: &mut Cells) -> Result<(), Problem> {
    command.compute(row, cells)?;
    if cells.overflow {
        return Err(Problem::of_row("the result is too large for a number"));
    }
    Ok(())
}
