//! Gauss coefficients of one date, scaled and arranged for the evaluation.

use crate::evaluate::{self, COLUMN, PAIRS, UNIT_KM};
use crate::table;
use crate::{DecimalYear, Error, Real};

pub(crate) struct Node {
    pub(crate) year: u16,
    pub(crate) hundredths_nt: &'static [i32],
}

pub const HIGHEST_DEGREE: u8 = 13;
pub const REFERENCE_RADIUS_KM: f64 = 6371.2;
const LAST_YEAR: f64 = 2030.0;

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coefficients<T> {
    degree: u8,
    pairs: [[T; 2]; PAIRS],
}

impl<T: Real> Coefficients<T> {
    pub fn at(date: DecimalYear) -> Result<Self, Error> {
        let DecimalYear(year) = date;
        let first = table::NODES.first().map_or(f64::NAN, |node| f64::from(node.year));
        if !(first..=LAST_YEAR).contains(&year) {
            return Err(Error::Date { decimal_year: year, first, last: LAST_YEAR });
        }
        let after = table::NODES.iter().position(|node| f64::from(node.year) > year);
        match after {
            Some(after) => {
                let (from, to) = (&table::NODES[after - 1], &table::NODES[after]);
                let f = (year - f64::from(from.year)) / f64::from(to.year - from.year);
                Ok(Self::prepare(13, |i| {
                    let a = f64::from(from.hundredths_nt.get(i).copied().unwrap_or(0));
                    let b = f64::from(to.hundredths_nt.get(i).copied().unwrap_or(0));
                    a + (b - a) * f
                }))
            }
            None => {
                let from = table::NODES.last().unwrap();
                let f = year - f64::from(from.year);
                Ok(Self::prepare(13, |i| {
                    let a = f64::from(from.hundredths_nt.get(i).copied().unwrap_or(0));
                    let b = f64::from(table::SECULAR_VARIATION.get(i).copied().unwrap_or(0));
                    a + b * f
                }))
            }
        }
    }

    fn prepare(degree: u8, value: impl Fn(usize) -> f64) -> Self {
        let mut norm = [0.0; COLUMN];
        let ratio = REFERENCE_RADIUS_KM / UNIT_KM;
        let mut v = 0.01 * ratio * ratio;
        for (n, slot) in norm.iter_mut().enumerate() {
            *slot = v;
            v *= ratio / (2 * n + 3) as f64;
        }
        let mut pairs = [[T::ZERO; 2]; PAIRS];
        let (mut n, mut m) = (0usize, 0usize);
        for pair in &mut pairs {
            if m > 0 {
                let f = if m == 1 { 2.0 } else { 1.0 };
                norm[n] *= libm::sqrt(f / ((n - m + 1) * (n + m)) as f64);
            }
            if n > 0 {
                if m == 0 {
                    pair[0] = T::from_f64(norm[n] * value(n * n - 1));
                } else {
                    pair[0] = T::from_f64(norm[n] * value(n * n + 2 * m - 2));
                    pair[1] = T::from_f64(norm[n] * value(n * n + 2 * m - 1));
                }
            }
            n += 1;
            if n >= COLUMN {
                m += 1;
                n = m;
            }
        }
        Self { degree, pairs }
    }

    pub fn with_degree(self, degree: u8) -> Result<Self, Error> {
        if !(1..=HIGHEST_DEGREE).contains(&degree) {
            return Err(Error::Degree { requested: degree, highest: HIGHEST_DEGREE });
        }
        Ok(Self { degree, ..self })
    }

    pub fn field_ecef_nt(&self, position_km: [T; 3]) -> Result<[T; 3], Error> {
        evaluate::field(usize::from(self.degree), &self.pairs, position_km)
    }
}
