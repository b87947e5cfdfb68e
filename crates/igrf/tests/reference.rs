//! Against the field of an independent evaluation with 40 digits (provenance: `data/README.md`).
#![cfg(feature = "history")]

mod support;

use igrf::{
    Coefficients, DecimalYear, GeocentricField, GeocentricPosition, GeodeticField,
    GeodeticPosition, Real,
};
use support::{Row, Table};

/// f64, nT. The reference is printed with all digits; 1e-8 leaves room for other `sin` and `cos`
/// (a metre is 0.03 nT, the rounding of an angle 1e-9 m).
const TOLERANCE_F64_NT: f64 = 1e-8;
/// f32, nT. The rounding of a position in km is 0.25 m, of an angle in rad up to 1 m: 0.03 nT.
/// The rest is the rounding of 50000 nT in a sum of 13 degrees.
const TOLERANCE_F32_NT: f64 = 0.2;

fn points() -> Table {
    Table::parse(include_str!("data/igrf14_field_reference.csv"))
}

fn real<T: Real>(value: f64) -> T {
    T::from_f64(value)
}

fn coefficients<T: Real>(row: &Row<'_>) -> Coefficients<T> {
    Coefficients::at(DecimalYear(row.number("decimal_year"))).unwrap()
}

fn geodetic_nt<T: Real>(coefficients: &Coefficients<T>, row: &Row<'_>) -> [f64; 3] {
    let position = GeodeticPosition::<T> {
        latitude_rad: real(row.number("geodetic_lat_deg").to_radians()),
        longitude_rad: real(row.number("lon_east_deg").to_radians()),
        height_km: real(row.number("height_above_wgs84_km")),
    };
    let GeodeticField { north_nt, east_nt, down_nt } =
        coefficients.field_geodetic_nt(position).unwrap();
    [north_nt, east_nt, down_nt].map(T::to_f64)
}

fn geocentric_nt<T: Real>(coefficients: &Coefficients<T>, row: &Row<'_>) -> [f64; 3] {
    let position = GeocentricPosition::<T> {
        radius_km: real(row.number("geocentric_r_km")),
        colatitude_rad: real(row.number("geocentric_colatitude_theta_deg").to_radians()),
        longitude_rad: real(row.number("lon_east_deg").to_radians()),
    };
    let GeocentricField { radial_nt, theta_nt, phi_nt } =
        coefficients.field_geocentric_nt(position).unwrap();
    [radial_nt, theta_nt, phi_nt].map(T::to_f64)
}

/// The Earth-fixed field at the row's geocentric position, turned to r, θ, φ in f64.
fn cartesian_nt<T: Real>(coefficients: &Coefficients<T>, row: &Row<'_>) -> [f64; 3] {
    let (sin_theta, cos_theta) =
        row.number("geocentric_colatitude_theta_deg").to_radians().sin_cos();
    let (sin_phi, cos_phi) = row.number("lon_east_deg").to_radians().sin_cos();
    let outward = [sin_theta * cos_phi, sin_theta * sin_phi, cos_theta];
    let south = [cos_theta * cos_phi, cos_theta * sin_phi, -sin_theta];
    let east = [-sin_phi, cos_phi, 0.0];
    let radius_km = row.number("geocentric_r_km");
    let field_nt = coefficients
        .field_ecef_nt(outward.map(|component| real(radius_km * component)))
        .unwrap()
        .map(T::to_f64);
    [outward, south, east].map(|axis| axis.iter().zip(field_nt).map(|(a, b)| a * b).sum())
}

fn assert_close(row: &Row<'_>, columns: [&str; 3], field_nt: [f64; 3], tolerance_nt: f64) {
    for (column, value) in columns.into_iter().zip(field_nt) {
        let difference = value - row.number(column);
        assert!(
            difference.abs() <= tolerance_nt,
            "point {} ({}), {column}: off by {difference:e} nT",
            row.text("id"),
            row.text("decimal_year"),
        );
    }
}

fn assert_all_points<T: Real>(tolerance_nt: f64) {
    let table = points();
    assert_eq!(table.rows().len(), 300);
    for row in table.rows() {
        let coefficients = coefficients::<T>(&row);
        let spherical = ["B_r_nT", "B_theta_nT", "B_phi_nT"];
        let local = ["B_north_nT", "B_east_nT", "B_down_nT"];
        assert_close(&row, spherical, cartesian_nt(&coefficients, &row), tolerance_nt);
        assert_close(&row, spherical, geocentric_nt(&coefficients, &row), tolerance_nt);
        assert_close(&row, local, geodetic_nt(&coefficients, &row), tolerance_nt);
    }
}

#[test]
fn f64_is_exact_at_all_reference_points() {
    assert_all_points::<f64>(TOLERANCE_F64_NT);
}

#[test]
fn f32_is_within_a_fifth_of_a_nanotesla_at_all_reference_points() {
    assert_all_points::<f32>(TOLERANCE_F32_NT);
}

#[test]
fn calendar_dates_give_the_decimal_year_and_the_field() {
    /// A double near 2000 has steps of 2.3e-13.
    const TOLERANCE_YEARS: f64 = 5e-13;

    let table = Table::parse(include_str!("data/igrf14_calendar_dates.csv"));
    assert_eq!(table.rows().len(), 30);
    for row in table.rows() {
        let utc = row.text("utc_iso");
        let number = |range| str::parse::<u16>(&utc[range]).unwrap();
        let (month, day) = (number(5..7) as u8, number(8..10) as u8);
        let seconds = 3600.0 * f64::from(number(11..13))
            + 60.0 * f64::from(number(14..16))
            + utc[17..].trim_end_matches('Z').parse::<f64>().unwrap();
        let date = DecimalYear::from_calendar(number(0..4), month, day, seconds).unwrap();
        let difference = date.0 - row.number("decimal_year");
        assert!(difference.abs() <= TOLERANCE_YEARS, "{utc}: off by {difference:e} years");

        let coefficients = Coefficients::<f64>::at(date).unwrap();
        let local = ["B_north_nT", "B_east_nT", "B_down_nT"];
        assert_close(&row, local, geodetic_nt(&coefficients, &row), TOLERANCE_F64_NT);
    }
}
