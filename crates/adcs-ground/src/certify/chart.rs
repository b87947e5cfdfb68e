//! The result as a picture: the largest multiplier over inclination, a line for each altitude.

use anyhow::{Result, anyhow};
use plotters::prelude::*;

use super::certificate::Certificate;
use crate::report::chart::colour;

const SIZE: (u32, u32) = (960, 420);

/// The picture as the text of an SVG file.
///
/// # Errors
/// When the backend fails, which it has no reason to: it writes into memory.
pub fn svg(certificate: &Certificate) -> Result<String> {
    let mut text = String::new();
    draw(certificate, SVGBackend::with_string(&mut text, SIZE))
        .map_err(|error| anyhow!("drawing the certificate: {error}"))?;
    Ok(text)
}

fn draw<DB: DrawingBackend>(
    certificate: &Certificate,
    backend: DB,
) -> Result<(), DrawingAreaErrorKind<DB::ErrorType>> {
    let entries = &certificate.entries;
    let low = entries.iter().map(|it| it.inclination_deg).fold(f64::INFINITY, f64::min);
    let high = entries.iter().map(|it| it.inclination_deg).fold(f64::NEG_INFINITY, f64::max);
    let top = entries.iter().map(|it| it.multiplier).fold(1.0, f64::max);
    let root = backend.into_drawing_area();
    root.fill(&WHITE)?;
    let mut chart = ChartBuilder::on(&root)
        .caption(
            "What an error is multiplied by each orbit, the worst of all seasons and bodies",
            ("sans-serif", 17),
        )
        .margin(12)
        .x_label_area_size(40)
        .y_label_area_size(56)
        .build_cartesian_2d(low - 1.0..high + 1.0, 0.0..1.08 * top)?;
    chart
        .configure_mesh()
        .x_desc("inclination, deg")
        .y_desc("multiplier")
        .light_line_style(TRANSPARENT)
        .draw()?;
    let limit = [(low - 1.0, certificate.limit), (high + 1.0, certificate.limit)];
    chart
        .draw_series([PathElement::new(limit, colour::GREY.stroke_width(1))])?
        .label("limit")
        .legend(|(x, y)| PathElement::new([(x, y), (x + 18, y)], colour::GREY));
    let one = [(low - 1.0, 1.0), (high + 1.0, 1.0)];
    chart
        .draw_series([PathElement::new(one, colour::VERMILION.stroke_width(2))])?
        .label("unstable above")
        .legend(|(x, y)| PathElement::new([(x, y), (x + 18, y)], colour::VERMILION));
    let mut altitudes: Vec<f64> = entries.iter().map(|it| it.altitude_km).collect();
    altitudes.sort_by(f64::total_cmp);
    altitudes.dedup();
    let colours = [colour::BLUE, colour::ORANGE, colour::GREEN, colour::PURPLE, colour::SKY];
    for (altitude, colour) in altitudes.iter().zip(colours.iter().cycle()) {
        let mut points: Vec<(f64, f64)> = Vec::new();
        for entry in entries.iter().filter(|it| it.altitude_km == *altitude) {
            match points.iter_mut().find(|(x, _)| *x == entry.inclination_deg) {
                Some((_, y)) => *y = y.max(entry.multiplier),
                None => points.push((entry.inclination_deg, entry.multiplier)),
            }
        }
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        let colour = *colour;
        chart
            .draw_series(LineSeries::new(points.clone(), colour.stroke_width(2)))?
            .label(format!("{altitude} km"))
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], colour));
        chart.draw_series(points.into_iter().map(|at| Circle::new(at, 4, colour.filled())))?;
    }
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::UpperRight)
        .background_style(WHITE.mix(0.8))
        .border_style(colour::GREY)
        .draw()?;
    root.present()
}
