//! How far from its target the satellite really pointed.

use adcs_app::LawParameters;
use adcs_core::control::guidance::{Aim, AimParameters, Scene};
use adcs_core::frames::{Body, Direction, Eci, Rotation, Target, Vector};
use adcs_core::modes::Mode;
use adcs_core::orbit::{OrbitModel, OrbitState};
use adcs_link::{CycleRecord, TruthRecord};
use adcs_sim::scenario::Scenario;
use serde::Serialize;

use super::rows::Row;

/// Nearer than this to its target, and for good, a satellite counts as captured, deg.
pub const CAPTURED_DEG: f64 = 10.0;
/// Figures are taken from so many orbits after the law began on.
const SETTLING_ORBITS: f64 = 2.0;

/// What a mission points at.
#[derive(Debug)]
pub struct Targets {
    orbit: Option<OrbitModel>,
    law: Option<Aim>,
    experiment: Option<Aim>,
    period_s: f64,
}

impl Targets {
    /// Those of a scenario; none of laws that do not point.
    pub fn of(scenario: &Scenario) -> Self {
        let aim = |law: LawParameters| Aim::new(&aim_of(law)?).ok();
        let experiment = scenario.flight.modes.and_then(|modes| modes.experiment);
        let elements = &scenario.world.elements;
        Self {
            orbit: OrbitModel::new(elements).ok(),
            law: aim(scenario.flight.law),
            experiment: experiment.and_then(|flown| aim(flown.law)),
            period_s: 86_400.0 / elements.mean_motion_rev_per_day,
        }
    }

    /// Length of an orbit, s.
    pub fn period_s(&self) -> f64 {
        self.period_s
    }

    /// Angle from Body to the target that the satellite should have had, deg, by the truth alone; `None`
    /// while nothing is pointed at.
    pub fn error_deg(&self, truth: &TruthRecord, record: &CycleRecord) -> Option<f64> {
        let aim = match record.mode.map(|report| report.mode) {
            None | Some(Mode::Point) => self.law?,
            Some(Mode::Experiment) => self.experiment?,
            Some(_) => return None,
        };
        let vector = |[x, y, z]: [f64; 3]| Vector::<Eci, f64>::new(x, y, z);
        let model = self.orbit.as_ref()?.state(record.utc).ok()?;
        let orbit = OrbitState { position: vector(truth.position_eci_m), ..model };
        let sun: Option<Direction<Eci>> = vector(truth.sun_eci).to_f32().direction();
        let goal = aim.goal(&Scene { now: record.utc, orbit: Some(&orbit), sun })?;
        let r_ti: Rotation<Target, Eci, f64> = Rotation::from_hamilton(goal.r_ti.hamilton().cast());
        let r_bi: Rotation<Body, Eci, f64> =
            Rotation::from_attitude_quaternion(truth.attitude_xyzw)?;
        Some((r_bi * r_ti.inverse()).angle_rad().to_degrees())
    }
}

/// Where a law points.
pub fn aim_of(law: LawParameters) -> Option<AimParameters> {
    match law {
        LawParameters::CrossProduct { guidance, .. } | LawParameters::Periodic { guidance, .. } => {
            Some(guidance.aim)
        }
        LawParameters::Off | LawParameters::BDot(_) | LawParameters::BangBang(_) => None,
    }
}

/// How well a flight pointed.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Pointing {
    /// When a pointing law first flew, s.
    pub first_s: f64,
    /// Since when the error has stayed below 10 deg, s; `None` when it did not at the end.
    pub captured_s: Option<f64>,
    /// The figures below count from here on, s: two orbits after the law began, or halfway to the end of a
    /// shorter flight.
    pub settled_s: f64,
    /// Fraction of the time since in which a pointing law flew.
    pub share: f64,
    /// Mean angle to the target, deg.
    pub mean_deg: f64,
    /// 95 % of the time it is below this, deg.
    pub p95_deg: f64,
    /// Its largest, deg.
    pub largest_deg: f64,
}

/// How well these rows pointed; `None` when they never aimed at anything.
pub fn pointing(rows: &[Row], period_s: f64) -> Option<Pointing> {
    let first_s = rows.iter().find(|row| row.pointing_error_deg.is_some())?.time_s;
    let last_s = rows.last()?.time_s;
    let settled_s = (first_s + SETTLING_ORBITS * period_s).min((first_s + last_s) / 2.0);
    let far = |row: &&Row| row.pointing_error_deg.is_none_or(|error| error >= CAPTURED_DEG);
    let near_since = match rows.iter().rposition(|row| far(&row)) {
        Some(last_far) => rows.get(last_far + 1),
        None => rows.first(),
    };
    let since: Vec<&Row> = rows.iter().filter(|row| row.time_s >= settled_s).collect();
    let mut errors: Vec<f64> = since.iter().filter_map(|row| row.pointing_error_deg).collect();
    errors.sort_by(f64::total_cmp);
    let at_95 = (0.95 * (errors.len() as f64 - 1.0)).round().max(0.0) as usize;
    Some(Pointing {
        first_s,
        captured_s: near_since.map(|row| row.time_s),
        settled_s,
        share: errors.len() as f64 / since.len().max(1) as f64,
        mean_deg: errors.iter().sum::<f64>() / errors.len().max(1) as f64,
        p95_deg: errors.get(at_95).copied()?,
        largest_deg: errors.last().copied()?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flight::records::tests::flown;
    use crate::report::rows::rows;

    fn with_errors(errors: &[Option<f64>]) -> Vec<Row> {
        let mut rows = rows(&flown(errors.len() as u32), None);
        for (row, error) in rows.iter_mut().zip(errors) {
            row.pointing_error_deg = *error;
        }
        rows
    }

    #[test]
    fn captured_is_since_the_last_time_it_was_far_off() {
        let rows = with_errors(&[None, Some(50.0), Some(5.0), Some(12.0), Some(4.0), Some(2.0)]);
        let found = pointing(&rows, 5400.0).unwrap();
        assert_eq!((found.first_s, found.captured_s), (0.5, Some(2.0)));
        let lost = with_errors(&[Some(2.0), Some(50.0)]);
        assert_eq!(pointing(&lost, 5400.0).unwrap().captured_s, None);
        assert_eq!(pointing(&with_errors(&[None; 5]), 5400.0), None);
    }

    #[test]
    fn figures_are_taken_after_settling() {
        let errors: Vec<_> = (0..101).map(|k| Some(100.0 - f64::from(k))).collect();
        // 50 s long: in orbits of 10 s it has settled after 20 s, in longer ones halfway.
        let found = pointing(&with_errors(&errors), 10.0).unwrap();
        assert_eq!((found.settled_s, found.mean_deg, found.largest_deg), (20.0, 30.0, 60.0));
        assert_eq!((found.p95_deg, found.share), (57.0, 1.0));
        assert_eq!(pointing(&with_errors(&errors), 5400.0).unwrap().settled_s, 25.0);
    }
}
