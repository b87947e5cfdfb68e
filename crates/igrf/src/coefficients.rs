//! Gauss coefficients of one date, scaled and arranged for the evaluation.

use crate::evaluate::{self, DEGREES, ROWS, Scaled, UNIT_KM};
use crate::generation::{Generation, VALIDITY_YEARS};
use crate::lanes::Four;
use crate::many::{self, Block};
use crate::{DecimalYear, Error, Real, table};

/// The highest degree of the model.
pub const HIGHEST_DEGREE: u8 = 13;

/// The radius to which Gauss coefficients refer, km (Alken et al. 2021, eq. 1).
pub const REFERENCE_RADIUS_KM: f64 = 6371.2;

/// Number of Gauss coefficients of degrees 1 to 13: N (N + 2).
pub(crate) const COEFFICIENTS: usize = HIGHEST_DEGREE as usize * (HIGHEST_DEGREE as usize + 2);

/// The tables are in hundredths of nT, in which the official values are whole numbers.
pub(crate) const TABLE_UNIT_NT: f64 = 0.01;

/// The main field at one node of the built-in model.
pub(crate) struct Node {
    /// The node is 1 January, 00:00, of this year.
    pub(crate) year: u16,
    /// g(1,0), g(1,1), h(1,1), g(2,0), …; degrees that are not there are zero.
    pub(crate) hundredths_nt: &'static [i32],
}

impl Node {
    fn hundredths_nt(&self, index: usize) -> f64 {
        self.hundredths_nt.get(index).copied().map_or(0.0, f64::from)
    }
}

/// Gauss coefficients for one date, ready to be evaluated at any number of positions.
///
/// The main field changes by up to 220 nT a year (2026), so coefficients prepared once a day are
/// within 0.6 nT. In `f32` they take 892 bytes, in `f64` 1784.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coefficients<T> {
    degree: u8,
    scaled: Scaled<T>,
}

impl<T: Real> Coefficients<T> {
    /// IGRF-14 at a date: linear between its nodes, with secular variation from 2025 on.
    ///
    /// Valid from 1900.0 (without the feature `history` from 2010.0) to 2030.0.
    ///
    /// # Errors
    /// [`Error::Date`] when the date is outside.
    pub fn at(date: DecimalYear) -> Result<Self, Error> {
        let DecimalYear(year) = date;
        for (from, to) in table::NODES.iter().zip(table::NODES.iter().skip(1)) {
            let (first, last) = (f64::from(from.year), f64::from(to.year));
            if (first..last).contains(&year) {
                let fraction = (year - first) / (last - first);
                return Ok(Self::prepare(HIGHEST_DEGREE, &|index| {
                    let start = from.hundredths_nt(index);
                    start + fraction * (to.hundredths_nt(index) - start)
                }));
            }
        }
        let (Some(oldest), Some(newest)) = (table::NODES.first(), table::NODES.last()) else {
            return Err(Error::Date { decimal_year: year, first: f64::NAN, last: f64::NAN });
        };
        let years = year - f64::from(newest.year);
        if !(0.0..=VALIDITY_YEARS).contains(&years) {
            let (first, last) = (f64::from(oldest.year), f64::from(newest.year) + VALIDITY_YEARS);
            return Err(Error::Date { decimal_year: year, first, last });
        }
        Ok(Self::prepare(HIGHEST_DEGREE, &|index| {
            let rate = table::SECULAR_VARIATION.get(index).copied().map_or(0.0, f64::from);
            newest.hundredths_nt(index) + years * rate
        }))
    }

    /// The main field of a replaced [`Generation`] at a date, with its secular variation.
    ///
    /// Valid for the five years from its epoch; its degree is the highest that can be evaluated.
    ///
    /// # Errors
    /// [`Error::Date`] when the date is outside.
    pub fn from_generation(generation: &Generation, date: DecimalYear) -> Result<Self, Error> {
        let first = f64::from(generation.epoch_year());
        let last = first + VALIDITY_YEARS;
        if !(first..=last).contains(&date.0) {
            return Err(Error::Date { decimal_year: date.0, first, last });
        }
        let years = date.0 - first;
        Ok(Self::prepare(generation.degree(), &|index| generation.hundredths_nt(index, years)))
    }

    /// Scales the Gauss coefficients, given in table units by their index in the official order.
    ///
    /// The factor of degree n and order m is S_nm (a/L)ⁿ⁺² / (2n+1)!!, with a the reference
    /// radius, L the unit of length of the evaluation and S_nm the Schmidt factor:
    /// S_n0 = 1, S_nm = S_n,m−1 √((1 + δ_m1) / ((n+m)(n−m+1))).
    fn prepare(degree: u8, hundredths_nt: &dyn Fn(usize) -> f64) -> Self {
        const RATIO: f64 = REFERENCE_RADIUS_KM / UNIT_KM;
        let mut factors = [0.0; DEGREES];
        let mut factor = TABLE_UNIT_NT * RATIO * RATIO;
        for (n, slot) in factors.iter_mut().enumerate() {
            *slot = factor;
            factor *= RATIO / (2 * n + 3) as f64;
        }
        // The official order: g(n,0), g(n,1), h(n,1), …, n² − 1 places before degree n.
        let mut zonal = [[T::ZERO; 2]; DEGREES - 1];
        for ((n, factor), pair) in factors.iter().enumerate().skip(1).zip(&mut zonal) {
            let g = *factor * hundredths_nt(n * n - 1);
            *pair = [g, g / (2 * n + 3) as f64].map(T::from_f64);
        }
        let mut rows = [Four::zero(); ROWS];
        let mut rest = rows.as_mut_slice();
        for m in (1..DEGREES).step_by(2) {
            let Some((rows, others)) = rest.split_at_mut_checked(DEGREES - m) else { break };
            rest = others;
            let mut scaled = |n: usize, m: usize| {
                let Some(factor) = factors.get_mut(n).filter(|_| m <= n) else {
                    return [T::ZERO; 2];
                };
                let both = if m == 1 { 2.0 } else { 1.0 };
                *factor *= libm::sqrt(both / ((n + m) * (n + 1 - m)) as f64);
                let g = n * n + 2 * m - 2;
                [g, g + 1].map(|index| T::from_f64(*factor * hundredths_nt(index)))
            };
            for (n, row) in (m..).zip(rows) {
                let ([g, h], [g_next, h_next]) = (scaled(n, m), scaled(n, m + 1));
                *row = Four([g, g_next, h, h_next]);
            }
        }
        Self { degree, scaled: Scaled { zonal, rows } }
    }

    /// The same coefficients, evaluated only up to `degree`: less accurate and less costly.
    ///
    /// # Errors
    /// [`Error::Degree`] when it is zero or above the degree so far.
    pub fn with_degree(self, degree: u8) -> Result<Self, Error> {
        if !(1..=self.degree).contains(&degree) {
            return Err(Error::Degree { requested: degree, highest: self.degree });
        }
        Ok(Self { degree, ..self })
    }

    /// The degree up to which the field is evaluated.
    pub fn degree(&self) -> u8 {
        self.degree
    }

    /// The field in Earth-fixed Cartesian axes at a position in the same axes.
    ///
    /// x points to latitude 0, longitude 0, z to the north pole, y completes; km in, nT out.
    /// No direction is singular and none is special. What it computes, and from which sources,
    /// stands in `evaluate.rs`.
    ///
    /// # Errors
    /// [`Error::NotFinite`], [`Error::Radius`].
    pub fn field_ecef_nt(&self, position_km: [T; 3]) -> Result<[T; 3], Error> {
        evaluate::field_nt(usize::from(self.degree), &self.scaled, position_km)
    }

    /// [`Coefficients::field_ecef_nt`] at each of many positions, in their order: several are
    /// evaluated side by side. On a PC this takes half the time in `f32`, and four fifths in `f64`
    /// (built for AVX, half as well).
    ///
    /// Each result is what the single evaluation gives, to the bit. A refused position has its
    /// error in its place, and does not concern the others.
    ///
    /// ```
    /// use igrf::{Coefficients, DecimalYear, Error};
    ///
    /// let coefficients = Coefficients::<f64>::at(DecimalYear(2026.5))?;
    /// let positions_km = [[4200.0, -1300.0, 5400.0], [0.0, 0.0, 6900.0], [0.0, 0.0, 0.0]];
    /// let mut fields_nt = coefficients.fields_ecef_nt(positions_km);
    /// assert_eq!(fields_nt.next(), Some(coefficients.field_ecef_nt(positions_km[0])));
    /// assert_eq!(fields_nt.last(), Some(Err(Error::Radius { radius_km: 0.0 })));
    /// # Ok::<(), Error>(())
    /// ```
    pub fn fields_ecef_nt<I>(
        &self,
        positions_km: I,
    ) -> impl Iterator<Item = Result<[T; 3], Error>> + use<'_, T, I>
    where
        I: IntoIterator<Item = [T; 3]>,
    {
        many::in_blocks(positions_km, |block| self.block_nt(block))
    }

    /// The field at [`many::BLOCK`] Earth-fixed positions.
    pub(crate) fn block_nt(&self, positions_km: Block<[T; 3]>) -> Block<Result<[T; 3], Error>> {
        evaluate::fields_nt(usize::from(self.degree), &self.scaled, positions_km)
    }
}
