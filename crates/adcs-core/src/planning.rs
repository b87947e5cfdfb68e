//! The look ahead in the cycle: where the target will be and which field, for the periodic optimal law.
//!
//! Every cycle does one slice of the sweep at most, whatever the mode: the plan is ready when pointing
//! begins. What it predicts is what stage I would say then: SGP4, IGRF and the formula of the Sun, by the
//! satellite's own clock.

use crate::control::guidance::{Aim, Scene};
use crate::control::periodic::{Ahead, Gains, Plan};
use crate::environment::field::FieldModel;
use crate::environment::sun_track::{SunNodes, SunTrack};
use crate::environment::sunlight::Sunlight;
use crate::frames::{Direction, Eci};
use crate::orbit::OrbitModel;
use crate::steering::Law;
use crate::time::Utc;

/// Largest turn of a target within a step of the sweep, rad. One that turns faster, as a spinning one
/// does, is not seen by the sweep, and there is no plan.
const LARGEST_TURN_RAD: f32 = 0.5;

/// What one cycle leaves for the next. `Default` is power-on.
#[derive(Debug, Clone, Default)]
pub struct PlanningState {
    plan: Plan,
    field: Option<FieldModel<f32>>,
    sun: SunNodes,
}

/// What the future is computed from.
#[derive(Debug, Clone, Copy)]
pub struct Models<'a> {
    /// SGP4; without it nothing is planned.
    pub orbit: Option<&'a OrbitModel>,
    /// Where the Sun is.
    pub sun: &'a SunTrack,
}

impl PlanningState {
    /// Forgets the plan and what it was made of, where it lies: a new one would be some 14 KB on the stack.
    pub fn forget(&mut self) {
        self.plan.forget();
        (self.field, self.sun) = (None, SunNodes::default());
    }

    /// One slice of work, when the law looks ahead; then the gains for now, when there are any.
    #[inline(never)]
    pub fn cycle(&mut self, law: &Law, models: &Models<'_>, now: Utc) -> Option<Gains> {
        let Law::Pointing(pointing) = law else { return None };
        let periodic = pointing.periodic.as_ref()?;
        let Self { plan, field, sun } = self;
        plan.work(periodic, now, |then| {
            let ahead = ahead(&pointing.guidance.aim, models, field, sun, then)?;
            (ahead.omega_t.norm() * periodic.step_s() <= LARGEST_TURN_RAD).then_some(ahead)
        });
        plan.gains(now)
    }
}

fn ahead(
    aim: &Aim,
    models: &Models<'_>,
    field: &mut Option<FieldModel<f32>>,
    sun: &mut SunNodes,
    then: Utc,
) -> Option<Ahead> {
    let orbit = models.orbit?.state(then).ok()?;
    if field.is_none() {
        *field = FieldModel::new(then).ok();
    }
    let field = field.as_mut()?.eci_t(then, orbit.position).ok()?;
    let sun: Option<Direction<Eci>> = match aim {
        Aim::Sun(_) => {
            let position = models.sun.position_m(sun, then).ok()?;
            Sunlight::seen(position, Some(orbit.position)).map(|sunlight| sunlight.direction)
        }
        Aim::Nadir | Aim::Inertial(_) | Aim::Site(_) => None,
    };
    let goal = aim.goal(&Scene { now: then, orbit: Some(&orbit), sun })?;
    Some(Ahead { field: goal.r_ti * field, omega_t: goal.omega_ti })
}
