//! `summary.json`: the flight in numbers.

use std::collections::BTreeMap;

use adcs_core::attitude::selection::AttitudeSource;
use adcs_core::pipeline::ControlStatus;
use adcs_core::reading::Reading;
use adcs_core::schedule::Phase;
use serde::Serialize;

use super::commissioning::{Climb, climb};
use super::damping::{Damping, damping};
use super::pointing::{Pointing, pointing};
use super::rows::{Row, attitude_word, missing_word, norm, reason_word};
use super::transitions::{TransitionAt, transitions};
use crate::flight::{Ending, Flight, Flown, World};

/// Seconds between the rates that are listed.
const RATE_EVERY_S: f64 = 300.0;

/// The flight in numbers.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Summary {
    /// The mission's name.
    pub mission: String,
    /// What it is.
    pub title: String,
    /// Where it flew.
    pub world: World,
    /// How it ended.
    pub ending: Ending,
    /// How far it was flown, s.
    pub flown_s: f64,
    /// How far it was meant to go, s.
    pub planned_s: f64,
    /// Cycles recorded.
    pub cycles: usize,
    /// Digest of the whole flight; `None` when it is not whole.
    pub digest: Option<String>,
    /// Frames of the records that could not be read.
    pub lost_frames: usize,
    /// The turning.
    pub rates: Rates,
    /// Kinetic energy.
    pub energy: Energy,
    /// Damping ratios of the true rates about x, y, z; `None` where there are fewer than two peaks.
    pub damping: [Option<Damping>; 3],
    /// What the torquers did.
    pub torquers: Torquers,
    /// What the control torque did to the tumble.
    pub control: Control,
    /// How well the field was measured.
    pub field: Option<Field>,
    /// How well the attitude was known; `None` when none was believed.
    pub attitude: Option<Attitude>,
    /// How well it pointed; `None` when it never aimed at anything.
    pub pointing: Option<Pointing>,
    /// How its modes followed each other; empty without modes.
    pub transitions: Vec<TransitionAt>,
    /// What it found out about itself; `None` without commissioning.
    pub commissioning: Option<Climb>,
    /// Readings that were missing.
    pub missing: Missing,
    /// Violations of a chip's protocol that the device models counted.
    pub violations: Option<u32>,
    /// Time the flight took on this computer, s.
    pub wall_s: Option<f64>,
    /// How many times faster than the satellite it flew.
    pub speed_over_real_time: Option<f64>,
}

/// The turning.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Rates {
    /// True rate at the start, Body, deg/s.
    pub start_deg_s: [f64; 3],
    /// True rate at the end.
    pub end_deg_s: [f64; 3],
    /// Its length at the start.
    pub start_norm_deg_s: f64,
    /// Its length at the end.
    pub end_norm_deg_s: f64,
    /// Length at the end over that at the start; `None` from rest.
    pub ratio: Option<f64>,
    /// The rate every 300 s, and at the end.
    pub listed: Vec<RateAt>,
}

/// The rate at a time.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RateAt {
    /// Seconds since the start.
    pub time_s: f64,
    /// True rate, Body, deg/s.
    pub rate_deg_s: [f64; 3],
    /// Its length.
    pub norm_deg_s: f64,
}

/// Kinetic energy.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Energy {
    /// At the start, J.
    pub start_j: f64,
    /// At the end, J.
    pub end_j: f64,
    /// End over start; `None` from rest.
    pub ratio: Option<f64>,
}

/// What the torquers did.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Torquers {
    /// Fraction of the time in which any torquer was driven.
    pub duty: f64,
    /// Mean length of the dipole while any was, A·m².
    pub mean_dipole_am2: Option<f64>,
    /// Fraction of the driven axes' commands at their limit.
    pub saturated: f64,
    /// Cycles in which they refused their command.
    pub refused_cycles: usize,
}

/// What the control torque did to the tumble.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Control {
    /// Work of the control torque over the flight, J.
    pub work_j: f64,
    /// Largest mean power of any cycle, W: above zero it drives the tumble.
    pub max_power_w: Option<f64>,
    /// Cycles in which it drove the tumble, out of those in which it acted.
    pub driving_cycles: usize,
    /// Cycles in which it acted.
    pub acting_cycles: usize,
    /// Cycles in each state of stage III.
    pub states: BTreeMap<String, usize>,
}

/// How well the field was measured.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Field {
    /// Least of measured minus model norm, nT.
    pub min_norm_error_nt: f64,
    /// Most.
    pub max_norm_error_nt: f64,
    /// Root of its mean square.
    pub rms_norm_error_nt: f64,
    /// Least angle between the measured and the true field, deg.
    pub min_angle_deg: f64,
    /// Largest.
    pub max_angle_deg: f64,
}

/// Readings that were missing.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Missing {
    /// Gyro axes that gave no reading, over all cycles.
    pub gyro_axes: usize,
    /// Magnetometer axes that gave none in a cycle that measured.
    pub magnetometer_axes_measuring: usize,
    /// Magnetometer axes that gave none in other cycles, which use none.
    pub magnetometer_axes_otherwise: usize,
    /// The same by reason.
    pub reasons: BTreeMap<String, usize>,
}

/// How well the attitude was known.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Attitude {
    /// When one was first believed, s.
    pub first_s: f64,
    /// Fraction of the cycles since in which one was believed.
    pub share: f64,
    /// Fraction of the cycles since in which it was that of the dynamics-aided filter.
    pub dynamic_share: f64,
    /// Rms of its angle to the truth in sunlight, deg, from [`SETTLED_S`] after the first on.
    pub sunlit_rms_deg: Option<f64>,
    /// The same in eclipse.
    pub eclipse_rms_deg: Option<f64>,
    /// Largest angle, likewise.
    pub largest_deg: Option<f64>,
    /// Rms of the length of the rate's error, likewise, deg/s.
    pub rate_rms_deg_s: Option<f64>,
    /// Cycles for each source and reason.
    pub reasons: BTreeMap<String, usize>,
}

/// How long after the first attitude its errors begin to count, s: as long as the gyro bias takes to be
/// known.
pub const SETTLED_S: f64 = 600.0;

/// The numbers of a flight in orbits of `period_s`; `None` when not a single cycle was recorded.
pub fn summary(flight: &Flight, flown: &Flown, rows: &[Row], period_s: f64) -> Option<Summary> {
    let (first, last) = (rows.first()?, rows.last()?);
    let ratio = |end: f64, start: f64| (start > 0.0).then(|| end / start);
    let axis = |at: usize| rows.iter().map(|row| row.rate_deg_s[at]).collect::<Vec<f64>>();
    let whole = flown.is_whole();
    Some(Summary {
        mission: flight.mission.name.clone(),
        title: flight.mission.title.clone(),
        world: flight.world,
        ending: flight.ending.clone(),
        flown_s: flown.flown_s(),
        planned_s: flown.planned_s(),
        cycles: rows.len(),
        digest: whole.then(|| format!("{:016x}", flown.digest)),
        lost_frames: flown.lost_frames,
        rates: Rates {
            start_deg_s: first.rate_deg_s,
            end_deg_s: last.rate_deg_s,
            start_norm_deg_s: first.rate_norm_deg_s,
            end_norm_deg_s: last.rate_norm_deg_s,
            ratio: ratio(last.rate_norm_deg_s, first.rate_norm_deg_s),
            listed: listed(rows, flown.cycle_s()),
        },
        energy: Energy {
            start_j: first.energy_j,
            end_j: last.energy_j,
            ratio: ratio(last.energy_j, first.energy_j),
        },
        damping: [0, 1, 2].map(|at| damping(&axis(at), flown.cycle_s())),
        torquers: torquers(rows),
        control: control(rows, flown.cycle_s()),
        field: field(rows),
        attitude: attitude(rows),
        pointing: pointing(rows, period_s),
        transitions: transitions(rows),
        commissioning: climb(rows),
        missing: missing(rows),
        violations: flown.end.map(|end| end.violations),
        wall_s: flight.wall_s,
        speed_over_real_time: flight
            .wall_s
            .filter(|&wall_s| wall_s > 0.0)
            .map(|wall_s| flown.flown_s() / wall_s),
    })
}

fn listed(rows: &[Row], cycle_s: f64) -> Vec<RateAt> {
    let every = (RATE_EVERY_S / cycle_s).round().max(1.0) as usize;
    let last = rows.len().saturating_sub(1);
    rows.iter()
        .enumerate()
        .filter(|(index, _)| index % every == 0 || *index == last)
        .map(|(_, row)| row)
        .map(|row| RateAt {
            time_s: row.time_s,
            rate_deg_s: row.rate_deg_s,
            norm_deg_s: row.rate_norm_deg_s,
        })
        .collect()
}

fn torquers(rows: &[Row]) -> Torquers {
    let driven = |row: &Row| row.dipole_am2.map(norm).filter(|&length| length > 0.0);
    let lengths: Vec<f64> = rows.iter().filter_map(driven).collect();
    let count = |wanted: fn(&Row) -> usize| rows.iter().map(wanted).sum::<usize>() as f64;
    let axes = count(|row| row.commanded_am2.iter().filter(|&&m| m != 0.0).count());
    let at_limit = count(|row| row.saturated.iter().filter(|&&saturated| saturated).count());
    Torquers {
        duty: lengths.len() as f64 / rows.len().max(1) as f64,
        mean_dipole_am2: mean(&lengths),
        saturated: if axes > 0.0 { at_limit / axes } else { 0.0 },
        refused_cycles: rows.iter().filter(|row| row.driven_am2.is_none()).count(),
    }
}

fn control(rows: &[Row], cycle_s: f64) -> Control {
    let powers = || rows.iter().filter_map(|row| row.control_power_w);
    let mut states = BTreeMap::new();
    for row in rows {
        *states.entry(super::rows::control_words(row.control)).or_default() += 1;
    }
    Control {
        work_j: powers().sum::<f64>() * cycle_s,
        max_power_w: powers().reduce(f64::max),
        driving_cycles: powers().filter(|&power| power > 0.0).count(),
        acting_cycles: rows.iter().filter(|row| row.control == ControlStatus::Acting).count(),
        states,
    }
}

fn field(rows: &[Row]) -> Option<Field> {
    let measured: Vec<(f64, f64)> = rows
        .iter()
        .filter_map(|row| {
            let measured = row.measured_field_nt?;
            let error = norm(measured) - row.model_field_norm_nt?;
            let dot: f64 = measured.iter().zip(row.field_nt).map(|(a, b)| a * b).sum();
            let lengths = norm(measured) * row.field_norm_nt;
            (lengths > 0.0).then(|| (error, (dot / lengths).clamp(-1.0, 1.0).acos().to_degrees()))
        })
        .collect();
    let errors: Vec<f64> = measured.iter().map(|(error, _)| *error).collect();
    let squares: Vec<f64> = errors.iter().map(|error| error * error).collect();
    let angles: Vec<f64> = measured.iter().map(|(_, angle)| *angle).collect();
    let least = |values: &[f64]| values.iter().copied().fold(f64::INFINITY, f64::min);
    let most = |values: &[f64]| values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    Some(Field {
        rms_norm_error_nt: mean(&squares)?.sqrt(),
        min_norm_error_nt: least(&errors),
        max_norm_error_nt: most(&errors),
        min_angle_deg: least(&angles),
        max_angle_deg: most(&angles),
    })
}

fn attitude(rows: &[Row]) -> Option<Attitude> {
    let error = |row: &Row| row.believed?.attitude_error_deg;
    let source = |row: &Row| Some(row.believed?.record.attitude?.source);
    let first = rows.iter().position(|row| error(row).is_some())?;
    let since = rows.get(first..)?;
    let first_s = since.first()?.time_s;
    let share = |wanted: &dyn Fn(&Row) -> bool| {
        since.iter().filter(|row| wanted(row)).count() as f64 / since.len() as f64
    };
    let settled = || since.iter().filter(|row| row.time_s >= first_s + SETTLED_S);
    let rms = |values: &mut dyn Iterator<Item = f64>| {
        mean(&values.map(|value| value * value).collect::<Vec<_>>()).map(f64::sqrt)
    };
    let mut reasons = BTreeMap::new();
    for row in rows {
        let from = source(row).map_or("none", attitude_word);
        let why = row.believed.map_or("not_flown", |it| reason_word(it.record.reason));
        *reasons.entry(format!("{from}:{why}")).or_default() += 1;
    }
    Some(Attitude {
        first_s,
        share: share(&|row| error(row).is_some()),
        dynamic_share: share(&|row| source(row) == Some(AttitudeSource::Dynamic)),
        sunlit_rms_deg: rms(&mut settled().filter(|row| row.sunlit).filter_map(error)),
        eclipse_rms_deg: rms(&mut settled().filter(|row| !row.sunlit).filter_map(error)),
        largest_deg: settled().filter_map(error).reduce(f64::max),
        rate_rms_deg_s: rms(&mut settled().filter_map(|row| row.believed?.rate_error_deg_s)),
        reasons,
    })
}

fn missing(rows: &[Row]) -> Missing {
    let mut missing = Missing::default();
    for row in rows {
        let lost = |axes: &[Reading<f64>; 3]| axes.iter().filter_map(Reading::missing).collect();
        let (gyro, magnetometer): (Vec<_>, Vec<_>) =
            (lost(&row.gyro_deg_s), lost(&row.magnetometer_nt));
        missing.gyro_axes += gyro.len();
        if row.phase == Phase::Measuring {
            missing.magnetometer_axes_measuring += magnetometer.len();
        } else {
            missing.magnetometer_axes_otherwise += magnetometer.len();
        }
        for reason in gyro.into_iter().chain(magnetometer) {
            *missing.reasons.entry(missing_word(reason).to_owned()).or_default() += 1;
        }
    }
    missing
}

fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}
