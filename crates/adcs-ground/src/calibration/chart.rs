//! The norm before and after a calibration, as the paper's fig. 5.2 shows it.

use adcs_core::calibration::{DataSheet, Sample};

use super::{Measured, Outcome};
use crate::report::chart::{Chart, Series, Style, colour};

/// |B| by the data sheet, |B| calibrated and |B_IGRF| over time; `None` when there is no time.
pub fn chart(measured: &[Measured], before: DataSheet<f64>, outcome: &Outcome) -> Option<Chart> {
    let timed: Option<Vec<(f64, Sample<f64>)>> =
        measured.iter().map(|one| Some((one.t_s?, one.sample))).collect();
    let timed = timed?;
    let (start, end) =
        timed.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), (t, _)| {
            (low.min(*t), high.max(*t))
        });
    let series = |label, colour, style, value: &dyn Fn(&Sample<f64>) -> f64| Series {
        label: Some(label),
        colour,
        style,
        points: timed.iter().map(|(t, sample)| (t - start, Some(value(sample) / 1e3))).collect(),
    };
    let zero_bias = -before.sensitivity * before.zero;
    let by_data_sheet =
        |sample: &Sample<f64>| norm(sample, [before.sensitivity; 3], [zero_bias; 3]);
    let calibrated = |sample: &Sample<f64>| norm(sample, outcome.scale_nt_per_v, outcome.bias_nt);
    let igrf = |sample: &Sample<f64>| sample.intensity;
    Some(Chart {
        title: "Strength of the field",
        y_label: "|B|, µT",
        series: vec![
            series("data sheet", colour::VERMILION, Style::Dots, &by_data_sheet),
            series("calibrated", colour::BLUE, Style::Dots, &calibrated),
            series("IGRF", colour::BLACK, Style::Line(1.6), &igrf),
        ],
        bands: Vec::new(),
        band_label: "",
        strips: Vec::new(),
        span_s: (0.0, end - start),
        from_zero: true,
    })
}

fn norm(sample: &Sample<f64>, scale: [f64; 3], bias: [f64; 3]) -> f64 {
    let axes = sample.reading.iter().zip(scale).zip(bias);
    axes.map(|((v, s), b)| (s * v + b).powi(2)).sum::<f64>().sqrt()
}
