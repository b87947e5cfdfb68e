//! A day of rounds with the flight's own law.

use adcs_app::LawParameters;
use adcs_core::control::cross_product::{self, CrossProduct, Gravity, PointingError};
use adcs_core::control::periodic::{Ahead, Motion, PeriodicLaw, Plan};
use adcs_core::environment::earth::MU_M3_S2;
use adcs_core::environment::field::FieldModel;
use adcs_core::frames::{Target, Vector};
use adcs_core::orbit::OrbitModel;
use adcs_core::orbit::frame::OrbitFrame;
use adcs_core::schedule::Round;
use adcs_core::time::Utc;
use anyhow::{Context as _, Result, bail};
use nalgebra::{Matrix3, Matrix6, SMatrix, Vector3};
use sgp4_lite::Elements;

use super::grid::Body;
use super::plant::{Around, Plant, UP};

const DAY_S: f64 = 86_400.0;
const MICROS: f64 = 1e6;

/// A pointing law and its rounds.
#[derive(Debug, Clone, Copy)]
pub struct Loop {
    law: Law,
    round: Round,
    inertia: Matrix3<f64>,
}

#[derive(Debug, Clone, Copy)]
#[allow(clippy::large_enum_variant, reason = "there is one")]
enum Law {
    CrossProduct(CrossProduct),
    Periodic(PeriodicLaw),
}

impl Loop {
    /// The law of a mission.
    ///
    /// # Errors
    /// When it does not point, or its parameters are refused.
    pub fn new(law: &LawParameters, round: Round) -> Result<Self> {
        let (law, inertia) = match law {
            LawParameters::CrossProduct { law, .. } => {
                (Law::CrossProduct(CrossProduct::new(law)?), law.inertia_kg_m2)
            }
            LawParameters::Periodic { law, .. } => {
                (Law::Periodic(PeriodicLaw::new(law)?), law.inertia_kg_m2)
            }
            _ => bail!("the mission's law does not point: there is no loop to be certified"),
        };
        let inertia = Matrix3::from_fn(|row, column| f64::from(inertia[row][column]));
        Ok(Self { law, round, inertia })
    }

    fn plant(&self, body: &Body) -> Result<Plant> {
        let root = Vector3::from(body.moments).map(f64::sqrt);
        let stretch = Matrix3::from_diagonal(&root);
        let inertia = stretch * self.inertia * stretch;
        let inverse = inertia.try_inverse().context("an inertia that is none")?;
        Ok(Plant { inertia, inverse })
    }

    /// dm/d(e, ω_e) at an instant; zero while a plan is made.
    fn gain(&self, plan: &Plan, now: Utc, around: &Around) -> Result<SMatrix<f64, 3, 6>> {
        let mut gain = SMatrix::<f64, 3, 6>::zeros();
        for state in 0..6 {
            // The laws are linear near the target: a milliradian and as much in rate.
            const STEP: f32 = 1e-3;
            let mut x = [0.0_f32; 6];
            x[state] = if state < 3 { STEP } else { STEP * 1e-2 };
            let scale = f64::from(x[state]);
            let moved = self.dipole(plan, now, around, x)?;
            let rest = self.dipole(plan, now, around, [0.0; 6])?;
            gain.set_column(state, &((moved - rest) / scale));
        }
        Ok(gain)
    }

    /// The dipole while the torquers act, Orbit, A·m².
    fn dipole(&self, plan: &Plan, now: Utc, around: &Around, x: [f32; 6]) -> Result<Vector3<f64>> {
        let [e_x, e_y, e_z, w_x, w_y, w_z] = x;
        let (attitude, rate) = (Vector3::new(e_x, e_y, e_z), Vector3::new(w_x, w_y, w_z));
        let field: Vector<Target> = Vector::from_xyz(around.field.cast());
        let found = match &self.law {
            Law::CrossProduct(law) => {
                let omega = around.omega.cast::<f32>();
                let up: Vector3<f32> = UP.cast();
                let error = PointingError {
                    attitude: Vector::from_xyz(attitude),
                    rate: Vector::from_xyz(rate),
                };
                let gravity = Gravity {
                    up: Vector::from_xyz(up + up.cross(&attitude)),
                    gradient: around.gradient as f32,
                };
                let omega_bi = Vector::from_xyz(rate + omega + omega.cross(&attitude));
                let torque = law.desired_torque(&error, omega_bi, Some(&gravity));
                cross_product::dipole(torque, field.relabel()).map(|m| m.xyz)
            }
            Law::Periodic(law) => match plan.gains(now) {
                None => return Ok(Vector3::zeros()),
                Some(gains) => {
                    let motion = Motion {
                        attitude: Vector::from_xyz(attitude),
                        rate: Vector::from_xyz(rate),
                        torque: Vector::zero(),
                    };
                    let round_s = self.round.on_s + self.round.off_s;
                    let mean = law.dipole(&gains, &motion, field, round_s);
                    mean.map(|m| m.xyz * self.round.inverse_duty())
                }
            },
        };
        Ok(found.context("the law gives no dipole")?.cast())
    }
}

/// What surrounds the satellite, from SGP4 and IGRF.
struct World {
    orbit: OrbitModel,
    field: FieldModel<f64>,
}

impl World {
    fn around(&mut self, now: Utc) -> Result<Around> {
        let state = self.orbit.state(now)?;
        let frame = OrbitFrame::of(&state).context("the orbit has no plane")?;
        let r = state.position.norm();
        Ok(Around {
            field: (frame.r_oi * self.field.eci_t(now, state.position)?).xyz,
            omega: frame.omega_oi.xyz,
            gradient: 3.0 * MU_M3_S2 / (r * r * r),
        })
    }

    fn ahead(&mut self, then: Utc) -> Option<Ahead> {
        let around = self.around(then).ok()?;
        Some(Ahead {
            field: Vector::from_xyz(around.field.cast()),
            omega_t: Vector::from_xyz(around.omega.cast()),
        })
    }
}

/// What an error on target is multiplied by each orbit: the largest modulus of the eigenvalues of a
/// day's matrix, to the power of one over the day's orbits.
///
/// # Errors
/// Elements or a date for which there is no orbit or field.
pub fn multiplier(lp: &Loop, elements: &Elements, body: &Body) -> Result<f64> {
    let orbit = OrbitModel::new(elements)?;
    let start = orbit.epoch();
    let mut world = World { field: FieldModel::new(start)?, orbit };
    let plant = lp.plant(body)?;
    let at = |t_s: f64| start.plus_micros((t_s * MICROS).round() as i64);
    let (off_s, on_s) = (f64::from(lp.round.off_s), f64::from(lp.round.on_s));
    let mut plan = Plan::default();
    if let Law::Periodic(law) = &lp.law {
        // The first sweep is complete when the day begins.
        for _ in 0..1000 {
            if plan.gains(start).is_some() {
                break;
            }
            plan.work(law, start, |then| world.ahead(then));
        }
    }
    let nothing = SMatrix::zeros();
    let mut x = Matrix6::identity();
    // Columns shrink by orders of magnitude in a day: what was taken out of them, as a logarithm.
    let mut taken = 0.0;
    let rounds = (DAY_S / (off_s + on_s)).floor() as u32;
    let mut before = world.around(start)?;
    for round in 0..rounds {
        let t_s = f64::from(round) * (off_s + on_s);
        let (acts, ends) = (at(t_s + off_s), at(t_s + off_s + on_s));
        if let Law::Periodic(law) = &lp.law {
            // One slice a cycle, and at least one cycle a second.
            for _ in 0..8 {
                plan.work(law, acts, |then| world.ahead(then));
            }
        }
        let middle = world.around(acts)?;
        x = plant.carried(&before, &middle, &nothing, &x, off_s);
        let gain = lp.gain(&plan, acts, &middle)?;
        before = world.around(ends)?;
        x = plant.carried(&middle, &before, &gain, &x, on_s);
        let size = x.norm();
        if !size.is_finite() || size == 0.0 {
            bail!("the loop's matrix is not finite");
        }
        x /= size;
        taken += size.ln();
    }
    let radius = x.complex_eigenvalues().iter().map(|it| it.re.hypot(it.im)).fold(0.0, f64::max);
    let orbits = f64::from(rounds) * (off_s + on_s) * elements.mean_motion_rev_per_day / DAY_S;
    Ok(((radius.ln() + taken) / orbits).exp())
}
