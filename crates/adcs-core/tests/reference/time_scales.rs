//! UTC, Unix time, TT and GPS time against reference values (see `tests/data/README.md`).

use crate::table::{Table, Worst};
use adcs_core::time::{LeapSeconds, MICROS_PER_SECOND, Utc};

const REFERENCE: &str = include_str!("../data/time_scales.csv");

/// A Julian date fraction in f64, a day long, resolves 1e-11 s; the sum with its day number, if
/// taken carelessly, 4e-5 s.
const JULIAN_DATE_BAR_S: f64 = 1e-10;
/// Two thousand million seconds in f64 resolve 2.4e-7 s.
const SECONDS_COUNT_BAR_S: f64 = 5e-7;
/// A day of the year in f64 resolves 6e-14.
const DAY_OF_YEAR_BAR: f64 = 1e-12;

#[test]
fn every_scale_agrees_with_the_reference() {
    const SECONDS_PER_DAY: f64 = 86_400.0;
    let table = LeapSeconds::BUILT_IN;
    let mut unix = Worst::new("Unix time, s");
    let mut utc_date = Worst::new("UTC Julian date, s");
    let mut tt_date = Worst::new("TT Julian date, s");
    let mut gps = Worst::new("GPS seconds, s");
    let mut day_of_year = Worst::new("day of year, d");
    for row in Table::parse(REFERENCE).rows() {
        let at = row.text("utc_iso");
        let utc = Utc::parse(at).unwrap();
        let seconds = |micros: i64| micros as f64 / MICROS_PER_SECOND as f64;
        unix.see((seconds(utc.unix_micros()) - row.number("unix_s")).abs(), at);
        assert_eq!(Utc::from_unix_micros(utc.unix_micros()), utc);

        let off_s = |date: adcs_core::time::JulianDate, scale: &str| {
            let day = row.number(&format!("{scale}_jd_day"));
            let fraction = row.number(&format!("{scale}_jd_fraction"));
            (((date.day - day) + (date.fraction - fraction)) * SECONDS_PER_DAY).abs()
        };
        utc_date.see(off_s(utc.julian_date(), "utc"), at);
        let tt = utc.to_tt(&table).unwrap();
        tt_date.see(off_s(tt.julian_date(), "tt"), at);

        let expected = row.number("tai_minus_utc_s");
        assert_eq!(table.tai_minus_utc_s(utc).map(f64::from), Some(expected), "{at}");
        assert_eq!(tt.to_tai().to_utc(&table), Ok(utc), "{at}");

        let gps_s = seconds(utc.to_gps(&table).unwrap().micros_since_1980());
        let expected = row.number("gps_seconds_since_1980_01_06");
        if expected.is_nan() {
            assert!(gps_s < 0.0, "the reference has no GPS time before its origin");
        } else {
            gps.see((gps_s - expected).abs(), at);
        }
        day_of_year.see((utc.day_of_year() - row.number("day_of_year")).abs(), at);
    }
    unix.report(SECONDS_COUNT_BAR_S);
    utc_date.report(JULIAN_DATE_BAR_S);
    tt_date.report(JULIAN_DATE_BAR_S);
    gps.report(SECONDS_COUNT_BAR_S);
    day_of_year.report(DAY_OF_YEAR_BAR);
}
