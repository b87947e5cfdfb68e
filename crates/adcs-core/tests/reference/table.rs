//! Reads the reference tables of `tests/data` by column name.

/// A table of comma-separated values with one header line.
pub struct Table<'a> {
    columns: Vec<&'a str>,
    rows: Vec<Vec<&'a str>>,
}

impl<'a> Table<'a> {
    /// The table of this text; every row must have as many fields as the header.
    pub fn parse(text: &'a str) -> Self {
        let mut lines = text.lines().map(|line| line.split(',').collect::<Vec<_>>());
        let columns = lines.next().expect("a header line");
        let rows: Vec<_> = lines.collect();
        assert!(!rows.is_empty(), "the table has no rows");
        assert!(rows.iter().all(|row| row.len() == columns.len()), "a row is of another length");
        Self { columns, rows }
    }

    /// The rows, in order.
    pub fn rows(&self) -> impl Iterator<Item = Row<'_>> {
        self.rows.iter().map(|fields| Row { columns: &self.columns, fields })
    }
}

/// One row.
#[derive(Clone, Copy)]
pub struct Row<'a> {
    columns: &'a [&'a str],
    fields: &'a [&'a str],
}

impl<'a> Row<'a> {
    /// The field of a column as it stands.
    pub fn text(&self, column: &str) -> &'a str {
        let at = self.columns.iter().position(|name| *name == column);
        self.fields[at.unwrap_or_else(|| panic!("no column {column}"))]
    }

    /// The field of a column as a number.
    pub fn number(&self, column: &str) -> f64 {
        self.text(column).parse().unwrap_or_else(|_| panic!("{column} is not a number"))
    }

    /// Three columns as a vector.
    pub fn vector(&self, columns: [&str; 3]) -> nalgebra::Vector3<f64> {
        nalgebra::Vector3::from(columns.map(|column| self.number(column)))
    }
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
