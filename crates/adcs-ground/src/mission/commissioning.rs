//! Section `modes.commissioning`: the ladder.

use adcs_core::commissioning::{CommissioningError, CommissioningParameters, Commit, StepTime};
use adcs_core::parameter::OutOfRange;

use super::problem::Fault;
use super::section::Section;
use super::typed::FINITE;

/// Its name below `modes`.
pub(super) const SECTION: &str = "commissioning";

const COMMITS: [(&str, Commit); 2] =
    [("by-ground", Commit::ByGround), ("when-passed", Commit::WhenPassed)];

/// Keys of the steps' times, and of the gates with the factor to SI, by the names of their fields.
const TIMES: [(&str, &str); 5] = [
    ("magnetometer", "magnetometer_s"),
    ("coupling", "coupling_s"),
    ("gyro", "gyro_s"),
    ("sun", "sun_s"),
    ("momentum", "momentum_s"),
];
const GATES: [(&str, &str, f64); 7] = [
    ("scale_sigma", "scale_sigma", 1.0),
    ("bias_sigma_t", "bias_sigma_nt", 1e-9),
    ("coupling_sigma_t_per_am2", "coupling_sigma_nt_per_am2", 1e-9),
    ("gyro_sigma_rad_s", "gyro_sigma_deg_s", core::f64::consts::PI / 180.0),
    ("sun_sigma_rad", "sun_sigma_deg", core::f64::consts::PI / 180.0),
    ("dipole_sigma_am2", "dipole_sigma_am2", 1.0),
    ("inertia_sigma", "inertia_sigma", 1.0),
];

/// `Some(None)` when there is none.
pub(super) fn commissioning(modes: &Section) -> Option<Option<CommissioningParameters>> {
    let Some(section) = modes.section_if_any(SECTION)? else { return Some(None) };
    let usual = CommissioningParameters::default();
    let time = |key, usual: StepTime| {
        let usual = [usual.least_s, usual.most_s].map(f64::from);
        let [least_s, most_s] = section.numbers_or(key, FINITE, usual)?;
        Some(StepTime { least_s: least_s as f32, most_s: most_s as f32 })
    };
    let [magnetometer, coupling, gyro, sun, momentum] = [
        (TIMES[0].1, usual.magnetometer),
        (TIMES[1].1, usual.coupling),
        (TIMES[2].1, usual.gyro),
        (TIMES[3].1, usual.sun),
        (TIMES[4].1, usual.momentum),
    ]
    .map(|(key, usual)| time(key, usual));
    let gate = |number: usize, usual: f32| {
        let (_, key, unit) = GATES[number];
        Some((section.number_or(key, FINITE, f64::from(usual) / unit)? * unit) as f32)
    };
    let gates = [
        gate(0, usual.scale_sigma),
        gate(1, usual.bias_sigma_t),
        gate(2, usual.coupling_sigma_t_per_am2),
        gate(3, usual.gyro_sigma_rad_s),
        gate(4, usual.sun_sigma_rad),
        gate(5, usual.dipole_sigma_am2),
        gate(6, usual.inertia_sigma),
    ];
    let commit = section.choice_or("commit", &COMMITS, usual.commit);
    section.finish();
    let [scale, bias, by_torquers, rate, turn, dipole, inertia] = gates;
    Some(Some(CommissioningParameters {
        magnetometer: magnetometer?,
        coupling: coupling?,
        gyro: gyro?,
        sun: sun?,
        momentum: momentum?,
        scale_sigma: scale?,
        bias_sigma_t: bias?,
        coupling_sigma_t_per_am2: by_torquers?,
        gyro_sigma_rad_s: rate?,
        sun_sigma_rad: turn?,
        dipole_sigma_am2: dipole?,
        inertia_sigma: inertia?,
        commit: commit?,
    }))
}

/// Says at its key what the flight software refuses.
pub(super) fn refuse(modes: &Section, error: &CommissioningError) {
    let Some(Some(section)) = modes.section_if_any(SECTION) else { return };
    let CommissioningError::OutOfRange(OutOfRange { name, found, from, to }) = *error else {
        return;
    };
    let time = TIMES.iter().find(|(field, _)| *field == name).map(|(_, key)| (*key, 1.0));
    let gate = GATES.iter().find(|(field, ..)| *field == name).map(|(_, key, unit)| (*key, *unit));
    let (key, unit) = time.or(gate).unwrap_or(("commit", 1.0));
    let shown = |x: f32| format!("{:.4e}", f64::from(x) / unit);
    let (found, from, to) = (shown(found), shown(from), shown(to));
    let reason = format!("{found} is impossible: must be from {from} to {to}");
    section.refuse(key, Fault::new(reason));
}
