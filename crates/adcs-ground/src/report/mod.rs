//! What a flight looks like: history, summary, plots, and a page that shows them.

pub mod chart;
pub mod commissioning;
pub mod damping;
mod facts;
pub mod history;
mod page;
pub mod plots;
pub mod pointing;
pub mod rows;
pub mod summary;
pub mod transitions;
pub mod words;

use std::fs;

use anyhow::{Context as _, Result, bail};

use crate::flight::folder;
use crate::flight::{Flight, Flown, Folder};

pub use summary::Summary;

/// Makes everything in `folder` that can be made from its records, also from those of a flight that
/// was cut off.
///
/// # Errors
/// When the folder holds no flight, no cycle of it, or cannot be written.
pub fn make(folder: &Folder) -> Result<Summary> {
    let flight = folder.read_flight()?;
    let flown = Flown::read(&folder.records())?;
    make_of(folder, &flight, &flown)
}

/// The same for a flight that has been read.
///
/// # Errors
/// When not a single cycle was recorded, or the folder cannot be written.
pub fn make_of(folder: &Folder, flight: &Flight, flown: &Flown) -> Result<Summary> {
    let targets = pointing::Targets::of(&flight.mission.scenario);
    let rows = rows::rows(flown, Some(&targets));
    let Some(summary) = summary::summary(flight, flown, &rows, targets.period_s()) else {
        bail!("{}: not a single cycle was recorded", folder.records().display());
    };
    history::write(&folder.history(), &rows)?;
    let mut text = serde_json::to_string_pretty(&summary)?;
    text.push('\n');
    folder::write(&folder.summary(), text)?;
    if let Some(climb) = &summary.commissioning {
        folder::write(&folder.commissioning(), climb.toml(&flight.mission))?;
    }
    let plots = plots::plots(&rows, &summary)?;
    let plot_folder = folder.plots();
    fs::create_dir_all(&plot_folder)
        .with_context(|| format!("{} cannot be made", plot_folder.display()))?;
    for plot in &plots {
        folder::write(&plot_folder.join(plot.name).with_extension("svg"), &plot.svg)?;
    }
    folder::write(&folder.report(), page::page(flight, flown, &summary, &plots))?;
    Ok(summary)
}
