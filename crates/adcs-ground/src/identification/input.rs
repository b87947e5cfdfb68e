//! Rates, fields and dipoles from a table, or from the history of a flight.

use adcs_core::identification::Recorded;

use crate::table::{Column, Failure, Header, Problem, Row};

/// Tesla in a nanotesla.
const T_PER_NT: f64 = 1e-9;

/// A row: what was recorded, and what else there was.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Line {
    /// s.
    pub t_s: f64,
    /// For the identification, in SI.
    pub recorded: Recorded<f64>,
    /// °C, where the table has it.
    pub temperature_c: Option<f64>,
    /// The Sun as measured, Body, and the cosine of the angle between Sun and field by the models.
    pub sun: Option<([f64; 3], f64)>,
}

/// The columns of a table.
#[derive(Debug, Clone, Copy)]
pub struct Columns {
    t: Column,
    gyros: [Column; 3],
    field: [Column; 3],
    dipole: Option<[Column; 3]>,
    temperature: Option<Column>,
    sun: Option<Sun>,
}

#[derive(Debug, Clone, Copy)]
enum Sun {
    Cosine {
        sun: [Column; 3],
        cosine: Column,
    },
    /// A history has no cosine of the models, but the true vectors.
    Vectors {
        sun: [Column; 3],
        true_sun: [Column; 3],
        true_field: [Column; 3],
    },
}

impl Columns {
    /// Finds them.
    ///
    /// # Errors
    /// [`Failure`] when a column is missing.
    pub fn find(header: &Header) -> Result<Self, Failure> {
        let gyros = header.columns(["gyro_x_deg_s", "gyro_y_deg_s", "gyro_z_deg_s"])?;
        let of_history = ["measured_field_x_nt", "measured_field_y_nt", "measured_field_z_nt"];
        if let Some(field) = header.optional_columns(of_history)? {
            let sun = ["measured_sun_x", "measured_sun_y", "measured_sun_z"];
            let sun = match header.optional_columns(sun)? {
                Some(sun) => Some(Sun::Vectors {
                    sun,
                    true_sun: header.columns(["sun_body_x", "sun_body_y", "sun_body_z"])?,
                    true_field: header.columns([
                        "field_body_x_nt",
                        "field_body_y_nt",
                        "field_body_z_nt",
                    ])?,
                }),
                None => None,
            };
            return Ok(Self {
                t: header.column("time_s")?,
                gyros,
                field,
                dipole: Some(header.columns(["driven_x_am2", "driven_y_am2", "driven_z_am2"])?),
                temperature: header.optional("temperature_c")?,
                sun,
            });
        }
        let sun = match header.optional_columns(["sun_x", "sun_y", "sun_z"])? {
            Some(sun) => Some(Sun::Cosine { sun, cosine: header.column("sun_field_cosine")? }),
            None => None,
        };
        Ok(Self {
            t: header.column("t_s")?,
            gyros,
            field: header.columns(["field_x_nt", "field_y_nt", "field_z_nt"])?,
            dipole: header.optional_columns(["dipole_x_am2", "dipole_y_am2", "dipole_z_am2"])?,
            temperature: header.optional("temperature_c")?,
            sun,
        })
    }

    /// Reads rows in the order of their times.
    pub fn reader(self) -> impl FnMut(Row<'_>) -> Result<Option<Line>, Problem> {
        let mut last_t_s = None;
        // A row says what the torquers do from its instant on.
        let mut dipole_before = [0.0; 3];
        move |row: Row<'_>| {
            let t_s = row.number(self.t)?;
            let dt_s = last_t_s.map_or(0.0, |last| t_s - last);
            if dt_s < 0.0 {
                return Err(Problem::of_column(self.t, format!("{t_s} s is before the last row")));
            }
            let dipole = self.dipole.map_or(Ok([0.0; 3]), |dipole| row.numbers(dipole))?;
            let Some(gyros) = given(row, self.gyros)? else { return Ok(None) };
            last_t_s = Some(t_s);
            let recorded = Recorded {
                dt_s,
                rate_rad_s: gyros.map(f64::to_radians),
                field_t: given(row, self.field)?.map(|field| field.map(|nt| nt * T_PER_NT)),
                dipole_am2: std::mem::replace(&mut dipole_before, dipole),
            };
            let temperature_c = match self.temperature {
                Some(column) if !row.bytes(column).is_empty() => Some(row.number(column)?),
                _ => None,
            };
            let sun = match self.sun {
                Some(Sun::Cosine { sun, cosine }) => match given(row, sun)? {
                    Some(sun) => Some((sun, row.number(cosine)?)),
                    None => None,
                },
                Some(Sun::Vectors { sun, true_sun, true_field }) => match given(row, sun)? {
                    Some(sun) => {
                        let (a, b) = (row.numbers(true_sun)?, row.numbers(true_field)?);
                        let [a, b] = [a, b].map(nalgebra::Vector3::from);
                        Some((sun, a.normalize().dot(&b.normalize())))
                    }
                    None => None,
                },
                None => None,
            };
            Ok(Some(Line { t_s, recorded, temperature_c, sun }))
        }
    }
}

/// Three numbers, or none when one of them is left out.
fn given(row: Row<'_>, columns: [Column; 3]) -> Result<Option<[f64; 3]>, Problem> {
    if columns.iter().any(|&column| matches!(row.bytes(column), b"" | b"nan")) {
        return Ok(None);
    }
    row.numbers(columns).map(Some)
}
