//! A second table, read whole before the first is worked on.

use std::io::BufReader;
use std::path::Path;

use anyhow::Context as _;
use csv::ByteRecord;

use super::convert::BadRow;
use super::header::Header;
use super::job::{name_of, open};
use super::progress::Progress;
use super::row::{Problem, Row};
use super::rows::Rows;
use super::{Failure, Tally};

/// What `bind` makes of the header makes a value of every row of `input`; `-` is standard input. Rows
/// that give none are reported on standard error and left out.
///
/// # Errors
/// When the file cannot be read, or a column that is needed is not there.
pub fn read<T, F>(
    input: &Path,
    bind: impl FnOnce(&Header) -> Result<F, Failure>,
) -> anyhow::Result<(Vec<T>, Tally)>
where
    F: FnMut(Row<'_>) -> Result<T, Problem>,
{
    let name = name_of(input, "standard input");
    let (bytes, size) = open(input).map_err(Failure::Read).with_context(|| name.clone())?;
    let progress = Progress::of_bytes(size, true);
    let mut rows =
        Rows::new(BufReader::new(progress.watch(bytes))).with_context(|| name.clone())?;
    let mut value_of = bind(rows.header()).with_context(|| name.clone())?;
    let (mut values, mut tally) = (Vec::new(), Tally::default());
    let mut fields = ByteRecord::new();
    while let Some((line, defect)) =
        rows.next(&mut fields).map_err(Failure::Read).with_context(|| name.clone())?
    {
        tally.rows += 1;
        let value = match defect {
            Some(defect) => Err(Problem::of_row(defect)),
            None => value_of(Row { fields: &fields }),
        };
        match value {
            Ok(value) => values.push(value),
            Err(problem) => {
                tally.bad += 1;
                progress.say(format_args!("{name}, {}", BadRow { line, problem: &problem }));
            }
        }
    }
    progress.finish();
    Ok((values, tally))
}
