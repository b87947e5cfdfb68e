//! A generation as bytes, to be sent to a satellite and kept in its storage.
//!
//! | offset | bytes | content, little endian |
//! |---|---|---|
//! | 0 | 1 | format version, 1 |
//! | 1 | 2 | year of the epoch |
//! | 3 | 1 | degree N of the main field, 1 to 13 |
//! | 4 | 1 | degree M of the secular variation, 1 to 13 |
//! | 5 | 3 N (N+2) | main field, signed, hundredths of nT: g(1,0), g(1,1), h(1,1), g(2,0), … |
//! | … | 2 M (M+2) | secular variation, signed, hundredths of nT a year |
//! | last 4 | 4 | CRC-32 (ISO-HDLC: that of Ethernet and zip) of all bytes before |

use crc::{CRC_32_ISO_HDLC, Crc, NoTable};

use crate::coefficients::{COEFFICIENTS, HIGHEST_DEGREE, TABLE_UNIT_NT};
use crate::generation::{
    Generation, GenerationError, check_epoch, check_main, check_variation, coefficient_count,
};

const VERSION: u8 = 1;
const HEADER_BYTES: usize = 5;
const MAIN_BYTES: usize = 3;
const VARIATION_BYTES: usize = 2;
const CRC_BYTES: usize = 4;

/// The longest encoded set: degree 13 in main field and secular variation.
pub const MAX_ENCODED_BYTES: usize =
    HEADER_BYTES + (MAIN_BYTES + VARIATION_BYTES) * COEFFICIENTS + CRC_BYTES;

/// Sets are decoded once in years: a table would cost a kilobyte of flash for nothing.
const CRC_32: Crc<u32, NoTable> = Crc::<u32, NoTable>::new(&CRC_32_ISO_HDLC);

impl Generation {
    /// The number of bytes that [`encode`](Self::encode) writes: 754 for IGRF-14.
    pub fn encoded_bytes(&self) -> usize {
        encoded_bytes(self.degree, self.variation_degree)
    }

    /// Writes the encoded set to the start of `buffer` and returns its length.
    ///
    /// # Errors
    /// [`GenerationError::Length`] when it does not fit; [`MAX_ENCODED_BYTES`] always do.
    pub fn encode(&self, buffer: &mut [u8]) -> Result<usize, GenerationError> {
        let expected = self.encoded_bytes();
        let too_short = GenerationError::Length { found: buffer.len(), expected };
        let encoded = buffer.get_mut(..expected).ok_or(too_short)?;
        let (content, checksum) = encoded.split_last_chunk_mut::<CRC_BYTES>().ok_or(too_short)?;
        let (header, body) = content.split_first_chunk_mut::<HEADER_BYTES>().ok_or(too_short)?;

        let [year_low, year_high] = self.epoch_year.to_le_bytes();
        *header = [VERSION, year_low, year_high, self.degree, self.variation_degree];
        let main = self.main_hundredths.iter().take(coefficient_count(self.degree));
        let main = main.flat_map(|value| value.to_le_bytes().into_iter().take(MAIN_BYTES));
        let variation =
            self.variation_hundredths.iter().take(coefficient_count(self.variation_degree));
        let variation = variation.flat_map(|value| value.to_le_bytes());
        for (slot, byte) in body.iter_mut().zip(main.chain(variation)) {
            *slot = byte;
        }
        *checksum = CRC_32.checksum(content).to_le_bytes();
        Ok(expected)
    }

    /// Reads an encoded set.
    ///
    /// # Errors
    /// [`GenerationError::Version`], [`Degree`](GenerationError::Degree),
    /// [`Length`](GenerationError::Length) (it must be exact),
    /// [`Checksum`](GenerationError::Checksum), and what is not plausible although the checksum
    /// is right: [`Epoch`](GenerationError::Epoch), [`Coefficient`](GenerationError::Coefficient),
    /// [`Variation`](GenerationError::Variation).
    pub fn decode(bytes: &[u8]) -> Result<Self, GenerationError> {
        let found = bytes.len();
        let shortest = GenerationError::Length { found, expected: encoded_bytes(1, 1) };
        let (content, checksum) = bytes.split_last_chunk::<CRC_BYTES>().ok_or(shortest)?;
        let (header, body) = content.split_first_chunk::<HEADER_BYTES>().ok_or(shortest)?;
        let [version, year_low, year_high, degree, variation_degree] = *header;
        if version != VERSION {
            return Err(GenerationError::Version { found: version });
        }
        for found in [degree, variation_degree] {
            if !(1..=HIGHEST_DEGREE).contains(&found) {
                return Err(GenerationError::Degree { found });
            }
        }
        let expected = encoded_bytes(degree, variation_degree);
        if found != expected {
            return Err(GenerationError::Length { found, expected });
        }
        let (stored, computed) = (u32::from_le_bytes(*checksum), CRC_32.checksum(content));
        if stored != computed {
            return Err(GenerationError::Checksum { stored, computed });
        }
        let epoch_year = u16::from_le_bytes([year_low, year_high]);
        check_epoch(epoch_year)?;
        let mut generation = Self::empty(epoch_year, degree, variation_degree);
        generation.read_coefficients(body)?;
        Ok(generation)
    }

    fn read_coefficients(&mut self, body: &[u8]) -> Result<(), GenerationError> {
        let (main, variation) =
            body.split_at_checked(MAIN_BYTES * coefficient_count(self.degree)).unwrap_or_default();
        let (main, _) = main.as_chunks::<MAIN_BYTES>();
        for (index, (slot, &[low, middle, high])) in
            self.main_hundredths.iter_mut().zip(main).enumerate()
        {
            // In the upper three bytes first, so that the shift down carries the sign.
            *slot = i32::from_le_bytes([0, low, middle, high]) >> 8;
            check_main(index, f64::from(*slot) * TABLE_UNIT_NT)?;
        }
        let (variation, _) = variation.as_chunks::<VARIATION_BYTES>();
        for (index, (slot, &bytes)) in
            self.variation_hundredths.iter_mut().zip(variation).enumerate()
        {
            *slot = i16::from_le_bytes(bytes);
            check_variation(index, f64::from(*slot) * TABLE_UNIT_NT)?;
        }
        Ok(())
    }
}

fn encoded_bytes(degree: u8, variation_degree: u8) -> usize {
    HEADER_BYTES
        + MAIN_BYTES * coefficient_count(degree)
        + VARIATION_BYTES * coefficient_count(variation_degree)
        + CRC_BYTES
}
