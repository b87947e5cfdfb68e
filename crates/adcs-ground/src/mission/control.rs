//! Sections `law` and `schedule`: what the flight software does, and when.

use adcs_app::LawParameters;
use adcs_core::control::b_dot::{BDot, BDotGain};
use adcs_core::schedule::{Schedule, ScheduleError, ScheduleParameters};

use super::problem::Fault;
use super::section::Section;
use super::typed::POSITIVE;

/// Longest on- or off-time that a mission may ask for: what a u32 of microseconds can count, in
/// whole seconds.
const LONGEST_S: f64 = 4294.0;

#[derive(Clone, Copy)]
enum Kind {
    Plain,
    Normalised,
    None,
}

pub(super) fn law(root: &Section) -> Option<LawParameters> {
    const PLAIN_GAIN: &str = "gain_am2_s_per_t";
    const NORMALISED_GAIN: &str = "gain_n_m_s";
    let section = root.section("law")?;
    let kinds =
        [("b-dot", Kind::Plain), ("b-dot-normalised", Kind::Normalised), ("none", Kind::None)];
    let kind = section.choice("kind", &kinds);
    let (key, gain): (_, Option<BDotGain>) = match kind {
        Some(Kind::Plain) => {
            section.meaningless(NORMALISED_GAIN, "kind");
            let gain = section.number(PLAIN_GAIN, POSITIVE);
            (PLAIN_GAIN, gain.map(|k| BDotGain::Plain { gain_am2_s_per_t: k as f32 }))
        }
        Some(Kind::Normalised) => {
            section.meaningless(PLAIN_GAIN, "kind");
            let gain = section.number(NORMALISED_GAIN, POSITIVE);
            (NORMALISED_GAIN, gain.map(|k| BDotGain::Normalised { gain_n_m_s: k as f32 }))
        }
        Some(Kind::None) | None => {
            if kind.is_some() {
                section.meaningless(PLAIN_GAIN, "kind");
                section.meaningless(NORMALISED_GAIN, "kind");
            } else {
                // Not known which of them is wanted, so neither is called unknown.
                let _ = (section.has(PLAIN_GAIN), section.has(NORMALISED_GAIN));
            }
            ("kind", None)
        }
    };
    section.finish();
    if let Some(Err(error)) = gain.map(BDot::new) {
        section.refuse(key, Fault::new(error.to_string()));
    }
    match kind? {
        Kind::None => Some(LawParameters::Off),
        Kind::Plain | Kind::Normalised => gain.map(LawParameters::BDot),
    }
}

pub(super) fn schedule(root: &Section, cycle_us: Option<u32>) -> Option<ScheduleParameters> {
    let section = root.section("schedule")?;
    let on_us = section.micros("on_s", 0.0..=LONGEST_S);
    let off_us = section.micros("off_s", 0.0..=LONGEST_S);
    // Without it only the last instant of the rest measures, as in the paper.
    let settle_us = section.micros_or("settle_s", 0.0..=LONGEST_S, off_us.unwrap_or_default());
    section.finish();
    let parameters = ScheduleParameters {
        on_us: on_us? as u32,
        off_us: off_us? as u32,
        settle_us: settle_us? as u32,
    };
    let Err(error) = Schedule::new(&parameters, cycle_us?) else { return Some(parameters) };
    let (key, advice) = match error {
        ScheduleError::NeverActs => {
            ("on_s", "for a flight without control write law.kind = \"none\"")
        }
        ScheduleError::NeverRests => ("off_s", "the field is measured while the torquers rest"),
        ScheduleError::NeverSettles { .. } => ("settle_s", "it must be within the rest"),
        ScheduleError::NotWholeCycles { found_us, .. } if found_us == parameters.on_us => {
            ("on_s", "change it or mission.cycle_s")
        }
        ScheduleError::NotWholeCycles { found_us, .. } if found_us == parameters.off_us => {
            ("off_s", "change it or mission.cycle_s")
        }
        ScheduleError::NotWholeCycles { .. } => ("settle_s", "change it or mission.cycle_s"),
        _ => ("on_s", ""),
    };
    section.refuse(key, Fault::advising(format!("impossible: {error}"), advice));
    None
}
