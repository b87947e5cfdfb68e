//! Reads a line of a TLE column by column, so that no column goes unseen.

use super::error::{Expected, TleError};
use crate::{Classification, InternationalDesignator, decimal};

/// Columns in line 1 and in line 2.
pub(super) const LINE_LENGTH: usize = 69;

/// The columns of one line that have not been read yet.
pub(super) struct Columns<'a> {
    line: u8,
    text: &'a [u8],
    rest: core::slice::Iter<'a, u8>,
    column: u8,
}

impl<'a> Columns<'a> {
    /// Line number `line`, of which the length and the number in column 1 are checked.
    pub fn of_line(line: u8, text: &'a [u8]) -> Result<Self, TleError> {
        if text.len() != LINE_LENGTH {
            return Err(TleError::Length { line, found: text.len() });
        }
        let mut columns = Self { line, text, rest: text.iter(), column: 0 };
        match columns.next()? {
            found if found == b'0' + line => Ok(columns),
            found => Err(TleError::LineNumber { line, found }),
        }
    }

    /// The next column.
    pub fn next(&mut self) -> Result<u8, TleError> {
        let length = TleError::Length { line: self.line, found: self.text.len() };
        let byte = self.rest.next().ok_or(length)?;
        self.column += 1;
        Ok(*byte)
    }

    /// The error that the column read last holds `found`.
    fn unexpected(&self, found: u8, expected: Expected) -> TleError {
        TleError::Character { line: self.line, column: self.column, found, expected }
    }

    pub fn blank(&mut self) -> Result<(), TleError> {
        match self.next()? {
            b' ' => Ok(()),
            found => Err(self.unexpected(found, Expected::Blank)),
        }
    }

    pub fn point(&mut self) -> Result<(), TleError> {
        match self.next()? {
            b'.' => Ok(()),
            found => Err(self.unexpected(found, Expected::Point)),
        }
    }

    /// `count` digits.
    pub fn digits(&mut self, count: u8) -> Result<u32, TleError> {
        let mut value = 0;
        for _ in 0..count {
            let found = self.next()?;
            if !found.is_ascii_digit() {
                return Err(self.unexpected(found, Expected::Digit));
            }
            value = 10 * value + u32::from(found - b'0');
        }
        Ok(value)
    }

    /// A number right-justified in `count` columns: blanks, then at least one digit.
    pub fn right_justified(&mut self, count: u8) -> Result<u32, TleError> {
        let mut value = None;
        for _ in 0..count {
            let found = self.next()?;
            match (found, value) {
                (b' ', None) => {}
                (b'0'..=b'9', _) => {
                    value = Some(10 * value.unwrap_or(0) + u32::from(found - b'0'));
                }
                (_, None) => return Err(self.unexpected(found, Expected::DigitOrLeadingBlank)),
                (_, Some(_)) => return Err(self.unexpected(found, Expected::Digit)),
            }
        }
        value.ok_or(self.unexpected(b' ', Expected::Digit))
    }

    /// A number with a decimal point, right-justified digits before it and `decimals` behind it.
    pub fn fixed_point(&mut self, before: u8, decimals: u8) -> Result<f64, TleError> {
        let whole = self.right_justified(before)?;
        self.point()?;
        let behind = self.digits(decimals)?;
        let digits = u64::from(whole) * 10_u64.pow(u32::from(decimals)) + u64::from(behind);
        Ok(decimal::scaled(digits, -i32::from(decimals)))
    }

    /// Blank or plus: 1, minus: -1.
    pub fn sign(&mut self) -> Result<f64, TleError> {
        match self.next()? {
            b' ' | b'+' => Ok(1.0),
            b'-' => Ok(-1.0),
            found => Err(self.unexpected(found, Expected::Sign)),
        }
    }

    /// A number written `±ddddd±d`: sign, five digits behind an implied point, power of ten.
    pub fn exponential(&mut self) -> Result<f64, TleError> {
        let sign = self.sign()?;
        let digits = self.digits(5)?;
        let exponent_sign = match self.next()? {
            b'+' => 1,
            b'-' => -1,
            found => return Err(self.unexpected(found, Expected::ExponentSign)),
        };
        let exponent = exponent_sign * i32::from(self.digits(1)? as u8);
        Ok(sign * decimal::scaled(u64::from(digits), exponent - 5))
    }

    /// The satellite number: five columns, Alpha-5 included.
    ///
    /// In Alpha-5 the first column is a letter that stands for 10 to 33, I and O left out.
    pub fn satellite_number(&mut self) -> Result<u32, TleError> {
        let expected = Expected::SatelliteNumber;
        match self.next()? {
            b' ' => self.right_justified(4),
            found if found.is_ascii_digit() => {
                Ok(u32::from(found - b'0') * 10_000 + self.digits(4)?)
            }
            found => {
                let letter = alpha5_value(found).ok_or(self.unexpected(found, expected))?;
                Ok(letter * 10_000 + self.digits(4)?)
            }
        }
    }

    /// The letter in column 8 of line 1.
    pub fn classification(&mut self) -> Result<Classification, TleError> {
        let found = self.next()?;
        Classification::from_letter(found).ok_or(self.unexpected(found, Expected::Classification))
    }

    /// The eight columns of the international designator.
    pub fn international_designator(&mut self) -> Result<InternationalDesignator, TleError> {
        let first_column = self.column + 1;
        let mut text = [b' '; 8];
        for byte in &mut text {
            *byte = self.next()?;
        }
        InternationalDesignator::from_columns(text).map_err(|wrong| TleError::Character {
            line: self.line,
            column: first_column + wrong.index,
            found: wrong.found,
            expected: Expected::InternationalDesignator,
        })
    }

    /// The ephemeris type: blank or 0, as distributed, or 2, which is SGP4 in the report's
    /// numbering.
    pub fn ephemeris_type(&mut self) -> Result<(), TleError> {
        match self.next()? {
            b' ' | b'0' | b'2' => Ok(()),
            found if found.is_ascii_digit() => Err(TleError::EphemerisType { found }),
            found => Err(self.unexpected(found, Expected::Digit)),
        }
    }

    /// The last column, which has to be a digit: compared with the sum when `check` is set.
    pub fn checksum(mut self, check: bool) -> Result<(), TleError> {
        let found = self.digits(1)? as u8;
        let expected = checksum(self.text);
        if check && found != expected {
            return Err(TleError::Checksum { line: self.line, expected, found });
        }
        Ok(())
    }
}

/// The value of a letter in Alpha-5: A = 10 … H = 17, J = 18 … N = 22, P = 23 … Z = 33.
fn alpha5_value(letter: u8) -> Option<u32> {
    let skipped = match letter {
        b'A'..=b'H' => 0,
        b'J'..=b'N' => 1,
        b'P'..=b'Z' => 2,
        _ => return None,
    };
    Some(u32::from(letter - b'A') + 10 - skipped)
}

/// The checksum of the columns before the last: the sum of the digits, a minus counting as 1,
/// modulo 10.
fn checksum(line: &[u8]) -> u8 {
    let sum: u32 = line
        .iter()
        .take(LINE_LENGTH - 1)
        .map(|&byte| match byte {
            b'0'..=b'9' => u32::from(byte - b'0'),
            b'-' => 1,
            _ => 0,
        })
        .sum();
    (sum % 10) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn alpha5_letters_run_from_10_to_33_without_i_and_o() {
        let letters = b"ABCDEFGHJKLMNPQRSTUVWXYZ";
        for (value, &letter) in (10..).zip(letters) {
            assert_eq!(alpha5_value(letter), Some(value));
        }
        for other in (0..=255).filter(|byte| !letters.contains(byte)) {
            assert_eq!(alpha5_value(other), None);
        }
    }
}
