//! Sections `law` and `schedule`: what the flight software does, and when.

use adcs_app::{LawParameters, ParameterError};
use adcs_core::control::b_dot::BDotGain;
use adcs_core::control::bang_bang::BangBangParameters;
use adcs_core::control::cross_product::{CrossProductError, CrossProductParameters};
use adcs_core::control::guidance::GuidanceParameters;
use adcs_core::control::periodic::{PeriodicError, PeriodicParameters};
use adcs_core::pipeline::{RateFrom, SteeringParameters};
use adcs_core::schedule::{Schedule, ScheduleError, ScheduleParameters};

use super::guidance;
use super::problem::Fault;
use super::section::Section;
use super::typed::{Check, POSITIVE};

const NOT_NEGATIVE: Check = Check::new(|x| x >= 0.0 && x.is_finite(), "zero or positive");

/// Longest on- or off-time that a mission may ask for: what a u32 of microseconds can count, in
/// whole seconds.
const LONGEST_S: f64 = 4294.0;

#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Plain,
    Normalised,
    BangBang,
    CrossProduct,
    Periodic,
    None,
}

const PLAIN_GAIN: &str = "gain_am2_s_per_t";
const NORMALISED_GAIN: &str = "gain_n_m_s";
const RATE: &str = "rate";
const CUT_HOLD: &str = "cut_hold";
const DEAD_BAND: &str = "dead_band_sigmas";
const RATE_NOISE: &str = "rate_noise_deg_s";
const FIELD_NOISE: &str = "field_noise_nt";
const STIFFNESS: &str = "stiffness_n_m_per_rad";
const DAMPING: &str = "damping_n_m_s";
const INERTIA: &str = "inertia_kg_m2";
const GYROSCOPIC: &str = "gyroscopic";
const GRAVITY: &str = "gravity_gradient";
const ATTITUDE_WEIGHT: &str = "attitude_weight_deg";
const RATE_WEIGHT: &str = "rate_weight_deg_s";
const DIPOLE_WEIGHT: &str = "dipole_weight_am2";
const PLAN_STEP: &str = "plan_step_s";
const PLAN_HORIZON: &str = "plan_horizon_s";
const FEED_FORWARD: &str = "residual_dipole_sigma_am2";

/// Half-width of the bang-bang law's dead band when a mission does not say: one wrong sign in 370.
const DEAD_BAND_SIGMAS: f64 = 3.0;

/// Every key that not every kind understands, and which do; those of the guidance are pointing's.
const KEYS: [(&str, &[Kind]); 18] = [
    (PLAIN_GAIN, &[Kind::Plain]),
    (NORMALISED_GAIN, &[Kind::Normalised]),
    (RATE, DESPIN),
    (CUT_HOLD, DESPIN),
    (DEAD_BAND, &[Kind::BangBang]),
    (RATE_NOISE, &[Kind::BangBang]),
    (FIELD_NOISE, &[Kind::BangBang]),
    (STIFFNESS, POINTING),
    (DAMPING, POINTING),
    (INERTIA, POINTING),
    (GYROSCOPIC, POINTING),
    (GRAVITY, POINTING),
    (ATTITUDE_WEIGHT, &[Kind::Periodic]),
    (RATE_WEIGHT, &[Kind::Periodic]),
    (DIPOLE_WEIGHT, &[Kind::Periodic]),
    (PLAN_STEP, &[Kind::Periodic]),
    (PLAN_HORIZON, &[Kind::Periodic]),
    (
        FEED_FORWARD,
        &[Kind::Plain, Kind::Normalised, Kind::BangBang, Kind::CrossProduct, Kind::Periodic],
    ),
];
const POINTING: &[Kind] = &[Kind::CrossProduct, Kind::Periodic];
const DESPIN: &[Kind] = &[Kind::Plain, Kind::Normalised, Kind::BangBang];

/// What the law takes over from other sections when its own says nothing.
pub(super) struct Usual {
    pub inertia_kg_m2: Option<[[f64; 3]; 3]>,
    pub max_dipole_am2: Option<f32>,
    pub rate_noise_rad_s: Option<f64>,
    pub field_noise_t: Option<f64>,
}

/// Section `law`: what flies from start to end; with modes, what points.
pub(super) fn law(root: &Section, usual: &Usual) -> Option<(LawParameters, SteeringParameters)> {
    flown(&root.section("law")?, usual)
}

/// A law and what surrounds it.
pub(super) fn flown(
    section: &Section,
    usual: &Usual,
) -> Option<(LawParameters, SteeringParameters)> {
    let kinds = [
        ("b-dot", Kind::Plain),
        ("b-dot-normalised", Kind::Normalised),
        ("bang-bang", Kind::BangBang),
        ("cross-product", Kind::CrossProduct),
        ("periodic", Kind::Periodic),
        ("none", Kind::None),
    ];
    let kind = section.choice("kind", &kinds);
    let Some(kind) = kind else {
        // Not known which of them are wanted, so none is called unknown.
        for key in KEYS.map(|(key, _)| key).into_iter().chain(guidance::NAMES) {
            let _ = section.has(key);
        }
        section.finish();
        return None;
    };
    for (key, _) in KEYS.iter().filter(|(_, understood)| !understood.contains(&kind)) {
        section.meaningless(key, "kind");
    }
    if !POINTING.contains(&kind) {
        guidance::NAMES.iter().for_each(|key| section.meaningless(key, "kind"));
    }
    let law = match kind {
        Kind::None => Some(LawParameters::Off),
        Kind::Plain => section
            .number(PLAIN_GAIN, POSITIVE)
            .map(|k| LawParameters::BDot(BDotGain::Plain { gain_am2_s_per_t: k as f32 })),
        Kind::Normalised => section
            .number(NORMALISED_GAIN, POSITIVE)
            .map(|k| LawParameters::BDot(BDotGain::Normalised { gain_n_m_s: k as f32 })),
        Kind::BangBang => bang_bang(section, usual),
        Kind::CrossProduct => pointing(section, usual)
            .map(|(law, guidance)| LawParameters::CrossProduct { law, guidance }),
        Kind::Periodic => periodic(section, usual),
    };
    let steering = steering(section, kind);
    section.finish();
    let law = law?;
    if let Err(error) = law.accept() {
        let key = match (kind, &error) {
            (Kind::Plain, _) => PLAIN_GAIN,
            (Kind::Normalised, _) => NORMALISED_GAIN,
            (_, ParameterError::CrossProduct(CrossProductError::Inertia)) => INERTIA,
            (_, ParameterError::CrossProduct(CrossProductError::Damping { .. })) => DAMPING,
            (_, ParameterError::CrossProduct(_)) => STIFFNESS,
            (_, ParameterError::Periodic(PeriodicError::Inertia)) => INERTIA,
            (_, ParameterError::Periodic(PeriodicError::OutOfRange(error))) => {
                periodic_key(error.name)
            }
            (_, error) => guidance::key_of(error).unwrap_or("kind"),
        };
        section.refuse(key, Fault::new(error.to_string()));
        return None;
    }
    Some((law, steering?))
}

fn bang_bang(section: &Section, usual: &Usual) -> Option<LawParameters> {
    const T_PER_NT: f64 = 1e-9;
    let sigmas = section.number_or(DEAD_BAND, NOT_NEGATIVE, DEAD_BAND_SIGMAS);
    let rate = usual.rate_noise_rad_s.unwrap_or_default().to_degrees();
    let rate = section.number_or(RATE_NOISE, NOT_NEGATIVE, rate);
    let field = usual.field_noise_t.unwrap_or_default() / T_PER_NT;
    let field = section.number_or(FIELD_NOISE, NOT_NEGATIVE, field);
    Some(LawParameters::BangBang(BangBangParameters {
        dipole_am2: usual.max_dipole_am2?,
        dead_band_sigmas: sigmas? as f32,
        rate_noise_rad_s: rate?.to_radians() as f32,
        field_noise_t: (field? * T_PER_NT) as f32,
    }))
}

/// The key of a field of the periodic law.
fn periodic_key(name: &str) -> &'static str {
    match name {
        "attitude_weight_rad" => ATTITUDE_WEIGHT,
        "rate_weight_rad_s" => RATE_WEIGHT,
        "dipole_weight_am2" => DIPOLE_WEIGHT,
        "step_s" => PLAN_STEP,
        _ => PLAN_HORIZON,
    }
}

fn periodic(section: &Section, usual: &Usual) -> Option<LawParameters> {
    let default = PeriodicParameters::<f64>::default();
    let attitude =
        section.number_or(ATTITUDE_WEIGHT, POSITIVE, default.attitude_weight_rad.to_degrees());
    let rate = section.number_or(RATE_WEIGHT, POSITIVE, default.rate_weight_rad_s.to_degrees());
    let dipole = section.number_or(DIPOLE_WEIGHT, POSITIVE, default.dipole_weight_am2);
    let step = section.number_or(PLAN_STEP, POSITIVE, default.step_s);
    let horizon = section.number_or(PLAN_HORIZON, POSITIVE, default.horizon_s);
    let (unplanned, guidance) = pointing(section, usual)?;
    let law = PeriodicParameters {
        attitude_weight_rad: attitude?.to_radians() as f32,
        rate_weight_rad_s: rate?.to_radians() as f32,
        dipole_weight_am2: dipole? as f32,
        step_s: step? as f32,
        horizon_s: horizon? as f32,
        inertia_kg_m2: unplanned.inertia_kg_m2,
    };
    Some(LawParameters::Periodic { law, unplanned, guidance })
}

fn pointing(
    section: &Section,
    usual: &Usual,
) -> Option<(CrossProductParameters, GuidanceParameters)> {
    let stiffness = section.number(STIFFNESS, POSITIVE);
    let damping = section.number(DAMPING, POSITIVE);
    let inertia = match usual.inertia_kg_m2 {
        Some(truth) => section.matrix_or(INERTIA, truth),
        None => section.matrix(INERTIA),
    };
    let gyroscopic = flag_or_off(section, GYROSCOPIC);
    let gravity_gradient = flag_or_off(section, GRAVITY);
    let guidance = guidance::guidance(section);
    let law = CrossProductParameters {
        stiffness_n_m_per_rad: stiffness? as f32,
        damping_n_m_s: damping? as f32,
        inertia_kg_m2: inertia?.map(|row| row.map(|entry| entry as f32)),
        gyroscopic: gyroscopic?,
        gravity_gradient: gravity_gradient?,
    };
    Some((law, guidance?))
}

fn steering(section: &Section, kind: Kind) -> Option<SteeringParameters> {
    let rates =
        [("gyro", RateFrom::Gyro), ("field", RateFrom::Field), ("estimate", RateFrom::Estimate)];
    let (rate, cut_hold) = if DESPIN.contains(&kind) {
        let rate = section.choice_or(RATE, &rates, RateFrom::Gyro);
        (rate, flag_or_off(section, CUT_HOLD))
    } else {
        (Some(RateFrom::Gyro), Some(false))
    };
    let feed_forward = if kind != Kind::None && section.has(FEED_FORWARD) {
        Some(section.number(FEED_FORWARD, POSITIVE)? as f32)
    } else {
        None
    };
    Some(SteeringParameters {
        rate: rate?,
        cut_hold: cut_hold?,
        feed_forward_sigma_am2: feed_forward,
    })
}

fn flag_or_off(section: &Section, key: &'static str) -> Option<bool> {
    if section.has(key) { section.flag(key) } else { Some(false) }
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
