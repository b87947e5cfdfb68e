//! The arguments and exit codes that the commands on tables have in common.

use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use adcs_core::time::Utc;
use adcs_ground::omm_file;
use adcs_ground::span::Span;
use adcs_ground::table::Tally;
use adcs_ground::tle_file::{self, Checksum};
use sgp4_lite::Elements;

/// The help of a command on tables: its own part, then what all of them have in common.
macro_rules! table_help {
    ($own:literal) => {
        concat!(
            $own,
            "

Columns are found by name, in any order. A column of the input that is called like
a computed one is kept as input_<name>. A row that cannot be computed stays in
its place, with nan for the numbers and the reason in its last column; it is
named by line and column on standard error. OUT.csv is written as OUT.csv.partial
and renamed when it is complete.

Exit code: 0 all rows have a result, 1 some have none, 2 nothing could be done."
        )
    };
}
pub(super) use table_help;

/// From which table to which.
#[derive(Debug, clap::Args)]
pub struct TableArgs {
    /// The table to read: comma-separated values under a header line; - is standard input
    #[arg(value_name = "IN.csv")]
    pub input: PathBuf,

    #[command(flatten)]
    pub output: OutputArgs,
}

/// To which table.
#[derive(Debug, clap::Args)]
pub struct OutputArgs {
    /// The table to write; - is standard output
    #[arg(short = 'o', long = "output", value_name = "OUT.csv", default_value = "-")]
    pub path: PathBuf,
}

/// The span between --from and --to.
pub fn span(from: Utc, to: Utc) -> anyhow::Result<Span> {
    Span::new(from, to).ok_or_else(|| anyhow::anyhow!("--to {to} is before --from {from}"))
}

/// How strictly a TLE is read.
#[derive(Debug, clap::Args)]
pub struct LenientArgs {
    /// Let wrong checksums of TLEs pass (everything else is checked)
    #[arg(long)]
    lenient: bool,
}

impl LenientArgs {
    pub fn checksum(&self) -> Checksum {
        if self.lenient { Checksum::Ignore } else { Checksum::Verify }
    }
}

/// The elements of one orbit, from the file that --tle or --omm names, if either does.
pub fn elements(
    tle: Option<&Path>,
    omm: Option<&Path>,
    checksum: Checksum,
) -> anyhow::Result<Option<Elements>> {
    match (tle, omm) {
        (Some(file), _) => tle_file::load(file, checksum).map(Some),
        (None, Some(file)) => omm_file::load(file).map(Some),
        (None, None) => Ok(None),
    }
}

/// 0 when every row has a result, 1 when some have none, 2 when nothing could be done; the reason for
/// that goes to standard error.
pub fn exit_code(result: anyhow::Result<Tally>) -> ExitCode {
    match result {
        Ok(tally) => ExitCode::from(u8::from(tally.bad > 0)),
        Err(error) => {
            // A standard error that cannot be written is no reason to panic.
            let _ = writeln!(io::stderr(), "error: {error:#}");
            ExitCode::from(2)
        }
    }
}
