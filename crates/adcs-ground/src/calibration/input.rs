//! Readings of a magnetometer from a table, or from the history of a flight.

use adcs_core::calibration::{CoupledSample, DataSheet, Sample};

use crate::table::{Column, Failure, Header, Problem, Row};

/// Names of the columns with currents.
pub const CURRENTS: [&str; 6] =
    ["current_1_a", "current_2_a", "current_3_a", "current_4_a", "current_5_a", "current_6_a"];
/// What takes their place in a history.
pub const DIPOLES: [&str; 3] = ["driven_x_am2", "driven_y_am2", "driven_z_am2"];
const GYROS: [&str; 3] = ["gyro_x_deg_s", "gyro_y_deg_s", "gyro_z_deg_s"];

/// A reading in volts, the strength of the model's field in nT, and what else was there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measured {
    /// Time, s, where the table has it.
    pub t_s: Option<f64>,
    /// What was read, V and nT.
    pub sample: Sample<f64>,
    /// What flowed then, in the order of `Columns::currents`; zeros behind.
    pub currents: [f64; CURRENTS.len()],
    /// Whether the field had come to rest: in a history, whether the torquers had.
    pub settled: bool,
    /// Rate by the gyros, deg/s, where the table has it.
    pub gyro_deg_s: Option<[f64; 3]>,
}

impl Measured {
    /// With the first C currents.
    pub fn coupled<const C: usize>(&self) -> CoupledSample<f64, C> {
        let mut currents = [0.0; C];
        currents.iter_mut().zip(self.currents).for_each(|(to, from)| *to = from);
        CoupledSample { sample: self.sample, currents }
    }
}

/// How a table has currents.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Currents {
    /// The columns' names.
    pub names: &'static [&'static str],
    /// Whether rows were left unsettled by them, which other models cannot use.
    pub unsettle: bool,
}

/// What a table of readings is made of.
#[derive(Debug, Clone, Copy)]
pub struct Columns {
    t: Option<Column>,
    kind: Kind,
    norm: Column,
    gyros: Option<[Column; 3]>,
}

#[derive(Debug, Clone, Copy)]
enum Kind {
    Voltages { volts: [Column; 3], currents: [Option<Column>; CURRENTS.len()] },
    History { phase: Column, status: Column, fields: [Column; 3], dipoles: [Column; 3] },
}

impl Columns {
    /// Finds the columns: those of a table of voltages, or those of `history.csv`.
    ///
    /// # Errors
    /// [`Failure`] when a column is missing.
    pub fn find(header: &Header) -> Result<Self, Failure> {
        if let Some(volts) = header.optional_columns(["V_x_volt", "V_y_volt", "V_z_volt"])? {
            let mut currents = [None; CURRENTS.len()];
            for (column, name) in currents.iter_mut().zip(CURRENTS) {
                *column = header.optional(name)?;
                if column.is_none() {
                    break;
                }
            }
            return Ok(Self {
                t: header.optional("t_s")?,
                kind: Kind::Voltages { volts, currents },
                norm: header.column("igrf_norm_nT")?,
                gyros: header.optional_columns(GYROS)?,
            });
        }
        let fields = ["magnetometer_x_nt", "magnetometer_y_nt", "magnetometer_z_nt"];
        let Some(fields) = header.optional_columns(fields)? else {
            return Err(header.missing("V_x_volt, nor magnetometer_x_nt of a history"));
        };
        let [t, phase, status, norm] =
            header.columns(["time_s", "phase", "magnetometer_status", "model_field_norm_nt"])?;
        let dipoles = header.columns(DIPOLES)?;
        let kind = Kind::History { phase, status, fields, dipoles };
        Ok(Self { t: Some(t), kind, norm, gyros: header.optional_columns(GYROS)? })
    }

    /// The currents that there are.
    pub fn currents(&self) -> Currents {
        match &self.kind {
            Kind::Voltages { currents, .. } => {
                let count = currents.iter().take_while(|column| column.is_some()).count();
                Currents { names: CURRENTS.get(..count).unwrap_or_default(), unsettle: false }
            }
            Kind::History { .. } => Currents { names: &DIPOLES, unsettle: true },
        }
    }

    /// Reads rows in their order. One of a history in which nothing was measured gives `None`.
    pub fn reader(
        self,
        data_sheet: DataSheet<f64>,
    ) -> impl FnMut(Row<'_>) -> Result<Option<Measured>, Problem> {
        // A history says what the torquers do from its instant on.
        let mut dipoles_before = [0.0; 3];
        move |row: Row<'_>| {
            let strength = |row| strength(row, self.norm);
            let gyro_deg_s = match self.gyros {
                Some(gyros) if gyros.iter().all(|&gyro| !row.bytes(gyro).is_empty()) => {
                    Some(row.numbers(gyros)?)
                }
                _ => None,
            };
            match self.kind {
                Kind::Voltages { volts, currents } => {
                    let t_s = self.t.map(|t| row.number(t)).transpose()?;
                    let sample = Sample { reading: row.numbers(volts)?, intensity: strength(row)? };
                    let mut flowing = [0.0; CURRENTS.len()];
                    for (current, column) in flowing.iter_mut().zip(currents) {
                        *current = column.map_or(Ok(0.0), |column| row.number(column))?;
                    }
                    Ok(Some(Measured { t_s, sample, currents: flowing, settled: true, gyro_deg_s }))
                }
                Kind::History { phase, status, fields, dipoles } => {
                    let now = row.numbers(dipoles)?;
                    let [x, y, z] = std::mem::replace(&mut dipoles_before, now);
                    if row.bytes(status) != b"ok" || row.bytes(self.norm).is_empty() {
                        return Ok(None);
                    }
                    let DataSheet { sensitivity, zero } = data_sheet;
                    let reading = row.numbers(fields)?.map(|nt| nt / sensitivity + zero);
                    Ok(Some(Measured {
                        t_s: self.t.map(|t| row.number(t)).transpose()?,
                        sample: Sample { reading, intensity: strength(row)? },
                        currents: [x, y, z, 0.0, 0.0, 0.0],
                        settled: matches!(row.bytes(phase), b"measuring" | b"settled"),
                        gyro_deg_s,
                    }))
                }
            }
        }
    }
}

fn strength(row: Row<'_>, column: Column) -> Result<f64, Problem> {
    match row.number(column)? {
        nt if nt > 0.0 => Ok(nt),
        nt => Err(Problem::of_column(column, format!("{nt} nT; a field has a positive strength"))),
    }
}
