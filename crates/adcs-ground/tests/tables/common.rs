//! Runs the command, reads and writes tables.

use std::collections::HashMap;
use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// What a run of the command left behind.
pub struct Run {
    pub code: Option<i32>,
    pub stdout: Vec<u8>,
    pub stderr: String,
}

impl Run {
    /// The table on standard output.
    pub fn table(&self) -> Table {
        Table::parse(&self.stdout)
    }
}

/// Runs `adcs` with these arguments and this standard input.
pub fn adcs<S: AsRef<std::ffi::OsStr>>(
    arguments: impl IntoIterator<Item = S>,
    stdin: impl Into<Vec<u8>>,
) -> Run {
    let mut child = Command::new(env!("CARGO_BIN_EXE_adcs"))
        .args(arguments)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("adcs runs");
    let mut pipe = child.stdin.take().expect("a pipe");
    let stdin = stdin.into();
    // The command may end before it has read everything.
    let writer = std::thread::spawn(move || drop(pipe.write_all(&stdin)));
    let output = child.wait_with_output().expect("adcs ends");
    writer.join().expect("the writer ends");
    Run {
        code: output.status.code(),
        stdout: output.stdout,
        stderr: String::from_utf8(output.stderr).expect("messages are UTF-8"),
    }
}

/// A file among the reference data of a crate.
pub fn data(name: &str) -> Vec<u8> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(name);
    fs::read(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// An empty folder for one test.
pub fn folder(test: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(test);
    if folder.exists() {
        fs::remove_dir_all(&folder).expect("the folder of an earlier run can go");
    }
    fs::create_dir_all(&folder).expect("a folder");
    folder
}

/// A table, read by the csv crate and not by the code under test.
#[derive(Debug)]
pub struct Table {
    pub header: Vec<String>,
    pub rows: Vec<HashMap<String, String>>,
}

impl Table {
    /// The table in these bytes. Every row must have as many fields as the header, and no column may
    /// stand twice.
    pub fn parse(bytes: &[u8]) -> Self {
        let mut reader = csv::Reader::from_reader(bytes);
        let header: Vec<String> =
            reader.headers().expect("a header").iter().map(str::to_owned).collect();
        let mut unique = header.clone();
        unique.sort();
        unique.dedup();
        assert_eq!(unique.len(), header.len(), "a column stands twice: {header:?}");
        let rows = reader.deserialize().map(|row| row.expect("a row like its header")).collect();
        Self { header, rows }
    }

    /// The same table with these columns only, in this order, as CSV.
    pub fn with_columns(&self, columns: &[&str]) -> Vec<u8> {
        let mut writer = csv::Writer::from_writer(Vec::new());
        writer.write_record(columns).expect("memory");
        for row in &self.rows {
            writer.write_record(columns.iter().map(|column| &row[*column])).expect("memory");
        }
        writer.into_inner().expect("memory")
    }
}

/// A cell as a number.
pub fn number(row: &HashMap<String, String>, column: &str) -> f64 {
    row[column].parse().unwrap_or_else(|_| panic!("{column} is '{}'", row[column]))
}

/// The largest value seen, and where.
pub struct Worst {
    what: &'static str,
    value: f64,
    at: String,
}

impl Worst {
    /// Nothing seen yet; `what` is what it measures, with its unit.
    pub fn new(what: &'static str) -> Self {
        Self { what, value: 0.0, at: String::new() }
    }

    /// Takes one more value; NaN counts as infinite.
    pub fn see(&mut self, value: f64, at: &str) {
        let value = if value.is_nan() { f64::INFINITY } else { value };
        if value > self.value {
            self.value = value;
            self.at = at.to_owned();
        }
    }

    /// Prints the largest value, and fails the test when it is above the bar.
    pub fn report(&self, bar: f64) {
        println!("{}: at most {:.3e} (bar {bar:.1e}) at {}", self.what, self.value, self.at);
        assert!(self.value <= bar, "{} is {} at {}", self.what, self.value, self.at);
    }
}
