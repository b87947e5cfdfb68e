//! States of one satellite at regular times.

use std::path::Path;

use adcs_core::time::Utc;
use sgp4_lite::{Elements, MinutesSinceEpoch, Propagator, ResonanceState};

use crate::columns::propagate::{STATE_COLUMNS, problem_of, write_problem, write_state};
use crate::span::{Span, utc_of_epoch};
use crate::table::{self, Cells, Tally};

const MICROS_PER_MINUTE: f64 = 60e6;

/// An orbit, to be written as a table.
#[derive(Debug, Clone)]
pub struct Ephemeris {
    propagator: Propagator,
    epoch: Utc,
}

impl Ephemeris {
    /// The orbit with these elements.
    ///
    /// # Errors
    /// Those of [`Propagator::new`].
    pub fn new(elements: &Elements) -> Result<Self, sgp4_lite::Error> {
        Ok(Self { propagator: Propagator::new(elements)?, epoch: utc_of_epoch(elements.epoch) })
    }

    /// Writes the states every `step_us` microseconds; `-` is standard output.
    ///
    /// # Errors
    /// When the output cannot be written.
    pub fn write(&self, span: Span, step_us: i64, output: &Path) -> anyhow::Result<Tally> {
        let mut resume = ResonanceState::default();
        table::run_without_input(output, span.steps(step_us), |writer, progress| {
            writer.write_record(["utc_iso", "tsince_min"].iter().chain(&STATE_COLUMNS))?;
            let mut tally = Tally::default();
            let mut cells = Cells::default();
            for utc in span.instants(step_us) {
                let minutes = utc.micros_since(self.epoch) as f64 / MICROS_PER_MINUTE;
                cells.clear();
                cells.text(&utc.to_string());
                cells.number(minutes);
                match self.propagator.propagate_resumed(MinutesSinceEpoch(minutes), &mut resume) {
                    Ok(state) => write_state(state, &mut cells),
                    Err(error) => {
                        let problem = problem_of(error);
                        progress.say(format_args!("{utc}: {problem}"));
                        write_problem(&problem, &mut cells);
                        tally.bad += 1;
                    }
                }
                writer.write_byte_record(cells.fields())?;
                tally.rows += 1;
                progress.advance(1);
            }
            Ok(tally)
        })
    }
}
