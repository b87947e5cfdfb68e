//! Runs the command and reads the tables that it writes.
#![allow(dead_code)] // each test uses its part

use std::io::Write as _;
use std::process::{Command, Output, Stdio};

/// Runs `adcs COMMAND` with these arguments and this standard input.
pub fn adcs(command: &str, arguments: &[&str], input: &str) -> Output {
    let mut child = Command::new(env!("CARGO_BIN_EXE_adcs"))
        .arg(command)
        .args(arguments)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("adcs starts");
    // A command that refuses its arguments does not read.
    let _ = child.stdin.take().expect("a pipe").write_all(input.as_bytes());
    child.wait_with_output().expect("adcs ends")
}

/// What was said on standard error.
pub fn errors_of(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// A table whose fields are found by column.
pub struct Table {
    pub columns: csv::StringRecord,
    pub rows: Vec<csv::StringRecord>,
}

impl Table {
    pub fn read(text: &[u8]) -> Self {
        let mut reader = csv::Reader::from_reader(text);
        let columns = reader.headers().expect("a header").clone();
        Self { columns, rows: reader.records().collect::<Result<_, _>>().expect("rows") }
    }

    pub fn text(&self, row: usize, column: &str) -> &str {
        let at = self.columns.iter().position(|name| name == column);
        &self.rows[row][at.unwrap_or_else(|| panic!("no column {column} in {:?}", self.columns))]
    }

    pub fn number(&self, row: usize, column: &str) -> f64 {
        self.text(row, column).parse().expect("a number")
    }

    /// `PREFIX_x` to `PREFIX_w`.
    pub fn quaternion(&self, row: usize, prefix: &str) -> [f64; 4] {
        ["x", "y", "z", "w"].map(|part| self.number(row, &format!("{prefix}_{part}")))
    }
}
