//! Whatever bytes come in: no panic, and a table goes out.

use adcs_ground::columns::field::Field;
use adcs_ground::columns::frames::Frames;
use adcs_ground::columns::propagate::Propagate;
use adcs_ground::columns::sun::Sun;
use adcs_ground::table::{Failure, Header, RowCommand, Rows, Tally, convert};
use adcs_ground::tle_file::Checksum;
use proptest::prelude::*;

type Bind = fn(&Header) -> Result<Box<dyn RowCommand>, Failure>;

const COMMANDS: [(&str, Bind); 6] = [
    ("line1,line2,tsince_min", |header| Ok(Box::new(Propagate::bind(header, Checksum::Verify)?))),
    ("line1,line2,tsince_min", |header| Ok(Box::new(Propagate::bind(header, Checksum::Ignore)?))),
    ("decimal_year,geodetic_lat_deg,lon_east_deg,height_above_wgs84_km", |header| {
        Ok(Box::new(Field::<f64>::bind(header, 13)?))
    }),
    ("utc_iso,geodetic_lat_deg,lon_east_deg,height_above_wgs84_km", |header| {
        Ok(Box::new(Field::<f32>::bind(header, 3)?))
    }),
    ("utc_iso", |header| Ok(Box::new(Sun::bind(header)?))),
    (
        "ut1_jd_day,ut1_jd_fraction,teme_x_km,teme_y_km,teme_z_km,teme_vx_km_s,teme_vy_km_s,\
         teme_vz_km_s",
        |header| Ok(Box::new(Frames::bind(header)?)),
    ),
];

/// The output and its tally; `None` when the header is refused.
fn run(bind: Bind, input: &[u8]) -> Option<(Vec<u8>, Tally, u64)> {
    let mut rows = Rows::new(input).ok()?;
    let mut command = bind(rows.header()).ok()?;
    let mut output = Vec::new();
    let mut reported = 0;
    let tally =
        convert(&mut rows, command.as_mut(), &mut output, &mut |_| reported += 1).expect("memory");
    Some((output, tally, reported))
}

/// A table with as many rows as were read, whose number columns hold numbers.
fn check(output: &[u8], tally: Tally, reported: u64) -> Result<(), TestCaseError> {
    let mut reader = csv::Reader::from_reader(output);
    let header = reader.byte_headers().expect("a header").clone();
    let mut rows = 0;
    let mut bad = 0;
    for row in reader.byte_records() {
        let row = row.expect("as many fields as the header has");
        rows += 1;
        let cell = |name: &[u8]| {
            header.iter().rposition(|other| other == name).and_then(|index| row.get(index))
        };
        let error = cell(b"error").expect("a column error");
        bad += u64::from(!matches!(error, b"" | b"0"));
        for name in [&b"sun_tod_x"[..], b"B_total_nT", b"gmst82_rad", b"x_teme_km"] {
            if let Some(text) = cell(name) {
                let number: f64 = str::from_utf8(text).unwrap().parse().unwrap();
                prop_assert_eq!(number.is_finite(), matches!(error, b"" | b"0"));
            }
        }
    }
    prop_assert_eq!((rows, bad, bad), (tally.rows, tally.bad, reported));
    Ok(())
}

/// Fields as they come, good and bad.
fn field() -> impl Strategy<Value = Vec<u8>> {
    let known = [
        "1 39770U 14029E   15086.04060623  .00002013  00000-0  25056-3 0  9990",
        "2 39770  97.8670 184.0112 0011259 108.3774 251.8661 14.83565425 45450",
        "1 11801U          80230.29629788  .01431103  00000-0  14311-1      13",
        "2 11801  46.7916 230.4354 7318036  47.4722  10.4117  2.28537848    13",
        "2015-03-27T02:00:00Z",
        "9999-12-31T23:59:59.999999Z",
        "0001-01-01T00:00:00Z",
        "2020.5",
        "2453101.5",
        "-90",
        "7000",
        "1e308",
        "-1e308",
        "5e-324",
        "NaN",
        "inf",
        "-0",
        "",
        " ",
        "\"",
        "\"\"",
        "\"a,b\"",
        "\"a\nb\"",
        "\"open",
    ];
    prop_oneof![
        8 => prop::sample::select(known.to_vec()).prop_map(|text| text.as_bytes().to_vec()),
        2 => any::<f64>().prop_map(|number| number.to_string().into_bytes()),
        1 => prop::collection::vec(any::<u8>(), 0..8),
    ]
}

/// Rows of some fields, often as many as eight columns need.
fn body() -> impl Strategy<Value = Vec<u8>> {
    let row =
        prop_oneof![prop::collection::vec(field(), 0..10), prop::collection::vec(field(), 4..5)];
    prop::collection::vec(row, 0..12).prop_map(|rows| {
        let rows: Vec<_> = rows.into_iter().map(|fields| fields.join(&b',')).collect();
        rows.join(&b"\n"[..])
    })
}

/// A TLE with some bytes changed, now and then.
fn satellite_rows() -> impl Strategy<Value = Vec<u8>> {
    let change = (0..139_usize, any::<u8>());
    (prop::collection::vec(change, 0..3), any::<f64>(), -1e7..1e7_f64).prop_map(
        |(changes, wild, minutes)| {
            let mut tle = b"1 39770U 14029E   15086.04060623  .00002013  00000-0  25056-3 0  9990,\
                            2 39770  97.8670 184.0112 0011259 108.3774 251.8661 14.83565425 45450"
                .to_vec();
            for (at, byte) in changes {
                tle[at] = byte;
            }
            let mut rows = Vec::new();
            for minutes in [0.0, minutes, wild] {
                rows.extend_from_slice(&tle);
                rows.extend_from_slice(format!(",{minutes}\n").as_bytes());
            }
            rows
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_bytes_are_a_table_or_are_refused(
        bytes in prop::collection::vec(any::<u8>(), 0..300),
        command in 0..COMMANDS.len(),
    ) {
        let (_, bind) = COMMANDS[command];
        if let Some((output, tally, reported)) = run(bind, &bytes) {
            check(&output, tally, reported)?;
        }
    }

    #[test]
    fn any_rows_below_a_good_header_come_out_as_rows(
        body in prop_oneof![3 => body(), 1 => prop::collection::vec(any::<u8>(), 0..200)],
        command in 0..COMMANDS.len(),
        extra in prop::sample::select(vec!["", ",id", ",error", ",error,input_error", ",\"a,b\""]),
    ) {
        let (header, bind) = COMMANDS[command];
        let mut input = format!("{header}{extra}\r\n").into_bytes();
        input.extend_from_slice(&body);
        let (output, tally, reported) = run(bind, &input).expect("the header is good");
        check(&output, tally, reported)?;
    }

    #[test]
    fn any_tle_and_time_has_a_state_or_an_error(rows in satellite_rows(), lenient: bool) {
        let (header, bind) = COMMANDS[usize::from(lenient)];
        let input = [header.as_bytes(), b"\n", &rows].concat();
        let (output, tally, reported) = run(bind, &input).expect("the header is good");
        check(&output, tally, reported)?;
    }
}
