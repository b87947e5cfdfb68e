//! Residual dipole, inertia ratios and torquer gains from how a tumble goes on.
//!
//! J ω̇ = (G m + M) × B − ω × J ω
//!
//! | symbol | code | meaning |
//! |---|---|---|
//! | ω, B | `RATE`, `FIELD` | rate and field, Body |
//! | w, d | `TURN`, `CHANGE` | turn of the field in inertial space, its change besides; seen from Body |
//! | b, c | `BIAS`, `OFFSET` | gyro bias; what calibration left of the magnetometer's, Body |
//! | J | `inertia` | tensor, Body; as told, or with five unknowns that leave its trace alone |
//! | M | [`MomentumFit::dipole`] | residual dipole, A·m² |
//! | G | [`MomentumFit::gains`] | what the torquers make of a commanded dipole: one, when they do as they are told |
//!
//! It is eq. (2) of the paper, followed through time: no difference of readings is taken, and no product of them. ω
//! and B are states, so that the gyros' noise enters where they are read and not again through ω × J ω, where
//! neighbours would share it. The sensors' biases are estimated along: what is told of them only shortens the way.
//!
//! What acts besides (gravity gradient, drag) is allowed for as a random torque. Modelling the gravity gradient
//! would need an attitude, which a satellite does not have while it tumbles before it knows itself, and drag
//! would remain; the allowance covers both, and costs nothing where they are weaker than gyro noise.
//!
//! Only products of J, M and G with each other show: M and G are in proportion to the trace of J as it is told.
//!
//! Source of the equation: Euler's; of the estimate: `joint.rs`.

use nalgebra::{ComplexField, Matrix3, RealField, SMatrix, SVector, Vector3};

use super::field_motion::{FIELD_CHANGE_T_S, FIELD_TURN_RAD_S, MAX_GAP_S, Motion, PRIOR_FIELD_T};
use super::joint::Joint;
use super::{
    BIAS_WALK, IdentificationError, Inertia, Noise, PRIOR_BIAS_RAD_S, Recorded, Solution, number,
    of_unit_dipoles, shown,
};

/// Unknowns of [`MomentumFit::ratios`]: M, then the tensor's xx − zz, yy − zz parts and its products.
pub const RATIO_UNKNOWNS: usize = 8;
/// Unknowns of [`MomentumFit::gains`]: M, then G column by column.
pub const GAIN_UNKNOWNS: usize = 12;
/// Unknowns of [`MomentumFit::ratios_and_gains`]: M, the tensor's, then G column by column.
pub const ALL_UNKNOWNS: usize = 17;

const STATES: usize = 18;
const RATE: usize = 0;
const FIELD: usize = 3;
const CHANGE: usize = 6;
const BIAS: usize = 9;
const OFFSET: usize = 12;
const TURN: usize = 15;

/// Of a rate at first, before the gyros are read, rad/s.
const PRIOR_RATE_RAD_S: f64 = 0.05;
/// Of M at first, A·m²: three times the paper's.
const PRIOR_DIPOLE_AM2: f64 = 1.0;
/// Of the tensor's unknowns at first, in mean moments.
const PRIOR_TENSOR: f64 = 0.2;
/// Of a gain at first: a torquer that works backwards is two sigma off.
const PRIOR_GAIN: f64 = 1.0;
/// Of what acts besides, each axis, in the mean square, N·m: SPROUT's gravity gradient, 1.5·10⁻⁸ at most, and drag,
/// 10⁻⁸ at most.
const DISTURBANCE_N_M: f64 = 1e-8;
/// It turns with the orbit: after half of 1/n it is another.
const DISTURBANCE_LASTS_S: f64 = 500.0;
/// At first the products of what is unknown (bias and rate, rate and tensor) are as large as what is learnt, and a
/// filter that leaves them out believes itself too much. So at these times, s, sigma is made larger by these
/// factors: what was learnt until then is where it starts from, and counts for little. Measured: with 150 s alone the
/// moments of long records are too sure by a third.
const SETTLING: [(f64, f64); 2] = [(SETTLED_S, 8.0), (300.0, 1.5)];
const SETTLED_S: f64 = 150.0;
/// A body turns by no more than this in a step of the integration, rad: its midpoint rule errs by 1/24 of
/// the square.
const MAX_TURN_RAD: f64 = 0.2;
const MAX_STEPS: u32 = 64;

/// What is unknown beside M.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Beside {
    tensor: bool,
    gains: bool,
}

/// Estimate over a record.
#[derive(Debug, Clone, Copy)]
pub struct MomentumFit<T: RealField + Copy, const N: usize> {
    told: Inertia<T>,
    beside: Beside,
    noise: Noise<T>,
    disturbance_n_m: T,
    running: bool,
    /// So far, s.
    lasted_s: T,
    joint: Joint<T, STATES, N>,
}

impl<T: RealField + Copy> MomentumFit<T, 3> {
    /// For M alone.
    ///
    /// # Errors
    /// [`IdentificationError::Inertia`].
    pub fn dipole(
        inertia_kg_m2: [[T; 3]; 3],
        noise: Noise<T>,
    ) -> Result<Self, IdentificationError> {
        Self::new(inertia_kg_m2, noise, Beside { tensor: false, gains: false })
    }
}

impl<T: RealField + Copy> MomentumFit<T, RATIO_UNKNOWNS> {
    /// For M and the ratios of the tensor, its trace being as told: the unknowns 3 to 7 are what is to be
    /// added to xx, to yy (and subtracted from zz), to xy, xz and yz, kg·m².
    ///
    /// # Errors
    /// [`IdentificationError::Inertia`].
    pub fn ratios(
        inertia_kg_m2: [[T; 3]; 3],
        noise: Noise<T>,
    ) -> Result<Self, IdentificationError> {
        Self::new(inertia_kg_m2, noise, Beside { tensor: true, gains: false })
    }
}

impl<T: RealField + Copy> MomentumFit<T, GAIN_UNKNOWNS> {
    /// For M and G: the unknowns 3 to 11 are G's columns.
    ///
    /// # Errors
    /// [`IdentificationError::Inertia`].
    pub fn gains(inertia_kg_m2: [[T; 3]; 3], noise: Noise<T>) -> Result<Self, IdentificationError> {
        Self::new(inertia_kg_m2, noise, Beside { tensor: false, gains: true })
    }
}

impl<T: RealField + Copy> MomentumFit<T, ALL_UNKNOWNS> {
    /// For all of them: the unknowns 3 to 7 are the tensor's as of [`MomentumFit::ratios`], 8 to 16 G's columns.
    /// A tensor that is off does not spoil the gains so, nor a weak torquer the tensor.
    ///
    /// # Errors
    /// [`IdentificationError::Inertia`].
    pub fn ratios_and_gains(
        inertia_kg_m2: [[T; 3]; 3],
        noise: Noise<T>,
    ) -> Result<Self, IdentificationError> {
        Self::new(inertia_kg_m2, noise, Beside { tensor: true, gains: true })
    }
}

/// Changes of a tensor that leave its trace alone.
fn tensor_changes<T: RealField + Copy>() -> [Matrix3<T>; 5] {
    let (o, i) = (T::zero(), T::one());
    [
        Matrix3::new(i, o, o, o, o, o, o, o, -i),
        Matrix3::new(o, o, o, o, i, o, o, o, -i),
        Matrix3::new(o, i, o, i, o, o, o, o, o),
        Matrix3::new(o, o, i, o, o, o, i, o, o),
        Matrix3::new(o, o, o, o, o, i, o, i, o),
    ]
}

/// What the unknowns stand for.
#[derive(Debug, Clone, Copy)]
struct Properties<T: RealField + Copy> {
    dipole: Vector3<T>,
    tensor: Matrix3<T>,
    gains: Matrix3<T>,
}

impl<T: RealField + Copy, const N: usize> MomentumFit<T, N> {
    fn new(
        inertia_kg_m2: [[T; 3]; 3],
        noise: Noise<T>,
        beside: Beside,
    ) -> Result<Self, IdentificationError> {
        let told = Inertia::new(inertia_kg_m2)?;
        let moment = told.tensor.trace() / number(3.0);
        let of_tensor = [(T::zero(), moment * number(PRIOR_TENSOR)); 5];
        let of_gains = [1, 0, 0, 0, 1, 0, 0, 0, 1].map(|one| number(f64::from(one)));
        let mut unknown = SVector::<T, N>::zeros();
        let mut sigma = SVector::<T, N>::repeat(number(PRIOR_DIPOLE_AM2));
        let priors = of_tensor.into_iter().filter(|_| beside.tensor).chain(
            of_gains.map(|gain| (gain, number(PRIOR_GAIN))).into_iter().filter(|_| beside.gains),
        );
        let to = unknown.iter_mut().zip(sigma.iter_mut()).skip(3);
        for ((unknown, sigma), prior) in to.zip(priors) {
            (*unknown, *sigma) = prior;
        }
        let mut joint = Joint::new(unknown, sigma);
        joint.begin(BIAS, &Vector3::zeros(), number(PRIOR_BIAS_RAD_S));
        joint.begin(OFFSET, &Vector3::zeros(), noise.field_offset_t);
        let disturbance_n_m = number(DISTURBANCE_N_M);
        Ok(Self {
            told,
            beside,
            noise,
            disturbance_n_m,
            running: false,
            lasted_s: T::zero(),
            joint,
        })
    }

    /// With what is known of the gyro bias, rad/s, and its standard deviation: 1 deg/s about none when it is not
    /// told.
    pub fn with_gyro_bias(mut self, bias_rad_s: [T; 3], sigma_rad_s: T) -> Self {
        let usable = bias_rad_s.iter().chain([&sigma_rad_s]).all(ComplexField::is_finite);
        if usable {
            self.joint.begin(BIAS, &bias_rad_s.into(), sigma_rad_s);
        }
        self
    }

    /// With so much acting besides, N·m, the mean square of an axis: 6·10⁻⁹ when it is not told.
    pub fn with_disturbance(mut self, sigma_n_m: T) -> Self {
        if sigma_n_m.is_finite() {
            self.disturbance_n_m = sigma_n_m;
        }
        self
    }

    /// Takes in an instant. Begins with the first field, and again after an interruption.
    pub fn add(&mut self, recorded: &Recorded<T>) {
        let continues = recorded.is_finite() && recorded.dt_s <= number(MAX_GAP_S);
        self.running &= continues;
        if !recorded.is_finite() {
            return;
        }
        let rate = Vector3::from(recorded.rate_rad_s);
        let field = recorded.field_t.map(Vector3::from);
        if self.running {
            self.carry(recorded.dt_s, &recorded.dipole_am2.into());
        } else if let Some(field) = field {
            let joint = &mut self.joint;
            joint.begin(RATE, &(rate - joint.three(BIAS)), number(PRIOR_RATE_RAD_S));
            joint.begin(FIELD, &(field - joint.three(OFFSET)), number(PRIOR_FIELD_T));
            joint.begin(CHANGE, &Vector3::zeros(), number(FIELD_CHANGE_T_S));
            joint.begin(TURN, &Vector3::zeros(), number(FIELD_TURN_RAD_S));
            self.running = true;
        }
        if self.running {
            self.read(&[RATE, BIAS], &rate, self.noise.rate_rad_s);
            if let Some(field) = field {
                self.read(&[FIELD, OFFSET], &field, self.noise.field_t);
            }
        }
    }

    /// Reads the sum of these states.
    fn read(&mut self, firsts: &[usize], reading: &Vector3<T>, sigma: T) {
        let mut of_state = SMatrix::<T, 3, STATES>::zeros();
        for first in firsts {
            of_state.fixed_columns_mut::<3>(*first).fill_with_identity();
        }
        self.joint.read(&of_state, &SMatrix::zeros(), reading, sigma * sigma);
    }

    fn carry(&mut self, dt_s: T, commanded: &Vector3<T>) {
        let mut steps = T::one();
        let mut count = 1;
        let turn = self.joint.three(RATE).norm() * dt_s;
        while turn > steps * number(MAX_TURN_RAD) && count < MAX_STEPS {
            count += 1;
            steps += T::one();
        }
        for _ in 0..count {
            self.step(dt_s / steps, commanded);
        }
        let before = self.lasted_s;
        self.lasted_s += dt_s;
        for (at, factor) in SETTLING {
            let at = number(at);
            if before < at && self.lasted_s >= at {
                self.joint.forget(number(factor));
            }
        }
    }

    /// The tensor that a solution means, row by row.
    pub fn tensor(&self, solution: &Solution<T, N>) -> [[T; 3]; 3] {
        self.properties(&solution.x).tensor.into()
    }

    fn properties(&self, unknown: &SVector<T, N>) -> Properties<T> {
        let mut values = unknown.iter().copied();
        let mut take = || values.next().unwrap_or(T::zero());
        let dipole = Vector3::from_fn(|_, _| take());
        let mut tensor = self.told.tensor;
        if self.beside.tensor {
            for change in tensor_changes::<T>() {
                tensor += change * take();
            }
        }
        let mut gains = Matrix3::identity();
        if self.beside.gains {
            gains.iter_mut().for_each(|gain| *gain = take());
        }
        Properties { dipole, tensor, gains }
    }

    /// Midpoint rule.
    fn step(&mut self, dt: T, commanded: &Vector3<T>) {
        let Properties { dipole, tensor, gains } = self.properties(&self.joint.unknown);
        // Far from the truth at first, it may not be one.
        let inverse = tensor.try_inverse().unwrap_or(self.told.inverse);
        let driven = dipole + gains * commanded;
        let acceleration = |rate: &Vector3<T>, field: &Vector3<T>| {
            inverse * (driven.cross(field) - rate.cross(&(tensor * rate)))
        };
        let half = dt * number(0.5);
        let joint = &mut self.joint;
        let [rate, field, change] = [RATE, FIELD, CHANGE].map(|first| joint.three(first));
        let mid_rate = rate + acceleration(&rate, &field) * half;
        let turn = joint.three(TURN);
        let motion = Motion::new(&(mid_rate - turn), dt, number(FIELD_CHANGE_T_S));
        let mid_field = motion.half_turn * (field + change * half);
        let slope = acceleration(&mid_rate, &mid_field);
        let (field, change) = motion.carry(&field, &change);
        joint.put(RATE, &(rate + slope * dt));
        joint.put(FIELD, &field);
        joint.put(CHANGE, &change);
        joint.put(TURN, &(motion.turn * turn));

        // ∂ω̇/∂ω = J⁻¹ ((J ω)× − ω× J)
        let spin = mid_rate.cross_matrix();
        let stiffness = inverse * ((tensor * mid_rate).cross_matrix() - spin * tensor) * dt;
        let mut of_state = SMatrix::<T, STATES, STATES>::identity();
        let mut put = |row: usize, column: usize, block: Matrix3<T>| {
            of_state.fixed_view_mut::<3, 3>(row, column).copy_from(&block);
        };
        put(RATE, RATE, Matrix3::identity() + stiffness + stiffness * stiffness * number::<T>(0.5));
        put(RATE, FIELD, inverse * driven.cross_matrix() * motion.half_turn * dt);
        put(FIELD, RATE, motion.of_rate(&field));
        put(FIELD, FIELD, motion.turn);
        put(FIELD, CHANGE, motion.of_change());
        put(FIELD, TURN, -motion.of_rate(&field));
        put(CHANGE, RATE, motion.of_rate(&change));
        put(CHANGE, CHANGE, motion.turn * motion.lasting);
        put(TURN, RATE, motion.of_rate(&joint.three(TURN)));
        put(TURN, TURN, motion.turn);

        let of_dipole = inverse * of_unit_dipoles(&mid_field) * dt;
        let of_unknown = self.of_unknowns(&inverse, &mid_rate, &slope, &of_dipole, commanded, dt);

        let mut noise = SMatrix::<T, STATES, STATES>::zeros();
        let mut put = |at: usize, block: Matrix3<T>| {
            noise.fixed_view_mut::<3, 3>(at, at).copy_from(&block);
        };
        // White noise of the power that a torque of such a duration has at low frequencies.
        let power = self.disturbance_n_m * self.disturbance_n_m * number(2.0 * DISTURBANCE_LASTS_S);
        put(RATE, inverse * inverse.transpose() * (power * dt));
        put(CHANGE, Matrix3::from_diagonal_element(motion.renewed));
        put(BIAS, Matrix3::from_diagonal_element(number::<T>(BIAS_WALK * BIAS_WALK) * dt));
        self.joint.carry(&of_state, &of_unknown, &noise);
    }

    /// ∂ω⁺/∂p.
    fn of_unknowns(
        &self,
        inverse: &Matrix3<T>,
        rate: &Vector3<T>,
        slope: &Vector3<T>,
        of_dipole: &Matrix3<T>,
        commanded: &Vector3<T>,
        dt: T,
    ) -> SMatrix<T, STATES, N> {
        // −J⁻¹ (δJ ω̇ + ω × δJ ω)
        let of_tensor = tensor_changes::<T>()
            .map(|change| inverse * (change * slope + rate.cross(&(change * rate))) * -dt);
        let of_gains = commanded.iter().flat_map(|commanded| {
            [0, 1, 2].map(|axis| Vector3::from(of_dipole.column(axis)) * *commanded)
        });
        let columns = [0, 1, 2].map(|axis| Vector3::from(of_dipole.column(axis)));
        let columns = columns
            .into_iter()
            .chain(of_tensor.into_iter().filter(|_| self.beside.tensor))
            .chain(of_gains.filter(|_| self.beside.gains));
        let mut of_unknown = SMatrix::<T, STATES, N>::zeros();
        for (mut to, from) in of_unknown.column_iter_mut().zip(columns) {
            to.fixed_rows_mut::<3>(RATE).copy_from(&from);
        }
        of_unknown
    }

    /// The unknowns, M first.
    ///
    /// # Errors
    /// [`IdentificationError`]: what the record does not support.
    pub fn solve(&self) -> Result<Solution<T, N>, IdentificationError> {
        if self.lasted_s < number(SETTLED_S) {
            let (found_s, needed_s) = (shown(self.lasted_s), SETTLED_S as f32);
            return Err(IdentificationError::TooBrief { found_s, needed_s });
        }
        self.joint.solve(self.noise.rate_rad_s)
    }
}
