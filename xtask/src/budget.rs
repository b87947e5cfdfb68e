//! What the image takes of the chip, held against `budgets.toml`.
//!
//! Flash and RAM come from the sections of the emulated image, which carries the simulated world
//! with it, and of the flight image. Instructions and stack come from the image
//! `bench`, which runs named stages of the flight software on the emulated core and counts.

use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    path::Path,
    time::Duration,
};

use anyhow::{Context as _, Result, bail};
use serde::{Deserialize, Serialize};

use crate::{
    image::{self, Kind},
    process::{is_ci, root, say},
    qemu,
    toolchain::{self, Wish},
};

const LIMITS: &str = "budgets.toml";
/// The counting image needs seconds; this is for a machine that does much else.
const BENCH_TIME: Duration = Duration::from_secs(300);

/// The committed limits. A name is measured if and only if it has a limit.
type Limits = BTreeMap<Unit, BTreeMap<String, u64>>;

/// What is counted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Unit {
    Bytes,
    Instructions,
}

/// One measured figure.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
struct Figure {
    name: String,
    unit: Unit,
    measured: u64,
}

/// One line of the table.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
struct Row {
    #[serde(flatten)]
    figure: Figure,
    limit: Option<u64>,
}

impl Row {
    fn keeps(&self) -> bool {
        self.limit.is_some_and(|limit| self.figure.measured <= limit)
    }
}

/// Measures, prints the table, writes it as JSON if asked, and fails if a limit is exceeded.
pub fn run(wish: Wish, json: Option<&Path>) -> Result<()> {
    let path = root().join(LIMITS);
    let text = fs::read_to_string(&path).with_context(|| format!("reading {}", path.display()))?;
    let limits: Limits = toml::from_str(&text).with_context(|| path.display().to_string())?;

    let rows = compare(measure(wish)?, &limits);
    print!("{}", table(&rows));
    if let Some(path) = json {
        fs::write(path, serde_json::to_string_pretty(&rows)? + "\n")
            .with_context(|| format!("writing {}", path.display()))?;
    }
    verdict(&rows, &limits, is_ci())
}

fn measure(wish: Wish) -> Result<Vec<Figure>> {
    let toolchain = toolchain::find(wish)?;
    let mut figures = Vec::new();
    for (kind, flash, ram) in
        [(Kind::Emulated, "flash", "ram"), (Kind::Flight, "flight_flash", "flight_ram")]
    {
        let size = image::size(&fs::read(image::build(&toolchain, kind)?)?)?;
        let bytes =
            |name: &str, measured| Figure { name: name.into(), unit: Unit::Bytes, measured };
        figures.extend([bytes(flash, size.flash), bytes(ram, size.ram)]);
    }

    match qemu::find() {
        Err(error) if is_ci() => return Err(error),
        Err(error) => say(&format!("left out: stack and instructions, because: {error:#}")),
        Ok(_) => {
            let bench = image::build(&toolchain, Kind::Bench)?;
            say("counting instructions on the emulated core");
            let lines = qemu::run_counting(&bench, &[], BENCH_TIME)?;
            figures.extend(lines.iter().filter_map(|line| parse(line)));
        }
    }
    figures.sort_by_key(|figure| figure.unit);
    Ok(figures)
}

/// A line of the counting image: `instructions NAME COUNT` or `bytes NAME COUNT`.
fn parse(line: &str) -> Option<Figure> {
    let mut words = line.split_whitespace();
    let unit = match words.next()? {
        "instructions" => Unit::Instructions,
        "bytes" => Unit::Bytes,
        _ => return None,
    };
    let (name, measured) = (words.next()?.to_owned(), words.next()?.parse().ok()?);
    words.next().is_none().then_some(Figure { name, unit, measured })
}

fn compare(figures: Vec<Figure>, limits: &Limits) -> Vec<Row> {
    let limit = |figure: &Figure| limits.get(&figure.unit)?.get(&figure.name).copied();
    figures.into_iter().map(|figure| Row { limit: limit(&figure), figure }).collect()
}

fn table(rows: &[Row]) -> String {
    let line = |row: &Row| {
        let Figure { name, unit, measured } = &row.figure;
        let (limit, used) = match row.limit {
            Some(limit) if limit > 0 => {
                (limit.to_string(), format!("{} %", measured * 100 / limit))
            }
            Some(limit) => (limit.to_string(), String::new()),
            None => ("none".into(), String::new()),
        };
        let unit = format!("{unit:?}").to_lowercase();
        format!("{name:<24} {measured:>10} of {limit:>10} {unit:<12} {used:>6}\n")
    };
    rows.iter().map(line).collect()
}

/// `strict`: a limit that nothing was measured for is an error, not a remark.
fn verdict(rows: &[Row], limits: &Limits, strict: bool) -> Result<()> {
    let exceeded = rows.iter().filter(|row| !row.keeps()).map(|row| row.figure.name.as_str());
    let exceeded: Vec<&str> = exceeded.collect();
    if !exceeded.is_empty() {
        bail!("over its limit in {LIMITS}, or without one: {}", exceeded.join(", "));
    }
    let measured: BTreeSet<_> =
        rows.iter().map(|row| (row.figure.unit, &row.figure.name)).collect();
    let all = limits.iter().flat_map(|(&unit, names)| names.keys().map(move |name| (unit, name)));
    let missing: Vec<&str> =
        all.filter(|name| !measured.contains(name)).map(|(_, name)| name.as_str()).collect();
    if !missing.is_empty() {
        say(&format!("not measured, though {LIMITS} limits it: {}", missing.join(", ")));
        if strict {
            bail!("a limit without a measurement guards nothing");
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn limits() -> Limits {
        toml::from_str("[bytes]\nflash = 100\n[instructions]\nsgp4 = 5000\n").unwrap()
    }

    fn figure(name: &str, unit: Unit, measured: u64) -> Figure {
        Figure { name: name.into(), unit, measured }
    }

    #[test]
    fn a_figure_at_its_limit_keeps_it_and_one_more_does_not() {
        let at = compare(vec![figure("flash", Unit::Bytes, 100)], &limits());
        assert!(verdict(&at, &limits(), false).is_ok());
        let over = compare(vec![figure("flash", Unit::Bytes, 101)], &limits());
        let message = verdict(&over, &limits(), false).unwrap_err().to_string();
        assert!(message.contains("flash"), "{message}");
    }

    #[test]
    fn a_figure_without_a_limit_is_refused() {
        let rows = compare(vec![figure("new_stage", Unit::Instructions, 1)], &limits());
        assert!(verdict(&rows, &limits(), false).is_err());
    }

    #[test]
    fn a_limit_for_bytes_does_not_cover_instructions() {
        let rows = compare(vec![figure("flash", Unit::Instructions, 1)], &limits());
        assert_eq!(rows[0].limit, None);
    }

    #[test]
    fn lines_of_the_counting_image_are_read_and_others_are_not() {
        assert_eq!(parse("instructions sgp4 4711"), Some(figure("sgp4", Unit::Instructions, 4711)));
        assert_eq!(parse("bytes stack 12"), Some(figure("stack", Unit::Bytes, 12)));
        for line in ["", "warning: nic", "bytes stack", "bytes stack -1", "bytes stack 1 2"] {
            assert_eq!(parse(line), None, "{line}");
        }
    }

    #[test]
    fn the_table_says_how_much_of_a_limit_is_used() {
        let rows = compare(vec![figure("flash", Unit::Bytes, 25)], &limits());
        let line = table(&rows);
        assert!(line.contains("25 of        100 bytes") && line.contains("25 %"), "{line}");
    }

    #[test]
    fn the_committed_limits_can_be_read() {
        let text = fs::read_to_string(root().join(LIMITS)).unwrap();
        let limits: Limits = toml::from_str(&text).unwrap();
        assert!(limits[&Unit::Bytes]["flash"] <= 1024 * 1024, "the chip has 1 MiB of flash");
    }
}
