//! Reading a section: every key by name, with its type and its range, and what is left over at the
//! end is unknown.
//!
//! A getter that finds something wrong notes the problem and returns `None`, so that one run shows
//! all problems of a file.

use std::cell::RefCell;
use std::ops::RangeInclusive;

use super::document::{Entry, Item, Table, Value};
use super::problem::{Fault, Place, Problem, Sources};
use super::typed::{
    Check, Refusal, array, choice, integer, matrix, micros, mismatch, number, quaternion, text,
};
use super::unit;

/// Where problems go.
#[derive(Debug)]
pub(super) struct Problems<'a> {
    sources: &'a Sources,
    found: RefCell<Vec<(Place, Problem)>>,
}

impl<'a> Problems<'a> {
    pub fn new(sources: &'a Sources) -> Self {
        Self { sources, found: RefCell::default() }
    }

    pub fn note(&self, place: Place, key: impl Into<String>, fault: Fault) {
        self.found.borrow_mut().push((place, Problem::at(self.sources, place, key, fault)));
    }

    pub fn is_empty(&self) -> bool {
        self.found.borrow().is_empty()
    }

    /// Everything noted, the mission's own file first, each from its top.
    pub fn into_sorted(self) -> Vec<Problem> {
        let mut found = self.found.into_inner();
        found.sort_by_key(|(place, _)| (place.file, place.start));
        found.into_iter().map(|(_, problem)| problem).collect()
    }
}

/// One section of the mission.
#[derive(Debug)]
pub(super) struct Section<'a> {
    problems: &'a Problems<'a>,
    /// `magnetometer.errors`, or empty at the top.
    path: String,
    place: Place,
    table: &'a Table,
    asked: RefCell<Vec<&'static str>>,
    missing: RefCell<Vec<&'static str>>,
    missing_sections: RefCell<Vec<&'static str>>,
}

impl<'a> Section<'a> {
    /// The top of the mission.
    pub fn root(problems: &'a Problems<'a>, table: &'a Table) -> Self {
        let place = Place { file: 0, start: 0, end: 0 };
        Self::new(problems, String::new(), place, table)
    }

    fn new(problems: &'a Problems<'a>, path: String, place: Place, table: &'a Table) -> Self {
        Self {
            problems,
            path,
            place,
            table,
            asked: RefCell::default(),
            missing: RefCell::default(),
            missing_sections: RefCell::default(),
        }
    }

    /// The key with its sections.
    pub fn path_of(&self, key: &str) -> String {
        if self.path.is_empty() { key.to_owned() } else { format!("{}.{key}", self.path) }
    }

    /// Where the value of `key` stands; where the section begins when it has none.
    pub fn place_of(&self, key: &str) -> Place {
        self.table.entries.get(key).map_or(self.place, |entry| entry.item.place)
    }

    /// Where entry `index` of the list at `key` stands; of a list of lists, `[row, column]`.
    pub fn place_within(&self, key: &str, index: &[usize]) -> Place {
        let mut place = self.place_of(key);
        let mut item = self.table.entries.get(key).map(|entry| &entry.item);
        for &at in index {
            item = match item.map(|item| &item.value) {
                Some(Value::List(items)) => items.get(at),
                _ => None,
            };
            place = item.map_or(place, |item| item.place);
        }
        place
    }

    /// Notes a problem with the value of `key`.
    pub fn refuse(&self, key: &str, fault: Fault) {
        self.problems.note(self.place_of(key), self.path_of(key), fault);
    }

    /// Notes a problem with the value of `key`, at a place within it.
    pub fn refuse_at(&self, place: Place, key: &str, fault: Fault) {
        self.problems.note(place, self.path_of(key), fault);
    }

    /// Whether the section says anything at `key`.
    pub fn has(&self, key: &'static str) -> bool {
        self.entry(key).is_some()
    }

    fn entry(&self, key: &'static str) -> Option<&'a Entry> {
        self.asked.borrow_mut().push(key);
        self.table.entries.get(key)
    }

    fn read<T>(
        &self,
        key: &'static str,
        parse: impl FnOnce(&'a Item) -> Result<T, Refusal>,
    ) -> Option<Option<T>> {
        let Some(entry) = self.entry(key) else { return Some(None) };
        match parse(&entry.item) {
            Ok(value) => Some(Some(value)),
            Err((place, fault)) => {
                self.problems.note(place, self.path_of(key), fault);
                None
            }
        }
    }

    fn required<T>(
        &self,
        key: &'static str,
        parse: impl FnOnce(&'a Item) -> Result<T, Refusal>,
    ) -> Option<T> {
        let value = self.read(key, parse)?;
        if value.is_none() {
            self.missing.borrow_mut().push(key);
        }
        value
    }

    pub fn number(&self, key: &'static str, check: Check) -> Option<f64> {
        self.required(key, |item| number(item, check))
    }

    pub fn number_or(&self, key: &'static str, check: Check, default: f64) -> Option<f64> {
        Some(self.read(key, |item| number(item, check))?.unwrap_or(default))
    }

    pub fn vector(&self, key: &'static str, check: Check) -> Option<[f64; 3]> {
        self.required(key, |item| array(item, "numbers", |item| number(item, check)))
    }

    pub fn vector_or(
        &self,
        key: &'static str,
        check: Check,
        default: [f64; 3],
    ) -> Option<[f64; 3]> {
        let vector = self.read(key, |item| array(item, "numbers", |item| number(item, check)))?;
        Some(vector.unwrap_or(default))
    }

    /// Three rows of three numbers.
    pub fn matrix(&self, key: &'static str) -> Option<[[f64; 3]; 3]> {
        self.required(key, matrix)
    }

    pub fn matrix_or(&self, key: &'static str, default: [[f64; 3]; 3]) -> Option<[[f64; 3]; 3]> {
        Some(self.read(key, matrix)?.unwrap_or(default))
    }

    /// A unit quaternion, scalar last; not normalised any further.
    pub fn quaternion(&self, key: &'static str) -> Option<[f64; 4]> {
        self.required(key, quaternion)
    }

    pub fn quaternion_or(&self, key: &'static str, default: [f64; 4]) -> Option<[f64; 4]> {
        Some(self.read(key, quaternion)?.unwrap_or(default))
    }

    /// A list of numbers of known length.
    pub fn numbers_or<const N: usize>(
        &self,
        key: &'static str,
        check: Check,
        default: [f64; N],
    ) -> Option<[f64; N]> {
        let list = self.read(key, |item| array(item, "numbers", |item| number(item, check)))?;
        Some(list.unwrap_or(default))
    }

    /// A list of vectors.
    pub fn vectors_or<const N: usize>(
        &self,
        key: &'static str,
        check: Check,
        default: [[f64; 3]; N],
    ) -> Option<[[f64; 3]; N]> {
        let vector = |item| array(item, "numbers", |item| number(item, check));
        Some(self.read(key, |item| array(item, "vectors", vector))?.unwrap_or(default))
    }

    /// A list of unit quaternions, scalar last.
    pub fn quaternions_or<const N: usize>(
        &self,
        key: &'static str,
        default: [[f64; 4]; N],
    ) -> Option<[[f64; 4]; N]> {
        let list = self.read(key, |item| array(item, "quaternions", quaternion))?;
        Some(list.unwrap_or(default))
    }

    /// A list of words of `choices`.
    pub fn words_or<T: Copy, const N: usize>(
        &self,
        key: &'static str,
        choices: &[(&'static str, T)],
        default: [T; N],
    ) -> Option<[T; N]> {
        let words = self.read(key, |item| array(item, "words", |item| choice(item, choices)))?;
        Some(words.unwrap_or(default))
    }

    /// Seconds, as a whole number of microseconds.
    pub fn micros(&self, key: &'static str, range_s: RangeInclusive<f64>) -> Option<i64> {
        self.required(key, |item| micros(item, range_s))
    }

    pub fn micros_or(
        &self,
        key: &'static str,
        range_s: RangeInclusive<f64>,
        default: i64,
    ) -> Option<i64> {
        Some(self.read(key, |item| micros(item, range_s))?.unwrap_or(default))
    }

    /// Any number of times in seconds, as whole numbers of microseconds.
    pub fn list_of_micros(
        &self,
        key: &'static str,
        range_s: RangeInclusive<f64>,
    ) -> Option<Vec<i64>> {
        self.required(key, |item| {
            let Value::List(items) = &item.value else {
                return Err((item.place, mismatch("a list of numbers", &item.value)));
            };
            items.iter().map(|item| micros(item, range_s.clone())).collect()
        })
    }

    pub fn integer(&self, key: &'static str, range: RangeInclusive<i64>) -> Option<i64> {
        self.required(key, |item| integer(item, range))
    }

    pub fn integer_or(
        &self,
        key: &'static str,
        range: RangeInclusive<i64>,
        default: i64,
    ) -> Option<i64> {
        Some(self.read(key, |item| integer(item, range))?.unwrap_or(default))
    }

    /// Three different small integers.
    pub fn channels(&self, key: &'static str) -> Option<[u8; 3]> {
        let channel = |item: &Item| integer(item, 0..=7).map(|channel| channel as u8);
        self.required(key, |item| array(item, "whole numbers", channel))
    }

    pub fn flag(&self, key: &'static str) -> Option<bool> {
        self.required(key, |item| match item.value {
            Value::Flag(flag) => Ok(flag),
            ref other => Err((item.place, mismatch("true or false", other))),
        })
    }

    pub fn text(&self, key: &'static str) -> Option<String> {
        self.required(key, |item| match text(item)?.trim() {
            "" => Err((item.place, Fault::new("is empty"))),
            text => Ok(text.to_owned()),
        })
    }

    /// A time, in quotes or without.
    pub fn time(&self, key: &'static str) -> Option<String> {
        self.required(key, |item| match &item.value {
            Value::Time(text) | Value::Text(text) => Ok(text.clone()),
            other => Err((item.place, mismatch("a UTC time", other))),
        })
    }

    /// Two texts and where their first characters stand.
    pub fn two_lines(&self, key: &'static str) -> Option<[(String, Place); 2]> {
        let line = |item: &Item| {
            let Place { file, start, end } = item.place;
            // Behind the opening quote.
            Ok((text(item)?.to_owned(), Place { file, start: start + 1, end }))
        };
        self.required(key, |item| array(item, "lines", line))
    }

    /// One of the words of `choices`, or nothing.
    pub fn choice_or<T: Copy>(
        &self,
        key: &'static str,
        choices: &[(&'static str, T)],
        default: T,
    ) -> Option<T> {
        Some(self.read(key, |item| choice(item, choices))?.unwrap_or(default))
    }

    pub fn choice<T: Copy>(&self, key: &'static str, choices: &[(&'static str, T)]) -> Option<T> {
        self.required(key, |item| choice(item, choices))
    }

    /// Any number of the words of `choices`; none when the key is absent.
    pub fn choices(
        &self,
        key: &'static str,
        choices: &[(&'static str, &'static str)],
    ) -> Option<Vec<&'static str>> {
        let words = self.read(key, |item| {
            let Value::List(items) = &item.value else {
                return Err((item.place, mismatch("a list of words", &item.value)));
            };
            items.iter().map(|item| choice(item, choices)).collect()
        })?;
        Some(words.unwrap_or_default())
    }

    /// The section below at `key`.
    pub fn section(&self, key: &'static str) -> Option<Self> {
        let section = self.section_if_any(key)?;
        if section.is_none() {
            self.missing_sections.borrow_mut().push(key);
        }
        section
    }

    /// The section below at `key`; an empty one when there is none.
    pub fn section_or_empty(&self, key: &'static str) -> Option<Self> {
        const EMPTY: &Table = &Table { entries: std::collections::BTreeMap::new() };
        let section = self.section_if_any(key)?;
        Some(
            section
                .unwrap_or_else(|| Self::new(self.problems, self.path_of(key), self.place, EMPTY)),
        )
    }

    /// The section below at `key`; `Some(None)` when there is none.
    pub fn section_if_any(&self, key: &'static str) -> Option<Option<Self>> {
        self.read(key, |item| match &item.value {
            Value::Table(table) => {
                Ok(Self::new(self.problems, self.path_of(key), item.place, table))
            }
            other => Err((item.place, mismatch("a section", other))),
        })
    }

    /// Of two keys that exclude each other, the one to read: that of the file nearer to the mission,
    /// so that a mission can replace what its base says. Both in one file are a problem.
    pub fn either(&self, first: &'static str, second: &'static str) -> Option<&'static str> {
        match (self.entry(first), self.entry(second)) {
            (Some(_), None) => Some(first),
            (None, Some(_)) => Some(second),
            (Some(a), Some(b)) if a.key.file != b.key.file => {
                Some(if a.key.file < b.key.file { first } else { second })
            }
            (Some(_), Some(b)) => {
                let fault = Fault::new(format!("excludes {first}, which is given too"));
                self.problems.note(b.key, self.path_of(second), fault);
                None
            }
            (None, None) => {
                let fault = Fault::new(format!("has neither {first} nor {second}"));
                self.problems.note(self.place, self.path.clone(), fault);
                None
            }
        }
    }

    /// A key that has no meaning beside the value of `because`. What a base says is let pass.
    pub fn meaningless(&self, key: &'static str, because: &str) {
        let Some(entry) = self.entry(key) else { return };
        let same_file =
            self.table.entries.get(because).is_some_and(|other| other.key.file == entry.key.file);
        if same_file {
            let fault = Fault::advising(format!("has no meaning with this {because}"), "remove it");
            self.problems.note(entry.key, self.path_of(key), fault);
        }
    }

    /// Ends the reading: what was never asked for is unknown, what was not found is missing.
    pub fn finish(&self) {
        let asked = self.asked.take();
        let mut missing = self.missing.take();
        let mut sections = self.missing_sections.take();
        for (key, entry) in &self.table.entries {
            if asked.contains(&key.as_str()) {
                continue;
            }
            let (fault, meant) = unknown(key, &asked);
            missing.retain(|missing| Some(*missing) != meant);
            sections.retain(|section| Some(*section) != meant);
            self.problems.note(entry.key, self.path_of(key), fault);
        }
        for key in missing {
            let fault = match unit::split(key) {
                (_, Some(unit)) => Fault::new(format!("is missing (wanted in {unit})")),
                (_, None) => Fault::new("is missing"),
            };
            self.problems.note(self.place, self.path_of(key), fault);
        }
        for key in sections {
            let fault = Fault::new(format!("the section [{}] is missing", self.path_of(key)));
            self.problems.note(self.place, "", fault);
        }
    }
}

/// What to say about an unknown key, and which of the known ones is probably meant.
fn unknown(key: &str, known: &[&'static str]) -> (Fault, Option<&'static str>) {
    let (stem, unit) = unit::split(key);
    let same_quantity = known.iter().copied().find(|known| {
        let (known_stem, known_unit) = unit::split(known);
        known_unit.is_some() && known_stem == stem
    });
    if let Some(meant) = same_quantity {
        let wanted = unit::split(meant).1.unwrap_or_default();
        let reason = match unit {
            Some(unit) => format!("wrong unit: given in {unit}, wanted in {wanted}"),
            None => format!("unknown key: its unit is missing, wanted in {wanted}"),
        };
        return (Fault::advising(reason, format!("write {meant}")), Some(meant));
    }
    let near = known
        .iter()
        .copied()
        .map(|known| (strsim::damerau_levenshtein(key, known), known))
        .filter(|(distance, known)| distance * 3 <= known.len().max(key.len()))
        .min();
    let reason = "unknown key";
    match near {
        Some((_, meant)) => {
            (Fault::advising(reason, format!("did you mean {meant}?")), Some(meant))
        }
        None => {
            let mut names = known.to_vec();
            names.sort_unstable();
            names.dedup();
            (Fault::advising(reason, format!("known here: {}", names.join(", "))), None)
        }
    }
}
