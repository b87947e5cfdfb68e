//! TEME, Earth-fixed and geodetic coordinates.

use adcs_core::environment::earth::{EcefState, ecef_from_eci_at_ut1};
use adcs_core::environment::geodetic::Geodetic;
use adcs_core::frames::Vector;
use adcs_core::orbit::OrbitState;
use adcs_core::time::{JulianDate, gmst82_rad};

use crate::table::{Row, Table, Worst};

const STATES: &str = include_str!("../data/teme_pef_itrf.csv");
const PLACES: &str = include_str!("../data/geodetic_ecef.csv");

/// The bars of the project.
const GMST_BAR_RAD: f64 = 1e-11;
const POSITION_BAR_KM: f64 = 1e-6;
const VELOCITY_BAR_KM_S: f64 = 1e-9;
const ANGLE_BAR_DEG: f64 = 1e-9;
const HEIGHT_BAR_KM: f64 = 1e-6;
/// The latitudes of `teme_pef_itrf.csv` are themselves that far from converged far out: in 50-digit
/// arithmetic the position of row 96 lies at 61.250838475977533 deg, the table has
/// 61.250838477282976.
const LATITUDE_OF_STATES_BAR_DEG: f64 = 2e-9;

const M_PER_KM: f64 = 1e3;

fn vector_m<F>(row: &Row<'_>, columns: [&str; 3]) -> Vector<F, f64> {
    Vector::from_xyz(row.vector(columns) * M_PER_KM)
}

/// Differences in latitude, longitude (as an arc) and height, deg, deg, km.
fn geodetic_differences(found: &Geodetic, row: &Row<'_>, columns: [&str; 3]) -> [f64; 3] {
    let [latitude_deg, longitude_deg, height_km] = columns.map(|column| row.number(column));
    let turn_deg = libm::remainder(found.longitude_east_rad.to_degrees() - longitude_deg, 360.0);
    // The poles have every longitude.
    let arc_deg = turn_deg * libm::cos(latitude_deg.to_radians());
    [
        (found.latitude_rad.to_degrees() - latitude_deg).abs(),
        arc_deg.abs(),
        (found.height_m / M_PER_KM - height_km).abs(),
    ]
}

#[test]
fn teme_states_become_earth_fixed_ones_and_back() {
    let mut gmst = Worst::new("GMST-82, rad");
    let mut position = Worst::new("TEME to PEF, position, km");
    let mut velocity = Worst::new("TEME to PEF, velocity, km/s");
    let mut position_back = Worst::new("PEF to TEME, position, km");
    let mut velocity_back = Worst::new("PEF to TEME, velocity, km/s");
    let mut latitude = Worst::new("PEF to geodetic, latitude, deg");
    let mut longitude = Worst::new("PEF to geodetic, longitude, deg");
    let mut height = Worst::new("PEF to geodetic, height, km");
    for row in Table::parse(STATES).rows() {
        let at = format!("row {} ({})", row.text("id"), row.text("tag"));
        let ut1 =
            JulianDate { day: row.number("ut1_jd_day"), fraction: row.number("ut1_jd_fraction") };
        gmst.see((gmst82_rad(ut1) - row.number("gmst82_rad")).abs(), &at);
        let r_ei = ecef_from_eci_at_ut1(ut1);
        let teme = OrbitState {
            position: vector_m(&row, ["teme_x_km", "teme_y_km", "teme_z_km"]),
            velocity: vector_m(&row, ["teme_vx_km_s", "teme_vy_km_s", "teme_vz_km_s"]),
        };
        let pef = EcefState {
            position: vector_m(&row, ["pef_x_km", "pef_y_km", "pef_z_km"]),
            velocity: vector_m(&row, ["pef_vx_km_s", "pef_vy_km_s", "pef_vz_km_s"]),
        };
        let found = EcefState::from_eci(r_ei, &teme);
        position.see((found.position - pef.position).norm() / M_PER_KM, &at);
        velocity.see((found.velocity - pef.velocity).norm() / M_PER_KM, &at);
        let back = pef.to_eci(r_ei);
        position_back.see((back.position - teme.position).norm() / M_PER_KM, &at);
        velocity_back.see((back.velocity - teme.velocity).norm() / M_PER_KM, &at);

        let place = Geodetic::from_position(pef.position).unwrap();
        let columns = ["pef_geodetic_lat_deg", "pef_lon_east_deg", "pef_height_wgs84_km"];
        let [latitude_deg, arc_deg, height_km] = geodetic_differences(&place, &row, columns);
        latitude.see(latitude_deg, &at);
        longitude.see(arc_deg, &at);
        height.see(height_km, &at);
    }
    gmst.report(GMST_BAR_RAD);
    position.report(POSITION_BAR_KM);
    velocity.report(VELOCITY_BAR_KM_S);
    position_back.report(POSITION_BAR_KM);
    velocity_back.report(VELOCITY_BAR_KM_S);
    latitude.report(LATITUDE_OF_STATES_BAR_DEG);
    longitude.report(ANGLE_BAR_DEG);
    height.report(HEIGHT_BAR_KM);
}

#[test]
fn places_on_the_map_become_positions_and_back() {
    let mut position = Worst::new("geodetic to ECEF, km");
    let mut latitude = Worst::new("ECEF to geodetic, latitude, deg");
    let mut longitude = Worst::new("ECEF to geodetic, longitude, deg");
    let mut height = Worst::new("ECEF to geodetic, height, km");
    for row in Table::parse(PLACES).rows() {
        let at = format!("row {}", row.text("id"));
        let expected = vector_m(&row, ["ecef_x_km", "ecef_y_km", "ecef_z_km"]);
        let columns = ["geodetic_lat_deg", "lon_east_deg", "height_wgs84_km"];
        let [latitude_deg, longitude_deg, height_km] = columns.map(|column| row.number(column));
        let place = Geodetic {
            latitude_rad: latitude_deg.to_radians(),
            longitude_east_rad: longitude_deg.to_radians(),
            height_m: height_km * M_PER_KM,
        };
        position.see((place.position() - expected).norm() / M_PER_KM, &at);
        let found = Geodetic::from_position(expected).unwrap();
        let [latitude_deg, arc_deg, height_km] = geodetic_differences(&found, &row, columns);
        latitude.see(latitude_deg, &at);
        longitude.see(arc_deg, &at);
        height.see(height_km, &at);
    }
    position.report(POSITION_BAR_KM);
    latitude.report(ANGLE_BAR_DEG);
    longitude.report(ANGLE_BAR_DEG);
    height.report(HEIGHT_BAR_KM);
}
