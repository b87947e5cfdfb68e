//! The text of a mission as a tree of values that know where they stand, with the values of its
//! base files filled in.

use std::collections::BTreeMap;
use std::fs;
use std::ops::Range;
use std::path::{Component, Path, PathBuf};

use toml::de::{DeTable, DeValue};

use super::problem::{Fault, MissionError, Place, Problem, Sources};

/// Files in a chain of bases: a mission, its family, its satellite, and some room.
const MAX_FILES: usize = 8;
/// Longest mission file, bytes: one of 10 KiB is long.
const MAX_BYTES: u64 = 1 << 20;

/// A value of the file.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Value {
    Text(String),
    Number {
        value: f64,
        /// The same when it was written as an integer that fits.
        integer: Option<i64>,
    },
    Flag(bool),
    /// A date and time that was written without quotes.
    Time(String),
    List(Vec<Item>),
    Table(Table),
}

impl Value {
    /// What it is, with its article.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Text(_) => "a text",
            Self::Number { .. } => "a number",
            Self::Flag(_) => "true or false",
            Self::Time(_) => "a time",
            Self::List(_) => "a list",
            Self::Table(_) => "a section",
        }
    }
}

/// A value and where it stands.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Item {
    pub place: Place,
    pub value: Value,
}

/// A key, where it stands, and its value.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Entry {
    pub key: Place,
    pub item: Item,
}

/// The entries of one section.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Table {
    pub entries: BTreeMap<String, Entry>,
}

impl Table {
    /// This table with what it leaves open filled in from `base`, section by section.
    fn over(mut self, base: Self) -> Self {
        for (key, below) in base.entries {
            let merged = match (self.entries.remove(&key), below) {
                (None, below) => below,
                (
                    Some(Entry {
                        key: key_place,
                        item: Item { place, value: Value::Table(above) },
                    }),
                    Entry { item: Item { value: Value::Table(below), .. }, .. },
                ) => {
                    let value = Value::Table(above.over(below));
                    Entry { key: key_place, item: Item { place, value } }
                }
                (Some(above), _) => above,
            };
            self.entries.insert(key, merged);
        }
        self
    }
}

/// Reads `path` and the chain of its bases into one tree. `base = "other.toml"` at the top of a
/// file names another, relative to itself, whose values hold wherever the file says nothing.
pub(super) fn read(path: &Path) -> Result<(Sources, Table), MissionError> {
    let mut sources = Sources::default();
    let mut tables = Vec::new();
    let mut next = Some((path.to_owned(), None));
    while let Some((path, named_at)) = next {
        let text = read_text(&path).map_err(|fault| match named_at {
            Some(place) => Problem::at(&sources, place, "base", fault),
            None => Problem::of_file(&path, fault),
        })?;
        let file = sources.files.len();
        sources.files.push((path.clone(), text));
        let table = parse(&sources, file)?;
        next = base_of(&sources, &path, &table)?;
        tables.push(table);
    }
    let whole = tables.into_iter().rev().reduce(|base, table| table.over(base));
    Ok((sources, whole.unwrap_or_default()))
}

fn read_text(path: &Path) -> Result<String, Fault> {
    let fault = |error: std::io::Error| Fault::new(format!("cannot be read: {error}"));
    let length = fs::metadata(path).map_err(fault)?.len();
    if length > MAX_BYTES {
        return Err(Fault::new(format!("is no mission file: it has {length} bytes")));
    }
    let bytes = fs::read(path).map_err(fault)?;
    String::from_utf8(bytes).map_err(|error| {
        let at = error.utf8_error().valid_up_to();
        Fault::advising(
            format!("is not text in UTF-8 (byte {})", at + 1),
            "save it as UTF-8 in your editor",
        )
    })
}

/// The file that is the base of `table`, and where it is named.
fn base_of(
    sources: &Sources,
    path: &Path,
    table: &Table,
) -> Result<Option<(PathBuf, Option<Place>)>, MissionError> {
    let Some(Entry { item: Item { place, value }, .. }) = table.entries.get("base") else {
        return Ok(None);
    };
    let refuse =
        |reason| MissionError::from(Problem::at(sources, *place, "base", Fault::new(reason)));
    let Value::Text(name) = value else {
        return Err(refuse(format!("expected the path of a file, found {}", value.kind())));
    };
    let base = without_detours(&path.parent().unwrap_or(Path::new("")).join(name));
    let same = |(other, _): &(PathBuf, String)| matches!((fs::canonicalize(other), fs::canonicalize(&base)), (Ok(a), Ok(b)) if a == b);
    if sources.files.iter().any(same) {
        return Err(refuse("the file is its own base, directly or through others".to_owned()));
    }
    if sources.files.len() == MAX_FILES {
        return Err(refuse(format!("more than {MAX_FILES} files build on each other")));
    }
    Ok(Some((base, Some(*place))))
}

/// `a/../b` as `b`, for shorter messages.
fn without_detours(path: &Path) -> PathBuf {
    let mut short = PathBuf::new();
    for part in path.components() {
        let last_is_name = matches!(short.components().next_back(), Some(Component::Normal(_)));
        match part {
            Component::ParentDir if last_is_name => {
                short.pop();
            }
            part => short.push(part),
        }
    }
    short
}

fn parse(sources: &Sources, file: usize) -> Result<Table, MissionError> {
    let text = sources.files.get(file).map_or("", |(_, text)| text);
    let place = |span: Range<usize>| Place { file, start: span.start, end: span.end };
    // Only the first error of syntax: those behind it are often its consequences.
    let error = match DeTable::parse(text) {
        Ok(table) => return Ok(converted_table(file, table.into_inner())),
        Err(error) => error,
    };
    let fault = Fault::new(format!("not TOML: {}", error.message()));
    let span = error.span().unwrap_or(text.len()..text.len());
    Err(Problem::at(sources, place(span), "", fault).into())
}

fn converted_table(file: usize, table: DeTable<'_>) -> Table {
    let place = |span: Range<usize>| Place { file, start: span.start, end: span.end };
    let entries = table.into_iter().map(|(key, value)| {
        let entry = Entry {
            key: place(key.span()),
            item: Item { place: place(value.span()), value: converted(file, value.into_inner()) },
        };
        (key.into_inner().into_owned(), entry)
    });
    Table { entries: entries.collect() }
}

fn converted(file: usize, value: DeValue<'_>) -> Value {
    match value {
        DeValue::String(text) => Value::Text(text.into_owned()),
        DeValue::Integer(number) => {
            let integer = i64::from_str_radix(number.as_str(), number.radix()).ok();
            let value = match integer {
                Some(integer) => integer as f64,
                None => number.as_str().parse().unwrap_or(f64::NAN),
            };
            Value::Number { value, integer }
        }
        DeValue::Float(number) => {
            Value::Number { value: number.as_str().parse().unwrap_or(f64::NAN), integer: None }
        }
        DeValue::Boolean(flag) => Value::Flag(flag),
        DeValue::Datetime(time) => Value::Time(time.to_string()),
        DeValue::Array(items) => Value::List(
            items
                .into_iter()
                .map(|item| {
                    let span = item.span();
                    Item {
                        place: Place { file, start: span.start, end: span.end },
                        value: converted(file, item.into_inner()),
                    }
                })
                .collect(),
        ),
        DeValue::Table(table) => Value::Table(converted_table(file, table)),
    }
}
