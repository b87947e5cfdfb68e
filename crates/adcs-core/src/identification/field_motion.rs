//! How the field moves in the body between two instants, and what its errors do meanwhile.
//!
//! | symbol | code | meaning |
//! |---|---|---|
//! | θ = ω Δt | | turn of the body |
//! | B⁺ = exp(−θ×) (B + d Δt) | [`Motion::carry`] | field, Body, T |
//! | d | | change of the field in inertial space, seen from Body, T/s |
//! | δB⁺ = B⁺ × δθ | [`Motion::of_turn`] | what an error of the turn does |
//!
//! d is what the orbit does. Its size is known, and how long it lasts; more is not assumed (Gauss–Markov).

use nalgebra::{Matrix3, RealField, Rotation3, Vector3};

use super::number;

/// Of d, each axis, T/s. A dipole's field in a polar orbit at 600 km changes by 3 n B₀ = 7.6·10⁻⁸ T/s at
/// most and by 5.4·10⁻⁸ T/s in the mean square, n = 1.08·10⁻³ rad/s, B₀ = 23.5 µT.
pub(super) const FIELD_CHANGE_T_S: f64 = 4e-8;
/// d turns at 2 n, smoothly: in 200 s, which is what an estimate looks back for, by 0.43 of itself. A Gauss–Markov
/// process that wanders as far in that time has this one.
const FIELD_CHANGE_LASTS_S: f64 = 1000.0;
/// Of its turn, each axis, rad/s: 2 n, the mean along a polar orbit, in any direction.
pub(super) const FIELD_TURN_RAD_S: f64 = 1.25e-3;
/// Of the field before its first reading, T: ten times what a reading says.
pub(super) const PRIOR_FIELD_T: f64 = 5e-6;
/// A field that was turned on for longer is given up, s.
pub(super) const MAX_GAP_S: f64 = 60.0;

/// Of one step.
#[derive(Debug, Clone, Copy)]
pub(super) struct Motion<T: RealField + Copy> {
    dt_s: T,
    /// exp(−θ×), and that of half the step.
    pub turn: Matrix3<T>,
    pub half_turn: Matrix3<T>,
    /// What is left of d, and the variance of what is new, (T/s)².
    pub lasting: T,
    pub renewed: T,
}

impl<T: RealField + Copy> Motion<T> {
    /// For a body that turns at `rate` for `dt_s`; of d as large as `change_t_s`.
    pub fn new(rate: &Vector3<T>, dt_s: T, change_t_s: T) -> Self {
        let half = Rotation3::new(-rate * (dt_s * number(0.5)));
        let lasting = T::one() / (T::one() + dt_s / number(FIELD_CHANGE_LASTS_S));
        Self {
            dt_s,
            turn: (half * half).into_inner(),
            half_turn: half.into_inner(),
            lasting,
            renewed: change_t_s * change_t_s * (T::one() - lasting * lasting),
        }
    }

    /// Field, and its change, after the step.
    pub fn carry(&self, field: &Vector3<T>, change: &Vector3<T>) -> (Vector3<T>, Vector3<T>) {
        (self.turn * (field + change * self.dt_s), self.turn * change * self.lasting)
    }

    /// ∂B⁺/∂ω of a field that is `carried` already.
    pub fn of_rate(&self, carried: &Vector3<T>) -> Matrix3<T> {
        carried.cross_matrix() * self.half_turn * self.dt_s
    }

    /// ∂B⁺/∂d.
    pub fn of_change(&self) -> Matrix3<T> {
        self.turn * self.dt_s
    }

    /// Covariance that gyro noise gives to a field turned by it.
    pub fn of_gyro_noise(&self, carried: &Vector3<T>, rate_rad_s: T) -> Matrix3<T> {
        let lever = carried.cross_matrix() * (rate_rad_s * self.dt_s);
        lever * lever.transpose()
    }
}
