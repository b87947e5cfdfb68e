//! Instants as CCSDS messages write them: `2020-04-06T19:53:20.932800` or `2020-097T19:53:20.9328`.

use crate::Epoch;

/// What [`parse_epoch`] reads, in words.
pub(super) const EXPECTED: &str =
    "an instant like 2020-04-06T19:53:20.9328 or 2020-097T19:53:20.9328, in UTC";

/// An instant in either of the two forms, with any number of decimals of the second, rounded to the
/// microsecond, and with or without `Z` at its end. `None` for anything else, for dates and times
/// that do not exist, and inside leap seconds.
pub(super) fn parse_epoch(text: &[u8]) -> Option<Epoch> {
    let text = text.strip_suffix(b"Z").unwrap_or(text);
    let (date, time) = split_at_byte(text, b'T')?;
    let midnight = parse_date(date)?;
    let micros = parse_time_of_day(time)?;
    // Rounding up may reach the next midnight.
    let (days, micros) = match micros.checked_sub(MICROS_PER_DAY) {
        Some(rest @ 0..) => (1, rest),
        _ => (0, micros),
    };
    Epoch::from_days(midnight.days_since_j2000_midnight() + days, micros)
}

const MICROS_PER_DAY: i64 = 86_400_000_000;
const MICROS_PER_SECOND: i64 = 1_000_000;

/// `YYYY-MM-DD` or `YYYY-DDD`.
fn parse_date(text: &[u8]) -> Option<Epoch> {
    let (year, rest) = split_at_byte(text, b'-')?;
    let year = digits::<4>(year)? as u16;
    match split_at_byte(rest, b'-') {
        Some((month, day)) => {
            Epoch::from_calendar(year, digits::<2>(month)? as u8, digits::<2>(day)? as u8, 0)
        }
        None => Epoch::from_day_of_year(year, digits::<3>(rest)? as u16, 0),
    }
}

/// `hh:mm:ss` with or without decimals, in microseconds.
fn parse_time_of_day(text: &[u8]) -> Option<i64> {
    let (hours, rest) = split_at_byte(text, b':')?;
    let (minutes, rest) = split_at_byte(rest, b':')?;
    let (seconds, micros) = match split_at_byte(rest, b'.') {
        Some((seconds, decimals)) => (seconds, parse_decimals(decimals)?),
        None => (rest, 0),
    };
    let (hours, minutes, seconds) =
        (digits::<2>(hours)?, digits::<2>(minutes)?, digits::<2>(seconds)?);
    let exists = hours < 24 && minutes < 60 && seconds < 60;
    let whole_seconds = i64::from((hours * 60 + minutes) * 60 + seconds);
    exists.then_some(whole_seconds * MICROS_PER_SECOND + micros)
}

/// The decimals of a second, at least one, in microseconds, the seventh rounded.
fn parse_decimals(text: &[u8]) -> Option<i64> {
    if text.is_empty() || !text.iter().all(u8::is_ascii_digit) {
        return None;
    }
    let mut places = text.iter().map(|digit| i64::from(digit - b'0')).chain(core::iter::repeat(0));
    let micros = places.by_ref().take(6).fold(0, |micros, digit| 10 * micros + digit);
    let round_up = places.next().is_some_and(|seventh| seventh >= 5);
    Some(micros + i64::from(round_up))
}

/// Exactly `N` digits.
fn digits<const N: usize>(text: &[u8]) -> Option<u32> {
    let well_formed = text.len() == N && text.iter().all(u8::is_ascii_digit);
    well_formed.then(|| text.iter().fold(0, |value, digit| 10 * value + u32::from(digit - b'0')))
}

/// What stands before and behind the first `byte`.
pub(super) fn split_at_byte(text: &[u8], byte: u8) -> Option<(&[u8], &[u8])> {
    let index = text.iter().position(|&candidate| candidate == byte)?;
    let (before, behind) = text.split_at_checked(index)?;
    Some((before, behind.split_first()?.1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_forms_of_a_date_are_the_same_instant() {
        let micros = ((19 * 60 + 53) * 60 + 20) * MICROS_PER_SECOND + 932_800;
        let expected = Epoch::from_calendar(2020, 4, 6, micros);
        assert!(expected.is_some());
        for text in [
            "2020-04-06T19:53:20.932800",
            "2020-04-06T19:53:20.9328Z",
            "2020-097T19:53:20.9328",
            "2020-097T19:53:20.93279951Z",
            "2020-04-06T19:53:20.9328000000000000000000000000000000000000000000",
        ] {
            assert_eq!(parse_epoch(text.as_bytes()), expected, "{text}");
        }
    }

    #[test]
    fn rounding_reaches_the_next_year() {
        let new_year = Epoch::from_calendar(2021, 1, 1, 0);
        assert_eq!(parse_epoch(b"2020-12-31T23:59:59.9999995"), new_year);
    }

    #[test]
    fn instants_that_do_not_exist_are_refused() {
        for text in [
            "",
            "Z",
            "2020-04-06",
            "2020-04-06 19:53:20",
            "2020-4-06T19:53:20",
            "2020-04-31T19:53:20",
            "2020-13-01T19:53:20",
            "2021-366T19:53:20",
            "2020-000T19:53:20",
            "20-097T19:53:20",
            "2020-04-06T24:00:00",
            "2020-04-06T19:60:20",
            "2016-12-31T23:59:60",
            "2020-04-06T19:53",
            "2020-04-06T19:53:20.",
            "2020-04-06T19:53:20.9z",
            "2020-04-06T19:53:20.9ZZ",
            "2020-04-06T19:53:-2",
            "2020-04-06T19:53:20,9",
            "+020-04-06T19:53:20",
            "2200-01-01T00:00:00",
        ] {
            assert_eq!(parse_epoch(text.as_bytes()), None, "{text}");
        }
    }
}
