//! Gyro bias and its slope with temperature, from a field that turns otherwise than the gyros say.
//!
//! | symbol | code | meaning |
//! |---|---|---|
//! | ω + b | `rate` | what the gyros show; b = b₀ + b₁ (T − T₀), the unknowns |
//! | B | | field, Body: read, and turned on by ω between readings |
//! | w | | turn of the field in inertial space, seen from Body, rad/s |
//! | d | | its change besides, seen from Body, T/s |
//! | c | | what calibration left of the magnetometer's bias, T |
//!
//! Seen from Body the field turns by −(ω − w) × B. The bias about the field does not show at once: the
//! field has to turn in the body. And it is not at rest: along a polar orbit w is twice the orbital rate, 0.12 deg/s,
//! about the orbit's normal. In a tumble w goes round in the body while b stays, and the two are told apart;
//! about the axis of a steady spin they are not, and sigma says so.
//!
//! Whoever has an attitude, and be it a coarse one, tells the change: what is left of w and d is the attitude's error.

use nalgebra::{Matrix3, RealField, SMatrix, SVector, Vector3};

use super::field_motion::{FIELD_CHANGE_T_S, FIELD_TURN_RAD_S, MAX_GAP_S, Motion, PRIOR_FIELD_T};
use super::joint::Joint;
use super::{IdentificationError, Noise, PRIOR_BIAS_RAD_S, Recorded, Solution, number};

const STATES: usize = 12;
const FIELD: usize = 0;
const CHANGE: usize = 3;
const TURN: usize = 6;
const OFFSET: usize = 9;

/// Of b₁ at first, rad/s per degree: 0.1 deg/s per degree.
const PRIOR_SLOPE: f64 = 0.00175;
/// Of a coarse attitude, each axis, rad: 3 deg. So much is left of a change that is told.
const ATTITUDE_RAD: f64 = 0.052;

/// Estimate over a record: unknowns b₀, then b₁ when `N` is 6.
#[derive(Debug, Clone, Copy)]
pub struct GyroBias<T: RealField + Copy, const N: usize> {
    noise: Noise<T>,
    reference_c: T,
    last: Option<Last<T>>,
    joint: Joint<T, STATES, N>,
}

#[derive(Debug, Clone, Copy)]
struct Last<T: RealField + Copy> {
    rate: Vector3<T>,
    warmer: T,
    told: bool,
}

impl<T: RealField + Copy> GyroBias<T, 3> {
    /// For a constant bias.
    pub fn constant(noise: Noise<T>) -> Self {
        Self::new(noise, T::zero())
    }
}

impl<T: RealField + Copy> GyroBias<T, 6> {
    /// For the bias at `reference_c`, and its slope (rad/s per degree), the unknowns 3 to 5.
    pub fn with_temperature(noise: Noise<T>, reference_c: T) -> Self {
        Self::new(noise, reference_c)
    }
}

impl<T: RealField + Copy, const N: usize> GyroBias<T, N> {
    fn new(noise: Noise<T>, reference_c: T) -> Self {
        let mut sigma = SVector::<T, N>::repeat(number(PRIOR_SLOPE));
        sigma.fixed_rows_mut::<3>(0).fill(number(PRIOR_BIAS_RAD_S));
        let mut joint = Joint::new(SVector::zeros(), sigma);
        joint.begin(OFFSET, &Vector3::zeros(), noise.field_offset_t);
        Self { noise, reference_c, last: None, joint }
    }

    /// Takes in an instant at this temperature, °C. `change_t` is what the field changed by in inertial space
    /// since the instant before, seen from Body now: A (B_now − B_before) by a model and an attitude of some
    /// degrees; `None` where there is none.
    pub fn add(&mut self, recorded: &Recorded<T>, temperature_c: T, change_t: Option<[T; 3]>) {
        let finite = recorded.is_finite() && temperature_c.is_finite();
        if !finite || recorded.dt_s > number(MAX_GAP_S) {
            self.last = None;
        }
        if !finite {
            return;
        }
        let rate = Vector3::from(recorded.rate_rad_s);
        let warmer = temperature_c - self.reference_c;
        let change = change_t.map(Vector3::from).filter(|it| it.iter().all(T::is_finite));
        let now = Last { rate, warmer, told: change.is_some() };
        let field = recorded.field_t.map(Vector3::from);
        match (self.last, field) {
            (Some(last), field) => {
                self.carry(&last, &now, recorded.dt_s, change);
                if let Some(field) = field {
                    self.read(&field);
                }
                self.last = Some(now);
            }
            (None, Some(field)) => {
                let offset = self.joint.three(OFFSET);
                self.joint.begin(FIELD, &(field - offset), number(PRIOR_FIELD_T));
                self.begin_change(now.told);
                self.read(&field);
                self.last = Some(now);
            }
            (None, None) => {}
        }
    }

    fn begin_change(&mut self, told: bool) {
        self.joint.begin(CHANGE, &Vector3::zeros(), number(left_of(FIELD_CHANGE_T_S, told)));
        self.joint.begin(TURN, &Vector3::zeros(), number(left_of(FIELD_TURN_RAD_S, told)));
    }

    fn carry(&mut self, last: &Last<T>, now: &Last<T>, dt_s: T, told: Option<Vector3<T>>) {
        if last.told != now.told {
            self.begin_change(now.told);
        }
        let half = number::<T>(0.5);
        let warmer = (last.warmer + now.warmer) * half;
        let joint = &mut self.joint;
        let mut unknowns = joint.unknown.iter().copied();
        let mut three = || Vector3::from_fn(|_, _| unknowns.next().unwrap_or(T::zero()));
        let bias = three() + three() * warmer;
        let rate = (last.rate + now.rate) * half - bias;
        let turn = joint.three(TURN);
        let change_sigma = number(left_of(FIELD_CHANGE_T_S, now.told));
        let motion = Motion::new(&(rate - turn), dt_s, change_sigma);
        let (field, change) = motion.carry(&joint.three(FIELD), &joint.three(CHANGE));
        let field = field + told.unwrap_or_else(Vector3::zeros);
        joint.put(FIELD, &field);
        joint.put(CHANGE, &change);
        joint.put(TURN, &(motion.turn * turn));

        let mut of_state = SMatrix::<T, STATES, STATES>::identity();
        let mut put = |row: usize, column: usize, block: Matrix3<T>| {
            of_state.fixed_view_mut::<3, 3>(row, column).copy_from(&block);
        };
        put(FIELD, FIELD, motion.turn);
        put(FIELD, CHANGE, motion.of_change());
        put(FIELD, TURN, -motion.of_rate(&field));
        put(CHANGE, CHANGE, motion.turn * motion.lasting);
        put(TURN, TURN, motion.turn);
        let mut of_unknown = SMatrix::<T, STATES, N>::zeros();
        for first in [FIELD, CHANGE, TURN] {
            let of_bias = -motion.of_rate(&joint.three(first));
            let columns = [of_bias, of_bias * warmer];
            let from = columns.iter().flat_map(Matrix3::column_iter);
            for (mut to, from) in of_unknown.column_iter_mut().zip(from) {
                to.fixed_rows_mut::<3>(first).copy_from(&from);
            }
        }
        let mut noise = SMatrix::<T, STATES, STATES>::zeros();
        let mut put = |at: usize, block: Matrix3<T>| {
            noise.fixed_view_mut::<3, 3>(at, at).copy_from(&block);
        };
        put(FIELD, motion.of_gyro_noise(&field, self.noise.rate_rad_s));
        put(CHANGE, Matrix3::from_diagonal_element(motion.renewed));
        joint.carry(&of_state, &of_unknown, &noise);
    }

    fn read(&mut self, reading: &Vector3<T>) {
        let mut of_state = SMatrix::<T, 3, STATES>::zeros();
        of_state.fixed_columns_mut::<3>(FIELD).fill_with_identity();
        of_state.fixed_columns_mut::<3>(OFFSET).fill_with_identity();
        let variance = self.noise.field_t * self.noise.field_t;
        self.joint.read(&of_state, &SMatrix::zeros(), reading, variance);
    }

    /// b₀, rad/s, and b₁, rad/s per degree. `residual_rms` is of the field's readings, T.
    ///
    /// # Errors
    /// [`IdentificationError`]: what the record does not support.
    pub fn solve(&self) -> Result<Solution<T, N>, IdentificationError> {
        self.joint.solve(self.noise.field_t)
    }
}

/// Sigma of a property of the field's motion.
fn left_of(sigma: f64, told: bool) -> f64 {
    if told { sigma * ATTITUDE_RAD } else { sigma }
}
