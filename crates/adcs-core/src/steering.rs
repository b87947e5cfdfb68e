//! Stage III in the cycle: which law, from which rate, beside which feed-forward, and for how long.
//!
//! A command is decided once a round, at the end of the rest, and held through the action.

use nalgebra::convert;
use serde::{Deserialize, Serialize};

use crate::attitude::field_slope::FieldSlope;
use crate::attitude::selection::Determination;
use crate::control::allocation::{Allocation, Command, Saturation};
use crate::control::b_dot::BDot;
use crate::control::bang_bang::BangBang;
use crate::control::cross_product::{self, CrossProduct, Gravity, PointingError};
use crate::control::feed_forward::{self, FeedForward};
use crate::control::guidance::{Goal, Guidance, Scene, SlewState};
use crate::control::hold;
use crate::control::periodic::{Gains, Motion, PeriodicLaw};
use crate::environment::earth::MU_M3_S2;
use crate::frames::{Body, Direction, Eci, Rotation, Vector};
use crate::orbit::OrbitState;
use crate::reading::{MissingReason, Reading};
use crate::schedule::{Phase, Round};
use crate::time::Utc;

/// The law of stage III.
#[derive(Debug, Clone, Copy)]
#[allow(
    clippy::large_enum_variant,
    reason = "there is one, in static memory, and no heap to box into"
)]
pub enum Law {
    /// The torquers stay off.
    Off,
    /// Despin from rate and magnetometer.
    BDot(BDot),
    /// The same at full dipole, by sign.
    BangBang(BangBang),
    /// An attitude is taken and held.
    Pointing(Pointing),
}

impl Law {
    /// Whether it takes and holds an attitude.
    pub fn points(&self) -> bool {
        match self {
            Self::Pointing(_) => true,
            Self::Off | Self::BDot(_) | Self::BangBang(_) => false,
        }
    }
}

/// Which attitude is held, and how.
#[derive(Debug, Clone, Copy)]
pub struct Pointing {
    /// The law with its gains; beside the one that plans, what flies while there is no plan.
    pub law: CrossProduct,
    /// The law that plans with the field to come; `None` to fly the cross-product law alone.
    pub periodic: Option<PeriodicLaw>,
    /// Where to point.
    pub guidance: Guidance,
}

/// From what the despin laws take the rate.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum RateFrom {
    /// The gyros, and while they are silent what stage II has instead.
    #[default]
    Gyro,
    /// The turning of the field during the rest, without gyros.
    Field,
    /// What stage II believes, and the gyros while it believes nothing.
    Estimate,
}

/// What surrounds every law, as stored and uplinked. `Default` is none of it.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct SteeringParameters {
    /// From what the despin laws take the rate.
    pub rate: RateFrom,
    /// Whether a despin command is switched off when it would begin to drive the spin.
    pub cut_hold: bool,
    /// Largest σ of the residual dipole with which it is fed forward, A·m²; `None` never to do so.
    pub feed_forward_sigma_am2: Option<f32>,
}

/// What surrounds every law.
#[derive(Debug, Clone, Copy)]
pub struct Steering {
    /// From what the despin laws take the rate.
    pub rate: RateFrom,
    /// Whether a despin command is switched off when it would begin to drive the spin.
    pub cut_hold: bool,
    /// The residual dipole's feed-forward.
    pub feed_forward: Option<FeedForward>,
    /// Action and rest.
    pub round: Round,
}

/// What stage III did, and if nothing, why.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ControlStatus {
    /// No law is selected.
    Off,
    /// The schedule lets the field settle.
    Resting,
    /// The torquers carry the command of this round.
    Acting,
    /// They do, but there is no plan: it is the command of the law that needs none.
    Unplanned,
    /// The rate was missing when it was needed; off until the next round.
    NoRate(MissingReason),
    /// The field was missing when it was needed; off until the next round.
    NoField(MissingReason),
    /// The law gave no finite dipole; off until the next round.
    NoDipole,
    /// No attitude, or no rate with it, was believed when it was needed; off until the next round.
    NoAttitude,
    /// The aim needs an orbit or the Sun, and there was none; off until the next round.
    NoTarget,
    /// The satellite has turned so far that the command would drive it; off until the next round.
    Spent,
}

/// What stages I and II and the sensors say.
#[derive(Debug, Clone, Copy)]
pub struct Known<'a> {
    /// Where the satellite is.
    pub orbit: Option<&'a OrbitState>,
    /// Where the Sun is from there.
    pub sun: Option<Direction<Eci>>,
    /// Rate as the gyros show it, rad/s.
    pub omega_bi: Reading<Vector<Body>>,
    /// Field as the magnetometer shows it, T.
    pub field_b: Reading<Vector<Body>>,
    /// What stage II believes.
    pub determination: Option<&'a Determination>,
    /// The model's field, T.
    pub reference_field: Option<Vector<Eci>>,
    /// Of the law that plans, for now.
    pub gains: Option<Gains>,
}

/// For how long the residual dipole is fed forward as it was last trusted, s: an orbit. The magnet does
/// not change because a filter doubts itself, and without feed-forward it turns a satellite that points
/// over within minutes.
const KEPT_S: f64 = 6_000.0;

/// What one cycle leaves for the next. `Default` is power-on.
#[derive(Debug, Clone, Copy, Default)]
pub struct SteeringState {
    held: Decision,
    slope: FieldSlope,
    slew: SlewState,
    /// The residual dipole as it was last trusted, and when, A·m².
    residual: Option<(Utc, Vector<Body>)>,
    last: Option<Utc>,
    error_rad: Option<f32>,
}

/// The outcome of stage III, held until the round ends.
#[derive(Debug, Clone, Copy)]
pub struct Decision {
    /// What was done, and if nothing, why.
    pub control: ControlStatus,
    /// What the torquers are asked for.
    pub command: Command,
    /// When it was decided, and for how long it is of use, s.
    useful: Option<(Utc, f32)>,
    /// Angle from Body to the target, rad, when it was decided; `None` when no attitude is aimed at.
    pub error_rad: Option<f32>,
}

impl Decision {
    fn off(control: ControlStatus) -> Self {
        Self { control, command: Command::off(), useful: None, error_rad: None }
    }

    fn acting(command: Command) -> Self {
        Self { control: ControlStatus::Acting, command, useful: None, error_rad: None }
    }

    /// The command as long as it is of use.
    fn still(self, now: Utc) -> Self {
        match self.useful {
            Some((since, useful_s)) if now.seconds_since(since) as f32 >= useful_s => {
                Self { error_rad: self.error_rad, ..Self::off(ControlStatus::Spent) }
            }
            _ => self,
        }
    }
}

impl Default for Decision {
    fn default() -> Self {
        Self::off(ControlStatus::Resting)
    }
}

impl SteeringState {
    /// Drops what was decided by a law that flies no longer: torquers off until the next round.
    pub fn interrupt(&mut self) {
        self.held = Decision::default();
        self.slew = SlewState::default();
        self.error_rad = None;
    }

    /// Angle from Body to the target, rad, as it was last decided upon.
    pub fn error_rad(&self) -> Option<f32> {
        self.error_rad
    }

    /// Stage III of one cycle.
    pub fn cycle(
        &mut self,
        law: &Law,
        steering: &Steering,
        allocation: &Allocation,
        (now, phase): (Utc, Phase),
        known: &Known<'_>,
    ) -> Decision {
        if steering.rate == RateFrom::Field {
            let dt_s = self.last.map_or(0.0, |last| now.seconds_since(last) as f32);
            let settled = matches!(phase, Phase::Settled | Phase::Measuring);
            self.slope.cycle(settled, known.field_b.value(), dt_s);
        }
        self.last = Some(now);
        self.held = match phase {
            Phase::Settling | Phase::Settled => Decision::default(),
            Phase::Measuring => {
                let residual = self.residual(steering, known, now);
                let Self { slope, slew, .. } = self;
                let mut round =
                    Deciding { steering, allocation, known, residual, slope, slew, now };
                let decision = round.decide(law).still(now);
                self.error_rad = decision.error_rad;
                decision
            }
            Phase::Acting => self.held.still(now),
        };
        self.held
    }
}

impl SteeringState {
    /// The residual dipole, and what is fed forward against it: while it is to be trusted, and for a
    /// while as it was then.
    fn residual(
        &mut self,
        steering: &Steering,
        known: &Known<'_>,
        now: Utc,
    ) -> Option<(Vector<Body>, Vector<Body>)> {
        let forward = steering.feed_forward?;
        let estimate = known.determination.and_then(|it| it.dynamic.estimate.as_ref());
        let trusted = estimate.filter(|it| it.trusted).and_then(|it| {
            let fed = forward.dipole(
                it.residual_dipole,
                it.residual_dipole_sigma_am2,
                &steering.round,
            )?;
            Some((it.residual_dipole, fed))
        });
        if let Some((residual, _)) = trusted {
            self.residual = Some((now, residual));
            return trusted;
        }
        let (at, residual) = self.residual?;
        let is_recent = (0.0..=KEPT_S).contains(&now.seconds_since(at));
        let fed = forward.dipole(residual, Vector::zero(), &steering.round)?;
        is_recent.then_some((residual, fed))
    }
}

/// One round's decision in the making.
struct Deciding<'a> {
    steering: &'a Steering,
    allocation: &'a Allocation,
    known: &'a Known<'a>,
    /// The residual dipole, and what is fed forward against it.
    residual: Option<(Vector<Body>, Vector<Body>)>,
    slope: &'a FieldSlope,
    slew: &'a mut SlewState,
    now: Utc,
}

impl Deciding<'_> {
    /// The law's dipole, brought within what the torquers can do. Whatever is missing switches them off
    /// for the round.
    fn decide(&mut self, law: &Law) -> Decision {
        match law {
            Law::Off => Decision::off(ControlStatus::Off),
            Law::BDot(law) => self.despin(|omega_bi, field_b| law.dipole(omega_bi, field_b)),
            Law::BangBang(law) => self.despin(|omega_bi, field_b| {
                let along = |v| self.allocation.to_torquers(v);
                let dipole = law.dipole(along(omega_bi), along(field_b))?;
                Some(self.allocation.to_body(dipole))
            }),
            Law::Pointing(pointing) => self.point(pointing),
        }
    }

    fn despin(
        &self,
        law: impl FnOnce(Vector<Body>, Vector<Body>) -> Option<Vector<Body>>,
    ) -> Decision {
        let (omega_bi, field_b) = match (self.rate(), self.known.field_b) {
            (Reading::Missing(reason), _) => return Decision::off(ControlStatus::NoRate(reason)),
            (_, Reading::Missing(reason)) => return Decision::off(ControlStatus::NoField(reason)),
            (Reading::Fresh(omega_bi), Reading::Fresh(field_b)) => (omega_bi, field_b),
        };
        let Some(wanted) = law(omega_bi, field_b) else {
            return Decision::off(ControlStatus::NoDipole);
        };
        let fed = self.residual.map(|(_, fed)| fed);
        let command = self.command(fed, wanted, Saturation::ClipAxes);
        let useful = self.steering.cut_hold.then(|| {
            // What is fed forward stands against M, which turns along: it never grows stale.
            let fed = fed.map_or(Vector::zero(), |fed| self.allocation.command(fed).dipole);
            let share = self.allocation.to_body(command.dipole - fed);
            (self.now, hold::useful_s(share, omega_bi, field_b))
        });
        Decision { useful, ..Decision::acting(command) }
    }

    fn point(&mut self, pointing: &Pointing) -> Decision {
        let Pointing { law, periodic, guidance } = pointing;
        let believed = self.known.determination.and_then(|it| it.attitude.zip(it.rate));
        let Some((attitude, rate)) = believed else {
            return Decision::off(ControlStatus::NoAttitude);
        };
        let Known { orbit, sun, .. } = *self.known;
        let Some(goal) = guidance.aim.goal(&Scene { now: self.now, orbit, sun }) else {
            return Decision::off(ControlStatus::NoTarget);
        };
        let error_rad = Some((attitude.r_bi * goal.r_ti.inverse()).angle_rad());
        if let Some(planned) = periodic.as_ref().and_then(|law| self.planned(law, &goal)) {
            return Decision { error_rad, ..planned };
        }
        let field_b = match self.known.field_b {
            Reading::Missing(reason) => {
                return Decision { error_rad, ..Decision::off(ControlStatus::NoField(reason)) };
            }
            Reading::Fresh(field_b) => field_b,
        };
        let asked = match &guidance.slew {
            Some(slew) => slew.towards(self.slew, self.now, attitude.r_bi, &goal),
            None => goal,
        };
        let residual = self.residual;
        let ripple = residual.map_or(Vector::zero(), |(residual, _)| {
            feed_forward::ripple(residual, field_b, law.inertia_kg_m2(), &self.steering.round)
        });
        let omega_bi = rate.omega_bi - ripple;
        let gravity = orbit.and_then(|orbit| gravity(orbit, attitude.r_bi));
        let error = PointingError::new(attitude.r_bi, omega_bi, &asked);
        let torque = law.desired_torque(&error, omega_bi, gravity.as_ref());
        match cross_product::dipole(torque, field_b) {
            None => Decision { error_rad, ..Decision::off(ControlStatus::NoDipole) },
            Some(wanted) => {
                let fed = residual.map(|(_, fed)| fed).unwrap_or(Vector::zero());
                let command = self.allocation.command_beside(fed, wanted, Saturation::ScaleAll);
                let control = match periodic {
                    Some(_) => ControlStatus::Unplanned,
                    None => ControlStatus::Acting,
                };
                Decision { error_rad, control, ..Decision::acting(command) }
            }
        }
    }

    /// The command of the law that plans; `None` without a plan, or without the field's model.
    fn planned(&self, law: &PeriodicLaw, goal: &Goal) -> Option<Decision> {
        let Known { orbit, determination, reference_field, gains, .. } = *self.known;
        let (gains, determination) = (gains?, determination?);
        let (r_bi, rate) = (determination.attitude?.r_bi, determination.rate?);
        let (round, inertia) = (&self.steering.round, law.inertia_kg_m2());
        let r_bt = r_bi * goal.r_ti.inverse();
        let r_tb = r_bt.inverse();
        let field = goal.r_ti * reference_field?;

        let residual = self.residual;
        let ripple = residual.map_or(Vector::zero(), |(residual, _)| {
            feed_forward::ripple(residual, r_bt * field, inertia, round)
        });
        let error = PointingError::new(r_bi, rate.omega_bi - ripple, goal);
        // What is known to turn the satellite: what stage II found, and on target what its unequal
        // moments make of gravity and of the target's own turn. Where stage II has learned the inertia,
        // its torque is what that leaves.
        let found = determination.dynamic.estimate.as_ref().filter(|it| it.trusted);
        let inertia = found.map_or(inertia, |estimate| &estimate.inertia_kg_m2);
        let found = found.map_or(Vector::zero(), |estimate| r_tb * estimate.torque);
        let omega = goal.omega_ti.xyz;
        let gyroscopic = Vector::from_xyz(-omega.cross(&(inertia * omega)));
        let pulled = orbit.and_then(|orbit| gravity(orbit, goal.r_ti)).map(|it| it.torque(inertia));
        let torque = found + gyroscopic + pulled.unwrap_or(Vector::zero());
        let motion = Motion { attitude: error.attitude.relabel(), rate: r_tb * error.rate, torque };

        let cycle_s = round.on_s + round.off_s;
        let mean = law.dipole(&gains, &motion, field, cycle_s)?;
        let wanted = r_bt * mean * round.inverse_duty();
        let fed = residual.map_or(Vector::zero(), |(_, fed)| fed);
        let command = self.allocation.command_beside(fed, wanted, Saturation::ScaleAll);
        Some(Decision::acting(command))
    }

    fn command(
        &self,
        fed: Option<Vector<Body>>,
        wanted: Vector<Body>,
        saturation: Saturation,
    ) -> Command {
        match fed {
            Some(fed) => self.allocation.command_beside(fed, wanted, saturation),
            None => self.allocation.command(wanted),
        }
    }

    /// The rate that despin works with. From the gyro, and when it is silent what stage II makes of the
    /// dynamics or of the field alone; or always from the field.
    fn rate(&self) -> Reading<Vector<Body>> {
        match self.steering.rate {
            RateFrom::Gyro | RateFrom::Estimate => {
                let believed = self.known.determination.and_then(|it| it.rate);
                let measured = self.known.omega_bi;
                let is_wanted =
                    self.steering.rate == RateFrom::Estimate || measured.missing().is_some();
                match believed.filter(|_| is_wanted) {
                    Some(rate) => Reading::Fresh(rate.omega_bi),
                    None => measured,
                }
            }
            RateFrom::Field => match self.slope.rate() {
                Some(rate) => Reading::Fresh(rate.omega_bi),
                // Too few of them while the torquers rested, unless this one says why it is missing.
                None => Reading::Missing(
                    self.known.field_b.missing().unwrap_or(MissingReason::TorquersOn),
                ),
            },
        }
    }
}

/// Where the Earth is in the axes that `rotation` leads to.
fn gravity<F>(orbit: &OrbitState, rotation: Rotation<F, Eci>) -> Option<Gravity<F>> {
    let up = (rotation * orbit.position.to_f32()).direction()?.vector();
    let r = orbit.position.norm();
    Some(Gravity { up, gradient: convert(3.0 * MU_M3_S2 / (r * r * r)) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::attitude::dynamic::{DynamicEstimate, DynamicOutput};
    use crate::attitude::mekf;
    use crate::attitude::selection::Reason;
    use crate::control::allocation::TorquerParameters;
    use crate::control::b_dot::BDotGain;
    use nalgebra::Matrix3;

    const RESIDUAL_AM2: [f32; 3] = [-0.3, 0.2, 0.1];

    /// A filter that knows the residual dipole, and says whether it is to be trusted.
    fn knowing(trusted: bool) -> Determination {
        let [x, y, z] = RESIDUAL_AM2;
        let estimate = DynamicEstimate {
            r_bi: Rotation::identity(),
            attitude_covariance: Matrix3::identity(),
            omega_bi: Vector::zero(),
            rate_covariance: Matrix3::identity(),
            gyro_bias: Vector::zero(),
            gyro_bias_sigma_rad_s: Vector::zero(),
            residual_dipole: Vector::new(x, y, z),
            residual_dipole_sigma_am2: Vector::new(0.01, 0.01, 0.01),
            inertia_kg_m2: Matrix3::identity(),
            torque: Vector::zero(),
            torque_sigma_n_m: 0.0,
            trusted,
            gyro_doubtful: false,
        };
        Determination {
            attitude: None,
            rate: None,
            reason: Reason::DynamicNotTrusted,
            mekf: mekf::Output { estimate: None, field: None, sun: None, event: None },
            dynamic: DynamicOutput {
                estimate: Some(estimate),
                gyro: None,
                field: None,
                sun: None,
                event: None,
            },
        }
    }

    #[test]
    fn a_residual_dipole_that_was_trusted_is_fed_forward_for_an_orbit_more() {
        let steering = Steering {
            rate: RateFrom::Gyro,
            cut_hold: false,
            feed_forward: Some(FeedForward::new(0.03).unwrap()),
            round: Round { on_s: 10.0, off_s: 2.5 },
        };
        let torquers =
            TorquerParameters { max_dipole_am2: 0.6, alignment_xyzw: [0.0, 0.0, 0.0, 1.0] };
        let allocation = Allocation::new(&torquers).unwrap();
        let law = Law::BDot(BDot::new(BDotGain::Plain { gain_am2_s_per_t: 1e5 }).unwrap());
        let mut state = SteeringState::default();
        let mut dipole = |seconds: i64, determination: Option<Determination>| {
            // At rest: what is commanded is what is fed forward.
            let known = Known {
                orbit: None,
                sun: None,
                omega_bi: Reading::Fresh(Vector::zero()),
                field_b: Reading::Fresh(Vector::new(3e-5, 0.0, 0.0)),
                determination: determination.as_ref(),
                reference_field: None,
                gains: None,
            };
            let at = (Utc::from_micros_since_2000(seconds * 1_000_000), Phase::Measuring);
            state.cycle(&law, &steering, &allocation, at, &known).command.dipole.to_array()
        };
        let fed = RESIDUAL_AM2.map(|m| m * -1.25);
        assert_eq!(dipole(0, Some(knowing(false))), [0.0; 3], "never trusted");
        assert_eq!(dipole(10, Some(knowing(true))), fed);
        for (seconds, unsure) in [(20, Some(knowing(false))), (4_000, None), (6_009, None)] {
            assert_eq!(dipole(seconds, unsure), fed, "{seconds} s");
        }
        assert_eq!(dipole(6_020, None), [0.0; 3], "too long ago");
        assert_eq!(dipole(5, None), [0.0; 3], "a clock that was set back");
    }
}
