//! `report.html`: one file with everything in it, to be read in any browser, offline.

use std::fmt::Write as _;

use super::facts::facts;
use super::plots::Plot;
use super::summary::Summary;
use super::words;
use crate::flight::{Ending, Flight, Flown};

const STYLE: &str = "
:root { color-scheme: light; }
* { box-sizing: border-box; }
body { margin: 0; background: #f4f5f7; color: #222; font: 16px/1.5 Helvetica, Arial, sans-serif; }
main { max-width: 1000px; margin: 0 auto; padding: 24px 20px 60px; }
h1 { font-size: 1.7rem; line-height: 1.25; margin: 0 0 4px; }
h2 { font-size: 1.2rem; margin: 36px 0 10px; }
p { margin: 8px 0; max-width: 78ch; }
.sub { color: #555; font-size: .92rem; margin: 0 0 14px; }
.numbers { display: grid; grid-template-columns: repeat(auto-fit, minmax(150px, 1fr)); gap: 12px;
  margin: 20px 0; }
.numbers div { background: #fff; border: 1px solid #dcdfe4; border-radius: 8px; padding: 12px 14px; }
.numbers b { display: block; font-size: 1.45rem; line-height: 1.2; white-space: nowrap; }
.numbers span { color: #555; font-size: .85rem; }
figure { margin: 0 0 18px; background: #fff; border: 1px solid #dcdfe4; border-radius: 8px;
  padding: 8px 8px 12px; }
figure svg { display: block; width: 100%; height: auto; }
figure svg polyline { stroke-linejoin: round; }
figcaption { padding: 4px 12px 0; font-size: .92rem; color: #333; }
table { border-collapse: collapse; background: #fff; border: 1px solid #dcdfe4; width: 100%;
  font-size: .92rem; }
th, td { text-align: left; vertical-align: top; padding: 6px 12px; border-top: 1px solid #eceef1; }
tr:first-child th, tr:first-child td { border-top: 0; }
th { width: 15em; font-weight: 600; color: #444; }
td { overflow-wrap: anywhere; }
td code { white-space: pre-wrap; }
code, pre { font-family: Menlo, Consolas, 'DejaVu Sans Mono', monospace; font-size: .88em; }
pre { margin: 0; overflow-x: auto; }
.warning { background: #fff4e5; border: 1px solid #e69f00; border-radius: 8px; padding: 10px 14px;
  margin: 14px 0; }
.good { background: #e8f5f0; border: 1px solid #009e73; border-radius: 8px; padding: 10px 14px;
  margin: 14px 0; }
@media print { body { background: #fff; } figure { break-inside: avoid; } }
";

/// The page of a flight.
pub fn page(flight: &Flight, flown: &Flown, summary: &Summary, plots: &[Plot]) -> String {
    let mut html = String::new();
    let title = escaped(&flight.mission.title);
    // Writing into a String cannot fail.
    let _ = write!(
        html,
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <title>{title}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n<main>\n\
         <h1>{title}</h1>\n<p class=\"sub\">{} · flown on {} · {:.0} s from {}</p>\n<p>{}</p>\n",
        escaped(&flight.mission.name),
        world_in_words(flight),
        summary.flown_s,
        flight.mission.scenario.world.start,
        escaped(&with_true_minus(&flight.mission.description)),
    );
    html.push_str(&banners(flight, flown, summary));
    html.push_str(&big_numbers(summary));
    html.push_str("<h2>What one sees</h2>\n");
    for plot in plots {
        let caption = escaped(&with_true_minus(&caption(plot.name, summary)));
        let _ =
            write!(html, "<figure>\n{}\n<figcaption>{caption}</figcaption>\n</figure>\n", plot.svg);
    }
    html.push_str("<h2>In numbers</h2>\n");
    html.push_str(&table(&numbers(summary)));
    html.push_str("<h2>What was flown</h2>\n");
    html.push_str(&table(&facts(&flight.mission)));
    html.push_str("<h2>Beside this page</h2>\n");
    html.push_str(&table(&[
        ("history.csv", "one row a cycle, units in the header".to_owned()),
        ("summary.json", "the numbers of this page and some more".to_owned()),
        ("plots/", "the plots, one by one".to_owned()),
        (
            "records.bin",
            "every message as it came; the command adcs report makes all of this from it"
                .to_owned(),
        ),
        ("flight.json", "the whole mission in SI units, as it was flown".to_owned()),
    ]));
    html.push_str("</main>\n</body>\n</html>\n");
    html
}

fn world_in_words(flight: &Flight) -> &'static str {
    match flight.world {
        crate::flight::World::Host => "the host",
        crate::flight::World::M4 => "the emulated STM32F405 (Cortex-M4F)",
    }
}

fn caption(plot: &str, summary: &Summary) -> String {
    match plot {
        "modes" => words::modes(summary),
        "pointing" => words::pointing(summary),
        "pointing-settled" => words::pointing_settled(),
        "pointing-rounds" => words::pointing_rounds(),
        "rates" => words::rates(summary),
        "field" => words::field(summary),
        "field-error" => words::field_error(),
        "sun-error" => words::sun_error(),
        "attitude-error" => words::attitude_error(summary),
        "residual-dipole" => words::residual_dipole(),
        "dipoles" => words::dipoles(summary),
        "first-minute" => words::first_minute(),
        "energy" => words::energy(summary),
        _ => words::power(summary),
    }
}

/// What the reader must know before anything else.
fn banners(flight: &Flight, flown: &Flown, summary: &Summary) -> String {
    let mut html = String::new();
    let mut banner = |class: &str, text: String| {
        let _ = writeln!(html, "<p class=\"{class}\">{}</p>", escaped(&text));
    };
    let how_far = format!("up to {:.1} of {:.1} s", summary.flown_s, summary.planned_s);
    match &flight.ending {
        Ending::Complete => {}
        Ending::Interrupted => {
            banner("warning", format!("This flight was interrupted; the report goes {how_far}."));
        }
        Ending::Failed(reason) => {
            banner(
                "warning",
                format!("This flight could not go on: {reason}. The report goes {how_far}."),
            );
        }
        Ending::Unfinished => {
            banner(
                "warning",
                format!("This flight was not brought to its end; the report goes {how_far}."),
            );
        }
    }
    if flight.ending == Ending::Complete && !flown.is_whole() {
        let lost = flown.lost_frames;
        banner("warning", format!("The records are damaged: {lost} frames could not be read."));
    }
    if let Some(other) = &flight.counterpart {
        match &other.difference {
            None => banner(
                "good",
                format!(
                    "The same mission flown on {} gave the same bits in every reading, state and \
                     command of every cycle.",
                    other.world
                ),
            ),
            Some(difference) => banner(
                "warning",
                format!("The same mission flown on {} gave other bits: {difference}.", other.world),
            ),
        }
    }
    html
}

fn big_numbers(summary: &Summary) -> String {
    let rates = &summary.rates;
    let or_dash = |value: Option<f64>, decimals: usize| {
        value.map_or_else(|| "–".to_owned(), |value| format!("{value:.decimals$}"))
    };
    let numbers = [
        (format!("{:.2} deg/s", rates.start_norm_deg_s), "rate at the start"),
        (format!("{:.2} deg/s", rates.end_norm_deg_s), "rate at the end"),
        (or_dash(rates.ratio, 3), "end over start"),
        (or_dash(summary.energy.ratio, 3), "energy, end over start"),
        (format!("{:.0} %", summary.torquers.duty * 100.0), "of the time torquers on"),
    ];
    let boxes = numbers
        .iter()
        .map(|(number, label)| format!("<div><b>{number}</b><span>{label}</span></div>"));
    format!("<div class=\"numbers\">{}</div>\n", boxes.collect::<String>())
}

fn numbers(summary: &Summary) -> Vec<(&'static str, String)> {
    let rates = &summary.rates;
    let vector = |v: [f64; 3]| format!("{:.3}, {:.3}, {:.3}", v[0], v[1], v[2]);
    let or_none = |text: Option<String>| text.unwrap_or_else(|| "–".to_owned());
    let mut rows = vec![
        (
            "digest",
            summary.digest.clone().unwrap_or_else(|| "none: the flight is not whole".to_owned()),
        ),
        (
            "flown",
            format!(
                "{:.1} of {:.1} s, {} cycles",
                summary.flown_s, summary.planned_s, summary.cycles
            ),
        ),
    ];
    rows.extend(rates.listed.iter().map(|at| {
        (
            "rate x, y, z; length",
            format!(
                "t = {:.0} s: {}; {:.3} deg/s",
                at.time_s,
                vector(at.rate_deg_s),
                at.norm_deg_s
            ),
        )
    }));
    rows.extend(summary.pointing.as_ref().map(|it| {
        let text = format!(
            "{:.2} deg mean, {:.2} deg 95 %, {:.2} deg at most from {:.0} s on",
            it.mean_deg, it.p95_deg, it.largest_deg, it.settled_s
        );
        ("angle to the target", text)
    }));
    rows.extend(summary.transitions.iter().map(|at| {
        let time_s = at.time_ms as f64 / 1e3;
        ("modes", format!("t = {time_s:.1} s: {} to {}: {}", at.from, at.to, at.cause))
    }));
    rows.extend(summary.commissioning.iter().flat_map(|climb| &climb.rungs).map(|at| {
        let time_s = at.time_ms as f64 / 1e3;
        let found = at.found.iter().map(ToString::to_string).collect::<Vec<_>>().join("; ");
        ("commissioning", format!("t = {time_s:.1} s: {}: {}. {found}", at.rung, at.outcome))
    }));
    let damping = summary.damping.map(|damping| {
        damping.map_or_else(|| "–".to_owned(), |damping| format!("{:.3}", damping.ratio))
    });
    rows.extend([
        ("damping ratios x, y, z", damping.join(", ")),
        (
            "kinetic energy",
            format!(
                "{:.4} mJ at the start, {:.4} mJ at the end",
                summary.energy.start_j * 1e3,
                summary.energy.end_j * 1e3
            ),
        ),
        ("work of the control torque", format!("{:+.4} mJ", summary.control.work_j * 1e3)),
        (
            "cycles by control status",
            summary
                .control
                .states
                .iter()
                .map(|(state, count)| format!("{state} {count}"))
                .collect::<Vec<_>>()
                .join(", "),
        ),
        ("missing readings", missing(summary)),
        ("protocol violations", or_none(summary.violations.map(|count| count.to_string()))),
        ("time on this computer", or_none(summary.wall_s.map(|wall_s| format!("{wall_s:.2} s")))),
        (
            "speed",
            or_none(
                summary.speed_over_real_time.map(|speed| format!("{speed:.0} times real time")),
            ),
        ),
    ]);
    rows
}

fn missing(summary: &Summary) -> String {
    let missing = &summary.missing;
    if missing.reasons.is_empty() {
        return "none".to_owned();
    }
    let reasons = missing.reasons.iter().map(|(reason, count)| format!("{reason} {count}"));
    format!(
        "gyro axes {}, magnetometer axes {} while measuring and {} otherwise ({})",
        missing.gyro_axes,
        missing.magnetometer_axes_measuring,
        missing.magnetometer_axes_otherwise,
        reasons.collect::<Vec<_>>().join(", ")
    )
}

/// Headings of texts whose every letter and blank counts.
const VERBATIM: [&str; 3] = ["digest", "orbit", "files"];

/// Two columns; a heading that repeats is written once.
fn table(rows: &[(&str, String)]) -> String {
    let mut html = "<table>\n".to_owned();
    let mut last = "";
    for (heading, text) in rows {
        let shown = if *heading == last { "" } else { heading };
        let text = match VERBATIM.contains(heading) {
            true => format!("<code>{}</code>", escaped(text)),
            false => escaped(&with_true_minus(text)),
        };
        let _ = writeln!(html, "<tr><th>{}</th><td>{text}</td></tr>", escaped(shown));
        last = heading;
    }
    html.push_str("</table>\n");
    html
}

/// The text with a minus before numbers, not a hyphen.
fn with_true_minus(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    let mut letters = text.chars().peekable();
    let mut before = ' ';
    while let Some(letter) = letters.next() {
        let is_minus = letter == '-'
            && letters.peek().is_some_and(char::is_ascii_digit)
            && !before.is_alphanumeric();
        out.push(if is_minus { '\u{2212}' } else { letter });
        before = letter;
    }
    out
}

/// Text as HTML shows it.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_of_a_mission_cannot_become_markup() {
        assert_eq!(escaped("<b a=\"x\">&"), "&lt;b a=&quot;x&quot;&gt;&amp;");
    }

    #[test]
    fn numbers_get_a_minus_and_words_keep_their_hyphen() {
        assert_eq!(with_true_minus("-1.5 of x-ray B-2"), "\u{2212}1.5 of x-ray B-2");
    }

    #[test]
    fn a_repeated_heading_is_written_once() {
        let html = table(&[("rate", "1".to_owned()), ("rate", "2".to_owned())]);
        assert_eq!(html.matches("<th>rate</th>").count(), 1);
        assert_eq!(html.matches("<th></th>").count(), 1);
    }
}
