//! Does the satellite answer the torquers as it should?
//!
//! Euler's equations tell how a commanded dipole changes the rate, if everything in them is known; so
//! what is not known is estimated along, by an extended Kalman filter without attitude:
//!
//! J ω̇ = (M + P m) × B − ω × J ω,  Ḃ = −ω × B,  gyro = ω + b,  magnetometer = B + c
//!
//! | state | code | meaning | prior σ |
//! |---|---|---|---|
//! | ω, B | `Quick` | rate, rad/s; field, in `FIELD_UNIT_T` | the first measurement |
//! | b | `BIAS` | gyro bias, rad/s | parameter |
//! | p | `INERTIA` | six parameters of J, in units of its mean moment | parameter |
//! | M | `DIPOLE` | residual dipole, A·m² | parameter |
//! | P | `WIRING` | the torquers do P m: nine numbers, column by column | 0.7 |
//! | c | `FIELD_BIAS` | what the magnetometer shows too much, in `FIELD_UNIT_T` | parameter |
//!
//! P is estimated as any matrix, with no opinion on what it is; `answer` has one.
//!
//! Source: Markley & Crassidis (2014), §12.3.7, for the filter.

use nalgebra::{Matrix3, SMatrix, SVector, Vector3};

use super::answer::{Answers, ResponseEvidence};
use super::parameters::PolarityParameters;
use crate::frames::SignedPermutation;

/// The unit of the field, T: fields in low orbit are of order one.
const FIELD_UNIT_T: f32 = 3e-5;
/// Longest step, s: longer ones are cut.
const LONGEST_STEP_S: f32 = 0.5;
/// After a longer gap it starts anew, s.
const LONGEST_GAP_S: f32 = 10.0;
/// Prior σ of each entry of P: of the 48, a third are ±1.
pub(super) const WIRING_PRIOR: f32 = 0.7;
/// A measurement further off than this many σ is left out.
const GATE: f32 = 5.0;
/// Over how long the work of a wiring is counted, s.
const WORK_MEMORY_S: f32 = 300.0;
/// So many of them in a row, and the estimate is lost.
const LOST: u8 = 30;
/// How the gyro bias walks, rad/s per √s (docs/filters), the residual dipole, A·m² per √s, and what is
/// known of P is forgotten, per √s.
const BIAS_WALK: f32 = 2e-6;
const DIPOLE_WALK: f32 = 1e-4;
const WIRING_WALK: f32 = 2e-3;
/// How the magnetometer's bias walks, in `FIELD_UNIT_T` per √s: 150 nT in an orbit.
const FIELD_BIAS_WALK: f32 = 2e-9 / FIELD_UNIT_T;
/// What the field turns in Eci along the orbit, twice the rate of a low orbit, rad/s; correlated over a
/// round.
const FIELD_WALK: f32 = 2.2e-3 * 3.5;

/// A magnetometer has turned wrong when for so long, s, each field is explained by a wrong wiring and not by
/// the right one: in three rests of the paper's.
const TURNED_WRONG_S: f32 = 15.0;
/// By how many σ a field must differ from what is expected to be another wiring's.
const JUMP: f32 = 10.0;
/// A satellite may turn so fast when that begins, rad/s: 0.3 deg/s, of which a gyro that is wrong makes 3 µT in
/// a round. And so fast while it lasts: beyond, `turning` knows better.
const SLOW_RAD_S: f32 = 5e-3;
const SLOWER_THAN_RAD_S: f32 = 0.0175;
/// What each axis turned round takes from the odds, natural logarithm, and twice that each one exchanged:
/// one wire goes more easily than two.
const EACH_CHANGE: f32 = 3.0;

/// Rate and field.
const QUICK: usize = 6;
/// Everything that does not move by itself.
const SLOW: usize = 24;
const BIAS: usize = 0;
const INERTIA: usize = 3;
const DIPOLE: usize = 9;
const WIRING: usize = 12;
const FIELD_BIAS: usize = 21;

type Quick = SVector<f32, QUICK>;
type Slow = SVector<f32, SLOW>;

/// The estimate; `Default` is power-on, without one.
#[derive(Debug, Clone, Copy, Default)]
pub struct Response {
    tracked: Option<Tracked>,
    /// Of all measurements, each as far off as the gate at most.
    log_likelihood: f32,
    /// Measurements in a row that were left out.
    contradictions: u8,
    /// The wrong wiring of the magnetometer that explains the last field, and for how long one has, s.
    turned_wrong: Option<(SignedPermutation, f32)>,
    /// C = ∫ (B × ω) mᵀ dt, fading: a wiring P of the torquers does the work tr(Pᵀ C) of late.
    work: Matrix3<f32>,
}

#[derive(Debug, Clone, Copy)]
struct Tracked {
    quick: Quick,
    slow: Slow,
    /// Covariance: of the quick states, between them and the slow ones, of those.
    qq: SMatrix<f32, QUICK, QUICK>,
    qs: SMatrix<f32, QUICK, SLOW>,
    ss: SMatrix<f32, SLOW, SLOW>,
}

/// Where the satellite stands, Body.
#[derive(Debug, Clone, Copy)]
pub(super) struct Estimate {
    /// Rate, rad/s, and σ of each axis.
    pub(super) rate: Vector3<f32>,
    pub(super) rate_sigma: Vector3<f32>,
    /// Field, T.
    pub(super) field: Vector3<f32>,
    /// Residual dipole, A·m², and σ of each axis.
    pub(super) dipole: Vector3<f32>,
    pub(super) dipole_sigma: Vector3<f32>,
}

/// Measurements of one cycle.
#[derive(Debug, Clone, Copy)]
pub(super) struct Seen {
    /// The gyro, rad/s.
    pub(super) gyro: Option<Vector3<f32>>,
    /// The field at rest, T.
    pub(super) field: Option<Vector3<f32>>,
    /// The dipole that was commanded since the last cycle, A·m².
    pub(super) dipole: Vector3<f32>,
}

impl Response {
    /// Takes in one cycle, `dt_s` after the last, with the tensor as it is known, kg·m².
    pub(super) fn cycle(
        &mut self,
        p: &PolarityParameters,
        inertia: &Matrix3<f32>,
        dt_s: f32,
        seen: &Seen,
    ) {
        let Some(mut tracked) = self.tracked else {
            if let Some((gyro, field)) = seen.gyro.zip(seen.field) {
                *self = Self { tracked: Some(Tracked::new(p, gyro, field)), ..Self::default() };
            }
            return;
        };
        let usable = dt_s > 0.0 && dt_s <= LONGEST_GAP_S;
        if !usable {
            *self = Self::default();
            return;
        }
        // At most 20.
        let steps = libm::ceilf(dt_s / LONGEST_STEP_S).max(1.0);
        for _ in 0..steps as u8 {
            tracked.predict(p, inertia, dt_s / steps, seen.dipole);
        }
        let (rate, field) = (tracked.quick.fixed_rows::<3>(0), tracked.quick.fixed_rows::<3>(3));
        let kept = 1.0 - dt_s / (WORK_MEMORY_S + dt_s);
        self.work = self.work * kept + field.cross(&rate) * seen.dipole.transpose() * dt_s;
        for (axis, value) in seen.gyro.iter().flat_map(|gyro| gyro.iter().enumerate()) {
            let noise = p.gyro_noise_rad_s;
            self.absorb(&mut tracked, Measured::Gyro(axis), *value, noise * noise);
        }
        if let Some((_, for_s)) = &mut self.turned_wrong {
            *for_s += dt_s;
        }
        if let Some(field) = seen.field.map(|field| field / FIELD_UNIT_T) {
            let noise = p.field_noise_t / FIELD_UNIT_T;
            let begun = self.turned_wrong.is_some();
            let limit_rad_s = if begun { SLOWER_THAN_RAD_S } else { SLOW_RAD_S };
            let slow = tracked.quick.fixed_rows::<3>(0).norm() <= limit_rad_s;
            let wiring = if slow { tracked.turned_wrong(field, noise) } else { None };
            let for_s = self.turned_wrong.map_or(0.0, |(_, for_s)| for_s);
            self.turned_wrong = wiring.map(|it| (it, for_s));
            // What a wrong wiring explains is not taken in: the next field is held against the right one.
            let believed = field.iter().enumerate().filter(|_| wiring.is_none());
            for (axis, value) in believed {
                self.absorb(&mut tracked, Measured::Field(axis), *value, noise * noise);
            }
        }
        if tracked.is_sound() && self.contradictions < LOST {
            tracked.symmetrise();
            self.tracked = Some(tracked);
        } else {
            *self = Self::default();
        }
    }

    fn absorb(&mut self, tracked: &mut Tracked, what: Measured, value: f32, noise: f32) {
        let (nis, variance) = tracked.absorb(what, value, noise);
        self.contradictions =
            if nis <= GATE * GATE { 0 } else { self.contradictions.saturating_add(1) };
        self.log_likelihood -= 0.5 * (nis.min(GATE * GATE) + libm::logf(variance));
    }

    /// How a magnetometer is wired that was right before, in a satellite that turns slowly.
    pub(super) fn magnetometer_turned_wrong(&self) -> Option<SignedPermutation> {
        self.turned_wrong.filter(|(_, for_s)| *for_s >= TURNED_WRONG_S).map(|(wiring, _)| wiring)
    }

    /// What is estimated beside the wiring.
    pub(super) fn motion(&self) -> Option<Estimate> {
        let sigma = |variances: Vector3<f32>| variances.map(|v| libm::sqrtf(v.max(0.0)));
        self.tracked.as_ref().map(|it| Estimate {
            rate: it.quick.fixed_rows::<3>(0).into_owned(),
            rate_sigma: sigma(it.qq.diagonal().fixed_rows::<3>(0).into_owned()),
            field: it.quick.fixed_rows::<3>(3) * FIELD_UNIT_T,
            dipole: it.slow.fixed_rows::<3>(DIPOLE).into_owned(),
            dipole_sigma: sigma(it.ss.diagonal().fixed_rows::<3>(DIPOLE).into_owned()),
        })
    }

    /// How far the wiring is known by now; `None` before it has started. With `by_work` what would have
    /// done the torquers' work of late all the same does not count as wrong.
    pub(super) fn evidence(&self, by_work: bool) -> Option<ResponseEvidence> {
        let tracked = self.tracked.as_ref()?;
        let wiring = tracked.slow.fixed_rows::<9>(WIRING).into_owned();
        let covariance = tracked.ss.fixed_view::<9, 9>(WIRING, WIRING).into_owned();
        let answers = Answers::new(wiring, covariance)?;
        answers.evidence(self.log_likelihood, by_work.then_some(&self.work))
    }
}

/// Which axis of which sensor.
#[derive(Debug, Clone, Copy)]
enum Measured {
    Gyro(usize),
    Field(usize),
}

impl Tracked {
    fn new(p: &PolarityParameters, gyro: Vector3<f32>, field: Vector3<f32>) -> Self {
        let mut quick = Quick::zeros();
        quick.fixed_rows_mut::<3>(0).copy_from(&gyro);
        quick.fixed_rows_mut::<3>(3).copy_from(&(field / FIELD_UNIT_T));
        let square = |v: f32| v * v;
        let (bias, noise) = (square(p.gyro_bias_rad_s), square(p.gyro_noise_rad_s));
        let mut ss = Slow::zeros();
        for (from, count, variance) in [
            (BIAS, 3, bias),
            (INERTIA, 6, square(p.inertia_prior)),
            (DIPOLE, 3, square(p.dipole_prior_am2)),
            (WIRING, 9, square(WIRING_PRIOR)),
            (FIELD_BIAS, 3, square(p.field_bias_t / FIELD_UNIT_T)),
        ] {
            ss.rows_mut(from, count).fill(variance);
        }
        let mut qq = Quick::zeros();
        qq.fixed_rows_mut::<3>(0).fill(bias + noise);
        let field_bias = square(p.field_bias_t / FIELD_UNIT_T);
        qq.fixed_rows_mut::<3>(3).fill(field_bias + square(p.field_noise_t / FIELD_UNIT_T));
        // Rate and field are what the sensors show less their bias.
        let mut qs = SMatrix::<f32, QUICK, SLOW>::zeros();
        qs.fixed_view_mut::<3, 3>(0, BIAS).fill_diagonal(-bias);
        qs.fixed_view_mut::<3, 3>(3, FIELD_BIAS).fill_diagonal(-field_bias);
        Self {
            quick,
            slow: Slow::zeros(),
            qq: SMatrix::from_diagonal(&qq),
            qs,
            ss: SMatrix::from_diagonal(&ss),
        }
    }

    /// One step: state at its middle for the derivatives, covariance by the transition to second order.
    fn predict(
        &mut self,
        p: &PolarityParameters,
        inertia: &Matrix3<f32>,
        dt_s: f32,
        dipole: Vector3<f32>,
    ) {
        let mean = inertia.trace() / 3.0;
        let tensor = inertia + self.inertia() * mean;
        let Some(inverse) = tensor.try_inverse() else { return };
        let wiring = self.wiring();
        let total = self.slow.fixed_rows::<3>(DIPOLE) + wiring * dipole;
        let slope = |state: &Quick| -> Quick {
            let omega: Vector3<f32> = state.fixed_rows::<3>(0).into_owned();
            let field: Vector3<f32> = state.fixed_rows::<3>(3).into_owned();
            let torque = total.cross(&field) * FIELD_UNIT_T - omega.cross(&(tensor * omega));
            let mut slope = Quick::zeros();
            slope.fixed_rows_mut::<3>(0).copy_from(&(inverse * torque));
            slope.fixed_rows_mut::<3>(3).copy_from(&field.cross(&omega));
            slope
        };
        // Runge–Kutta of fourth order.
        let k1 = slope(&self.quick);
        let k2 = slope(&(self.quick + k1 * (0.5 * dt_s)));
        let k3 = slope(&(self.quick + k2 * (0.5 * dt_s)));
        let k4 = slope(&(self.quick + k3 * dt_s));
        let middle = self.quick + k1 * (0.5 * dt_s);
        self.quick += (k1 + (k2 + k3) * 2.0 + k4) * (dt_s / 6.0);

        let omega: Vector3<f32> = middle.fixed_rows::<3>(0).into_owned();
        let field: Vector3<f32> = middle.fixed_rows::<3>(3).into_owned();
        let acceleration: Vector3<f32> = k2.fixed_rows::<3>(0).into_owned();
        let spin = omega.cross_matrix();
        let mut a = SMatrix::<f32, QUICK, QUICK>::zeros();
        let momentum = tensor * omega;
        a.fixed_view_mut::<3, 3>(0, 0)
            .copy_from(&(inverse * (momentum.cross_matrix() - spin * tensor)));
        a.fixed_view_mut::<3, 3>(0, 3).copy_from(&(inverse * total.cross_matrix() * FIELD_UNIT_T));
        a.fixed_view_mut::<3, 3>(3, 0).copy_from(&field.cross_matrix());
        a.fixed_view_mut::<3, 3>(3, 3).copy_from(&-spin);
        let mut by_slow = SMatrix::<f32, QUICK, SLOW>::zeros();
        let by_dipole = inverse * field.cross_matrix() * -FIELD_UNIT_T;
        by_slow.fixed_view_mut::<3, 3>(0, DIPOLE).copy_from(&by_dipole);
        for (column, m) in dipole.iter().enumerate() {
            by_slow.fixed_view_mut::<3, 3>(0, WIRING + 3 * column).copy_from(&(by_dipole * *m));
        }
        for (column, e) in ENTRIES.iter().enumerate() {
            let e = entry(*e) * mean;
            let torque = e * acceleration + omega.cross(&(e * omega));
            by_slow.fixed_view_mut::<3, 1>(0, INERTIA + column).copy_from(&-(inverse * torque));
        }

        let identity = SMatrix::<f32, QUICK, QUICK>::identity();
        let phi = identity + a * dt_s + a * a * (0.5 * dt_s * dt_s);
        let gamma = (identity * dt_s + a * (0.5 * dt_s * dt_s)) * by_slow;
        let qq = phi * self.qq + gamma * self.qs.transpose();
        let qs = phi * self.qs + gamma * self.ss;
        self.qq = qq * phi.transpose() + qs * gamma.transpose();
        self.qs = qs;
        let walk = |sigma: f32| sigma * sigma * dt_s;
        let mut noise = Quick::zeros();
        noise.fixed_rows_mut::<3>(0).fill(walk(p.rate_walk_rad_s_per_sqrt_s));
        noise.fixed_rows_mut::<3>(3).fill(walk(FIELD_WALK) * field.norm_squared() / 3.0);
        self.qq += SMatrix::from_diagonal(&noise);
        for (from, count, sigma) in [
            (BIAS, 3, BIAS_WALK),
            (DIPOLE, 3, DIPOLE_WALK),
            (WIRING, 9, WIRING_WALK),
            (FIELD_BIAS, 3, FIELD_BIAS_WALK),
        ] {
            for state in from..from + count {
                if let Some(variance) = self.ss.get_mut((state, state)) {
                    *variance += walk(sigma);
                }
            }
        }
    }

    /// Takes in one number; its squared innovation over its variance, and that. Beyond the gate it
    /// changes nothing.
    fn absorb(&mut self, what: Measured, value: f32, noise: f32) -> (f32, f32) {
        let (quick, slow) = match what {
            Measured::Gyro(axis) => (axis, BIAS + axis),
            Measured::Field(axis) => (3 + axis, FIELD_BIAS + axis),
        };
        let mut by_quick = self.qq.column(quick) + self.qs.column(slow);
        let mut by_slow = self.qs.row(quick).transpose() + self.ss.column(slow);
        // h x and h P hᵀ; both indices are there.
        let along = |q: &Quick, s: &Slow| {
            q.get(quick).copied().unwrap_or(0.0) + s.get(slow).copied().unwrap_or(0.0)
        };
        let expected = along(&self.quick, &self.slow);
        let variance = along(&by_quick, &by_slow) + noise;
        let innovation = value - expected;
        let nis = innovation * innovation / variance;
        if !(variance > 0.0 && nis <= GATE * GATE) {
            return (nis, variance);
        }
        self.quick += by_quick * (innovation / variance);
        self.slow += by_slow * (innovation / variance);
        let root = 1.0 / libm::sqrtf(variance);
        by_quick *= root;
        by_slow *= root;
        self.qq.ger(-1.0, &by_quick, &by_quick, 1.0);
        self.qs.ger(-1.0, &by_quick, &by_slow, 1.0);
        self.ss.ger(-1.0, &by_slow, &by_slow, 1.0);
        (nis, variance)
    }

    /// The wrong wiring of the magnetometer that makes of the field that is expected the one that was
    /// measured, `FIELD_UNIT_T`, when that differs.
    fn turned_wrong(&self, field: Vector3<f32>, noise: f32) -> Option<SignedPermutation> {
        let expected = self.quick.fixed_rows::<3>(3) + self.slow.fixed_rows::<3>(FIELD_BIAS);
        let variance = self.qq.fixed_view::<3, 3>(3, 3).trace() / 3.0 + noise * noise;
        let squares =
            |it: SignedPermutation| (field - it.apply(expected)).norm_squared() / variance;
        if squares(SignedPermutation::IDENTITY) <= JUMP * JUMP {
            return None;
        }
        let cost = |it: SignedPermutation| {
            let changes: f32 = it.matrix().diagonal().iter().map(|own| changes(*own)).sum();
            0.5 * squares(it) + EACH_CHANGE * changes
        };
        let best = SignedPermutation::all().min_by(|a, b| cost(*a).total_cmp(&cost(*b)))?;
        (squares(best) <= GATE * GATE).then_some(best)
    }

    fn wiring(&self) -> Matrix3<f32> {
        Matrix3::from_iterator(self.slow.iter().skip(WIRING).copied())
    }

    /// What the tensor has more than was known, in units of the mean moment.
    fn inertia(&self) -> Matrix3<f32> {
        let parameters = self.slow.fixed_rows::<6>(INERTIA);
        parameters.iter().zip(ENTRIES).map(|(p, e)| entry(e) * *p).sum()
    }

    /// Rounding makes a covariance lopsided.
    fn symmetrise(&mut self) {
        self.qq = (self.qq + self.qq.transpose()) * 0.5;
        self.ss = (self.ss + self.ss.transpose()) * 0.5;
    }

    fn is_sound(&self) -> bool {
        let finite = self.quick.iter().chain(self.slow.iter()).all(|it| it.is_finite());
        let positive = |variance: &f32| variance.is_finite() && *variance > 0.0;
        let (quick, slow) = (self.qq.diagonal(), self.ss.diagonal());
        finite && quick.iter().chain(slow.iter()).all(positive)
    }
}

/// Changes of an axis, of which a wiring shows so much on its own.
fn changes(own: f32) -> f32 {
    match own {
        1.0 => 0.0,
        -1.0 => 1.0,
        _ => 2.0,
    }
}

/// The entries of the tensor, in the order of its parameters.
const ENTRIES: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)];

/// The symmetric matrix with ones at an entry and its mirror image.
fn entry((row, column): (usize, usize)) -> Matrix3<f32> {
    Matrix3::from_fn(|r, c| {
        let here = (r, c) == (row, column) || (c, r) == (row, column);
        if here { 1.0 } else { 0.0 }
    })
}
