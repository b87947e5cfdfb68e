//! The norm before and after a calibration, as the paper's fig. 5.2 shows it.

use adcs_core::calibration::DataSheet;
use nalgebra::Vector3;

use plotters::style::RGBColor;

use super::{Measured, Outcome};
use crate::report::chart::{Chart, Series, Style, colour};

/// |B| by the data sheet, |B| calibrated and |B_IGRF| over time; `None` when there is no time.
pub fn chart(measured: &[Measured], before: DataSheet<f64>, outcome: &Outcome) -> Option<Chart> {
    let rows = Timed::of(measured)?;
    let by_data_sheet = |one: &Measured| by_data_sheet(one, before).norm() / 1e3;
    let calibrated = |one: &Measured| outcome.field(one).norm() / 1e3;
    let igrf = |one: &Measured| one.sample.intensity / 1e3;
    Some(Chart {
        title: "Strength of the field",
        y_label: "|B|, µT",
        series: vec![
            rows.series(Some("data sheet"), colour::VERMILION, Style::Dots, &by_data_sheet),
            rows.series(Some("calibrated"), colour::BLUE, Style::Dots, &calibrated),
            rows.series(Some("IGRF"), colour::BLACK, Style::Line(1.6), &igrf),
        ],
        bands: Vec::new(),
        band_label: "",
        strips: Vec::new(),
        span_s: (0.0, rows.length_s),
        from_zero: true,
    })
}

/// The angle between the field by the data sheet and the calibrated one over time, as the paper's
/// fig. 5.3 shows it; `None` when there is no time.
pub fn angle_chart(
    measured: &[Measured],
    before: DataSheet<f64>,
    outcome: &Outcome,
) -> Option<Chart> {
    let rows = Timed::of(measured)?;
    let angle = |one: &Measured| by_data_sheet(one, before).angle(&outcome.field(one)).to_degrees();
    Some(Chart {
        title: "What the calibration turns the field by",
        y_label: "angle, deg",
        series: vec![rows.series(None, colour::BLUE, Style::Dots, &angle)],
        bands: Vec::new(),
        band_label: "",
        strips: Vec::new(),
        span_s: (0.0, rows.length_s),
        from_zero: true,
    })
}

/// Rows with their times, s since the first.
struct Timed {
    rows: Vec<(f64, Measured)>,
    length_s: f64,
}

impl Timed {
    fn of(measured: &[Measured]) -> Option<Self> {
        let settled = measured.iter().filter(|one| one.settled);
        let mut rows =
            settled.map(|one| Some((one.t_s?, *one))).collect::<Option<Vec<(f64, Measured)>>>()?;
        let (start, end) =
            rows.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), (t, _)| {
                (low.min(*t), high.max(*t))
            });
        rows.iter_mut().for_each(|(t, _)| *t -= start);
        Some(Self { rows, length_s: end - start })
    }

    fn series(
        &self,
        label: Option<&'static str>,
        colour: RGBColor,
        style: Style,
        value: &dyn Fn(&Measured) -> f64,
    ) -> Series {
        let points = self.rows.iter().map(|(t, one)| (*t, Some(value(one)))).collect();
        Series { label, colour, style, points }
    }
}

fn by_data_sheet(one: &Measured, sheet: DataSheet<f64>) -> Vector3<f64> {
    Vector3::from(one.sample.reading).map(|v| sheet.sensitivity * (v - sheet.zero))
}
