//! How far a long run is, for the person who waits for it.

use std::cell::Cell;
use std::io::{self, Read, Write as _};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// Runs that are shorter than this show nothing.
const PATIENCE: Duration = Duration::from_secs(2);

/// A bar on standard error, when that is a terminal, and only after two seconds.
#[derive(Debug)]
pub struct Progress {
    bar: ProgressBar,
    appears: Cell<Option<Instant>>,
}

impl Progress {
    /// Over bytes to be read; without a total when it is not known.
    pub fn of_bytes(total: Option<u64>, wanted: bool) -> Self {
        let template = match total {
            Some(_) => "{bar:40} {bytes}/{total_bytes}  {eta} left",
            None => "{spinner} {bytes}  {elapsed}",
        };
        Self::new(total, template, wanted)
    }

    /// Over steps to be computed.
    pub fn of_steps(total: u64, wanted: bool) -> Self {
        Self::new(Some(total), "{bar:40} {percent} %  {eta} left", wanted)
    }

    fn new(total: Option<u64>, template: &str, wanted: bool) -> Self {
        let bar = ProgressBar::with_draw_target(total, ProgressDrawTarget::hidden());
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style);
        }
        Self { bar, appears: Cell::new(wanted.then(|| Instant::now() + PATIENCE)) }
    }

    /// Goes on by so many bytes or steps.
    pub fn advance(&self, by: u64) {
        self.bar.inc(by);
        if self.appears.get().is_some_and(|instant| Instant::now() >= instant) {
            self.appears.set(None);
            self.bar.set_draw_target(ProgressDrawTarget::stderr());
        }
    }

    /// Writes a line to standard error, above the bar.
    ///
    /// A standard error that cannot be written is no reason to end: the rows are in the output.
    pub fn say(&self, line: impl std::fmt::Display) {
        self.bar.suspend(|| {
            let _ = writeln!(io::stderr(), "{line}");
        });
    }

    /// The same input, counted.
    pub fn watch<R: Read>(&self, input: R) -> impl Read {
        Watched { input, progress: self }
    }

    /// Takes the bar away.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

struct Watched<'a, R> {
    input: R,
    progress: &'a Progress,
}

impl<R: Read> Read for Watched<'_, R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = self.input.read(buffer)?;
        self.progress.advance(count as u64);
        Ok(count)
    }
}
