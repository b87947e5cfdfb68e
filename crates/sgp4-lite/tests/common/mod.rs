//! The reference data as rows of named columns.
#![allow(dead_code)] // each test file uses its part

use sgp4_lite::Elements;

pub const VALLADO_TLE: &str = include_str!("../data/vallado_tle.csv");
pub const VALLADO_EXPECTED: &str = include_str!("../data/vallado_expected.csv");
pub const LEO_TLE: &str = include_str!("../data/sample_leo_tle.csv");
pub const LEO_EXPECTED: &str = include_str!("../data/sample_leo_expected.csv");
pub const DEEP_TLE: &str = include_str!("../data/sample_deep_tle.csv");
pub const DEEP_EXPECTED: &str = include_str!("../data/sample_deep_expected.csv");

/// One row of a CSV file.
pub struct Row {
    header: Vec<&'static str>,
    cells: Vec<&'static str>,
}

impl Row {
    pub fn text(&self, column: &str) -> &'static str {
        let index = self.header.iter().position(|name| *name == column);
        self.cells[index.unwrap_or_else(|| panic!("no column {column}"))]
    }

    pub fn number(&self, column: &str) -> f64 {
        self.text(column).parse().unwrap_or_else(|error| panic!("{column}: {error}"))
    }

    pub fn vector(&self, columns: [&str; 3]) -> [f64; 3] {
        columns.map(|column| self.number(column))
    }
}

/// The rows of a CSV file below its header. No cell of ours holds a comma.
pub fn rows(csv: &'static str) -> Vec<Row> {
    let mut lines = csv.lines();
    let header: Vec<_> = lines.next().expect("a header").split(',').collect();
    lines
        .map(|line| {
            let cells: Vec<_> = line.split(',').collect();
            assert_eq!(cells.len(), header.len(), "{line}");
            Row { header: header.clone(), cells }
        })
        .collect()
}

/// One satellite of a reference set.
pub struct Satellite {
    pub id: &'static str,
    pub deep: bool,
    pub elements: Elements,
}

/// The satellites of a `*_tle.csv` file. Wrong checksums, which three records of the verification
/// set have, are let pass.
pub fn satellites(csv: &'static str) -> Vec<Satellite> {
    rows(csv)
        .into_iter()
        .map(|row| Satellite {
            id: row.text("id"),
            deep: row.text("method_n_near_d_deep") == "d",
            elements: Elements::from_tle_lenient(row.text("line1"), row.text("line2"))
                .unwrap_or_else(|error| panic!("{}: {error}", row.text("line1"))),
        })
        .collect()
}

/// Largest difference between two vectors in any component.
pub fn largest_difference(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// A valid TLE of a low orbit, for tests that spoil it.
pub const GOOD: [&str; 2] = [
    "1 41001U 24001BC  21122.17684994 -.00003012  00000-0  16685-3 0 95855",
    "2 41001  98.3250 156.3788 0008614  60.6878  66.8195 14.45753939371069",
];

/// A line of a TLE with `text` from `column` (from 1) on, and its checksum made right again.
pub fn with_text(line: &str, column: usize, text: &str) -> String {
    let mut bytes = line.as_bytes().to_vec();
    bytes[column - 1..column - 1 + text.len()].copy_from_slice(text.as_bytes());
    with_checksum(&String::from_utf8(bytes).expect("ASCII")[..68])
}

/// The 68 columns before the checksum, with it.
pub fn with_checksum(columns: &str) -> String {
    let sum: u32 = columns
        .chars()
        .map(|character| character.to_digit(10).unwrap_or(u32::from(character == '-')))
        .sum();
    format!("{columns}{}", sum % 10)
}
