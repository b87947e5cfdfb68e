//! Gyro bias and its slope with temperature, from a field that turns otherwise than the gyros say.
//!
//! | symbol | code | meaning |
//! |---|---|---|
//! | ω + b | `rate` | what the gyros show; b = b₀ + b₁ (T − T₀) |
//! | R | | turn from one reading of the field to the next, as the gyros say |
//! | Γ = ∫ R(end ← t) dt | | how a constant bias adds up on the way |
//!
//! A vector at rest in space that was B appears as R B by the gyros, and truly a little less turned:
//!
//! B_next − R B = (Γ b) × (R B)
//!
//! The bias about the field does not show in one such equation: the field has to turn in the body. The
//! field itself turns by up to 0.12 deg/s along the orbit. In a tumble that averages out; a body that is at rest in space
//! would show it as a bias, and its gyros are better identified by a filter that knows the attitude.

use nalgebra::{Matrix3, RealField, Rotation3, SMatrix, Vector3};

use super::{IdentificationError, Normal, Recorded, Solution, number, shown};

/// Sums over a record: unknowns b₀, then b₁ when `N` is 6.
#[derive(Debug, Clone, Copy)]
pub struct GyroBias<T: RealField + Copy, const N: usize> {
    interval_s: T,
    reference_c: T,
    start: Option<Start<T>>,
    last_rate: Option<Vector3<T>>,
    normal: Normal<T, N>,
}

#[derive(Debug, Clone, Copy)]
struct Start<T: RealField + Copy> {
    field: Vector3<T>,
    age_s: T,
    turn: Rotation3<T>,
    /// Γ, and Γ with T − T₀ inside.
    exposure: Matrix3<T>,
    warm_exposure: Matrix3<T>,
}

impl<T: RealField + Copy> GyroBias<T, 3> {
    /// For a constant bias, from readings of the field at least `interval_s` apart.
    ///
    /// # Errors
    /// [`IdentificationError::Interval`].
    pub fn constant(interval_s: T) -> Result<Self, IdentificationError> {
        Self::new(interval_s, T::zero())
    }
}

impl<T: RealField + Copy> GyroBias<T, 6> {
    /// For the bias at `reference_c`, and its slope (rad/s per degree), the unknowns 3 to 5.
    ///
    /// # Errors
    /// [`IdentificationError::Interval`].
    pub fn with_temperature(interval_s: T, reference_c: T) -> Result<Self, IdentificationError> {
        Self::new(interval_s, reference_c)
    }
}

impl<T: RealField + Copy, const N: usize> GyroBias<T, N> {
    fn new(interval_s: T, reference_c: T) -> Result<Self, IdentificationError> {
        let usable = interval_s.is_finite() && interval_s > T::zero();
        if !usable {
            return Err(IdentificationError::Interval { found: shown(interval_s) });
        }
        Ok(Self {
            interval_s,
            reference_c,
            start: None,
            last_rate: None,
            normal: Normal::default(),
        })
    }

    /// Takes in an instant at this temperature, °C.
    pub fn add(&mut self, recorded: &Recorded<T>, temperature_c: T) {
        if !recorded.is_finite() || !temperature_c.is_finite() {
            (self.start, self.last_rate) = (None, None);
            return;
        }
        let rate = Vector3::from(recorded.rate_rad_s);
        let mean_rate = self.last_rate.map_or(rate, |last| (last + rate) * number::<T>(0.5));
        self.last_rate = Some(rate);
        let dt = recorded.dt_s;
        if let Some(start) = self.start.as_mut() {
            let step = Rotation3::new(-mean_rate * dt);
            // What is added in this step is turned by half of it.
            let added = Rotation3::new(-mean_rate * (dt * number(0.5))).into_inner() * dt;
            let warmer = temperature_c - self.reference_c;
            start.turn = step * start.turn;
            start.exposure = step * start.exposure + added;
            start.warm_exposure = step * start.warm_exposure + added * warmer;
            start.age_s += dt;
        }
        let Some(reading) = recorded.field_t.map(Vector3::from) else { return };
        match self.start {
            Some(start) if start.age_s < self.interval_s => {}
            start => {
                if let Some(start) = start {
                    self.compare(&start, &reading);
                }
                self.start = Some(Start {
                    field: reading,
                    age_s: T::zero(),
                    turn: Rotation3::identity(),
                    exposure: Matrix3::zeros(),
                    warm_exposure: Matrix3::zeros(),
                });
            }
        }
    }

    fn compare(&mut self, start: &Start<T>, reading: &Vector3<T>) {
        let expected = start.turn * start.field;
        let strength = expected.norm();
        let usable = strength > T::zero();
        if !usable {
            return;
        }
        // (Γ b) × B = −B × (Γ b); in units of the field, so that weak and strong ones count alike.
        let lever = -expected.cross_matrix() / strength;
        let columns = [lever * start.exposure, lever * start.warm_exposure];
        let mut a = SMatrix::<T, 3, N>::zeros();
        let from = columns.iter().flat_map(Matrix3::column_iter);
        for (mut to, from) in a.column_iter_mut().zip(from) {
            to.copy_from(&from);
        }
        self.normal.add(&a, &((reading - expected) / strength));
    }

    /// b₀, rad/s, and b₁, rad/s per degree.
    ///
    /// # Errors
    /// [`IdentificationError`]: what the record does not support.
    pub fn solve(&self) -> Result<Solution<T, N>, IdentificationError> {
        self.normal.solve()
    }
}
