//! Reading one value: its type, its range, and what to say when it has another.

use std::ops::RangeInclusive;

use super::document::{Item, Value};
use super::problem::{Fault, Place};

/// What is wrong with a value, and where in it.
pub(super) type Refusal = (Place, Fault);

/// A range of numbers and how it is called.
#[derive(Debug, Clone, Copy)]
pub(super) struct Check {
    holds: fn(f64) -> bool,
    wanted: &'static str,
}

/// Any finite number.
pub(super) const FINITE: Check = Check { holds: f64::is_finite, wanted: "finite" };
/// Above zero.
pub(super) const POSITIVE: Check =
    Check { holds: |x| x.is_finite() && x > 0.0, wanted: "positive and finite" };
/// An entry of a matrix: an inertia in kg·m², or a factor.
const ENTRY: Check = Check::new(|x| x.abs() <= 1e5, "finite, and within 100000");
/// A turn, deg.
pub(super) const TURN_DEG: Check = Check::new(|x| x.abs() <= 180.0, "within 180 deg");
/// Usable as a factor that can be undone.
pub(super) const NOT_ZERO: Check =
    Check { holds: |x| x.is_finite() && x != 0.0, wanted: "finite and not zero" };

impl Check {
    pub const fn new(holds: fn(f64) -> bool, wanted: &'static str) -> Self {
        Self { holds, wanted }
    }
}

/// How far the length of a quaternion in a file may be from one: four decimals round to 1e-4, a
/// forgotten component does more.
const QUATERNION_TOLERANCE: f64 = 0.01;

pub(super) fn mismatch(wanted: &str, found: &Value) -> Fault {
    let reason = format!("expected {wanted}, found {}", found.kind());
    match found {
        Value::Text(text) if wanted.contains("number") && text.trim().parse::<f64>().is_ok() => {
            Fault::advising(reason, "write it without quotes")
        }
        Value::Number { .. } if wanted == "a text" => Fault::advising(reason, "write it in quotes"),
        _ => Fault::new(reason),
    }
}

pub(super) fn number(item: &Item, check: Check) -> Result<f64, Refusal> {
    match item.value {
        Value::Number { value, .. } if (check.holds)(value) => Ok(value),
        Value::Number { value, .. } => Err((
            item.place,
            Fault::new(format!("{value} is impossible: must be {}", check.wanted)),
        )),
        ref other => Err((item.place, mismatch("a number", other))),
    }
}

pub(super) fn integer(item: &Item, range: RangeInclusive<i64>) -> Result<i64, Refusal> {
    match item.value {
        Value::Number { integer: Some(integer), .. } if range.contains(&integer) => Ok(integer),
        Value::Number { value, .. } => Err((
            item.place,
            Fault::new(format!(
                "{value} is impossible: must be a whole number from {} to {}",
                range.start(),
                range.end()
            )),
        )),
        ref other => Err((item.place, mismatch("a whole number", other))),
    }
}

pub(super) fn text(item: &Item) -> Result<&str, Refusal> {
    match &item.value {
        Value::Text(text) => Ok(text),
        other => Err((item.place, mismatch("a text", other))),
    }
}

pub(super) fn array<'a, T, const N: usize>(
    item: &'a Item,
    of: &str,
    parse: impl Fn(&'a Item) -> Result<T, Refusal>,
) -> Result<[T; N], Refusal> {
    let Value::List(items) = &item.value else {
        return Err((item.place, mismatch(&format!("a list of {N} {of}"), &item.value)));
    };
    let parsed = items.iter().map(parse).collect::<Result<Vec<T>, _>>()?;
    let found = parsed.len();
    parsed.try_into().map_err(|_| {
        (item.place, Fault::new(format!("expected a list of {N} {of}, found one of {found}")))
    })
}

pub(super) fn matrix(item: &Item) -> Result<[[f64; 3]; 3], Refusal> {
    array(item, "rows", |row| array(row, "numbers", |item| number(item, ENTRY)))
}

pub(super) fn quaternion(item: &Item) -> Result<[f64; 4], Refusal> {
    let xyzw: [f64; 4] = array(item, "numbers", |item| number(item, FINITE))?;
    let length = xyzw.iter().map(|x| x * x).sum::<f64>().sqrt();
    if length == 0.0 {
        return Err((
            item.place,
            Fault::advising(
                "a zero quaternion is no attitude",
                "no rotation is [0, 0, 0, 1]: x, y, z, and the scalar last",
            ),
        ));
    }
    if (length - 1.0).abs() > QUATERNION_TOLERANCE {
        return Err((
            item.place,
            Fault::advising(
                format!("a quaternion of length {length:.4} is no attitude"),
                "an attitude quaternion has length 1; are all four components there, scalar last?",
            ),
        ));
    }
    Ok(xyzw)
}

pub(super) fn micros(item: &Item, range_s: RangeInclusive<f64>) -> Result<i64, Refusal> {
    const MICROS_PER_S: f64 = 1e6;
    // A decimal number of microseconds is within this of the nearest double times 1e6.
    const ROUNDING: f64 = 1e-3;
    let seconds = number(item, FINITE)?;
    if !range_s.contains(&seconds) {
        let (low, high) = (range_s.start(), range_s.end());
        let reason = format!("{seconds} s is impossible: must be from {low} to {high} s");
        return Err((item.place, Fault::new(reason)));
    }
    let micros = (seconds * MICROS_PER_S).round();
    if (seconds * MICROS_PER_S - micros).abs() > ROUNDING {
        let reason = format!("{seconds} s is finer than a microsecond");
        return Err((item.place, Fault::new(reason)));
    }
    Ok(micros as i64)
}

pub(super) fn choice<T: Copy>(item: &Item, choices: &[(&'static str, T)]) -> Result<T, Refusal> {
    let words = || choices.iter().map(|(word, _)| format!("{word:?}")).collect::<Vec<_>>();
    let Value::Text(text) = &item.value else {
        return Err((item.place, mismatch(&format!("one of {}", words().join(", ")), &item.value)));
    };
    choices.iter().find(|(word, _)| word == text).map(|(_, value)| *value).ok_or_else(|| {
        let reason = format!("expected one of {}, found {text:?}", words().join(", "));
        (item.place, Fault::new(reason))
    })
}
