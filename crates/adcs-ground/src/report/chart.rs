//! A chart over time as SVG.

use anyhow::{Result, anyhow};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// Size of a chart, CSS pixels.
const WIDTH: u32 = 960;
const HEIGHT: u32 = 300;
/// The backend draws in whole pixels; drawn this much larger, lines are smooth to a quarter of one.
const FINE: u32 = 4;
/// The backend takes a font of size s to have letters of s / 1.24.
const FONT_FACTOR: f64 = 1.24;
const FONT: &str = "Helvetica, Arial, sans-serif";
const TEXT_PX: f64 = 13.0;
/// Mean width of a letter of that font, in letter sizes.
const LETTER_WIDTH: f64 = 0.52;
/// More points than this cannot be told apart on a chart: two for each pixel column.
const MAX_POINTS: usize = 2 * WIDTH as usize;
/// More bands than this would be a grey smear.
const MAX_BANDS: usize = 200;

/// Colours that differ for colour-blind people too.
///
/// Source: Okabe & Ito (2008), "Color Universal Design".
pub mod colour {
    use plotters::style::RGBColor;

    /// For x.
    pub const BLUE: RGBColor = RGBColor(0, 114, 178);
    /// For y.
    pub const ORANGE: RGBColor = RGBColor(230, 159, 0);
    /// For z.
    pub const GREEN: RGBColor = RGBColor(0, 158, 115);
    /// For lengths and sums.
    pub const BLACK: RGBColor = RGBColor(30, 30, 30);
    /// For what is safe, and waits.
    pub const GREY: RGBColor = RGBColor(120, 120, 120);
    /// For what is on its way.
    pub const SKY: RGBColor = RGBColor(86, 180, 233);
    /// For what is special.
    pub const PURPLE: RGBColor = RGBColor(204, 121, 167);
    /// For what was measured.
    pub const VERMILION: RGBColor = RGBColor(213, 94, 0);
    /// x, y, z.
    pub const AXES: [RGBColor; 3] = [BLUE, ORANGE, GREEN];

    /// The same, as seen through milk.
    pub fn pale(RGBColor(r, g, b): RGBColor) -> RGBColor {
        let mix = |c: u8| (f64::from(c) * 0.35 + 255.0 * 0.65) as u8;
        RGBColor(mix(r), mix(g), mix(b))
    }
}

const GRID: RGBColor = RGBColor(222, 222, 222);
const BAND: RGBColor = RGBColor(233, 233, 233);
const INK: RGBColor = RGBColor(60, 60, 60);

/// How a series is drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Style {
    /// A line of this width, CSS pixels.
    Line(f64),
    /// A dot at each point.
    Dots,
    /// A line that keeps each value until the next.
    Steps,
}

/// One line or cloud of dots.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// What the legend calls it; nothing when it is not in the legend.
    pub label: Option<&'static str>,
    /// Its colour.
    pub colour: RGBColor,
    /// How it is drawn.
    pub style: Style,
    /// Time (s) and value; `None` leaves a gap.
    pub points: Vec<(f64, Option<f64>)>,
}

/// Times in one colour along the upper edge of a chart.
#[derive(Debug, Clone, PartialEq)]
pub struct Strip {
    /// What the legend calls them.
    pub label: &'static str,
    /// Their colour.
    pub colour: RGBColor,
    /// The times, s.
    pub spans: Vec<(f64, f64)>,
}

/// Height of the strip, as a fraction of the plot's.
const STRIP: f64 = 0.05;

/// A chart over time.
#[derive(Debug, Clone, PartialEq)]
pub struct Chart {
    /// What it shows.
    pub title: &'static str,
    /// The value axis, with its unit.
    pub y_label: &'static str,
    /// What is drawn, the first at the bottom.
    pub series: Vec<Series>,
    /// Times (s) with a grey ground.
    pub bands: Vec<(f64, f64)>,
    /// What the legend calls them.
    pub band_label: &'static str,
    /// Coloured times along the upper edge.
    pub strips: Vec<Strip>,
    /// First and last time, s.
    pub span_s: (f64, f64),
    /// Whether zero must be on the value axis.
    pub from_zero: bool,
}

/// A unit for the time axis that keeps its numbers short.
fn time_unit(span_s: f64) -> (f64, &'static str) {
    match span_s {
        ..=7200.0 => (1.0, "time since the start, s"),
        ..=172_800.0 => (60.0, "time since the start, min"),
        _ => (3600.0, "time since the start, h"),
    }
}

fn px(css: f64) -> i32 {
    (css * f64::from(FINE)).round() as i32
}

fn stroke(colour: RGBColor, width_px: f64) -> ShapeStyle {
    colour.stroke_width(px(width_px) as u32)
}

fn font(size_px: f64) -> TextStyle<'static> {
    (FONT, size_px * f64::from(FINE) * FONT_FACTOR).into_font().color(&INK)
}

impl Chart {
    /// The chart as the text of an SVG file.
    ///
    /// # Errors
    /// When the backend fails, which it has no reason to: it writes into memory.
    pub fn svg(&self) -> Result<String> {
        let mut svg = String::new();
        self.draw(SVGBackend::with_string(&mut svg, (WIDTH * FINE, HEIGHT * FINE)))
            .map_err(|error| anyhow!("drawing {:?}: {error}", self.title))?;
        // The viewBox stays: what was drawn large is shown small.
        let large = format!(r#"width="{}" height="{}""#, WIDTH * FINE, HEIGHT * FINE);
        Ok(svg.replacen(&large, &format!(r#"width="{WIDTH}" height="{HEIGHT}""#), 1))
    }

    fn draw<DB: DrawingBackend>(
        &self,
        backend: DB,
    ) -> Result<(), DrawingAreaErrorKind<DB::ErrorType>> {
        let root = backend.into_drawing_area();
        root.fill(&WHITE)?;
        let (head, body) = root.split_vertically(px(28.0));
        self.draw_head(&head)?;

        let (per_unit, x_label) = time_unit(self.span_s.1 - self.span_s.0);
        let (x_from, x_to) = (self.span_s.0 / per_unit, self.span_s.1 / per_unit);
        let (y_from, y_to) = self.value_range();
        let mut chart = ChartBuilder::on(&body)
            .margin_right(px(22.0))
            .margin_left(px(4.0))
            .margin_top(px(4.0))
            .x_label_area_size(px(38.0))
            .y_label_area_size(px(66.0))
            .build_cartesian_2d(x_from..x_to.max(x_from + 1e-9), y_from..y_to)?;
        if self.bands.len() <= MAX_BANDS {
            chart.draw_series(self.bands.iter().map(|&(from, to)| {
                Rectangle::new([(from / per_unit, y_from), (to / per_unit, y_to)], BAND.filled())
            }))?;
        }
        for Strip { colour, spans, .. } in &self.strips {
            let below = y_to - STRIP * (y_to - y_from);
            chart.draw_series(spans.iter().map(|&(from, to)| {
                Rectangle::new([(from / per_unit, below), (to / per_unit, y_to)], colour.filled())
            }))?;
        }
        let decimals = decimals_for(y_to - y_from);
        chart
            .configure_mesh()
            .x_desc(x_label)
            .y_desc(self.y_label)
            .x_label_formatter(&|x| number(*x, decimals_for(x_to - x_from)))
            .y_label_formatter(&|y| number(*y, decimals))
            .x_labels(13)
            .y_labels(7)
            .axis_desc_style(font(TEXT_PX))
            .label_style(font(12.0))
            .axis_style(stroke(INK, 0.8))
            .bold_line_style(stroke(GRID, 0.6))
            .light_line_style(TRANSPARENT)
            .draw()?;
        if y_from < 0.0 && y_to > 0.0 {
            let zero = [(x_from, 0.0), (x_to, 0.0)];
            chart.draw_series([PathElement::new(zero, stroke(INK, 0.8))])?;
        }
        for series in &self.series {
            for piece in pieces(series, self.span_s.1) {
                let piece = piece.iter().map(|&(t, y)| (t / per_unit, y));
                match series.style {
                    Style::Dots => {
                        let dot = |at| Circle::new(at, px(1.8), series.colour.filled());
                        chart.draw_series(piece.map(dot))?;
                    }
                    Style::Line(width) => {
                        let line = piece.collect::<Vec<_>>();
                        chart
                            .draw_series([PathElement::new(line, stroke(series.colour, width))])?;
                    }
                    Style::Steps => {
                        let line = piece.collect::<Vec<_>>();
                        chart.draw_series([PathElement::new(line, stroke(series.colour, 1.3))])?;
                    }
                }
            }
        }
        root.present()
    }

    /// The title on the left, the legend on the right, above the plot so that it covers nothing.
    fn draw_head<DB: DrawingBackend>(
        &self,
        head: &DrawingArea<DB, plotters::coord::Shift>,
    ) -> Result<(), DrawingAreaErrorKind<DB::ErrorType>> {
        let middle = px(14.0);
        let left = Pos::new(HPos::Left, VPos::Center);
        let title = (FONT, TEXT_PX * f64::from(FINE) * FONT_FACTOR, FontStyle::Bold);
        let title = title.into_font().color(&INK).pos(left);
        head.draw(&Text::new(self.title, (px(10.0), middle), title))?;

        let labelled = self.series.iter().filter_map(|series| Some((series, series.label?)));
        let mut entries: Vec<_> =
            labelled.map(|(series, label)| (Sample::Series(series), label)).collect();
        if !self.bands.is_empty() && self.bands.len() <= MAX_BANDS {
            entries.push((Sample::Ground(BAND), self.band_label));
        }
        entries.extend(self.strips.iter().map(|it| (Sample::Ground(it.colour), it.label)));
        let (sample, gap, space) = (px(20.0), px(6.0), px(18.0));
        let text_width = |label: &str| px(label.chars().count() as f64 * TEXT_PX * LETTER_WIDTH);
        let total: i32 =
            entries.iter().map(|(_, label)| sample + gap + text_width(label) + space).sum();
        let mut x = px(f64::from(WIDTH)) - total;
        for (series, label) in entries {
            match series {
                Sample::Ground(colour) => head.draw(&Rectangle::new(
                    [(x, middle - px(5.0)), (x + sample, middle + px(5.0))],
                    colour.filled(),
                ))?,
                Sample::Series(Series { style: Style::Dots, colour, .. }) => {
                    head.draw(&Circle::new((x + sample / 2, middle), px(2.5), colour.filled()))?;
                }
                Sample::Series(Series { colour, .. }) => head.draw(&PathElement::new(
                    [(x, middle), (x + sample, middle)],
                    stroke(*colour, 2.5),
                ))?,
            }
            let style = font(TEXT_PX).pos(left);
            head.draw(&Text::new(label, (x + sample + gap, middle), style))?;
            x += sample + gap + text_width(label) + space;
        }
        Ok(())
    }

    fn value_range(&self) -> (f64, f64) {
        let values = || {
            let all = self.series.iter().flat_map(|series| &series.points);
            all.filter_map(|(_, value)| value.filter(|value| value.is_finite()))
        };
        let mut low = values().fold(f64::INFINITY, f64::min);
        let mut high = values().fold(f64::NEG_INFINITY, f64::max);
        if low > high {
            return (0.0, 1.0);
        }
        if self.from_zero {
            (low, high) = (low.min(0.0), high.max(0.0));
        }
        if low == high {
            let room = low.abs().max(1.0);
            return (low - room, high + room);
        }
        let room = (high - low) * 0.05;
        let keep_zero =
            |edge: f64, moved: f64| if self.from_zero && edge == 0.0 { 0.0 } else { moved };
        // Above what is drawn there is room for the strip.
        let strip = if self.strips.is_empty() { 0.0 } else { (high - low) * STRIP };
        (keep_zero(low, low - room), keep_zero(high, high + room) + strip)
    }
}

/// What stands before a text of the legend.
enum Sample<'a> {
    Series(&'a Series),
    Ground(RGBColor),
}

/// The unbroken pieces of a series, thinned to what can be seen.
fn pieces(series: &Series, end_s: f64) -> Vec<Vec<(f64, f64)>> {
    let mut pieces = vec![Vec::new()];
    for (index, &(t, value)) in series.points.iter().enumerate() {
        let Some(value) = value.filter(|value| value.is_finite()) else {
            pieces.push(Vec::new());
            continue;
        };
        if let Some(piece) = pieces.last_mut() {
            piece.push((t, value));
            if series.style == Style::Steps {
                let until = series.points.get(index + 1).map_or(end_s, |(next, _)| *next);
                piece.push((until, value));
            }
        }
    }
    pieces.retain(|piece| !piece.is_empty());
    if series.style != Style::Dots {
        pieces.iter_mut().for_each(|piece| *piece = thinned(piece));
    }
    pieces
}

/// At most [`MAX_POINTS`] points with the same outline: the least and the most of each stretch.
fn thinned(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    if points.len() <= MAX_POINTS {
        return points.to_vec();
    }
    let stretch = points.len().div_ceil(MAX_POINTS / 2);
    let extremes = |stretch: &[(f64, f64)]| {
        let by_value = |a: &&(f64, f64), b: &&(f64, f64)| a.1.total_cmp(&b.1);
        let least = stretch.iter().min_by(by_value).copied();
        let most = stretch.iter().max_by(by_value).copied();
        let mut both: Vec<_> = least.into_iter().chain(most).collect();
        both.sort_by(|a, b| a.0.total_cmp(&b.0));
        both
    };
    points.chunks(stretch).flat_map(extremes).collect()
}

/// Decimals that tell the marks of an axis of this range apart.
fn decimals_for(range: f64) -> usize {
    match range {
        20.0.. => 0,
        2.0..20.0 => 1,
        0.2..2.0 => 2,
        _ => 3,
    }
}

/// A number without needless zeros, with a true minus.
fn number(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    let text = match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.'),
        false => text.as_str(),
    };
    match text {
        "-0" => "0".to_owned(),
        text => text.replace('-', "\u{2212}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chart(points: Vec<(f64, Option<f64>)>, style: Style) -> Chart {
        let series = Series { label: Some("x"), colour: colour::BLUE, style, points };
        Chart {
            title: "rate",
            y_label: "deg/s",
            series: vec![series],
            bands: vec![(0.0, 1.0)],
            band_label: "acting",
            strips: vec![Strip { label: "point", colour: colour::GREEN, spans: vec![(0.0, 5.0)] }],
            span_s: (0.0, 10.0),
            from_zero: false,
        }
    }

    #[test]
    fn a_chart_is_small_svg_with_its_labels() {
        let svg = chart(vec![(0.0, Some(1.0)), (10.0, Some(2.0))], Style::Line(1.0)).svg().unwrap();
        assert!(
            svg.starts_with(r#"<svg width="960" height="300" viewBox="0 0 3840 1200""#),
            "{svg}"
        );
        for text in ["rate", "deg/s", "time since the start, s", "acting", "point"] {
            assert!(svg.contains(text), "{text}");
        }
    }

    #[test]
    fn nothing_to_draw_is_an_empty_chart_and_no_panic() {
        for points in [vec![], vec![(0.0, None)], vec![(0.0, Some(f64::NAN))]] {
            for style in [Style::Line(1.0), Style::Dots, Style::Steps] {
                assert!(chart(points.clone(), style).svg().is_ok());
            }
        }
    }

    #[test]
    fn a_gap_parts_a_line() {
        let points = vec![(0.0, Some(1.0)), (1.0, None), (2.0, Some(3.0))];
        let series = &chart(points, Style::Line(1.0)).series[0];
        assert_eq!(pieces(series, 3.0), [vec![(0.0, 1.0)], vec![(2.0, 3.0)]]);
    }

    #[test]
    fn steps_keep_their_value_until_the_next() {
        let points = vec![(0.0, Some(1.0)), (1.0, Some(2.0))];
        let series = &chart(points, Style::Steps).series[0];
        assert_eq!(pieces(series, 3.0), [vec![(0.0, 1.0), (1.0, 1.0), (1.0, 2.0), (3.0, 2.0)]]);
    }

    #[test]
    fn thinning_keeps_every_spike() {
        let mut points: Vec<_> = (0..100_000).map(|k| (f64::from(k), 0.0)).collect();
        points[54_321].1 = 9.0;
        let thin = thinned(&points);
        assert!(thin.len() <= MAX_POINTS + 2 && thin.contains(&(54_321.0, 9.0)));
    }

    #[test]
    fn numbers_are_short_and_have_a_true_minus() {
        assert_eq!(number(-1.50, 2), "\u{2212}1.5");
        assert_eq!(number(100.0, 0), "100");
        assert_eq!(number(-0.001, 1), "0");
    }
}
