//! The geomagnetic field at given dates and places.

use adcs_core::environment::field::decimal_year;
use igrf::{Coefficients, DecimalYear, GeodeticField, GeodeticPosition, Real};

use crate::table::{Cells, Column, Failure, Header, Problem, Row, RowCommand};

#[derive(Debug, Clone, Copy)]
enum Date {
    DecimalYear(Column),
    Utc(Column),
}

/// [`RowCommand`] of `adcs field`, in the precision `T`.
#[derive(Debug)]
pub struct Field<T> {
    date: Date,
    /// Latitude, longitude, height.
    place: [Column; 3],
    degree: u8,
    /// Of the date of the row before: a table often has many rows of one date.
    prepared: Option<(DecimalYear, Coefficients<T>)>,
    note: Option<&'static str>,
}

impl<T: Real> Field<T> {
    /// Finds the columns.
    ///
    /// # Errors
    /// [`Failure`] when a column is missing.
    pub fn bind(header: &Header, degree: u8) -> Result<Self, Failure> {
        let (decimal_year, utc) = (header.optional("decimal_year")?, header.optional("utc_iso")?);
        let date = match (decimal_year, utc) {
            (Some(column), _) => Date::DecimalYear(column),
            (None, Some(column)) => Date::Utc(column),
            (None, None) => return Err(header.missing("decimal_year or utc_iso")),
        };
        let both = decimal_year.is_some() && utc.is_some();
        Ok(Self {
            date,
            place: header.columns(["geodetic_lat_deg", "lon_east_deg", "height_above_wgs84_km"])?,
            degree,
            prepared: None,
            note: both.then_some("the date is taken from decimal_year, not from utc_iso"),
        })
    }

    fn coefficients(&mut self, date: DecimalYear) -> Result<Coefficients<T>, igrf::Error> {
        match self.prepared {
            Some((prepared, coefficients)) if prepared == date => Ok(coefficients),
            _ => {
                let coefficients = Coefficients::at(date)?.with_degree(self.degree)?;
                self.prepared = Some((date, coefficients));
                Ok(coefficients)
            }
        }
    }
}

/// A number of either precision as a cell.
pub trait Cell: Real {
    /// Writes it.
    fn write(self, cells: &mut Cells);
}

impl Cell for f64 {
    fn write(self, cells: &mut Cells) {
        cells.number(self);
    }
}

impl Cell for f32 {
    fn write(self, cells: &mut Cells) {
        cells.single(self);
    }
}

impl<T: Cell> RowCommand for Field<T> {
    fn computed(&self) -> &'static [&'static str] {
        &["B_north_nT", "B_east_nT", "B_down_nT", "B_total_nT", "error"]
    }

    fn note(&self) -> Option<&'static str> {
        self.note
    }

    fn compute(&mut self, row: Row<'_>, cells: &mut Cells) -> Result<(), Problem> {
        let (date, column) = match self.date {
            Date::DecimalYear(column) => (Ok(DecimalYear(row.number(column)?)), column),
            Date::Utc(column) => (decimal_year(row.utc(column)?), column),
        };
        let [latitude_deg, longitude_deg, height_km] = row.numbers(self.place)?;
        let coefficients = date
            .and_then(|date| self.coefficients(date))
            .map_err(|error| Problem::of_column(column, error))?;
        let [latitude_column, _, height_column] = self.place;
        if !(-90.0..=90.0).contains(&latitude_deg) {
            let message = format!("{latitude_deg} is outside -90 to 90");
            return Err(Problem::of_column(latitude_column, message));
        }
        let position = GeodeticPosition {
            latitude_rad: T::from_f64(latitude_deg.to_radians()),
            longitude_rad: T::from_f64((longitude_deg % 360.0).to_radians()),
            height_km: T::from_f64(height_km),
        };
        let GeodeticField { north_nt, east_nt, down_nt } = coefficients
            .field_geodetic_nt(position)
            .map_err(|error| Problem::of_column(height_column, error))?;
        let total_nt = (north_nt * north_nt + east_nt * east_nt + down_nt * down_nt).sqrt();
        for value in [north_nt, east_nt, down_nt, total_nt] {
            value.write(cells);
        }
        cells.text("");
        Ok(())
    }
}
