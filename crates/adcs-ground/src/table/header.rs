//! The header line: which column is where.

use csv::ByteRecord;

use super::Failure;

/// A column that a command reads.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Column {
    pub(super) index: usize,
    /// Its name in the header line.
    pub name: &'static str,
}

/// The names of the columns, in order.
#[derive(Debug, Clone)]
pub struct Header {
    names: Vec<String>,
    written: ByteRecord,
}

impl Header {
    pub(super) fn new(written: ByteRecord) -> Self {
        let names =
            written.iter().map(|name| String::from_utf8_lossy(name).trim().to_owned()).collect();
        Self { names, written }
    }

    /// The number of columns.
    pub(super) fn len(&self) -> usize {
        self.written.len()
    }

    /// The column of this name.
    ///
    /// # Errors
    /// [`Failure::MissingColumn`], [`Failure::ColumnTwice`].
    pub fn column(&self, name: &'static str) -> Result<Column, Failure> {
        self.optional(name)?.ok_or_else(|| self.missing(name))
    }

    /// The column of this name, if there is one.
    ///
    /// # Errors
    /// [`Failure::ColumnTwice`].
    pub fn optional(&self, name: &'static str) -> Result<Option<Column>, Failure> {
        let mut found = self
            .names
            .iter()
            .enumerate()
            .filter(|(_, other)| *other == name)
            .map(|(index, _)| index);
        match (found.next(), found.next()) {
            (Some(first), Some(second)) => {
                Err(Failure::ColumnTwice { name, first: first + 1, second: second + 1 })
            }
            (first, _) => Ok(first.map(|index| Column { index, name })),
        }
    }

    /// Columns that are wanted together.
    ///
    /// # Errors
    /// As [`column`](Self::column), for the first that is not there.
    pub fn columns<const N: usize>(
        &self,
        names: [&'static str; N],
    ) -> Result<[Column; N], Failure> {
        let mut columns = [Column { index: 0, name: "" }; N];
        for (column, name) in columns.iter_mut().zip(names) {
            *column = self.column(name)?;
        }
        Ok(columns)
    }

    /// Columns that are wanted together or not at all.
    ///
    /// # Errors
    /// As [`column`](Self::column), for the first that is not there while another is.
    pub fn optional_columns<const N: usize>(
        &self,
        names: [&'static str; N],
    ) -> Result<Option<[Column; N]>, Failure> {
        let mut any = false;
        for name in names {
            any |= self.optional(name)?.is_some();
        }
        if any { self.columns(names).map(Some) } else { Ok(None) }
    }

    /// The error that `wanted`, a column or a choice of columns, is not there.
    pub fn missing(&self, wanted: &str) -> Failure {
        Failure::MissingColumn { wanted: wanted.to_owned(), found: self.names.clone() }
    }

    /// The header of the output: the columns to carry over, then those that are computed.
    ///
    /// A column of the input that is called like a computed one is kept under the name
    /// `input_<name>`, so that the computed one can be found.
    pub(super) fn of_output(&self, carried: &[usize], computed: &[&str]) -> ByteRecord {
        let mut header = ByteRecord::new();
        for &index in carried {
            let name = self.names.get(index).map_or("", String::as_str);
            if computed.contains(&name) {
                let mut free = format!("input_{name}");
                while self.names.contains(&free) {
                    free.insert_str(0, "input_");
                }
                header.push_field(free.as_bytes());
            } else {
                header.push_field(self.written.get(index).unwrap_or_default());
            }
        }
        for name in computed {
            header.push_field(name.as_bytes());
        }
        header
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn header(names: &[&str]) -> Header {
        Header::new(ByteRecord::from(names.to_vec()))
    }

    #[test]
    fn a_missing_column_is_named_with_those_that_are_there() {
        let failure = header(&["id", " utc "]).column("utc_iso").unwrap_err();
        assert_eq!(failure.to_string(), "no column utc_iso; the columns are: id, utc");
    }

    #[test]
    fn a_table_with_semicolons_is_recognised() {
        let failure = header(&["id;utc_iso"]).column("utc_iso").unwrap_err();
        assert!(failure.to_string().contains("separated by semicolons"), "{failure}");
    }

    #[test]
    fn a_column_that_stands_twice_is_refused_only_when_it_is_needed() {
        let header = header(&["a", "b", "a", "b"]);
        assert!(matches!(
            header.column("b"),
            Err(Failure::ColumnTwice { name: "b", first: 2, second: 4 })
        ));
        assert!(header.optional("c").unwrap().is_none());
    }

    #[test]
    fn columns_that_belong_together_are_all_there_or_none() {
        let header = header(&["a", "b", "c"]);
        assert!(header.optional_columns(["x", "y"]).unwrap().is_none());
        assert!(header.optional_columns(["a", "c"]).unwrap().is_some());
        let failure = header.optional_columns(["x", "b"]).unwrap_err();
        assert_eq!(failure.to_string(), "no column x; the columns are: a, b, c");
    }

    #[test]
    fn columns_called_like_computed_ones_are_kept_under_another_name() {
        let header = header(&["id", "gmst", "input_gmst", "dropped"]);
        let output = header.of_output(&[0, 1, 2], &["gmst", "error"]);
        assert_eq!(output, vec!["id", "input_input_gmst", "input_gmst", "gmst", "error"]);
    }
}
