//! The field that the torquers make at the magnetometer.
//!
//! reading = B + K m + noise
//!
//! | symbol | code | meaning |
//! |---|---|---|
//! | m | `dipole_am2` | what the torquers carry at the instant of the reading, Body, A·m² |
//! | K | [`TorquerCoupling::matrix`] | T for 1 A·m²; the unknowns, column by column |
//! | B | | the field of the Earth, Body: read at rest, and turned on by the gyros while torquers are on |
//!
//! B as turned on gets worse with the time since the last rest: by the gyros' noise and bias, and by the field's
//! own change along the orbit. Bias and change are estimated along (`field_motion.rs`), so
//! that the gyros need not be calibrated before. A reading late in a pulse counts less by itself, and the next
//! rest says afterwards how far off the turned field was.
//!
//! A pattern of pulses that has three independent dipoles in it is enough; a law that holds one dipole for the
//! whole record is not, and is refused.

use nalgebra::{Matrix3, RealField, SMatrix, SVector, Vector3};

use super::field_motion::{FIELD_CHANGE_T_S, MAX_GAP_S, Motion, PRIOR_FIELD_T};
use super::joint::Joint;
use super::{BIAS_WALK, IdentificationError, Noise, PRIOR_BIAS_RAD_S, Solution, number};

/// Unknowns: K column by column.
pub const COUPLING_UNKNOWNS: usize = 9;
/// States: field, its change, gyro bias, what calibration left of the magnetometer's.
const STATES: usize = 12;
const FIELD: usize = 0;
const CHANGE: usize = 3;
const BIAS: usize = 6;
const OFFSET: usize = 9;

/// Of K at first, T for 1 A·m²: a dipole makes 2·10⁻⁷/r³ on its axis, this at 9 cm.
const PRIOR_T_PER_AM2: f64 = 3e-4;

/// An instant at which the magnetometer was read.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CouplingSample<T> {
    /// Since the instant before, s; zero at the first.
    pub dt_s: T,
    /// By the gyros, Body, rad/s.
    pub rate_rad_s: [T; 3],
    /// As read, whatever the torquers do, Body, T.
    pub field_t: [T; 3],
    /// What the torquers carry while it is read, Body, A·m²; zero at rest.
    pub dipole_am2: [T; 3],
}

/// Estimate over a record of pulses and rests.
#[derive(Debug, Clone, Copy)]
pub struct TorquerCoupling<T: RealField + Copy> {
    noise: Noise<T>,
    joint: Joint<T, STATES, COUPLING_UNKNOWNS>,
    last_rate: Option<Vector3<T>>,
}

impl<T: RealField + Copy> Default for TorquerCoupling<T> {
    fn default() -> Self {
        Self::new(Noise::default())
    }
}

impl<T: RealField + Copy> TorquerCoupling<T> {
    /// For sensors with this noise.
    pub fn new(noise: Noise<T>) -> Self {
        let prior = SVector::from_element(number(PRIOR_T_PER_AM2));
        let mut joint = Joint::new(SVector::zeros(), prior);
        joint.begin(BIAS, &Vector3::zeros(), number(PRIOR_BIAS_RAD_S));
        joint.begin(OFFSET, &Vector3::zeros(), noise.field_offset_t);
        Self { noise, joint, last_rate: None }
    }

    /// Takes in an instant. Begins at the first rest, and again after an interruption.
    pub fn add(&mut self, sample: &CouplingSample<T>) {
        let values = sample.rate_rad_s.iter().chain(&sample.field_t).chain(&sample.dipole_am2);
        let finite = values.chain([&sample.dt_s]).all(nalgebra::ComplexField::is_finite);
        if !finite || sample.dt_s < T::zero() {
            self.last_rate = None;
            return;
        }
        let rate = Vector3::from(sample.rate_rad_s);
        let dipole = Vector3::from(sample.dipole_am2);
        match self.last_rate {
            Some(last) if sample.dt_s <= number(MAX_GAP_S) => {
                self.carry((last + rate) * number::<T>(0.5), sample.dt_s);
                self.read(&Vector3::from(sample.field_t), &dipole);
                self.last_rate = Some(rate);
            }
            _ => {
                let rests = dipole == Vector3::zeros();
                self.last_rate = rests.then_some(rate);
                if rests {
                    let field = Vector3::from(sample.field_t);
                    let joint = &mut self.joint;
                    joint.begin(FIELD, &(field - joint.three(OFFSET)), number(PRIOR_FIELD_T));
                    joint.begin(CHANGE, &Vector3::zeros(), number(FIELD_CHANGE_T_S));
                    self.read(&field, &dipole);
                }
            }
        }
    }

    fn carry(&mut self, rate: Vector3<T>, dt_s: T) {
        let joint = &mut self.joint;
        let motion = Motion::new(&(rate - joint.three(BIAS)), dt_s, number(FIELD_CHANGE_T_S));
        let (field, change) = motion.carry(&joint.three(FIELD), &joint.three(CHANGE));
        joint.put(FIELD, &field);
        joint.put(CHANGE, &change);

        let mut of_state = SMatrix::<T, STATES, STATES>::identity();
        let mut put = |row: usize, column: usize, block: Matrix3<T>| {
            of_state.fixed_view_mut::<3, 3>(row, column).copy_from(&block);
        };
        put(FIELD, FIELD, motion.turn);
        put(FIELD, CHANGE, motion.of_change());
        put(FIELD, BIAS, -motion.of_rate(&field));
        put(CHANGE, CHANGE, motion.turn * motion.lasting);
        put(CHANGE, BIAS, -motion.of_rate(&change));
        let mut noise = SMatrix::<T, STATES, STATES>::zeros();
        let mut put = |at: usize, block: Matrix3<T>| {
            noise.fixed_view_mut::<3, 3>(at, at).copy_from(&block);
        };
        put(FIELD, motion.of_gyro_noise(&field, self.noise.rate_rad_s));
        put(CHANGE, Matrix3::from_diagonal_element(motion.renewed));
        put(BIAS, Matrix3::from_diagonal_element(number::<T>(BIAS_WALK * BIAS_WALK) * dt_s));
        joint.carry(&of_state, &SMatrix::zeros(), &noise);
    }

    fn read(&mut self, reading: &Vector3<T>, dipole: &Vector3<T>) {
        let mut of_state = SMatrix::<T, 3, STATES>::zeros();
        of_state.fixed_columns_mut::<3>(FIELD).fill_with_identity();
        of_state.fixed_columns_mut::<3>(OFFSET).fill_with_identity();
        // K m, column by column.
        let of_unknown = dipole.transpose().kronecker(&Matrix3::identity());
        let variance = self.noise.field_t * self.noise.field_t;
        self.joint.read(&of_state, &of_unknown, reading, variance);
    }

    /// K, column by column, T for 1 A·m².
    ///
    /// # Errors
    /// [`IdentificationError`]: what the record does not support.
    pub fn solve(&self) -> Result<Solution<T, COUPLING_UNKNOWNS>, IdentificationError> {
        self.joint.solve(self.noise.field_t)
    }

    /// K, row by row, of a solution or of its sigma: row i has what each axis of the dipole adds to axis i.
    pub fn matrix(values: &SVector<T, COUPLING_UNKNOWNS>) -> [[T; 3]; 3] {
        // An array of arrays is filled column by column: rows of the transpose.
        Matrix3::from_iterator(values.iter().copied()).transpose().into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of K, T for 1 A·m²: 586 nT in 0.4 A·m², over 60 s.
    const NEAR_T_PER_AM2: f64 = 1e-6;
    const COUPLING: [[f64; 3]; 3] = [[2e-5, -1e-5, 0.0], [5e-6, 3e-5, 1e-5], [0.0, -2e-5, 4e-5]];

    /// A body at rest in a field at rest, whose torquers follow `dipole`.
    fn record(fit: &mut TorquerCoupling<f64>, dipole: impl Fn(u32) -> [f64; 3]) {
        for step in 0..120 {
            let dipole = dipole(step);
            let made = Matrix3::from(COUPLING).transpose() * Vector3::from(dipole);
            fit.add(&CouplingSample {
                dt_s: 0.5,
                rate_rad_s: [0.0; 3],
                field_t: (Vector3::new(1e-5, 2e-5, 3e-5) + made).into(),
                dipole_am2: dipole,
            });
        }
    }

    #[test]
    fn nine_numbers_are_found_from_pulses_about_three_axes() {
        let mut fit = TorquerCoupling::default();
        record(&mut fit, |step| [1, 2, 3].map(|axis| if step / 5 % 4 == axis { 0.4 } else { 0.0 }));
        let solution = fit.solve().unwrap();
        let found = Matrix3::from(TorquerCoupling::matrix(&solution.x));
        assert!((found - Matrix3::from(COUPLING)).amax() < NEAR_T_PER_AM2, "{found}");
    }

    #[test]
    fn one_dipole_does_not_tell_nine_numbers() {
        let mut fit = TorquerCoupling::default();
        assert_eq!(fit.solve(), Err(IdentificationError::TooFew { found: 0, needed: 27 }));
        record(&mut fit, |step| if step < 5 { [0.0; 3] } else { [0.4, 0.0, 0.0] });
        let error = fit.solve().unwrap_err();
        assert!(matches!(error, IdentificationError::NotLearnt { weakest: 3.., .. }), "{error}");
    }

    #[test]
    fn what_is_read_before_the_first_rest_is_left_out() {
        let mut fit = TorquerCoupling::default();
        record(&mut fit, |_| [0.4, 0.3, 0.2]);
        assert_eq!(fit.solve(), Err(IdentificationError::TooFew { found: 0, needed: 27 }));
    }
}
