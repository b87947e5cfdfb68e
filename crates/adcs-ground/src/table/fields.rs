//! A row of comma-separated values, cut into its fields.

use csv::ByteRecord;

/// Quotation marks that do not stand as RFC 4180 has them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum WrongQuote {
    /// A field begins with a quotation mark, and the row ends before its second one.
    NotClosed,
    /// Something stands between the second quotation mark of a field and the next comma.
    TextBehind,
}

/// Cuts `row` (without line end) into `fields`, quotation marks taken off.
///
/// A quotation mark in the middle of a field that does not begin with one is a character like any
/// other.
pub(super) fn split(row: &[u8], fields: &mut ByteRecord) -> Result<(), WrongQuote> {
    fields.clear();
    let mut rest = row;
    loop {
        rest = match rest.strip_prefix(b"\"") {
            Some(quoted) => take_quoted(quoted, fields)?,
            None => take_plain(rest, fields),
        };
        rest = match rest {
            [] => return Ok(()),
            [b',', next @ ..] => next,
            _ => return Err(WrongQuote::TextBehind),
        };
    }
}

/// Cuts at every comma, whatever the quotation marks say: what is left of a row that has them wrong.
pub(super) fn split_at_every_comma(row: &[u8], fields: &mut ByteRecord) {
    fields.clear();
    for field in row.split(|&byte| byte == b',') {
        fields.push_field(field);
    }
}

fn take_plain<'a>(text: &'a [u8], fields: &mut ByteRecord) -> &'a [u8] {
    let end = text.iter().position(|&byte| byte == b',').unwrap_or(text.len());
    let (field, rest) = text.split_at(end);
    fields.push_field(field);
    rest
}

/// `text` begins behind the first quotation mark; two in a row stand for one.
fn take_quoted<'a>(text: &'a [u8], fields: &mut ByteRecord) -> Result<&'a [u8], WrongQuote> {
    let mut field = Vec::new();
    let mut rest = text;
    loop {
        let end = rest.iter().position(|&byte| byte == b'"').ok_or(WrongQuote::NotClosed)?;
        field.extend_from_slice(&rest[..end]);
        rest = &rest[end + 1..];
        match rest.strip_prefix(b"\"") {
            Some(behind_pair) => {
                field.push(b'"');
                rest = behind_pair;
            }
            None => {
                fields.push_field(&field);
                return Ok(rest);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn fields(row: &str) -> Result<Vec<String>, WrongQuote> {
        let mut fields = ByteRecord::new();
        split(row.as_bytes(), &mut fields)?;
        Ok(fields.iter().map(|field| String::from_utf8(field.to_vec()).unwrap()).collect())
    }

    #[test]
    fn commas_and_quotation_marks_stand_as_in_rfc_4180() {
        for (row, expected) in [
            ("", &[""] as &[&str]),
            ("a,b", &["a", "b"]),
            ("a,", &["a", ""]),
            (",,", &["", "", ""]),
            (r#""a,b",c"#, &["a,b", "c"]),
            (r#""say ""when""",2"#, &[r#"say "when""#, "2"]),
            (r#""""#, &[""]),
            (r#"5" pipe,b"#, &[r#"5" pipe"#, "b"]),
            ("\"two\nlines\",b", &["two\nlines", "b"]),
        ] {
            assert_eq!(fields(row).unwrap(), expected, "{row}");
        }
    }

    #[test]
    fn wrong_quotation_marks_are_told_apart() {
        assert_eq!(fields(r#"a,"b"#), Err(WrongQuote::NotClosed));
        assert_eq!(fields(r#"a,"b"""#), Err(WrongQuote::NotClosed));
        assert_eq!(fields(r#"a,"b"c,d"#), Err(WrongQuote::TextBehind));
    }

    proptest! {
        /// The crate that writes our tables is the judge of how they are read.
        #[test]
        fn what_the_csv_crate_writes_is_read_back(
            row in prop::collection::vec(prop::collection::vec(any::<u8>(), 0..8), 1..6)
        ) {
            let mut writer = csv::Writer::from_writer(Vec::new());
            writer.write_record(&row).unwrap();
            let written = writer.into_inner().unwrap();
            let written = written.strip_suffix(b"\n").unwrap();
            let mut fields = ByteRecord::new();
            split(written, &mut fields).unwrap();
            prop_assert_eq!(fields, ByteRecord::from(row));
        }
    }
}
