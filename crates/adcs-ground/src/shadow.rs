//! Entries into and exits from the Earth's shadow, as a table.

use std::cell::Cell;
use std::iter;
use std::path::Path;

use adcs_core::environment::crossings::{CrossingKind, Crossings, SHADOW_STEP_S};
use adcs_core::environment::eclipse::{EarthShape, Shadow, shadow_margin_rad};
use adcs_core::environment::sun::ApparentSun;
use adcs_core::orbit::OrbitModel;
use adcs_core::time::{LeapSeconds, MICROS_PER_SECOND, Utc};
use anyhow::Context as _;

use crate::span::Span;
use crate::table::{self, Tally};

/// Penumbra and umbra, with their names.
const SHADOWS: [(Shadow, &str); 2] = [(Shadow::Penumbra, "penumbra"), (Shadow::Umbra, "umbra")];

/// An orbit in the light of the Sun.
#[derive(Debug)]
pub struct ShadowSearch<'a> {
    /// The satellite.
    pub orbit: &'a OrbitModel,
    /// When to search.
    pub span: Span,
    /// What casts the shadow.
    pub shape: EarthShape,
}

/// One entry or exit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Event {
    /// `penumbra` or `umbra`.
    pub shadow: &'static str,
    /// Which way.
    pub kind: CrossingKind,
    /// After the beginning of the span.
    pub seconds: f64,
}

impl ShadowSearch<'_> {
    /// Writes the events in order of time; `-` is standard output. An orbit that ends within the span
    /// counts as one bad row.
    ///
    /// # Errors
    /// When the span begins before 1972, or the output cannot be written.
    pub fn write(&self, output: &Path) -> anyhow::Result<Tally> {
        const SHADOW_COUNT: u64 = SHADOWS.len() as u64;
        self.span.from().to_tt(&LeapSeconds::BUILT_IN).context("--from")?;
        let steps = self.span.seconds() as u64 * SHADOW_COUNT;
        table::run_without_input(output, steps, |writer, progress| {
            writer.write_record(["shadow", "event", "utc_iso", "t_after_start_s"])?;
            let mut tally = Tally::default();
            for event in self.events(&|seconds| progress.advance(seconds)) {
                match event {
                    Ok(event) => {
                        writer.write_record(self.cells(&event))?;
                        tally.rows += 1;
                    }
                    Err(error) => {
                        progress.say(format_args!("the search ends early: {error}"));
                        tally.bad += 1;
                        break;
                    }
                }
            }
            Ok(tally)
        })
    }

    /// The events in order of time, and the error that ends the search early. `advance` is told by how
    /// many seconds the search for each kind of shadow has gone on.
    pub fn events<'s>(
        &'s self,
        advance: &'s dyn Fn(u64),
    ) -> impl Iterator<Item = anyhow::Result<Event>> + 's {
        let mut searches = SHADOWS.map(|(shadow, name)| {
            let found = self.crossings(shadow, advance).map(move |crossing| {
                crossing.map(|(kind, seconds)| Event { shadow: name, kind, seconds })
            });
            found.peekable()
        });
        iter::from_fn(move || {
            let [penumbra, umbra] = &mut searches;
            // An error comes last, so that no event found before it is lost.
            let time_of = |event: Option<&anyhow::Result<Event>>| match event {
                Some(Ok(event)) => event.seconds,
                Some(Err(_)) => f64::MAX,
                None => f64::INFINITY,
            };
            if time_of(umbra.peek()) < time_of(penumbra.peek()) {
                umbra.next()
            } else {
                penumbra.next()
            }
        })
    }

    fn crossings<'s>(
        &'s self,
        shadow: Shadow,
        advance: &'s dyn Fn(u64),
    ) -> impl Iterator<Item = anyhow::Result<(CrossingKind, f64)>> + 's {
        let reached_s = Cell::new(0);
        let margin_rad = move |seconds: f64| {
            let whole_s = seconds.max(0.0) as u64;
            advance(whole_s.saturating_sub(reached_s.replace(whole_s.max(reached_s.get()))));
            let now = self.utc(seconds);
            let sun = ApparentSun::at(now.to_tt(&LeapSeconds::BUILT_IN)?).position_eci_m();
            let satellite = self.orbit.state(now)?.position;
            Ok(shadow_margin_rad(shadow, satellite, sun, self.shape))
        };
        // A span has a finite length that is not negative, which is all that is asked for.
        let crossings = Crossings::new(margin_rad, self.span.seconds(), SHADOW_STEP_S);
        crossings
            .into_iter()
            .flatten()
            .map(|crossing| crossing.map(|crossing| (crossing.kind, crossing.seconds)))
    }

    fn utc(&self, seconds: f64) -> Utc {
        self.span.from().plus_micros((seconds * MICROS_PER_SECOND as f64).round() as i64)
    }

    fn cells(&self, event: &Event) -> [String; 4] {
        let kind = match event.kind {
            CrossingKind::Entry => "entry",
            CrossingKind::Exit => "exit",
        };
        [
            event.shadow.to_owned(),
            kind.to_owned(),
            to_the_millisecond(self.utc(event.seconds)),
            format!("{:.3}", event.seconds),
        ]
    }
}

/// `2015-11-19T02:55:21.393Z`, rounded.
fn to_the_millisecond(utc: Utc) -> String {
    const MICROS: i64 = 1_000;
    let millis = utc.plus_micros(MICROS / 2).micros_since_2000().div_euclid(MICROS);
    let text = Utc::from_micros_since_2000(millis.saturating_mul(MICROS)).to_string();
    text.strip_suffix("000Z").map_or(text.clone(), |text| format!("{text}Z"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn instants_are_rounded_to_the_millisecond() {
        for (micros, text) in [
            (0, "2000-01-01T00:00:00.000Z"),
            (499, "2000-01-01T00:00:00.000Z"),
            (500, "2000-01-01T00:00:00.001Z"),
            (-1, "2000-01-01T00:00:00.000Z"),
            (-501, "1999-12-31T23:59:59.999Z"),
        ] {
            assert_eq!(to_the_millisecond(Utc::from_micros_since_2000(micros)), text);
        }
    }
}
