//! `history.csv`: one row a cycle, units in the header.

use std::path::Path;

use adcs_core::reading::Reading;
use anyhow::{Context as _, Result};

use super::rows::{
    Believed, Row, attitude_word, control_words, face_word, missing_word, norm, phase_word,
    rate_word, reason_word,
};
use super::transitions::cause_words;

const HEADER: &[&str] = &[
    "cycle",
    "time_s",
    "utc",
    "phase",
    "rate_x_deg_s",
    "rate_y_deg_s",
    "rate_z_deg_s",
    "rate_norm_deg_s",
    "q_x",
    "q_y",
    "q_z",
    "q_w",
    "position_eci_x_km",
    "position_eci_y_km",
    "position_eci_z_km",
    "field_body_x_nt",
    "field_body_y_nt",
    "field_body_z_nt",
    "field_norm_nt",
    "gyro_x_deg_s",
    "gyro_y_deg_s",
    "gyro_z_deg_s",
    "gyro_status",
    "magnetometer_x_nt",
    "magnetometer_y_nt",
    "magnetometer_z_nt",
    "magnetometer_status",
    "measured_rate_x_deg_s",
    "measured_rate_y_deg_s",
    "measured_rate_z_deg_s",
    "measured_field_x_nt",
    "measured_field_y_nt",
    "measured_field_z_nt",
    "measured_field_norm_nt",
    "model_field_norm_nt",
    "commanded_x_am2",
    "commanded_y_am2",
    "commanded_z_am2",
    "driven_x_am2",
    "driven_y_am2",
    "driven_z_am2",
    "dipole_body_x_am2",
    "dipole_body_y_am2",
    "dipole_body_z_am2",
    "mode",
    "transition",
    "rung",
    "committed",
    "control",
    "pointing_error_deg",
    "believed_pointing_error_deg",
    "saturated_x",
    "saturated_y",
    "saturated_z",
    "kinetic_energy_j",
    "control_power_w",
    "sunlit",
    "model_sunlit",
    "sun_body_x",
    "sun_body_y",
    "sun_body_z",
    "measured_sun_x",
    "measured_sun_y",
    "measured_sun_z",
    "measured_sun_sigma_deg",
    "sun_error_deg",
    "sun_status",
    "sun_face_0",
    "sun_face_1",
    "sun_face_2",
    "sun_face_3",
    "sun_face_4",
    "sun_face_5",
    "estimated_q_x",
    "estimated_q_y",
    "estimated_q_z",
    "estimated_q_w",
    "estimated_sigma_x_deg",
    "estimated_sigma_y_deg",
    "estimated_sigma_z_deg",
    "attitude_error_deg",
    "attitude_source",
    "estimated_rate_x_deg_s",
    "estimated_rate_y_deg_s",
    "estimated_rate_z_deg_s",
    "estimated_rate_sigma_deg_s",
    "rate_source",
    "estimate_reason",
    "gyro_bias_x_deg_s",
    "gyro_bias_y_deg_s",
    "gyro_bias_z_deg_s",
    "estimated_dipole_x_am2",
    "estimated_dipole_y_am2",
    "estimated_dipole_z_am2",
    "nis_field",
    "nis_sun",
];

/// Writes the history of a flight. Cells without a value are empty.
///
/// # Errors
/// When the file cannot be written.
pub fn write(path: &Path, rows: &[Row]) -> Result<()> {
    let write = || -> csv::Result<()> {
        let mut file = csv::Writer::from_path(path)?;
        file.write_record(HEADER)?;
        for row in rows {
            file.write_record(cells(row))?;
        }
        file.flush()?;
        Ok(())
    };
    write().with_context(|| format!("{} cannot be written", path.display()))
}

fn cells(row: &Row) -> Vec<String> {
    let mut cells = Cells(Vec::with_capacity(HEADER.len()));
    cells.add(row.cycle);
    cells.add(row.time_s);
    cells.add(row.utc);
    cells.add(phase_word(row.phase));
    cells.all(row.rate_deg_s);
    cells.add(row.rate_norm_deg_s);
    cells.all(row.attitude_xyzw);
    cells.all(row.position_km);
    cells.all(row.field_nt);
    cells.add(row.field_norm_nt);
    cells.readings(row.gyro_deg_s);
    cells.readings(row.magnetometer_nt);
    cells.all_of(row.measured_rate_deg_s);
    cells.all_of(row.measured_field_nt);
    cells.one_of(row.measured_field_nt.map(norm));
    cells.one_of(row.model_field_norm_nt);
    cells.all(row.commanded_am2);
    cells.all_of(row.driven_am2);
    cells.all_of(row.dipole_am2);
    cells.add(row.mode.map_or_else(String::new, |report| report.mode.to_string()));
    let transition = row.mode.and_then(|report| report.transition);
    cells.add(transition.map_or_else(String::new, |it| cause_words(it.cause)));
    let rung = row.commissioning.and_then(|report| report.rung);
    cells.add(rung.map_or_else(String::new, |rung| rung.to_string()));
    cells.add(u8::from(row.committed));
    cells.add(control_words(row.control));
    cells.one_of(row.pointing_error_deg);
    cells.one_of(row.believed_pointing_deg);
    cells.all(row.saturated.map(u8::from));
    cells.add(row.energy_j);
    cells.one_of(row.control_power_w);
    cells.add(u8::from(row.sunlit));
    cells.one_of(row.model_sunlit);
    cells.all(row.sun);
    let measured = row.measured_sun.value();
    cells.all_of(measured.map(|sun| sun.direction));
    cells.one_of(measured.map(|sun| sun.sigma_deg));
    cells.one_of(measured.map(|sun| sun.error_deg));
    cells.add(row.measured_sun.missing().map_or("ok", missing_word));
    cells.all(row.sun_faces.map(face_word));
    believed(&mut cells, row.believed.as_ref());
    cells.0
}

fn believed(cells: &mut Cells, believed: Option<&Believed>) {
    let record = believed.map(|believed| believed.record);
    let attitude = record.and_then(|record| record.attitude);
    match attitude {
        Some(attitude) => cells.all(attitude.xyzw),
        None => cells.all([""; 4]),
    }
    let deg = |xyz: [f32; 3]| xyz.map(|x| f64::from(x).to_degrees());
    cells.all_of(attitude.map(|attitude| deg(attitude.sigma_rad)));
    cells.one_of(believed.and_then(|believed| believed.attitude_error_deg));
    cells.add(attitude.map_or("", |attitude| attitude_word(attitude.source)));
    let rate = record.and_then(|record| record.rate);
    cells.all_of(rate.map(|rate| deg(rate.omega_bi_rad_s)));
    cells.one_of(rate.map(|rate| f64::from(rate.sigma_rad_s).to_degrees()));
    cells.add(rate.map_or("", |rate| rate_word(rate.source)));
    cells.add(record.map_or("", |record| reason_word(record.reason)));
    cells.all_of(record.and_then(|record| record.gyro_bias_rad_s).map(deg));
    cells.all_of(record.and_then(|record| record.residual_dipole_am2).map(|m| m.map(f64::from)));
    cells.one_of(record.and_then(|record| record.nis_field).map(f64::from));
    cells.one_of(record.and_then(|record| record.nis_sun).map(f64::from));
}

struct Cells(Vec<String>);

impl Cells {
    fn add(&mut self, value: impl ToString) {
        self.0.push(value.to_string());
    }

    fn all<T: ToString, const N: usize>(&mut self, values: [T; N]) {
        self.0.extend(values.iter().map(ToString::to_string));
    }

    fn one_of(&mut self, value: Option<f64>) {
        self.0.push(value.map_or_else(String::new, |value| value.to_string()));
    }

    fn all_of(&mut self, values: Option<[f64; 3]>) {
        match values {
            Some(values) => self.all(values),
            None => self.all([""; 3]),
        }
    }

    /// Three readings, and `ok` or the first reason for which one is missing.
    fn readings(&mut self, axes: [Reading<f64>; 3]) {
        for axis in axes {
            self.one_of(axis.value());
        }
        let reason = axes.iter().find_map(Reading::missing);
        self.add(reason.map_or("ok", missing_word));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flight::records::tests::flown;
    use crate::report::rows::rows;
    use adcs_core::reading::MissingReason;

    #[test]
    fn every_column_has_a_cell_and_a_name() {
        for row in rows(&flown(2), None) {
            assert_eq!(cells(&row).len(), HEADER.len());
        }
    }

    #[test]
    fn a_missing_reading_is_an_empty_cell_and_a_reason() {
        let mut flight = flown(1);
        flight.steps[0].record.gyro_rad_s[1] = Reading::Missing(MissingReason::Bus);
        let cells = cells(&rows(&flight, None)[0]);
        let cell = |name| &cells[HEADER.iter().position(|&header| header == name).unwrap()];
        assert_eq!((cell("gyro_y_deg_s").as_str(), cell("gyro_status").as_str()), ("", "bus"));
        assert_eq!(cell("magnetometer_status"), "ok");
    }
}
