//! Where the Sun stands at given instants.

use adcs_core::environment::sun::ApparentSun;
use adcs_core::time::LeapSeconds;

use crate::table::{Cells, Column, Failure, Header, Problem, Row, RowCommand};

/// [`RowCommand`] of `adcs sun`.
#[derive(Debug)]
pub struct Sun {
    utc: Column,
}

impl Sun {
    /// Finds the columns.
    ///
    /// # Errors
    /// [`Failure`] when there is no column `utc_iso`.
    pub fn bind(header: &Header) -> Result<Self, Failure> {
        Ok(Self { utc: header.column("utc_iso")? })
    }
}

impl RowCommand for Sun {
    fn computed(&self) -> &'static [&'static str] {
        &[
            "sun_tod_x",
            "sun_tod_y",
            "sun_tod_z",
            "sun_teme_x",
            "sun_teme_y",
            "sun_teme_z",
            "distance_au",
            "error",
        ]
    }

    fn compute(&mut self, row: Row<'_>, cells: &mut Cells) -> Result<(), Problem> {
        let utc = row.utc(self.utc)?;
        let tt = utc
            .to_tt(&LeapSeconds::BUILT_IN)
            .map_err(|error| Problem::of_column(self.utc, error))?;
        let sun = ApparentSun::at(tt);
        cells.numbers(sun.direction_true_of_date().vector().to_array());
        cells.numbers(sun.direction_eci().vector().to_array());
        cells.number(sun.distance_au);
        cells.text("");
        Ok(())
    }
}
