//! Decimal numbers to `f64`: small and without a way to panic, unlike the standard library's
//! parser, which brings 14 KiB of tables.

/// Powers of ten that a double holds exactly: all there are.
const EXACT_POWERS_OF_TEN: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16,
    1e17, 1e18, 1e19, 1e20, 1e21, 1e22,
];
/// The largest of their exponents.
const LAST_EXACT_EXPONENT: i32 = 22;
/// Beyond this exponent any 64-bit integer is zero or infinite as a double.
const LIMIT_EXPONENT: i32 = 400;
/// Largest value that takes one more digit without overflow.
const LAST_EXTENSIBLE: u64 = (u64::MAX - 9) / 10;

/// `digits · 10^exponent`.
///
/// The double nearest to the true value when `digits` is below 2⁵³ and the exponent within ±22:
/// both factors are then exact and there is one rounding (Clinger 1990). All numbers of a TLE are,
/// and those of an OMM with up to 15 digits. Otherwise a few roundings add up.
pub(crate) fn scaled(digits: u64, exponent: i32) -> f64 {
    let mut value = digits as f64;
    let mut left = exponent.clamp(-LIMIT_EXPONENT, LIMIT_EXPONENT);
    while left > LAST_EXACT_EXPONENT {
        value *= 1e22;
        left -= LAST_EXACT_EXPONENT;
    }
    while left < -LAST_EXACT_EXPONENT {
        value /= 1e22;
        left += LAST_EXACT_EXPONENT;
    }
    let power = EXACT_POWERS_OF_TEN.get(left.unsigned_abs() as usize).copied().unwrap_or(1.0);
    if left < 0 { value / power } else { value * power }
}

/// A number written with digits, and perhaps a sign, a point and an exponent: `-1.5E-3`.
///
/// `None` when it is anything else; infinite when it is too large for a double.
pub(crate) fn parse(text: &[u8]) -> Option<f64> {
    let (negative, text) = split_sign(text);
    let mut number = Mantissa::default();
    let mut rest = text.iter();
    let exponent = loop {
        match rest.next() {
            Some(digit @ b'0'..=b'9') => number.push(u64::from(digit - b'0')),
            Some(b'.') if !number.point_seen => number.point_seen = true,
            Some(b'e' | b'E') => break parse_exponent(rest.as_slice())?,
            Some(_) => return None,
            None => break 0,
        }
    };
    if !number.digit_seen {
        return None;
    }
    let magnitude = scaled(number.digits, exponent.saturating_add(number.exponent));
    Some(if negative { -magnitude } else { magnitude })
}

/// The digits read so far, as `digits · 10^exponent`.
#[derive(Default)]
struct Mantissa {
    digits: u64,
    exponent: i32,
    digit_seen: bool,
    point_seen: bool,
}

impl Mantissa {
    fn push(&mut self, digit: u64) {
        self.digit_seen = true;
        // From the 20th significant digit on, only the place counts.
        if self.digits <= LAST_EXTENSIBLE {
            self.digits = 10 * self.digits + digit;
            self.exponent = self.exponent.saturating_sub(i32::from(self.point_seen));
        } else {
            self.exponent = self.exponent.saturating_add(i32::from(!self.point_seen));
        }
    }
}

/// At least one digit, with a sign or without.
fn parse_exponent(text: &[u8]) -> Option<i32> {
    let (negative, digits) = split_sign(text);
    if digits.is_empty() || !digits.iter().all(u8::is_ascii_digit) {
        return None;
    }
    let magnitude = digits.iter().fold(0_i32, |value, digit| {
        value.saturating_mul(10).saturating_add(i32::from(digit - b'0'))
    });
    Some(if negative { -magnitude } else { magnitude })
}

fn split_sign(text: &[u8]) -> (bool, &[u8]) {
    match text {
        [b'-', rest @ ..] => (true, rest),
        [b'+', rest @ ..] => (false, rest),
        _ => (false, text),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    extern crate std;
    use std::format;

    #[test]
    fn up_to_15_digits_are_rounded_as_by_the_standard_library() {
        let mut digits = 1_u64;
        for step in 0..20_000_u64 {
            digits = digits.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(step) | 1;
            let fifteen = digits % 1_000_000_000_000_000;
            let exponent = i32::try_from(step % 45).unwrap() - 22;
            for text in [
                format!("{fifteen}e{exponent}"),
                format!("-{fifteen}E{exponent:+}"),
                format!("{}.{:09}", fifteen / 1_000_000_000, fifteen % 1_000_000_000),
                format!("+.{fifteen:015}"),
            ] {
                assert_eq!(parse(text.as_bytes()), text.parse().ok(), "{text}");
            }
        }
    }

    #[test]
    fn longer_numbers_are_right_to_the_last_bits() {
        // Four roundings at most.
        const TOLERANCE: f64 = 5e-16;
        for text in [
            "0.1234567890123456789012345678901234567890",
            "12345678901234567890123456789012345678901234567890",
            "9999999999999999999999e-40",
            "1.7976931348623157e308",
            "0.000000000000000000000000000000000000000000000000012345678901234567",
        ] {
            let expected: f64 = text.parse().unwrap();
            let found = parse(text.as_bytes()).unwrap();
            assert!((found / expected - 1.0).abs() < TOLERANCE, "{text}: {found}");
        }
    }

    #[test]
    fn extremes_are_zero_or_infinite() {
        for (text, value) in [
            ("0", 0.0),
            ("-0.000", 0.0),
            ("0e99999999999999999999", 0.0),
            ("1e-99999999999999999999", 0.0),
            ("1e400", f64::INFINITY),
            ("-1e99999999999999999999", f64::NEG_INFINITY),
        ] {
            assert_eq!(parse(text.as_bytes()), Some(value), "{text}");
        }
    }

    #[test]
    fn what_is_no_number_is_refused() {
        for text in [
            "", ".", "-", "+.", "e5", ".e5", "1e", "1e+", "1.2.3", "1e5.0", "1 ", " 1", "--1",
            "1-", "inf", "nan", "0x1", "1_000", "1,5", "1e5e5",
        ] {
            assert_eq!(parse(text.as_bytes()), None, "{text}");
        }
    }
}
