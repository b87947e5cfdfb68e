//! Tables as they should not be.

use crate::common::{Run, adcs};

/// The commands on tables, each with a header it accepts.
const COMMANDS: [(&str, &str); 4] = [
    ("propagate", "line1,line2,tsince_min"),
    ("field", "decimal_year,geodetic_lat_deg,lon_east_deg,height_above_wgs84_km"),
    ("sun", "utc_iso"),
    ("frames", "utc_iso,teme_x_km,teme_y_km,teme_z_km,teme_vx_km_s,teme_vy_km_s,teme_vz_km_s"),
];

fn sun(table: impl Into<Vec<u8>>) -> Run {
    adcs(["sun", "-"], table)
}

/// The errors in the rows.
fn errors(run: &Run) -> Vec<String> {
    run.table().rows.iter().map(|row| row["error"].clone()).collect()
}

#[test]
fn a_bad_row_says_why_and_the_others_are_computed() {
    let run = sun("note,utc_iso\n\
                   a,2015-03-27T02:00:00Z\n\
                   \"b,\"\"c\"\"\",yesterday\n\
                   d,2015-03-27T02:00:00Z\n");
    assert_eq!(run.code, Some(1));
    let table = run.table();
    assert_eq!(table.rows[0]["error"], "");
    assert_eq!(table.rows[0]["sun_tod_x"], table.rows[2]["sun_tod_x"]);
    assert!(table.rows[1]["error"].starts_with("column utc_iso: 'yesterday': not a UTC instant"));
    for column in ["sun_tod_x", "sun_teme_z", "distance_au"] {
        assert_eq!(table.rows[1][column], "nan");
    }
    assert_eq!(table.rows[1]["note"], "b,\"c\"", "carried through");
    let messages: Vec<_> = run.stderr.lines().collect();
    assert_eq!(messages.len(), 2, "{messages:?}");
    assert!(messages[0].starts_with("standard input, line 3, column utc_iso: 'yesterday'"));
    assert_eq!(messages[1], "standard input: 1 of 3 rows have no result");
}

#[test]
fn a_missing_column_is_named_with_those_that_are_there() {
    for (command, header) in COMMANDS {
        for missing in header.split(',') {
            let without = header.replace(missing, "spare");
            let run = adcs([command, "-"], format!("{without}\n"));
            assert_eq!(run.code, Some(2));
            assert_eq!(run.stdout, b"");
            assert!(run.stderr.contains(&format!("no column {missing}")), "{}", run.stderr);
            assert!(run.stderr.contains(&without.replace(',', ", ")), "{}", run.stderr);
        }
    }
}

#[test]
fn a_table_of_a_header_alone_gives_a_header_alone() {
    for (command, header) in COMMANDS {
        let run = adcs([command, "-"], header);
        assert_eq!((run.code, run.stderr.as_str()), (Some(0), ""));
        assert!(run.table().rows.is_empty());
    }
}

#[test]
fn empty_files_other_encodings_and_other_separators_are_named() {
    for (text, reason) in [
        (&b""[..], "empty"),
        (b"\n\r\n", "empty"),
        (b"\xFF\xFEu\0t\0c\0", "UTF-16"),
        (b"id;utc_iso\n1;2\n", "separated by semicolons"),
        (b"id\tutc_iso\n1\t2\n", "separated by tabs"),
        (b"utc_iso,id,utc_iso\n", "column utc_iso stands twice, at 1 and at 3"),
        (b"utc_iso,\"id\n2015\n", "a quotation mark is not closed"),
        (b"\xFF\x00\xC3\x28", "no column utc_iso"),
    ] {
        let run = sun(text);
        assert_eq!((run.code, run.stdout.len()), (Some(2), 0), "{text:?}");
        assert!(run.stderr.contains(reason), "{text:?}: {}", run.stderr);
    }
}

#[test]
fn line_ends_byte_order_mark_blanks_and_quotes_change_nothing() {
    let plain = sun("id,utc_iso\n1,2015-03-27T02:00:00Z\n2,2016-03-27T02:00:00.5Z\n");
    assert_eq!(plain.code, Some(0));
    for variant in [
        "id,utc_iso\r\n1,2015-03-27T02:00:00Z\r\n2,2016-03-27T02:00:00.5Z",
        "\u{FEFF}id,utc_iso\n1,2015-03-27T02:00:00Z\n\n2,2016-03-27T02:00:00.5Z\n\n",
        "\"id\",\"utc_iso\"\n\"1\",\"2015-03-27T02:00:00Z\"\n2,\"2016-03-27T02:00:00.5Z\"\n",
    ] {
        let run = sun(variant);
        assert_eq!(run.code, Some(0), "{variant}: {}", run.stderr);
        assert_eq!(run.stdout, plain.stdout, "{variant}");
    }
    let blanks = sun("id , utc_iso\n1, 2015-03-27T02:00:00Z \n");
    assert_eq!(blanks.code, Some(0), "{}", blanks.stderr);
}

#[test]
fn ragged_rows_slipped_quotes_and_foreign_bytes_cost_their_own_row() {
    let mut table = b"utc_iso,note\n\
                      2015-03-27T02:00:00Z\n\
                      2015-03-27T02:00:00Z,1,2\n\
                      2015-03-27T02:00:00Z,\"open\n\
                      2015-03-27T02:00:00Z,\"a\"b\n\
                      2015-03-27T02:00:0\xFFZ,x\n\
                      ,x\n\
                      2015-03-27T02:00:00Z,\xFF\xFE\n"
        .to_vec();
    table.extend(vec![b'9'; 3 << 20]);
    table.extend_from_slice(b"\n2015-03-27T02:00:00Z,last\n");
    let run = sun(table);
    assert_eq!(run.code, Some(1));
    let mut reader = csv::Reader::from_reader(run.stdout.as_slice());
    let rows: Vec<_> = reader.byte_records().map(Result::unwrap).collect();
    let error = |row: &csv::ByteRecord| {
        String::from_utf8(row.iter().next_back().unwrap().to_vec()).unwrap()
    };
    let found: Vec<_> = rows.iter().map(error).collect();
    for (found, expected) in found.iter().zip([
        "number of fields: 1, but the header line has 2",
        "number of fields: 3, but the header line has 2",
        "a quotation mark is not closed",
        "text behind a closing quotation mark",
        "column utc_iso: '2015-03-27T02:00:0\u{FFFD}Z' is not UTF-8 text",
        "column utc_iso: nothing stands here",
        "",
        "longer than 1 MiB",
        "",
    ]) {
        assert_eq!(found, expected);
    }
    assert_eq!(rows.len(), 9);
    assert_eq!(&rows[6][1], b"\xFF\xFE", "columns that are not read are carried as they are");
}

#[test]
fn numbers_must_be_finite_numbers() {
    let header = "decimal_year,geodetic_lat_deg,lon_east_deg,height_above_wgs84_km";
    let run = adcs(
        ["field", "-"],
        format!("{header}\nnan,0,0,0\n2020,inf,0,0\n2020,0,0x10,0\n2020,0,0,\"1,5\"\n2020,0,0,\n"),
    );
    assert_eq!(
        errors(&run),
        [
            "column decimal_year: 'nan' is not finite",
            "column geodetic_lat_deg: 'inf' is not finite",
            "column lon_east_deg: '0x10' is not a number",
            "column height_above_wgs84_km: '1,5' is not a number",
            "column height_above_wgs84_km: nothing stands here",
        ]
    );
}

#[test]
fn instants_that_do_not_exist_are_refused() {
    let run = sun("utc_iso\n2015-02-29T00:00:00Z\n2016-12-31T23:59:60Z\n1971-12-31T23:59:59Z\n\
                   2015-03-27 02:00:00\n2015-03-27T02:00:00+09:00\n");
    assert_eq!(run.code, Some(1));
    for (error, reason) in errors(&run).iter().zip([
        "the day 29 does not exist",
        "the second 60 does not exist",
        "before 1972",
        "departs at character 11",
        "departs at character 20",
    ]) {
        assert!(error.contains(reason), "{error}");
    }
}

#[test]
fn what_is_asked_for_wrongly_is_refused() {
    for arguments in [
        &["sun"][..],
        &["propagate"],
        &["propagate", "--tle", "x.tle"],
        &["propagate", "in.csv", "--tle", "x.tle"],
        &["propagate", "in.csv", "--step", "1"],
        &["field", "-", "--degree", "0"],
        &["eclipse", "--tle", "x.tle"],
        &["tle", "check"],
    ] {
        let run = adcs(arguments, "");
        assert_eq!(run.code, Some(2), "{arguments:?}");
        assert!(run.stderr.contains("For more information, try '--help'"), "{}", run.stderr);
    }
}
