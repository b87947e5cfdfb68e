//! Whether two flights were the same to the bit, and if not, where they parted.

use std::fmt;

use adcs_link::Message;
use adcs_link::frame::{self, MAX_FRAME};
use anyhow::Result;
use serde_json::Value;

use super::Flown;

/// Where two flights part for the first time.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Difference {
    /// In a field of a cycle.
    Field {
        /// The cycle.
        cycle: u32,
        /// Seconds since the start, in words.
        time_s: String,
        /// The field, with its index: `truth.omega_bi_rad_s[1]`.
        field: String,
        /// Its value in the first flight.
        first: String,
        /// Its value in the second.
        second: String,
    },
    /// One ends, the other goes on.
    Length {
        /// Cycles of the first flight.
        first: usize,
        /// Cycles of the second.
        second: usize,
    },
}

/// The first difference between two flights; `None` when they are the same to the bit.
///
/// # Errors
/// When a record cannot be encoded, which no record that was read can cause.
pub fn first_difference(first: &Flown, second: &Flown) -> Result<Option<Difference>> {
    for (a, b) in first.steps.iter().zip(&second.steps) {
        let pairs = [
            ("truth", Message::Truth(a.truth), Message::Truth(b.truth)),
            ("record", Message::Cycle(a.record), Message::Cycle(b.record)),
        ];
        for (name, message_a, message_b) in pairs {
            if bytes(&message_a)? == bytes(&message_b)? {
                continue;
            }
            let (field, first_value, second_value) = parted(name, &message_a, &message_b)?;
            return Ok(Some(Difference::Field {
                cycle: a.truth.cycle,
                time_s: format!("{:.1}", first.time_s(a.truth.cycle)),
                field,
                first: first_value,
                second: second_value,
            }));
        }
    }
    let (first, second) = (first.steps.len(), second.steps.len());
    Ok((first != second).then_some(Difference::Length { first, second }))
}

fn bytes(message: &Message) -> Result<Vec<u8>> {
    let mut buffer = [0; MAX_FRAME];
    Ok(frame::encode(message, &mut buffer)?.to_vec())
}

/// The first field of two different messages that differs, and both values.
fn parted(name: &str, a: &Message, b: &Message) -> Result<(String, String, String)> {
    let [a, b] = [a, b].map(|message| match message {
        Message::Truth(truth) => serde_json::to_value(truth),
        Message::Cycle(record) => serde_json::to_value(record),
        other => serde_json::to_value(other),
    });
    let (a, b) = (leaves(name, a?), leaves(name, b?));
    let parted = a.iter().zip(&b).find(|(a, b)| a != b);
    Ok(match parted {
        Some(((field, a), (other, b))) if field == other => (field.clone(), a.clone(), b.clone()),
        // One has a value where the other has none.
        Some(((field, a), (other, b))) => (field.clone(), a.clone(), format!("{b} ({other})")),
        None => (name.to_owned(), "the same in decimals".to_owned(), "not in bits".to_owned()),
    })
}

/// Every number and word of a value with its path. Numbers are written so that they round-trip, so
/// that texts differ when numbers do; −0 is not 0.
fn leaves(path: &str, value: Value) -> Vec<(String, String)> {
    match value {
        Value::Object(fields) => fields
            .into_iter()
            .flat_map(|(key, value)| leaves(&format!("{path}.{key}"), value))
            .collect(),
        Value::Array(items) => items
            .into_iter()
            .enumerate()
            .flat_map(|(index, value)| leaves(&format!("{path}[{index}]"), value))
            .collect(),
        leaf => vec![(path.to_owned(), leaf.to_string())],
    }
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Field { cycle, time_s, field, first, second } => {
                write!(f, "cycle {cycle} (t = {time_s} s), {field}: {first} against {second}")
            }
            Self::Length { first, second } => {
                write!(
                    f,
                    "the same as far as both go, but one has {first} cycles, the other {second}"
                )
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flight::records::tests::flown;

    #[test]
    fn a_flight_is_the_same_as_itself() {
        assert_eq!(first_difference(&flown(3), &flown(3)).unwrap(), None);
    }

    #[test]
    fn the_first_field_that_differs_is_named_with_both_values() {
        let (a, mut b) = (flown(4), flown(4));
        b.steps[2].record.commanded_am2[1] = 0.25;
        b.steps[3].truth.omega_bi_rad_s[0] = 7.0;
        let difference = first_difference(&a, &b).unwrap().unwrap();
        assert_eq!(
            difference.to_string(),
            "cycle 2 (t = 1.0 s), record.commanded_am2[1]: 0.0 against 0.25"
        );
    }

    #[test]
    fn minus_zero_is_not_zero() {
        let (a, mut b) = (flown(1), flown(1));
        b.steps[0].truth.omega_bi_rad_s[2] = -0.0;
        let difference = first_difference(&a, &b).unwrap().unwrap().to_string();
        assert!(difference.contains("truth.omega_bi_rad_s[2]: 0.0 against -0.0"), "{difference}");
    }

    #[test]
    fn a_flight_that_is_shorter_is_not_equal() {
        let difference = first_difference(&flown(3), &flown(2)).unwrap();
        assert_eq!(difference, Some(Difference::Length { first: 3, second: 2 }));
    }
}
