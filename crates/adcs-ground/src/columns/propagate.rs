//! Position and velocity by SGP4.

use sgp4_lite::{Elements, MinutesSinceEpoch, Propagator, ResonanceState, State};

use crate::table::{Cells, Column, Failure, Header, Problem, Row, RowCommand};
use crate::tle_file::{self, Checksum};

/// The code of a TLE that is wrong.
const WRONG_TLE: u8 = 11;
/// The code of elements that no orbit belongs to.
const IMPOSSIBLE_ELEMENTS: u8 = 12;
/// The code of a time beyond the integration of the resonance.
const RESONANCE_TIME: u8 = 13;

/// The number in the column `error`; those of SGP4 where it has one.
fn code_of(error: &sgp4_lite::Error) -> u8 {
    error.code().unwrap_or(match error {
        sgp4_lite::Error::ResonanceTime { .. } => RESONANCE_TIME,
        sgp4_lite::Error::Time { .. } => Problem::UNREADABLE,
        _ => IMPOSSIBLE_ELEMENTS,
    })
}

pub(crate) fn problem_of(error: sgp4_lite::Error) -> Problem {
    Problem::of_row(error).with_code(code_of(&error))
}

/// The cells from `error` on.
pub(crate) const STATE_COLUMNS: [&str; 8] = [
    "error",
    "x_teme_km",
    "y_teme_km",
    "z_teme_km",
    "vx_teme_km_s",
    "vy_teme_km_s",
    "vz_teme_km_s",
    "message",
];

pub(crate) fn write_state(state: State, cells: &mut Cells) {
    cells.text("0");
    cells.numbers(state.position_km);
    cells.numbers(state.velocity_km_s);
    cells.text("");
}

pub(crate) fn write_problem(problem: &Problem, cells: &mut Cells) {
    cells.text(&problem.code.to_string());
    for _ in 0..6 {
        cells.nan();
    }
    cells.text(&problem.to_string());
}

/// A satellite, ready to be propagated, or why it cannot be.
#[derive(Debug)]
struct Satellite {
    line1: Vec<u8>,
    line2: Vec<u8>,
    propagator: Result<Propagator, Problem>,
    resume: ResonanceState,
}

/// [`RowCommand`] of `adcs propagate`.
#[derive(Debug)]
pub struct Propagate {
    line1: Column,
    line2: Column,
    minutes: Column,
    checksum: Checksum,
    /// Of the row before: a table often has many times of one satellite.
    satellite: Option<Satellite>,
}

impl Propagate {
    /// Finds the columns.
    ///
    /// # Errors
    /// [`Failure`] when a column is missing.
    pub fn bind(header: &Header, checksum: Checksum) -> Result<Self, Failure> {
        let [line1, line2, minutes] = header.columns(["line1", "line2", "tsince_min"])?;
        Ok(Self { line1, line2, minutes, checksum, satellite: None })
    }

    fn satellite(&mut self, row: Row<'_>) -> &mut Satellite {
        let (line1, line2) = (row.bytes(self.line1), row.bytes(self.line2));
        let is_same = |known: &Satellite| known.line1 == line1 && known.line2 == line2;
        let satellite = match self.satellite.take() {
            Some(known) if is_same(&known) => known,
            _ => Satellite {
                propagator: self.propagator(line1, line2),
                line1: line1.to_vec(),
                line2: line2.to_vec(),
                resume: ResonanceState::default(),
            },
        };
        self.satellite.insert(satellite)
    }

    fn propagator(&self, line1: &[u8], line2: &[u8]) -> Result<Propagator, Problem> {
        let elements = match self.checksum {
            Checksum::Verify => Elements::from_tle(line1, line2),
            Checksum::Ignore => Elements::from_tle_lenient(line1, line2),
        };
        let elements = elements.map_err(|error| {
            let in_line2 = tle_file::place(&error).is_some_and(|place| place.line == 2);
            let column = if in_line2 { self.line2 } else { self.line1 };
            Problem::of_column(column, format!("TLE {error}")).with_code(WRONG_TLE)
        })?;
        Propagator::new(&elements).map_err(problem_of)
    }
}

impl RowCommand for Propagate {
    fn computed(&self) -> &'static [&'static str] {
        &STATE_COLUMNS
    }

    fn left_out(&self) -> Vec<Column> {
        vec![self.line1, self.line2]
    }

    fn compute(&mut self, row: Row<'_>, cells: &mut Cells) -> Result<(), Problem> {
        let minutes = row.number(self.minutes)?;
        let satellite = self.satellite(row);
        let propagator = satellite.propagator.as_ref().map_err(Clone::clone)?;
        let time = MinutesSinceEpoch(minutes);
        let state =
            propagator.propagate_resumed(time, &mut satellite.resume).map_err(problem_of)?;
        write_state(state, cells);
        Ok(())
    }

    fn bad_row(&self, problem: &Problem, cells: &mut Cells) {
        write_problem(problem, cells);
    }
}
