//! Readings of a magnetometer from a table, or from the history of a flight.

use adcs_core::calibration::{DataSheet, Sample};

use crate::table::{Column, Failure, Header, Problem, Row};

/// A reading in volts, the strength of the model's field in nT, and when that was.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measured {
    /// Time, s, where the table has it.
    pub t_s: Option<f64>,
    /// What was read, V and nT.
    pub sample: Sample<f64>,
}

/// Finds the columns: those of a table of voltages, or those of `history.csv`.
///
/// A row of a history in which nothing was measured gives `None`: the torquers were on, a reading was
/// missing, or the satellite did not know where it was.
///
/// # Errors
/// [`Failure`] when a column is missing.
pub fn bind(
    header: &Header,
    data_sheet: DataSheet<f64>,
) -> Result<impl FnMut(Row<'_>) -> Result<Option<Measured>, Problem> + use<>, Failure> {
    let columns = Columns::find(header)?;
    Ok(move |row: Row<'_>| columns.read(row, data_sheet))
}

#[derive(Debug, Clone, Copy)]
enum Columns {
    Voltages { t: Option<Column>, volts: [Column; 3], norm: Column },
    History { t: Column, phase: Column, status: Column, fields: [Column; 3], norm: Column },
}

impl Columns {
    fn find(header: &Header) -> Result<Self, Failure> {
        if let Some(volts) = header.optional_columns(["V_x_volt", "V_y_volt", "V_z_volt"])? {
            let (t, norm) = (header.optional("t_s")?, header.column("igrf_norm_nT")?);
            return Ok(Self::Voltages { t, volts, norm });
        }
        let fields = ["magnetometer_x_nt", "magnetometer_y_nt", "magnetometer_z_nt"];
        let Some(fields) = header.optional_columns(fields)? else {
            return Err(header.missing("V_x_volt, nor magnetometer_x_nt of a history"));
        };
        let [t, phase, status, norm] =
            header.columns(["time_s", "phase", "magnetometer_status", "model_field_norm_nt"])?;
        Ok(Self::History { t, phase, status, fields, norm })
    }

    fn read(self, row: Row<'_>, data_sheet: DataSheet<f64>) -> Result<Option<Measured>, Problem> {
        match self {
            Self::Voltages { t, volts, norm } => {
                let t_s = t.map(|t| row.number(t)).transpose()?;
                let sample =
                    Sample { reading: row.numbers(volts)?, intensity: strength(row, norm)? };
                Ok(Some(Measured { t_s, sample }))
            }
            Self::History { t, phase, status, fields, norm } => {
                let measured = matches!(row.bytes(phase), b"measuring" | b"settled")
                    && row.bytes(status) == b"ok"
                    && !row.bytes(norm).is_empty();
                if !measured {
                    return Ok(None);
                }
                let DataSheet { sensitivity, zero } = data_sheet;
                let reading = row.numbers(fields)?.map(|nt| nt / sensitivity + zero);
                let sample = Sample { reading, intensity: strength(row, norm)? };
                Ok(Some(Measured { t_s: Some(row.number(t)?), sample }))
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
