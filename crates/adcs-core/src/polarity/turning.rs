//! Does the field turn in Body as the gyro says it should?
//!
//! From one rest to the next the field of before, turned by the gyro, must be the field of now. That is
//! tried with each of the 48 ways in which the gyro may be wired:
//!
//! B⁺ = R_G B,  Ṙ = −[ω×] R,  ω = G⁻¹ ω_gyro
//!
//! | symbol | code | meaning |
//! |---|---|---|
//! | B, B⁺ | `field` | field of this rest and of the next, Body, T |
//! | G | `wiring` | the gyro shows G ω |
//! | R₊, R₋ | `turn` | the turn with ω_gyro, and with −ω_gyro |
//! | Θ | `lever` | ∫ R dt: what a constant rate error adds to the turn, s |
//!
//! Two integrations serve all 48: R_G = G⁻¹ R₊ G for a rotation, and with R₋ for what mirrors. The gyro's
//! bias is a nuisance, estimated beside each wiring by least squares: r = B⁺ − R_G B = −[B⁺×] Θ_G b.
//!
//! **What it does not see.** A magnetometer wired as P shows a field that turns with P R P⁻¹: like a gyro
//! wired as G = (det P · P)⁻¹. So a rotation G is the gyro's or the magnetometer's, only what mirrors is
//! the gyro's alone; and a magnetometer reversed as a whole looks right.

use nalgebra::{Matrix3, UnitQuaternion, Vector3};

use super::parameters::PolarityParameters;
use crate::frames::SignedPermutation;

/// Between two fields the satellite may turn for this long, s: twice the longest round of the paper.
const LONGEST_S: f32 = 30.0;
/// Shorter ones tell nothing, s.
const SHORTEST_S: f32 = 1.0;
/// What the field turns in Eci along the orbit, twice the rate of a low orbit, rad/s.
pub(super) const FIELD_TURN_RAD_S: f32 = 2.2e-3;
/// A field that no wiring explains within this many σ is none.
const EXPLAINED: f32 = 8.0;
/// Over how long fields are remembered, s: some rounds decide in a tumble, and what turns wrong later must
/// not be outvoted by the days before.
const MEMORY_S: f32 = 1000.0;
/// Odds worse than this need not be told apart, natural logarithm.
const LEAST: f32 = -1e6;
/// Wirings tried.
const COUNT: usize = SignedPermutation::COUNT as usize;

/// What speaks for one wiring: the normal equations of the bias, and the squares that are left.
#[derive(Debug, Clone, Copy)]
struct Trial {
    normal: Matrix3<f32>,
    right: Vector3<f32>,
    squares: f32,
}

/// The turn since the last field.
#[derive(Debug, Clone, Copy)]
struct Turn {
    field: Vector3<f32>,
    elapsed_s: f32,
    /// Of the samples of the gyro, each of which stands for the time since the one before, s².
    sampled_s2: f32,
    forward: UnitQuaternion<f32>,
    backward: UnitQuaternion<f32>,
    lever_forward: Matrix3<f32>,
    lever_backward: Matrix3<f32>,
}

/// What speaks for each wiring of the gyro. `Default` is power-on.
#[derive(Debug, Clone, Copy)]
pub struct Turning {
    turn: Option<Turn>,
    /// The last gyro sample, rad/s, and how long ago, s.
    rate: Option<(Vector3<f32>, f32)>,
    trials: [Trial; COUNT],
    fields: u16,
}

/// How far the wirings are known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TurningEvidence {
    /// The wiring that explains the fields best.
    pub best: SignedPermutation,
    /// Natural logarithm of its odds against the second best.
    pub lead: f32,
    /// Natural logarithm of the odds of all wrong wirings together against the right one.
    pub wrong: f32,
    /// From how many pairs of fields.
    pub fields: u16,
}

impl Default for Turning {
    fn default() -> Self {
        let trial = Trial { normal: Matrix3::zeros(), right: Vector3::zeros(), squares: 0.0 };
        Self { turn: None, rate: None, trials: [trial; COUNT], fields: 0 }
    }
}

impl Turning {
    /// Takes in one cycle, `dt_s` after the last: the gyro and the field at rest, each if it was measured,
    /// and whether the field is the last of its rest. What turned more slowly than `slowest_rad_s` in the
    /// mean is passed over. Returns whether a pair of fields was compared.
    pub(super) fn cycle(
        &mut self,
        parameters: &PolarityParameters,
        dt_s: f32,
        gyro: Option<Vector3<f32>>,
        field: Option<Vector3<f32>>,
        last_of_rest: bool,
        slowest_rad_s: f32,
    ) -> bool {
        self.carry(dt_s, gyro);
        if !last_of_rest {
            return false;
        }
        // Without the gyro's word at this instant the turn ends before it.
        let spoke = self.rate.is_some_and(|(_, age_s)| age_s == 0.0);
        let field = field.filter(|_| spoke);
        let pair = self.turn.filter(|turn| turn.tells(slowest_rad_s)).zip(field);
        let compared = pair.is_some_and(|(turn, field)| self.compare(parameters, &turn, field));
        self.turn = field.map(Turn::new);
        compared
    }

    /// Turns on to the gyro's newest sample; a satellite that has turned too long unseen is lost.
    fn carry(&mut self, dt_s: f32, gyro: Option<Vector3<f32>>) {
        if !(0.0..=LONGEST_S).contains(&dt_s) {
            (self.turn, self.rate) = (None, None);
        }
        if let Some((_, age_s)) = &mut self.rate {
            *age_s += dt_s;
        }
        let Some(rate) = gyro else { return };
        if let (Some((before, age_s)), Some(turn)) = (self.rate, &mut self.turn) {
            turn.advance((before + rate) * 0.5, age_s);
        }
        self.turn = self.turn.filter(|turn| turn.elapsed_s <= LONGEST_S);
        self.rate = Some((rate, 0.0));
    }

    fn compare(&mut self, p: &PolarityParameters, turn: &Turn, field: Vector3<f32>) -> bool {
        let strength = turn.field.norm();
        // Both fields' noise, the orbit's turn, and the gyro's noise over the time.
        let orbit = FIELD_TURN_RAD_S * turn.elapsed_s * strength;
        let gyro = p.gyro_noise_rad_s * libm::sqrtf(turn.sampled_s2) * strength;
        let variance = 2.0 * p.field_noise_t * p.field_noise_t + orbit * orbit + gyro * gyro;
        let bias = p.gyro_bias_rad_s * turn.elapsed_s * strength;
        let explained = EXPLAINED * EXPLAINED * (variance + bias * bias);

        let residual = |wiring| turn.seen_with(wiring, field);
        let least = SignedPermutation::all()
            .map(|wiring| residual(wiring).0.norm_squared())
            .fold(f32::INFINITY, f32::min);
        if !(least <= explained && variance > 0.0) {
            return false;
        }
        let kept = MEMORY_S / (MEMORY_S + turn.elapsed_s);
        for (trial, wiring) in self.trials.iter_mut().zip(SignedPermutation::all()) {
            let (residual, lever) = residual(wiring);
            let h = -field.cross_matrix() * lever;
            let weighted = h.transpose() / variance;
            trial.normal = trial.normal * kept + weighted * h;
            trial.right = trial.right * kept + weighted * residual;
            trial.squares = trial.squares * kept + residual.norm_squared() / variance;
        }
        self.fields = self.fields.saturating_add(1);
        true
    }

    /// How far the wirings are known by now.
    pub(super) fn evidence(&self, p: &PolarityParameters) -> TurningEvidence {
        let prior = 1.0 / (p.gyro_bias_rad_s * p.gyro_bias_rad_s);
        let cost = |trial: &Trial| {
            let normal = trial.normal + Matrix3::from_diagonal_element(prior);
            let explained =
                normal.cholesky().map_or(0.0, |it| trial.right.dot(&it.solve(&trial.right)));
            0.5 * (trial.squares - explained)
        };
        let (mut best, mut least, mut second) =
            (SignedPermutation::IDENTITY, f32::INFINITY, f32::INFINITY);
        let (mut right, mut wrong) = (0.0, LogSum::default());
        for (trial, wiring) in self.trials.iter().zip(SignedPermutation::all()) {
            let cost = cost(trial);
            if wiring == SignedPermutation::IDENTITY {
                right = cost;
            } else {
                wrong.add(-cost);
            }
            if cost < least {
                (best, least, second) = (wiring, cost, least);
            } else if cost < second {
                second = cost;
            }
        }
        let wrong = wrong.mean_over(COUNT as f32 - 1.0) + right;
        TurningEvidence { best, lead: second - least, wrong, fields: self.fields }
    }
}

impl Turn {
    fn new(field: Vector3<f32>) -> Self {
        Self {
            field,
            elapsed_s: 0.0,
            sampled_s2: 0.0,
            forward: UnitQuaternion::identity(),
            backward: UnitQuaternion::identity(),
            lever_forward: Matrix3::zeros(),
            lever_backward: Matrix3::zeros(),
        }
    }

    /// Whether wirings can be told apart by it.
    fn tells(&self, slowest_rad_s: f32) -> bool {
        let turned = self.forward.angle() >= slowest_rad_s * self.elapsed_s;
        self.elapsed_s >= SHORTEST_S && turned
    }

    /// Turns on with a mean rate over `dt_s`.
    fn advance(&mut self, rate: Vector3<f32>, dt_s: f32) {
        self.elapsed_s += dt_s;
        self.sampled_s2 += dt_s * dt_s;
        for (turn, lever, sign) in [
            (&mut self.forward, &mut self.lever_forward, -dt_s),
            (&mut self.backward, &mut self.lever_backward, dt_s),
        ] {
            let step = UnitQuaternion::from_scaled_axis(rate * sign);
            *turn = step * *turn;
            // Θ⁺ = R_step Θ + Δt at the middle of the step, to first order in its turn.
            *lever = step.to_rotation_matrix() * (*lever + Matrix3::from_diagonal_element(dt_s));
        }
    }

    /// What is left of `field` with this wiring, and Θ_G.
    fn seen_with(
        &self,
        wiring: SignedPermutation,
        field: Vector3<f32>,
    ) -> (Vector3<f32>, Matrix3<f32>) {
        let (turn, lever) = if wiring.is_rotation() {
            (&self.forward, &self.lever_forward)
        } else {
            (&self.backward, &self.lever_backward)
        };
        // −1 commutes with everything: G and −G conjugate alike.
        let g = wiring.matrix();
        let turned = g.transpose() * (turn * (g * self.field));
        (field - turned, g.transpose() * lever * g)
    }
}

/// log Σ exp, without overflow.
#[derive(Debug, Clone, Copy)]
pub(super) struct LogSum {
    largest: f32,
    sum: f32,
}

impl Default for LogSum {
    fn default() -> Self {
        Self { largest: f32::NEG_INFINITY, sum: 0.0 }
    }
}

impl LogSum {
    pub(super) fn add(&mut self, logarithm: f32) {
        if logarithm > self.largest {
            let kept = if self.sum > 0.0 { libm::expf(self.largest - logarithm) } else { 0.0 };
            self.sum = self.sum * kept + 1.0;
            self.largest = logarithm;
        } else {
            self.sum += libm::expf(logarithm - self.largest);
        }
    }

    /// The logarithm of the mean over `count`, those that were not added counting as impossible; [`LEAST`]
    /// at least.
    pub(super) fn mean_over(&self, count: f32) -> f32 {
        if self.sum > 0.0 {
            (self.largest + libm::logf(self.sum / count)).max(LEAST)
        } else {
            LEAST
        }
    }
}
