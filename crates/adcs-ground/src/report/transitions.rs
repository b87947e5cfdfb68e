//! The modes of a flight, and how they followed each other.

use adcs_core::modes::{Cause, Mode, Sensor};
use serde::Serialize;

use super::rows::Row;

/// One mode followed another.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct TransitionAt {
    /// When, ms since the start: whole numbers, so that two lists can be compared.
    pub time_ms: u64,
    /// What was left.
    pub from: String,
    /// What was entered.
    pub to: String,
    /// Why.
    pub cause: String,
}

/// All transitions of a flight.
pub fn transitions(rows: &[Row]) -> Vec<TransitionAt> {
    let at = |row: &Row| {
        let transition = row.mode?.transition?;
        Some(TransitionAt {
            time_ms: (row.time_s * 1e3).round() as u64,
            from: transition.from.to_string(),
            to: transition.to.to_string(),
            cause: cause_words(transition.cause),
        })
    };
    rows.iter().filter_map(at).collect()
}

/// The times (s) that each mode took, in the order of the modes' first appearance.
pub fn spans(rows: &[Row]) -> Vec<(Mode, Vec<(f64, f64)>)> {
    let mut all: Vec<(Mode, Vec<(f64, f64)>)> = Vec::new();
    let mut last = None;
    for row in rows {
        let mode = row.mode.map(|report| report.mode);
        let t = row.time_s;
        if let Some(before) = last
            && let Some((_, spans)) = all.iter_mut().find(|(known, _)| *known == before)
            && let Some(span) = spans.last_mut()
        {
            span.1 = t;
        }
        if let Some(mode) = mode.filter(|_| mode != last) {
            match all.iter_mut().find(|(known, _)| *known == mode) {
                Some((_, spans)) => spans.push((t, t)),
                None => all.push((mode, vec![(t, t)])),
            }
        }
        last = mode;
    }
    all
}

/// Why a mode was entered, in words.
pub fn cause_words(cause: Cause) -> String {
    let words = match cause {
        Cause::PowerOn => "power on",
        Cause::Commanded => "commanded",
        Cause::Despun => "despun",
        Cause::Trusted => "attitude and dipole trusted",
        Cause::Tumbling => "tumbling",
        Cause::AttitudeLost => "attitude lost",
        Cause::Silent(Sensor::Gyro) => "gyro silent",
        Cause::Silent(Sensor::Magnetometer) => "magnetometer silent",
        Cause::Silent(Sensor::SunSensors) => "Sun sensors silent",
        Cause::TorquersRefuse => "torquers refuse",
        Cause::RateGrows => "rate grows",
        Cause::ErrorGrows => "pointing error grows",
        Cause::TooLong => "time limit",
        Cause::NotCaptured => "not captured in time",
        Cause::Over => "experiment over",
        Cause::Recovered => "sensors recovered",
        Cause::Checked => "wired as it should be",
        Cause::Commissioned => "commissioned",
        Cause::Resumed => "commissioning goes on after a reset",
        Cause::Unchecked(why) => return format!("wiring not known: {why}"),
        Cause::Miswired(suspect) => return suspect.to_string(),
        _ => "unknown",
    };
    words.to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flight::records::tests::flown;
    use crate::report::rows::rows;
    use adcs_core::modes::{ModeReport, Transition};

    #[test]
    fn each_mode_keeps_its_spans_and_each_transition_its_time() {
        use Mode::{Detumble, Safe};
        let mut rows = rows(&flown(6), None);
        let modes = [Detumble, Detumble, Safe, Safe, Detumble, Detumble];
        for (row, mode) in rows.iter_mut().zip(modes) {
            row.mode = Some(ModeReport { mode, transition: None, refused: None, retries: 0 });
        }
        let (from, to, cause) = (Detumble, Safe, Cause::Silent(Sensor::Gyro));
        rows[2].mode.as_mut().unwrap().transition = Some(Transition { from, to, cause });
        let spans = spans(&rows);
        assert_eq!(spans[0], (Detumble, vec![(0.0, 1.0), (2.0, 2.5)]));
        assert_eq!(spans[1], (Safe, vec![(1.0, 2.0)]));
        let [only] = &transitions(&rows)[..] else { panic!("one") };
        assert_eq!((only.time_ms, only.cause.as_str()), (1000, "gyro silent"));
    }
}
