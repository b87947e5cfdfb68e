//! Two-line elements: what is read, and what is refused where.

mod common;

use common::{GOOD, rows, with_text};
use sgp4_lite::{
    Classification, Element, Elements, Epoch, Expected, InternationalDesignator, TleError, TleText,
};

#[test]
fn fields_of_the_synthetic_sets_are_decoded_exactly() {
    for row in rows(common::LEO_TLE).into_iter().chain(rows(common::DEEP_TLE)) {
        let elements = Elements::from_tle(row.text("line1"), row.text("line2")).unwrap();
        let number = |column| row.number(column);
        assert_eq!(f64::from(elements.norad_id), number("satnum"));
        assert_eq!(f64::from(elements.epoch.year()), number("epoch_year"));
        assert_eq!(elements.mean_motion_dot_over_2_rev_per_day2, number("ndot_over2_rev_per_day2"));
        assert_eq!(
            elements.mean_motion_ddot_over_6_rev_per_day3,
            number("nddot_over6_rev_per_day3")
        );
        assert_eq!(elements.bstar_per_earth_radius, number("bstar_per_earth_radius"));
        assert_eq!(f64::from(elements.element_set_number), number("elset"));
        assert_eq!(elements.inclination_deg, number("inclination_deg"));
        assert_eq!(elements.raan_deg, number("raan_deg"));
        assert_eq!(elements.eccentricity, number("eccentricity"));
        assert_eq!(elements.argument_of_perigee_deg, number("arg_perigee_deg"));
        assert_eq!(elements.mean_anomaly_deg, number("mean_anomaly_deg"));
        assert_eq!(elements.mean_motion_rev_per_day, number("mean_motion_rev_per_day"));
        assert_eq!(f64::from(elements.revolution_number), number("rev_number"));
        let (midnight, fraction) = elements.epoch.julian_date();
        assert_eq!((midnight, fraction), (number("epoch_jd_day"), number("epoch_jd_fraction")));
        let day = f64::from(elements.epoch.day_of_year()) + fraction;
        assert!((day - number("epoch_day")).abs() < 1e-12);
    }
}

#[test]
fn a_whole_record_is_read() {
    let elements = Elements::from_tle(GOOD[0], GOOD[1]).unwrap();
    let expected = Elements {
        norad_id: 41001,
        classification: Classification::Unclassified,
        international_designator: InternationalDesignator::from_columns(*b"24001BC ").unwrap(),
        epoch: Epoch::from_day_of_year(2021, 122, 17_684_994 * 864).unwrap(),
        mean_motion_dot_over_2_rev_per_day2: -0.000_030_12,
        mean_motion_ddot_over_6_rev_per_day3: 0.0,
        bstar_per_earth_radius: 0.000_166_85,
        inclination_deg: 98.325,
        raan_deg: 156.3788,
        eccentricity: 0.000_861_4,
        argument_of_perigee_deg: 60.6878,
        mean_anomaly_deg: 66.8195,
        mean_motion_rev_per_day: 14.457_539_39,
        element_set_number: 9585,
        revolution_number: 37106,
    };
    assert_eq!(elements, expected);
}

#[test]
fn the_verification_set_is_read_but_for_its_wrong_checksums() {
    for row in rows(common::VALLADO_TLE) {
        let (line1, line2) = (row.text("line1"), row.text("line2"));
        let strict = Elements::from_tle(line1, line2);
        let lenient = Elements::from_tle_lenient(line1, line2);
        match (row.text("line1_checksum_ok"), row.text("line2_checksum_ok")) {
            ("1", "1") => {
                assert!(strict.is_ok(), "{line1}: {strict:?}");
                assert_eq!(strict, lenient);
            }
            (line1_ok, _) => {
                let wrong_line = if line1_ok == "1" { 2 } else { 1 };
                let refused = |line| matches!(strict, Err(TleError::Checksum { line: found, .. }) if found == line);
                assert!(refused(wrong_line), "{line1}: {strict:?}");
                assert!(lenient.is_ok(), "{line1}: {lenient:?}");
            }
        }
    }
}

#[test]
fn a_foreign_character_is_named_with_its_line_and_column() {
    for line in [1, 2] {
        for column in 1..=69_u8 {
            for foreign in [b'?', b'\t', 0, 0x80, 0xFF, b'x'] {
                let mut lines = GOOD.map(|line| line.as_bytes().to_vec());
                lines[line - 1][usize::from(column) - 1] = foreign;
                let line = line as u8;
                match Elements::from_tle(&lines[0], &lines[1]) {
                    Err(TleError::LineNumber { line: at, found }) => {
                        assert_eq!((at, found, column), (line, foreign, 1));
                    }
                    Err(TleError::Character { line: at_line, column: at, found, .. }) => {
                        assert_eq!((at_line, at, found), (line, column, foreign));
                    }
                    other => panic!("line {line}, column {column}: {other:?}"),
                }
            }
        }
    }
}

/// Of all ways to change one character, those remain that do not change the orbit: a leading zero
/// for a blank, a plus for a blank, the type 0 for a blank; and letters, which no checksum covers.
#[test]
fn no_single_wrong_character_changes_the_orbit() {
    let tles: Vec<_> = rows(common::LEO_TLE).into_iter().chain(rows(common::DEEP_TLE)).collect();
    for row in tles {
        let lines = [row.text("line1"), row.text("line2")];
        let original = Elements::from_tle(lines[0], lines[1]).unwrap();
        for line in 0..2 {
            for column in 0..69 {
                for byte in 0..=u8::MAX {
                    let mut spoilt = lines.map(|line| line.as_bytes().to_vec());
                    spoilt[line][column] = byte;
                    if let Ok(mut elements) = Elements::from_tle(&spoilt[0], &spoilt[1]) {
                        elements.classification = original.classification;
                        elements.international_designator = original.international_designator;
                        assert_eq!(elements, original, "line {line}, column {column}, {byte}");
                    }
                }
            }
        }
    }
}

#[test]
fn a_wrong_checksum_is_named_with_the_right_one() {
    for wrong in (0..=9).filter(|digit| *digit != 5) {
        let line1 = format!("{}{wrong}", &GOOD[0][..68]);
        let expected = TleError::Checksum { line: 1, expected: 5, found: wrong };
        assert_eq!(Elements::from_tle(&line1, GOOD[1]), Err(expected));
        assert_eq!(
            Elements::from_tle_lenient(&line1, GOOD[1]),
            Elements::from_tle(GOOD[0], GOOD[1])
        );
    }
}

#[test]
fn the_lenient_entry_lets_nothing_but_the_checksum_pass() {
    let refused = |line1: &str, line2: &str| {
        let lenient = Elements::from_tle_lenient(line1, line2);
        assert!(lenient.is_err());
        assert_eq!(lenient, Elements::from_tle(line1, line2));
    };
    refused(&GOOD[0].replace('.', ","), GOOD[1]);
    refused(&format!("{}x", &GOOD[0][..68]), GOOD[1]);
    refused(GOOD[0], &with_text(GOOD[1], 9, "180.0001"));
    refused(GOOD[0], &GOOD[1][..68]);
}

#[test]
fn lines_of_other_lengths_are_refused() {
    for length in (0..69).chain(70..140) {
        let mut other = GOOD[0].to_owned();
        other.extend(std::iter::repeat_n(' ', 100));
        let line1 = &other[..length];
        assert_eq!(
            Elements::from_tle(line1, GOOD[1]),
            Err(TleError::Length { line: 1, found: length })
        );
    }
    assert_eq!(Elements::from_tle(GOOD[0], ""), Err(TleError::Length { line: 2, found: 0 }));
}

#[test]
fn lines_in_wrong_order_are_refused() {
    assert_eq!(
        Elements::from_tle(GOOD[1], GOOD[0]),
        Err(TleError::LineNumber { line: 1, found: b'2' })
    );
}

#[test]
fn lines_of_two_satellites_are_refused() {
    let other = with_text(GOOD[1], 3, "41002");
    assert_eq!(
        Elements::from_tle(GOOD[0], other),
        Err(TleError::SatelliteNumber { line1: 41001, line2: 41002 })
    );
}

#[test]
fn values_out_of_range_are_refused_with_their_columns() {
    let line2_cases = [
        (9, "180.0001", Element::Inclination, 16, 180.0001),
        (18, "360.0001", Element::Raan, 25, 360.0001),
        (35, "999.9999", Element::ArgumentOfPerigee, 42, 999.9999),
        (44, "360.0001", Element::MeanAnomaly, 51, 360.0001),
        (53, " 0.00000000", Element::MeanMotion, 63, 0.0),
        (53, "18.00000001", Element::MeanMotion, 63, 18.000_000_01),
    ];
    for (first_column, text, element, last_column, value) in line2_cases {
        let line2 = with_text(GOOD[1], usize::from(first_column), text);
        let expected = TleError::Range { element, line: 2, first_column, last_column, value };
        assert_eq!(Elements::from_tle(GOOD[0], line2), Err(expected));
    }
}

#[test]
fn limits_of_the_ranges_are_accepted() {
    for (column, text) in [
        (9, "  0.0000"),
        (9, "180.0000"),
        (18, "  0.0000"),
        (18, "360.0000"),
        (27, "0000000"),
        (27, "9999999"),
        (35, "360.0000"),
        (44, "000.0000"),
        (53, " 0.00000001"),
        (53, "18.00000000"),
        (64, "    0"),
    ] {
        let line2 = with_text(GOOD[1], column, text);
        assert!(Elements::from_tle(GOOD[0], &line2).is_ok(), "{line2}");
    }
}

#[test]
fn epochs_run_from_1957_to_2056() {
    for (text, year, day) in [
        ("57001.00000000", 1957, 1),
        ("99365.99999999", 1999, 365),
        ("00366.50000000", 2000, 366),
        ("56366.00000000", 2056, 366),
        ("21  1.00000000", 2021, 1),
    ] {
        let elements = Elements::from_tle(with_text(GOOD[0], 19, text), GOOD[1]).unwrap();
        assert_eq!((elements.epoch.year(), elements.epoch.day_of_year()), (year, day));
    }
}

#[test]
fn days_that_the_year_does_not_have_are_refused() {
    for (text, year, day) in [
        ("21000.99999999", 2021, 0),
        ("21366.00000000", 2021, 366),
        ("20367.00000000", 2020, 367),
        ("21999.00000000", 2021, 999),
    ] {
        let line1 = with_text(GOOD[0], 19, text);
        assert_eq!(Elements::from_tle(line1, GOOD[1]), Err(TleError::DayOfYear { year, day }));
    }
}

#[test]
fn ephemeris_types_of_other_theories_are_refused() {
    for accepted in [" ", "0", "2"] {
        assert!(Elements::from_tle(with_text(GOOD[0], 63, accepted), GOOD[1]).is_ok());
    }
    for other in ["1", "3", "4", "5", "9"] {
        let found = other.as_bytes()[0];
        let line1 = with_text(GOOD[0], 63, other);
        assert_eq!(Elements::from_tle(line1, GOOD[1]), Err(TleError::EphemerisType { found }));
    }
}

#[test]
fn satellite_numbers_may_be_alpha5_but_not_with_i_or_o() {
    let read = |text: &str| {
        Elements::from_tle(with_text(GOOD[0], 3, text), with_text(GOOD[1], 3, text))
            .map(|elements| elements.norad_id)
    };
    assert_eq!(read("    5"), Ok(5));
    assert_eq!(read("00005"), Ok(5));
    assert_eq!(read("99999"), Ok(99_999));
    assert_eq!(read("A0000"), Ok(100_000));
    assert_eq!(read("J2931"), Ok(182_931));
    assert_eq!(read("Z9999"), Ok(339_999));
    for (text, column, expected) in [
        ("I0000", 3, Expected::SatelliteNumber),
        ("O0000", 3, Expected::SatelliteNumber),
        ("a0000", 3, Expected::SatelliteNumber),
        ("A 000", 4, Expected::Digit),
        ("0A000", 4, Expected::Digit),
        ("5 000", 4, Expected::Digit),
        ("     ", 7, Expected::Digit),
        ("  5 5", 6, Expected::Digit),
    ] {
        let found = text.as_bytes()[usize::from(column) - 3];
        assert_eq!(read(text), Err(TleError::Character { line: 1, column, found, expected }));
    }
}

#[test]
fn signs_and_exponents_are_read() {
    for (text, value) in [
        (" 12345-3", 0.123_45e-3),
        ("+12345-3", 0.123_45e-3),
        ("-12345-3", -0.123_45e-3),
        (" 12345+0", 0.123_45),
        (" 12345+9", 0.123_45e9),
        (" 00001-9", 0.000_01e-9),
        ("-00000-0", -0.0),
    ] {
        let elements = Elements::from_tle(with_text(GOOD[0], 54, text), GOOD[1]).unwrap();
        assert_eq!(elements.bstar_per_earth_radius, value, "{text}");
        let elements = Elements::from_tle(with_text(GOOD[0], 45, text), GOOD[1]).unwrap();
        assert_eq!(elements.mean_motion_ddot_over_6_rev_per_day3, value, "{text}");
    }
}

#[test]
fn texts_of_two_or_three_lines_are_read() {
    let expected = Elements::from_tle(GOOD[0], GOOD[1]);
    let [line1, line2] = GOOD;
    for text in [
        format!("{line1}\n{line2}"),
        format!("{line1}\n{line2}\n"),
        format!("{line1}\r\n{line2}\r\n"),
        format!("SPROUT\n{line1}\n{line2}\n"),
        format!("0 SPROUT\r\n{line1}\r\n{line2}\r\n\r\n"),
    ] {
        assert_eq!(Elements::from_tle_text(&text), expected, "{text:?}");
    }
    assert_eq!(TleText::split(b"0 A B \nx\ny").unwrap().name, Some("A B"));
    for text in [
        format!("\n{line1}\n{line2}"),
        format!("{line1}\r{line2}"),
        format!("{line1} \n{line2}"),
        format!("{line1}\n\n{line2}"),
        format!("\u{feff}{line1}\n{line2}"),
        format!("n\u{e4}me\n{line1}\n{line2}"),
        format!("{line1}\n{line2}\n{line1}\n{line2}\n"),
    ] {
        assert!(Elements::from_tle_text(&text).is_err(), "{text:?}");
    }
}

#[test]
fn messages_say_what_is_wrong_where() {
    let message =
        |line1: &str, line2: &str| Elements::from_tle(line1, line2).unwrap_err().to_string();
    assert_eq!(
        message(&GOOD[0].replacen('.', "5", 1), GOOD[1]),
        "line 1, column 24: expected a decimal point, found '5'"
    );
    assert_eq!(
        message(GOOD[0], &with_text(GOOD[1], 9, "181.0000")),
        "line 2, columns 9 to 16: inclination (deg) is out of range: 181"
    );
    assert_eq!(
        message(&GOOD[0].replace("95855", "95857"), GOOD[1]),
        "line 1, column 69: the checksum is 7, but the line sums up to 5"
    );
}
