//! Which charts a report has.

use adcs_core::attitude::selection::AttitudeSource;
use adcs_core::modes::Mode;
use adcs_core::schedule::Phase;
use adcs_core::sensing::FaceVerdict;
use anyhow::Result;

use super::chart::{Chart, Series, Strip, Style, colour};
use super::rows::{Row, norm};
use super::summary::Summary;
use super::transitions;

/// How much of the flight the close-up shows, s.
const CLOSE_UP_S: f64 = 60.0;
/// How much of the end of a flight that points is shown round by round, s.
const LAST_S: f64 = 300.0;

/// A chart, drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct Plot {
    /// The name of its file, without `.svg`.
    pub name: &'static str,
    /// The SVG.
    pub svg: String,
}

/// All charts of a flight, in the order of the report.
///
/// # Errors
/// When one cannot be drawn.
pub fn plots(rows: &[Row], summary: &Summary) -> Result<Vec<Plot>> {
    let draw = |name, chart: Chart| -> Result<Plot> { Ok(Plot { name, svg: chart.svg()? }) };
    let end_s = rows.last().map_or(0.0, |row| row.time_s);
    let first_minute = rows.iter().take_while(|row| row.time_s <= CLOSE_UP_S).count();
    let mut plots = Vec::new();
    if rows.iter().any(|row| row.mode.is_some()) {
        plots.push(draw("modes", modes(rows))?);
    }
    if let Some(pointing) = &summary.pointing {
        plots.push(draw("pointing", pointing_error(rows, "Angle to the target"))?);
        let settled = rows.partition_point(|row| row.time_s < pointing.settled_s);
        let settled = rows.get(settled..).unwrap_or_default();
        plots.push(draw("pointing-settled", pointing_settled(settled))?);
        let last = rows.partition_point(|row| row.time_s < end_s - LAST_S);
        if last > 0
            && let Some(last) = rows.get(last..)
        {
            plots.push(draw("pointing-rounds", pointing_rounds(last))?);
        }
    }
    plots.extend([draw("rates", rates(rows))?, draw("field", field(rows))?]);
    if rows.iter().any(|row| row.measured_field_nt.is_some()) {
        plots.push(draw("field-error", field_error(rows))?);
    }
    if rows.iter().any(|row| row.measured_sun.value().is_some()) {
        plots.push(draw("sun-error", sun_error(rows))?);
    }
    if rows.iter().any(|row| attitude_error(row).is_some()) {
        plots.push(draw("attitude-error", attitude_errors(rows))?);
    }
    if rows.iter().any(|row| residual_dipole(row).is_some()) {
        plots.push(draw("residual-dipole", residual_dipoles(rows))?);
    }
    plots.push(draw("dipoles", dipoles(rows, "Dipole of the torquers"))?);
    let acted = rows.iter().any(is_driven);
    if acted
        && end_s > 2.0 * CLOSE_UP_S
        && let Some(close_up) = rows.get(..first_minute)
    {
        plots
            .push(draw("first-minute", dipoles(close_up, "Dipole of the torquers, first minute"))?);
    }
    plots.push(draw("energy", energy(rows))?);
    if acted {
        plots.push(draw("power", power(rows))?);
    }
    Ok(plots)
}

fn chart(title: &'static str, y_label: &'static str, rows: &[Row], series: Vec<Series>) -> Chart {
    let span_s =
        (rows.first().map_or(0.0, |row| row.time_s), rows.last().map_or(1.0, |row| row.time_s));
    let (bands, strips) = (Vec::new(), Vec::new());
    Chart { title, y_label, series, bands, band_label: "", strips, span_s, from_zero: true }
}

fn series(
    label: Option<&'static str>,
    colour: plotters::style::RGBColor,
    style: Style,
    rows: &[Row],
    value: impl Fn(&Row) -> Option<f64>,
) -> Series {
    let points = rows.iter().map(|row| (row.time_s, value(row))).collect();
    Series { label, colour, style, points }
}

/// One series for each axis.
fn axes(
    style: Style,
    rows: &[Row],
    value: impl Fn(&Row) -> Option<[f64; 3]>,
) -> impl Iterator<Item = Series> {
    (0..3).map(move |axis| {
        let of_axis = |row: &Row| value(row).map(|xyz| xyz[axis]);
        series(Some(["x", "y", "z"][axis]), colour::AXES[axis], style, rows, of_axis)
    })
}

fn rates(rows: &[Row]) -> Chart {
    let measured = axes(Style::Line(0.8), rows, |row| row.measured_rate_deg_s)
        .map(|series| Series { label: None, colour: colour::pale(series.colour), ..series });
    let mut all: Vec<Series> = measured.collect();
    all.extend(axes(Style::Line(1.6), rows, |row| Some(row.rate_deg_s)));
    all.push(series(Some("|ω|"), colour::BLACK, Style::Line(1.8), rows, |row| {
        Some(row.rate_norm_deg_s)
    }));
    chart("Rate of the body: true, and measured (pale)", "rate, deg/s", rows, all)
}

/// A colour for each mode.
fn mode_colour(mode: Mode) -> (&'static str, plotters::style::RGBColor) {
    match mode {
        Mode::Off => ("off", colour::pale(colour::GREY)),
        Mode::Safe => ("safe", colour::GREY),
        Mode::Detumble => ("detumble", colour::ORANGE),
        Mode::Acquire => ("acquire", colour::SKY),
        Mode::Point => ("point", colour::GREEN),
        Mode::Experiment => ("experiment", colour::PURPLE),
    }
}

/// The modes along the upper edge.
fn strips(rows: &[Row]) -> Vec<Strip> {
    let spans = transitions::spans(rows).into_iter();
    spans
        .map(|(mode, spans)| {
            let (label, colour) = mode_colour(mode);
            Strip { label, colour, spans }
        })
        .collect()
}

fn modes(rows: &[Row]) -> Chart {
    let rate = series(None, colour::BLACK, Style::Line(1.6), rows, |row| Some(row.rate_norm_deg_s));
    let title = "Modes, and the rate of the body";
    Chart { strips: strips(rows), ..chart(title, "|ω|, deg/s", rows, vec![rate]) }
}

/// The true angle to the target; eclipse shaded, modes along the edge.
fn pointing_error(rows: &[Row], title: &'static str) -> Chart {
    let error = series(None, colour::BLACK, Style::Line(1.4), rows, |row| row.pointing_error_deg);
    Chart {
        bands: eclipses(rows),
        band_label: "eclipse",
        strips: strips(rows),
        ..chart(title, "error, deg", rows, vec![error])
    }
}

/// The same after settling, beside what the satellite believes, and how well it knows.
fn pointing_settled(rows: &[Row]) -> Chart {
    let whole = pointing_error(rows, "Angle to the target, settled");
    let sigma = series(Some("3 σ of the attitude"), colour::SKY, Style::Line(1.0), rows, |row| {
        Some(3.0 * row.believed?.attitude_sigma_deg?)
    });
    let believed = series(Some("as believed"), colour::VERMILION, Style::Dots, rows, |row| {
        row.believed_pointing_deg.filter(|_| row.phase == Phase::Measuring)
    });
    let truth = whole.series.into_iter().map(|truth| Series { label: Some("true"), ..truth });
    Chart {
        series: [sigma, believed].into_iter().chain(truth).collect(),
        strips: Vec::new(),
        ..pointing_error(rows, whole.title)
    }
}

/// Some rounds of it: the torquers' windows shaded.
fn pointing_rounds(rows: &[Row]) -> Chart {
    let error =
        series(Some("true"), colour::BLACK, Style::Line(1.4), rows, |row| row.pointing_error_deg);
    let believed = series(Some("as believed"), colour::VERMILION, Style::Dots, rows, |row| {
        row.believed_pointing_deg.filter(|_| row.phase == Phase::Measuring)
    });
    let title = "Angle to the target, last five minutes";
    Chart {
        bands: acting(rows),
        band_label: "torquers act",
        from_zero: false,
        ..chart(title, "error, deg", rows, vec![error, believed])
    }
}

fn microtesla(nt: f64) -> f64 {
    nt / 1e3
}

fn field(rows: &[Row]) -> Chart {
    let model = series(
        Some("model (IGRF at the SGP4 position)"),
        colour::BLACK,
        Style::Line(1.6),
        rows,
        |row| row.model_field_norm_nt.map(microtesla),
    );
    let measured =
        series(Some("as measured on board"), colour::VERMILION, Style::Dots, rows, |row| {
            row.measured_field_nt.map(|field| microtesla(norm(field)))
        });
    let chart = chart("Strength of the geomagnetic field", "|B|, µT", rows, vec![model, measured]);
    Chart { from_zero: false, ..chart }
}

fn field_error(rows: &[Row]) -> Chart {
    let error = series(None, colour::VERMILION, Style::Dots, rows, |row| {
        Some(microtesla(norm(row.measured_field_nt?) - row.model_field_norm_nt?))
    });
    chart("Measured minus model field strength", "|B| error, µT", rows, vec![error])
}

fn sun_error(rows: &[Row]) -> Chart {
    let seen = |row: &Row| row.sun_faces.iter().filter(|f| **f == FaceVerdict::Used).count();
    let error = |row: &Row| row.measured_sun.value().map(|sun| sun.error_deg);
    let one = series(Some("one face"), colour::VERMILION, Style::Dots, rows, |row| {
        error(row).filter(|_| seen(row) == 1)
    });
    let more = series(Some("two or three faces"), colour::BLUE, Style::Dots, rows, |row| {
        error(row).filter(|_| seen(row) > 1)
    });
    chart("Angle between the measured and the true Sun", "error, deg", rows, vec![one, more])
}

fn attitude_error(row: &Row) -> Option<f64> {
    row.believed?.attitude_error_deg
}

/// The error of the believed attitude, by its source, and 3 σ of what was promised; eclipse shaded.
fn attitude_errors(rows: &[Row]) -> Chart {
    let of = |source: AttitudeSource| {
        move |row: &Row| {
            let believed = row.believed?;
            let from = believed.record.attitude?.source;
            believed.attitude_error_deg.filter(|_| from == source)
        }
    };
    let all = vec![
        series(
            Some("3 σ as promised"),
            colour::pale(colour::BLACK),
            Style::Line(1.2),
            rows,
            |row| Some(3.0 * row.believed?.attitude_sigma_deg?),
        ),
        series(
            Some("two vectors"),
            colour::BLACK,
            Style::Dots,
            rows,
            of(AttitudeSource::TwoVectors),
        ),
        series(Some("MEKF"), colour::BLUE, Style::Dots, rows, of(AttitudeSource::Mekf)),
        series(
            Some("dynamics-aided"),
            colour::VERMILION,
            Style::Dots,
            rows,
            of(AttitudeSource::Dynamic),
        ),
    ];
    let title = "Angle between the believed and the true attitude";
    Chart { bands: eclipses(rows), band_label: "eclipse", ..chart(title, "error, deg", rows, all) }
}

/// When the Sun was out of sight.
fn eclipses(rows: &[Row]) -> Vec<(f64, f64)> {
    let mut bands: Vec<(f64, f64)> = Vec::new();
    let mut open = false;
    for row in rows {
        match bands.last_mut() {
            Some(band) if open && !row.sunlit => band.1 = row.time_s,
            _ if !row.sunlit => bands.push((row.time_s, row.time_s)),
            _ => {}
        }
        open = !row.sunlit;
    }
    bands
}

fn residual_dipole(row: &Row) -> Option<[f64; 3]> {
    Some(row.believed?.record.residual_dipole_am2?.map(f64::from))
}

fn residual_dipoles(rows: &[Row]) -> Chart {
    let all = axes(Style::Line(1.4), rows, residual_dipole).collect();
    let title = "Residual dipole as the dynamics-aided filter estimates it";
    Chart { from_zero: false, ..chart(title, "dipole, A·m²", rows, all) }
}

fn dipoles(rows: &[Row], title: &'static str) -> Chart {
    let all = axes(Style::Steps, rows, |row| row.dipole_am2).collect();
    Chart {
        bands: acting(rows),
        band_label: "torquers act",
        ..chart(title, "dipole, A·m²", rows, all)
    }
}

/// Whether a torquer carries a dipole from this cycle on.
fn is_driven(row: &Row) -> bool {
    row.dipole_am2.is_some_and(|dipole| norm(dipole) > 0.0)
}

/// When the torquers acted: each from the instant of measuring to the next rest.
fn acting(rows: &[Row]) -> Vec<(f64, f64)> {
    let mut bands: Vec<(f64, f64)> = Vec::new();
    let mut open = false;
    for pair in rows.windows(2) {
        let (now, next) = (&pair[0], &pair[1]);
        if is_driven(now) {
            match bands.last_mut() {
                Some(band) if open => band.1 = next.time_s,
                _ => bands.push((now.time_s, next.time_s)),
            }
        }
        open = is_driven(now);
    }
    bands
}

fn energy(rows: &[Row]) -> Chart {
    let line = series(None, colour::BLACK, Style::Line(1.8), rows, |row| Some(row.energy_j * 1e3));
    chart("Kinetic energy of turning", "energy, mJ", rows, vec![line])
}

fn power(rows: &[Row]) -> Chart {
    let line = series(None, colour::BLUE, Style::Steps, rows, |row| {
        row.control_power_w.map(|power| power * 1e6)
    });
    chart(
        "Power of the control torque on the tumble (below zero: it brakes)",
        "power, µW",
        rows,
        vec![line],
    )
}
