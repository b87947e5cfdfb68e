//! A flight as the person at the terminal sees it: how far it is, what the image says, and Ctrl-C.

use std::fmt::Display;
use std::io::{self, IsTerminal as _, Write as _};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use adcs_ground::flight::{Watcher, World};
use anyhow::{Context as _, Result};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// The wish to stop, made by Ctrl-C or a polite kill.
#[derive(Debug, Clone)]
pub struct Stop(Arc<AtomicBool>);

impl Stop {
    /// Listens from now on. The first signal ends the flight and keeps what was flown; a second one
    /// ends the program.
    pub fn listen() -> Result<Self> {
        let stop = Self(Arc::default());
        let wanted = Arc::clone(&stop.0);
        ctrlc::set_handler(move || {
            if wanted.swap(true, Ordering::Relaxed) {
                std::process::exit(i32::from(INTERRUPTED));
            }
        })
        .context("cannot listen for Ctrl-C")?;
        Ok(stop)
    }

    /// Whether it was made.
    pub fn is_wanted(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// Exit code of a program that was interrupted, as shells have it.
pub const INTERRUPTED: u8 = 130;

/// Prints a line to standard output. One that nobody reads any more is no reason to end: the results
/// are in the output folder.
pub fn print(line: impl Display) {
    let _ = writeln!(io::stdout(), "{line}");
}

/// Prints a line to standard error, likewise.
pub fn complain(line: impl Display) {
    let _ = writeln!(io::stderr(), "{line}");
}

/// Watches one flight: a bar on a terminal, a line each tenth elsewhere.
#[derive(Debug)]
pub struct Console {
    world: World,
    bar: Option<ProgressBar>,
    quiet: bool,
    cycles: u32,
    tenths_said: u32,
    stop: Stop,
}

impl Console {
    /// For a flight of `cycles`.
    pub fn new(world: World, cycles: u32, quiet: bool, stop: &Stop) -> Self {
        let bar = (!quiet && io::stderr().is_terminal()).then(|| {
            let target = ProgressDrawTarget::stderr_with_hz(10);
            let bar = ProgressBar::with_draw_target(Some(cycles.into()), target);
            let template = "{prefix:>4} {bar:40} {percent:>3} %  {elapsed} gone, {eta} left";
            if let Ok(style) = ProgressStyle::with_template(template) {
                bar.set_style(style);
            }
            bar.set_prefix(world.to_string());
            bar
        });
        Self { world, bar, quiet, cycles, tenths_said: 0, stop: stop.clone() }
    }

    /// Takes the bar away.
    pub fn finish(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }

    fn say(&self, line: &str) {
        match &self.bar {
            Some(bar) => bar.suspend(|| complain(line)),
            None => complain(line),
        }
    }
}

impl Watcher for Console {
    fn cycle(&mut self, cycle: u32) {
        if let Some(bar) = &self.bar {
            bar.set_position(cycle.into());
        } else if !self.quiet {
            let tenths = (u64::from(cycle) * 10 / u64::from(self.cycles.max(1))) as u32;
            if tenths > self.tenths_said {
                self.tenths_said = tenths;
                self.say(&format!("{:>4}: {} %", self.world.to_string(), tenths * 10));
            }
        }
    }

    fn log(&mut self, line: &str) {
        if !self.quiet {
            self.say(&format!("{:>4}: {line}", self.world.to_string()));
        }
    }

    fn wants_to_stop(&self) -> bool {
        self.stop.is_wanted()
    }
}
