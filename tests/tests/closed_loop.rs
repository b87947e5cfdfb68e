//! Four flights of 1200 s that were solved by independent code.

use adcs_sim::scenario::Readings;
use adcs_tests::{Flight, Row, Table, fly, mission};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};

/// Rate, per axis: a hundred times what remains between two independent f64 solutions, to leave
/// room for the f32 law.
const RATE_TOLERANCE_DEG_S: f64 = 3e-4;
/// Attitude, whole angle.
const ATTITUDE_TOLERANCE_DEG: f64 = 0.01;
/// Field in TEME, per axis, nT.
const FIELD_TOLERANCE_NT: f64 = 0.02;
/// Position in TEME, per axis, km: the bar of SGP4 itself.
const POSITION_TOLERANCE_KM: f64 = 1e-6;
/// Dipole commanded, A·m²: what the rate tolerance makes of k ω B, k = 2e5, B = 5e-5 T.
const COMMAND_TOLERANCE_AM2: f64 = 1e-4;

fn attitude(xyzw: [f64; 4]) -> UnitQuaternion<f64> {
    let [x, y, z, w] = xyzw;
    UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z))
}

fn largest(a: [f64; 3], b: [f64; 3]) -> f64 {
    (Vector3::from(a) - Vector3::from(b)).amax()
}

/// The largest differences of one flight from the reference.
#[derive(Debug, Default)]
struct Worst {
    rate_deg_s: f64,
    attitude_deg: f64,
    position_km: f64,
    field_nt: f64,
}

impl Worst {
    fn compare(&mut self, flight: &Flight, row: &Row) {
        let time_s = row.number("t_s");
        let truth = flight.truth_at(time_s);
        let rate = row.numbers(["rate_x_deg_s", "rate_y_deg_s", "rate_z_deg_s"]);
        let q = attitude(row.numbers(["q_x", "q_y", "q_z", "q_w"]));
        let position = row.numbers(["r_teme_x_km", "r_teme_y_km", "r_teme_z_km"]);
        let field = row.numbers(["B_teme_x_nT", "B_teme_y_nT", "B_teme_z_nT"]);
        let angle_deg = attitude(truth.attitude_xyzw).angle_to(&q).to_degrees();
        self.rate_deg_s = self.rate_deg_s.max(largest(flight.rate_deg_s(time_s).into(), rate));
        self.attitude_deg = self.attitude_deg.max(angle_deg);
        let km = truth.position_eci_m.map(|m| m * 1e-3);
        self.position_km = self.position_km.max(largest(km, position));
        let nt = truth.field_eci_t.map(|t| t * 1e9);
        self.field_nt = self.field_nt.max(largest(nt, field));
    }
}

fn follows_the_reference(name: &str) {
    let mission = mission(&format!("reference/{}", name.to_lowercase()));
    assert_eq!(mission.scenario.readings, Readings::Exact);
    let flight = fly(&mission.scenario);

    let mut worst = Worst::default();
    let expected = Table::read("closedloop/closedloop_expected.csv");
    let rows: Vec<Row> = expected.rows().filter(|row| row.text("id") == name).collect();
    assert_eq!(rows.len(), 13, "one row each 100 s");
    for row in &rows {
        worst.compare(&flight, row);
    }
    println!("{name}: {worst:?}");
    assert!(worst.rate_deg_s <= RATE_TOLERANCE_DEG_S, "{worst:?}");
    assert!(worst.attitude_deg <= ATTITUDE_TOLERANCE_DEG, "{worst:?}");
    assert!(worst.position_km <= POSITION_TOLERANCE_KM, "{worst:?}");
    assert!(worst.field_nt <= FIELD_TOLERANCE_NT, "{worst:?}");
    every_command_is_the_references(name, &flight);
}

fn every_command_is_the_references(name: &str, flight: &Flight) {
    let commands = Table::read("closedloop/closedloop_commands.csv");
    let mut compared = 0;
    for row in commands.rows().filter(|row| row.text("id") == name) {
        let time_s = row.number("t_s");
        let record = flight
            .records
            .iter()
            .find(|record| (flight.time_s(record.cycle) - time_s).abs() < 1e-9)
            .unwrap_or_else(|| panic!("{name}: no cycle at {time_s} s"));
        let expected = row.numbers(["m_x_A_m2", "m_y_A_m2", "m_z_A_m2"]);
        let commanded = record.commanded_am2.map(f64::from);
        let difference = largest(commanded, expected);
        assert!(difference <= COMMAND_TOLERANCE_AM2, "{name} at {time_s} s: {difference} A·m²");
        compared += 1;
    }
    assert!(compared > 90, "{compared} commands");
}

#[test]
fn flight_p1_follows_the_independent_solution() {
    follows_the_reference("P1");
}

#[test]
fn flight_p2_follows_the_independent_solution() {
    follows_the_reference("P2");
}

#[test]
fn flight_p3_with_gravity_gradient_follows_the_independent_solution() {
    follows_the_reference("P3");
}

#[test]
fn flight_p4_with_gravity_gradient_follows_the_independent_solution() {
    follows_the_reference("P4");
}
