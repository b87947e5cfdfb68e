//! A generation travels as bytes: nothing damaged and nothing implausible is taken for a field.
#![cfg(feature = "uplink")]

use igrf::{Coefficients, DecimalYear, Error, Generation, GenerationError, MAX_ENCODED_BYTES};
use proptest::prelude::*;

/// Bytes of degree 13 with a variation of degree 8, by the table in `uplink.rs`:
/// 5 + 3 · 195 + 2 · 80 + 4.
const IGRF_14_BYTES: usize = 754;

/// Epoch 2025 with its secular variation, read from the official file.
fn igrf_14() -> Generation {
    let rows: Vec<Vec<f64>> = include_str!("../data/igrf14coeffs.txt")
        .lines()
        .skip(4)
        .map(|line| line.split_whitespace().skip(3).map(|field| field.parse().unwrap()).collect())
        .collect();
    let main: Vec<f64> = rows.iter().map(|row| row[25]).collect();
    let variation: Vec<f64> = rows.iter().take(80).map(|row| row[26]).collect();
    Generation::new(2025, &main, &variation).unwrap()
}

fn encoded(generation: &Generation) -> Vec<u8> {
    let mut buffer = [0; MAX_ENCODED_BYTES];
    let length = generation.encode(&mut buffer).unwrap();
    assert_eq!(length, generation.encoded_bytes());
    buffer[..length].to_vec()
}

/// Replaces the checksum by the right one, computed bit by bit.
fn with_right_checksum(mut bytes: Vec<u8>) -> Vec<u8> {
    bytes.truncate(bytes.len() - 4);
    let mut crc = u32::MAX;
    for &byte in &bytes {
        crc ^= u32::from(byte);
        for _ in 0..8 {
            crc = if crc & 1 == 1 { crc >> 1 ^ 0xedb8_8320 } else { crc >> 1 };
        }
    }
    bytes.extend_from_slice(&(!crc).to_le_bytes());
    bytes
}

#[test]
fn an_uplinked_generation_is_the_built_in_model_bit_for_bit() {
    let bytes = encoded(&igrf_14());
    assert_eq!(bytes.len(), IGRF_14_BYTES);
    let received = Generation::decode(&bytes).unwrap();
    assert_eq!(received, igrf_14());
    for year in [2025.0, 2026.3, 2030.0].map(DecimalYear) {
        assert_eq!(
            Coefficients::<f64>::from_generation(&received, year),
            Coefficients::<f64>::at(year)
        );
    }
}

#[test]
fn format_is_what_the_documentation_says() {
    let main = [-29350.25, -1410.3, 4545.5];
    let generation = Generation::new(2030, &main, &[12.6, 10.0, -21.5]).unwrap();
    let mut expected = vec![1, 0xee, 0x07, 1, 1];
    expected.extend_from_slice(&(-2_935_025_i32).to_le_bytes()[..3]);
    expected.extend_from_slice(&(-141_030_i32).to_le_bytes()[..3]);
    expected.extend_from_slice(&454_550_i32.to_le_bytes()[..3]);
    for rate in [1260_i16, 1000, -2150] {
        expected.extend_from_slice(&rate.to_le_bytes());
    }
    expected.extend_from_slice(&[0; 4]);
    assert_eq!(encoded(&generation), with_right_checksum(expected));
}

#[test]
fn a_generation_is_valid_for_five_years_and_up_to_its_degree() {
    let generation = Generation::new(2030, &[-29_000.0, -1_300.0, 4_400.0], &[10.0, 9.0, -20.0]);
    let generation = generation.unwrap();
    let at = |year| Coefficients::<f32>::from_generation(&generation, DecimalYear(year));
    assert_eq!(at(2030.0).unwrap().degree(), 1);
    assert!(at(2035.0).is_ok());
    for decimal_year in [2029.999, 2035.001] {
        let refused = Error::Date { decimal_year, first: 2030.0, last: 2035.0 };
        assert_eq!(at(decimal_year), Err(refused));
    }
    assert!(at(f64::NAN).is_err());
    let refused = Err(Error::Degree { requested: 2, highest: 1 });
    assert_eq!(at(2030.0).unwrap().with_degree(2), refused);
}

#[test]
fn secular_variation_moves_the_field_by_its_rate() {
    /// nT; the rates below are exact in hundredths.
    const TOLERANCE_NT: f64 = 1e-9;

    let generation = Generation::new(2030, &[-29_000.0, 0.0, 0.0], &[10.0, 0.0, 0.0]).unwrap();
    let down_at_the_pole = |year| {
        let coefficients = Coefficients::<f64>::from_generation(&generation, DecimalYear(year));
        coefficients.unwrap().field_ecef_nt([0.0, 0.0, igrf::REFERENCE_RADIUS_KM]).unwrap()[2]
    };
    assert!((down_at_the_pole(2030.0) - -58_000.0).abs() < TOLERANCE_NT);
    assert!((down_at_the_pole(2034.0) - -57_920.0).abs() < TOLERANCE_NT);
}

#[test]
fn every_flipped_bit_is_noticed() {
    let bytes = encoded(&igrf_14());
    for bit in 0..8 * bytes.len() {
        let mut damaged = bytes.clone();
        damaged[bit / 8] ^= 1 << (bit % 8);
        assert!(Generation::decode(&damaged).is_err(), "bit {bit}");
    }
}

#[test]
fn a_wrong_length_is_refused_with_the_right_one() {
    let bytes = encoded(&igrf_14());
    let longer = [&bytes[..], &[0]].concat();
    for wrong in [&bytes[..IGRF_14_BYTES - 1], &longer] {
        let refused = GenerationError::Length { found: wrong.len(), expected: IGRF_14_BYTES };
        assert_eq!(Generation::decode(wrong), Err(refused));
    }
    for short in 0..9 {
        assert!(matches!(
            Generation::decode(&bytes[..short]),
            Err(GenerationError::Length { found, .. }) if found == short
        ));
    }
}

#[test]
fn a_damaged_body_fails_the_checksum() {
    let mut bytes = encoded(&igrf_14());
    bytes[100] ^= 0x10;
    assert!(matches!(Generation::decode(&bytes), Err(GenerationError::Checksum { .. })));
}

#[test]
fn what_is_not_plausible_is_refused_although_the_checksum_is_right() {
    let with = |offset: usize, values: &[u8]| {
        let mut bytes = encoded(&igrf_14());
        bytes[offset..offset + values.len()].copy_from_slice(values);
        Generation::decode(&with_right_checksum(bytes)).unwrap_err()
    };
    assert_eq!(with(0, &[2]), GenerationError::Version { found: 2 });
    assert_eq!(with(1, &[0, 0]), GenerationError::Epoch { year: 0 });
    assert_eq!(with(3, &[0]), GenerationError::Degree { found: 0 });
    assert_eq!(with(3, &[14]), GenerationError::Degree { found: 14 });
    assert_eq!(with(4, &[14]), GenerationError::Degree { found: 14 });
    let dipole = GenerationError::Coefficient { index: 0, value_nt: 0.0 };
    assert_eq!(with(5, &[0, 0, 0]), dipole);
    let index = 1;
    assert!(matches!(
        with(5 + 3 * index, &[0xff, 0xff, 0x7f]),
        GenerationError::Coefficient { index: 1, value_nt } if value_nt > 80_000.0
    ));
    assert!(matches!(
        with(5 + 3 * 195 + 2, &[0xff, 0x7f]),
        GenerationError::Variation { index: 1, value_nt_per_year } if value_nt_per_year > 327.0
    ));
}

#[test]
fn coefficients_that_cannot_be_are_refused_when_a_set_is_made() {
    let rates = [12.6, 10.0, -21.5];
    for g10 in [0.0, 19_999.0, -40_001.0, f64::INFINITY] {
        let refused = GenerationError::Coefficient { index: 0, value_nt: g10 };
        assert_eq!(Generation::new(2030, &[g10, 0.0, 0.0], &rates), Err(refused));
    }
    let main = [-29_350.0, -1_410.3, f64::NAN];
    assert!(matches!(
        Generation::new(2030, &main, &rates),
        Err(GenerationError::Coefficient { index: 2, .. })
    ));
    let main = [-29_350.0, -1_410.3, 4_545.5];
    assert!(matches!(
        Generation::new(2030, &main, &[0.0, f64::NAN, 0.0]),
        Err(GenerationError::Variation { index: 1, .. })
    ));
    assert_eq!(Generation::new(2030, &main, &[]), Err(GenerationError::Count { found: 0 }));
    assert_eq!(
        Generation::new(2030, &[-29_350.0; 4], &rates),
        Err(GenerationError::Count { found: 4 })
    );
    assert_eq!(Generation::new(1899, &main, &rates), Err(GenerationError::Epoch { year: 1899 }));
}

#[test]
fn a_buffer_that_is_too_short_is_refused_with_the_size_it_needs() {
    let refused = GenerationError::Length { found: 10, expected: IGRF_14_BYTES };
    assert_eq!(igrf_14().encode(&mut [0; 10]), Err(refused));
}

proptest! {
    #[test]
    fn any_bytes_are_a_generation_or_an_error(
        bytes in prop::collection::vec(any::<u8>(), 0..1100),
        degrees in (0u8..15, 0u8..15),
    ) {
        let _ = Generation::decode(&bytes);
        // The same with a right header and checksum, so that the body is read too.
        let (n, m) = (usize::from(degrees.0), usize::from(degrees.1));
        let length = 9 + 3 * n * (n + 2) + 2 * m * (m + 2);
        let mut framed = vec![1, 0xee, 0x07, degrees.0, degrees.1];
        framed.extend(bytes.iter().cycle().take(length - 5));
        framed.resize(length, 0);
        let _ = Generation::decode(&with_right_checksum(framed));
    }

    #[test]
    fn what_is_encoded_is_decoded(
        dipole in -39_999.0..-20_001.0,
        others in prop::array::uniform7(-9_999.0..9_999.0),
        rates in prop::array::uniform3(-299.0..299.0),
    ) {
        let main: Vec<f64> = core::iter::once(dipole).chain(others).collect();
        let generation = Generation::new(2035, &main, &rates).unwrap();
        prop_assert_eq!(generation.degree(), 2);
        prop_assert_eq!(generation.variation_degree(), 1);
        prop_assert_eq!(Generation::decode(&encoded(&generation)), Ok(generation));
    }
}
