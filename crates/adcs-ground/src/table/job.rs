//! Work on a table from beginning to end: files, messages, progress.

use std::fs::{self, File};
use std::io::{self, BufReader, IsTerminal as _, Read};
use std::path::Path;

use anyhow::{Context as _, bail};

use super::Failure;
use super::convert::{RowCommand, Tally, convert};
use super::header::Header;
use super::output::{Output, is_dash, partial_path};
use super::progress::Progress;
use super::rows::Rows;

/// Bytes read at a time.
const READ_BYTES: usize = 1 << 16;

/// Does to every row of `input` what `bind` makes of the header, and writes `output`; `-` is standard
/// input or output. Rows without result are reported on standard error.
///
/// # Errors
/// When nothing can be done: a file that cannot be read or written, a table without a column that is
/// needed.
pub fn run(
    input: &Path,
    output: &Path,
    bind: impl FnOnce(&Header) -> Result<Box<dyn RowCommand>, Failure>,
) -> anyhow::Result<Tally> {
    let name = name_of(input, "standard input");
    let (bytes, size) = open(input).map_err(Failure::Read).with_context(|| name.clone())?;
    let progress = Progress::of_bytes(size, leaves_terminal_free(output));
    let bytes = BufReader::with_capacity(READ_BYTES, progress.watch(bytes));
    let mut rows = Rows::new(bytes).with_context(|| name.clone())?;
    let mut command = bind(rows.header()).with_context(|| name.clone())?;
    if is_same_file(input, &partial_path(output)) {
        bail!("{name} would be overwritten; choose another name for the output");
    }
    if let Some(note) = command.note() {
        progress.say(format_args!("{name}: {note}"));
    }
    let written = write_output(output, |file| {
        let tally = convert(&mut rows, command.as_mut(), file, &mut |bad| {
            progress.say(format_args!("{name}, {bad}"));
        });
        progress.finish();
        tally
    });
    match written {
        Ok(tally) => {
            if let Tally { rows, bad: bad @ 1.. } = tally {
                progress.say(format_args!("{name}: {bad} of {rows} rows have no result"));
            }
            Ok(tally)
        }
        Err(failure @ Failure::Write(_)) => Err(failure).with_context(|| output_name(output)),
        Err(failure) => Err(failure).context(name),
    }
}

/// Writes a table that is computed from no other, in so many steps.
///
/// # Errors
/// When the output cannot be written.
pub fn run_without_input(
    output: &Path,
    steps: u64,
    fill: impl FnOnce(&mut csv::Writer<&mut Output>, &Progress) -> Result<Tally, csv::Error>,
) -> anyhow::Result<Tally> {
    let progress = Progress::of_steps(steps, leaves_terminal_free(output));
    let written = write_output(output, |file| {
        let mut writer = csv::Writer::from_writer(file);
        let tally = fill(&mut writer, &progress).map_err(Failure::of_writer)?;
        writer.flush().map_err(Failure::Write)?;
        progress.finish();
        Ok(tally)
    });
    written.with_context(|| output_name(output))
}

/// Opens the output, has it filled, and gives it its name.
fn write_output(
    path: &Path,
    fill: impl FnOnce(&mut Output) -> Result<Tally, Failure>,
) -> Result<Tally, Failure> {
    let mut output = Output::create(path).map_err(Failure::Write)?;
    let written = fill(&mut output).and_then(|tally| {
        output.finish().map_err(Failure::Write)?;
        Ok(tally)
    });
    match written {
        // Whoever reads has had enough, as in `adcs sun days.csv | head`.
        Err(Failure::Write(error)) if error.kind() == io::ErrorKind::BrokenPipe => {
            Ok(Tally::default())
        }
        other => other,
    }
}

/// A file, or standard input for `-`; with its size in bytes, if it is known.
pub(crate) fn open(path: &Path) -> io::Result<(Box<dyn Read>, Option<u64>)> {
    if is_dash(path) {
        return Ok((Box::new(io::stdin()), None));
    }
    let file = File::open(path)?;
    let metadata = file.metadata()?;
    if metadata.is_dir() {
        return Err(io::ErrorKind::IsADirectory.into());
    }
    Ok((Box::new(file), metadata.is_file().then_some(metadata.len())))
}

/// The name of a file, or of what stands for it when it is `-`.
pub(crate) fn name_of(path: &Path, standard: &str) -> String {
    if is_dash(path) { standard.to_owned() } else { path.display().to_string() }
}

fn output_name(path: &Path) -> String {
    name_of(path, "standard output")
}

/// Whether a progress bar would not stand between the rows of the table.
fn leaves_terminal_free(output: &Path) -> bool {
    !is_dash(output) || !io::stdout().is_terminal()
}

fn is_same_file(a: &Path, b: &Path) -> bool {
    match (fs::canonicalize(a), fs::canonicalize(b)) {
        (Ok(a), Ok(b)) => a == b,
        _ => false,
    }
}
