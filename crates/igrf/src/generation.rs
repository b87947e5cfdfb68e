//! One generation of the model: main field at an epoch, and its secular variation.

use core::fmt;

use crate::coefficients::{COEFFICIENTS, HIGHEST_DEGREE, TABLE_UNIT_NT};

/// A generation is made for the five years from its epoch; then the next one is published.
pub(crate) const VALIDITY_YEARS: f64 = 5.0;

/// The axial dipole g(1,0) lies within these magnitudes, nT. It was −31543 in 1900, is −29350 in
/// 2025, and decays by 5 % a century (Alken et al. 2021): what lies outside is no main field.
const DIPOLE_NT: core::ops::RangeInclusive<f64> = 20_000.0..=40_000.0;
/// No other coefficient is above this magnitude, nT. The largest since 1900 is h(1,1) = 5922.
const HIGHEST_COEFFICIENT_NT: f64 = 10_000.0;
/// No rate is above this magnitude, nT a year. The largest of the present generation is 25.
const HIGHEST_VARIATION_NT_PER_YEAR: f64 = 300.0;
/// Epochs a generation may have.
const EPOCHS: core::ops::RangeInclusive<u16> = 1900..=2200;

/// Main field and secular variation of one generation of IGRF: what a satellite in orbit
/// receives when the built-in model ends.
///
/// Coefficients are kept in hundredths of nT (and nT a year), in which the published ones are
/// whole numbers. Implausible values are refused, so a `Generation` is always fit for use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Generation {
    pub(crate) epoch_year: u16,
    pub(crate) degree: u8,
    pub(crate) variation_degree: u8,
    pub(crate) main_hundredths: [i32; COEFFICIENTS],
    pub(crate) variation_hundredths: [i16; COEFFICIENTS],
}

/// Why a set of coefficients was refused. Each variant carries what was wrong with it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum GenerationError {
    /// The number of coefficients is no N (N + 2) with 1 ≤ N ≤ 13.
    Count {
        /// How many there are.
        found: usize,
    },
    /// The degree is outside what the model has.
    Degree {
        /// What was found.
        found: u8,
    },
    /// The epoch is no year from 1900 to 2200.
    Epoch {
        /// What was found.
        year: u16,
    },
    /// A coefficient of the main field cannot be one.
    Coefficient {
        /// Its place in the official order g(1,0), g(1,1), h(1,1), g(2,0), …, from 0.
        index: usize,
        /// Its value, nT.
        value_nt: f64,
    },
    /// A rate of the secular variation cannot be one.
    Variation {
        /// Its place in the official order, from 0.
        index: usize,
        /// Its value, nT a year.
        value_nt_per_year: f64,
    },
    /// The encoded set is too short or too long.
    Length {
        /// Bytes there are.
        found: usize,
        /// Bytes there should be.
        expected: usize,
    },
    /// The encoded set has a format that is not known here.
    Version {
        /// What was found.
        found: u8,
    },
    /// The encoded set was damaged on its way.
    Checksum {
        /// The CRC-32 it carries.
        stored: u32,
        /// The CRC-32 of what arrived.
        computed: u32,
    },
}

impl Generation {
    /// A generation from published coefficients in their official order g(1,0), g(1,1), h(1,1),
    /// g(2,0), …, in nT and nT a year. Values are rounded to hundredths.
    ///
    /// # Errors
    /// [`GenerationError::Count`], [`Epoch`](GenerationError::Epoch),
    /// [`Coefficient`](GenerationError::Coefficient), [`Variation`](GenerationError::Variation).
    pub fn new(
        epoch_year: u16,
        main_nt: &[f64],
        variation_nt_per_year: &[f64],
    ) -> Result<Self, GenerationError> {
        check_epoch(epoch_year)?;
        let mut generation = Self::empty(
            epoch_year,
            degree_of(main_nt.len())?,
            degree_of(variation_nt_per_year.len())?,
        );
        let main = generation.main_hundredths.iter_mut().zip(main_nt);
        for (index, (slot, &value_nt)) in main.enumerate() {
            check_main(index, value_nt)?;
            *slot = libm::round(value_nt / TABLE_UNIT_NT) as i32;
        }
        let variation = generation.variation_hundredths.iter_mut().zip(variation_nt_per_year);
        for (index, (slot, &value_nt_per_year)) in variation.enumerate() {
            check_variation(index, value_nt_per_year)?;
            *slot = libm::round(value_nt_per_year / TABLE_UNIT_NT) as i16;
        }
        Ok(generation)
    }

    pub(crate) fn empty(epoch_year: u16, degree: u8, variation_degree: u8) -> Self {
        Self {
            epoch_year,
            degree,
            variation_degree,
            main_hundredths: [0; COEFFICIENTS],
            variation_hundredths: [0; COEFFICIENTS],
        }
    }

    /// The main field is that of 1 January, 00:00, of this year.
    pub fn epoch_year(&self) -> u16 {
        self.epoch_year
    }

    /// The highest degree of the main field.
    pub fn degree(&self) -> u8 {
        self.degree
    }

    /// The highest degree of the secular variation.
    pub fn variation_degree(&self) -> u8 {
        self.variation_degree
    }

    /// A coefficient, hundredths of nT, so many years after the epoch. Zero where there is none.
    pub(crate) fn hundredths_nt(&self, index: usize, years: f64) -> f64 {
        let main = self.main_hundredths.get(index).copied().map_or(0.0, f64::from);
        let variation = self.variation_hundredths.get(index).copied().map_or(0.0, f64::from);
        main + years * variation
    }
}

/// The degree N of a set of N (N + 2) coefficients.
fn degree_of(count: usize) -> Result<u8, GenerationError> {
    (1..=HIGHEST_DEGREE)
        .find(|&degree| coefficient_count(degree) == count)
        .ok_or(GenerationError::Count { found: count })
}

/// N (N + 2).
pub(crate) fn coefficient_count(degree: u8) -> usize {
    usize::from(degree) * (usize::from(degree) + 2)
}

pub(crate) fn check_epoch(year: u16) -> Result<(), GenerationError> {
    if EPOCHS.contains(&year) { Ok(()) } else { Err(GenerationError::Epoch { year }) }
}

pub(crate) fn check_main(index: usize, value_nt: f64) -> Result<(), GenerationError> {
    let plausible = if index == 0 { DIPOLE_NT } else { 0.0..=HIGHEST_COEFFICIENT_NT };
    if plausible.contains(&value_nt.abs()) {
        Ok(())
    } else {
        Err(GenerationError::Coefficient { index, value_nt })
    }
}

pub(crate) fn check_variation(index: usize, value_nt_per_year: f64) -> Result<(), GenerationError> {
    if value_nt_per_year.abs() <= HIGHEST_VARIATION_NT_PER_YEAR {
        Ok(())
    } else {
        Err(GenerationError::Variation { index, value_nt_per_year })
    }
}

impl fmt::Display for GenerationError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Count { found } => {
                write!(f, "{found} coefficients are no full set of degree 1 to {HIGHEST_DEGREE}")
            }
            Self::Degree { found } => write!(f, "degree {found} is outside 1 to {HIGHEST_DEGREE}"),
            Self::Epoch { year } => write!(f, "epoch {year} is outside 1900 to 2200"),
            Self::Coefficient { index, value_nt } => {
                write!(f, "coefficient {index} cannot be {value_nt} nT")
            }
            Self::Variation { index, value_nt_per_year } => {
                write!(f, "variation {index} cannot be {value_nt_per_year} nT a year")
            }
            Self::Length { found, expected } => {
                write!(f, "{found} bytes where {expected} are needed")
            }
            Self::Version { found } => write!(f, "format {found} is not known"),
            Self::Checksum { stored, computed } => {
                write!(f, "CRC-32 is {stored:#010x}, computed {computed:#010x}")
            }
        }
    }
}

impl core::error::Error for GenerationError {}
