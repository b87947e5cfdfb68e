//! The fields of one row as values, and what may be wrong with them.

use std::fmt;

use adcs_core::time::Utc;
use csv::ByteRecord;

use super::header::Column;

/// How much of a wrong field is shown in a message.
const SHOWN_CHARACTERS: usize = 40;
/// The longest message. A number such as 1e300, written out, is longer.
const MESSAGE_CHARACTERS: usize = 200;

/// Why a row has no result.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Problem {
    /// The column that is wrong, if one can be named.
    pub column: Option<&'static str>,
    /// For commands whose column `error` holds a number.
    pub code: u8,
    /// What is wrong.
    pub message: String,
}

impl Problem {
    /// The code of a row that cannot be read. Below are the error codes of SGP4.
    pub const UNREADABLE: u8 = 10;

    /// The row as a whole cannot be read or computed.
    pub fn of_row(message: impl fmt::Display) -> Self {
        Self { column: None, code: Self::UNREADABLE, message: shortened(&message.to_string()) }
    }

    /// One column cannot be read or used.
    pub fn of_column(column: Column, message: impl fmt::Display) -> Self {
        Self { column: Some(column.name), ..Self::of_row(message) }
    }

    /// The same with another code.
    #[must_use]
    pub fn with_code(self, code: u8) -> Self {
        Self { code, ..self }
    }
}

/// `column utc_iso: 'yesterday': not a UTC instant ...`, or the message alone.
impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.column {
            Some(column) => write!(f, "column {column}: {}", self.message),
            None => f.write_str(&self.message),
        }
    }
}

/// The fields of one row.
#[derive(Debug, Clone, Copy)]
pub struct Row<'a> {
    pub(super) fields: &'a ByteRecord,
}

impl<'a> Row<'a> {
    /// The field as it stands.
    pub fn bytes(&self, column: Column) -> &'a [u8] {
        self.fields.get(column.index).unwrap_or_default()
    }

    /// The field as a finite number.
    ///
    /// # Errors
    /// A [`Problem`] that names the column and shows the field.
    pub fn number(&self, column: Column) -> Result<f64, Problem> {
        let text = self.text(column)?;
        match text.parse::<f64>() {
            Ok(number) if number.is_finite() => Ok(number),
            Ok(_) => Err(Problem::of_column(column, format!("'{}' is not finite", shown(text)))),
            Err(_) => Err(Problem::of_column(column, format!("'{}' is not a number", shown(text)))),
        }
    }

    /// Fields as finite numbers.
    ///
    /// # Errors
    /// As [`number`](Self::number), for the first that is none.
    pub fn numbers<const N: usize>(&self, columns: [Column; N]) -> Result<[f64; N], Problem> {
        let mut numbers = [0.0; N];
        for (number, column) in numbers.iter_mut().zip(columns) {
            *number = self.number(column)?;
        }
        Ok(numbers)
    }

    /// The field as an instant such as `2015-11-19T02:55:21.392832Z`.
    ///
    /// # Errors
    /// A [`Problem`] that names the column and shows the field.
    pub fn utc(&self, column: Column) -> Result<Utc, Problem> {
        let text = self.text(column)?;
        Utc::parse(text)
            .map_err(|error| Problem::of_column(column, format!("'{}': {error}", shown(text))))
    }

    fn text(&self, column: Column) -> Result<&'a str, Problem> {
        let bytes = self.bytes(column).trim_ascii();
        let text = str::from_utf8(bytes).map_err(|_| {
            let lossy = String::from_utf8_lossy(bytes);
            Problem::of_column(column, format!("'{}' is not UTF-8 text", shown(&lossy)))
        })?;
        if text.is_empty() {
            return Err(Problem::of_column(column, "nothing stands here"));
        }
        Ok(text)
    }
}

fn shortened(message: &str) -> String {
    match message.char_indices().nth(MESSAGE_CHARACTERS) {
        Some((end, _)) => format!("{}…", &message[..end]),
        None => message.to_owned(),
    }
}

/// A text from the file as it can stand in a message: shortened, control characters made visible.
pub(super) fn shown(text: &str) -> String {
    let mut shown = String::new();
    for character in text.chars().take(SHOWN_CHARACTERS) {
        if character.is_control() {
            shown.extend(character.escape_default());
        } else {
            shown.push(character);
        }
    }
    if text.chars().nth(SHOWN_CHARACTERS).is_some() {
        shown.push('…');
    }
    shown
}

#[cfg(test)]
mod tests {
    use super::*;

    const COLUMN: Column = Column { index: 0, name: "height_km" };

    fn number(field: &[u8]) -> Result<f64, String> {
        let fields = ByteRecord::from(vec![field]);
        Row { fields: &fields }.number(COLUMN).map_err(|problem| problem.to_string())
    }

    #[test]
    fn numbers_are_read_with_blanks_around_them() {
        assert_eq!(number(b" -1.5e3\t"), Ok(-1500.0));
    }

    #[test]
    fn what_is_no_number_is_shown_with_its_column() {
        for (field, message) in [
            (&b"12,5"[..], "'12,5' is not a number"),
            (b"NaN", "'NaN' is not finite"),
            (b"-inf", "'-inf' is not finite"),
            (b"1e999", "'1e999' is not finite"),
            (b" ", "nothing stands here"),
            (b"a\nb", "'a\\nb' is not a number"),
            (b"1\xFF", "'1\u{FFFD}' is not UTF-8 text"),
        ] {
            assert_eq!(number(field), Err(format!("column height_km: {message}")));
        }
        let long = number(&[b'x'; 1000]).unwrap_err();
        assert!(long.contains("x…' is"), "{long}");
    }

    #[test]
    fn a_row_too_short_for_its_columns_has_empty_fields() {
        let fields = ByteRecord::new();
        assert!(Row { fields: &fields }.number(COLUMN).is_err());
    }
}
