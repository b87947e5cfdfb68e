//! Which axis of the magnetometer is which, and which way round: what the strength of the field cannot
//! tell.
//!
//! | symbol | code | meaning |
//! |---|---|---|
//! | P | [`SignedPermutation`] | field in Body = P · field along the sensor's axes; 48 of them |
//! | ω | `rate` | rate by the gyros, Body |
//! | m | `dipole` | of the torquers, Body |
//! | J | `inertia` | tensor, Body |
//!
//! **The gyros** tell 24 pairs apart. The field hardly turns in space, so in Body it turns against the
//! gyros: dB/dt = −ω × B. For every P a field is turned on by the gyros until the body has turned by
//! half a radian and a reading at rest comes; what is missed then is summed up, and the reading is
//! the next to be turned on. P and −P miss the same, as the equation is linear in B.
//!
//! **The torquers** tell P from −P. Their work changes the energy of turning,
//!
//! ½ ω · J ω = constant + a ∫ ω · (m × B) dt + M · ∫ B × ω dt,
//!
//! in which neither the gyroscopic torque nor an attitude enters. The response a is 1, or −1 when B has
//! the other sign; M is the satellite's residual dipole, which takes energy and gives it back, and is fitted along.
//! The sign of the torquers enters as that of the field does: if both are the wrong way round, m × B is
//! right, and so is every law that works by it.
//!
//! Nothing is kept of the past but sums; a step costs 24 turns of a vector and as many sums of 5×5.

use core::fmt;

use nalgebra::{ComplexField, Matrix3, RealField, Rotation3, SMatrix, SVector, Vector3};

use super::symmetric::Spectrum;
use super::{number, shown};
use crate::frames::SignedPermutation;

/// P and −P are one for the gyros.
const PAIRS: usize = 24;
/// Comparisons after which a verdict is possible.
pub const MIN_FIELDS: u32 = 20;
/// The body turns by so much between two fields that are compared, rad: less would compare their noise.
const TURN_RAD: f64 = 0.5;
/// The best P must miss less than the second best by this factor (of squares): with 8 % of cross-axis
/// errors left, and turns of 10 degrees between readings, it does by ten.
pub const MIN_GYRO_RATIO: f64 = 2.0;
/// The response of the energy must be so many of its standard deviations. Neighbouring errors of the
/// energy are not independent, as those of the field are not, so five would not be safe.
pub const MIN_RESPONSE_SIGMAS: f64 = 8.0;
/// And this much, up or down, as the tensor or the torquers may be wrong by some tens of percent.
pub const RESPONSE: core::ops::RangeInclusive<f64> = 0.4..=2.5;
/// A field that was turned on for longer is too old to be compared, s: the field turns by 0.1 deg/s
/// along the orbit, and gyros drift.
const MAX_AGE_S: f64 = 60.0;

/// What was recorded at an instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxesStep<T> {
    /// Since the instant before, s.
    pub dt_s: T,
    /// By the gyros, Body, rad/s.
    pub rate_rad_s: [T; 3],
    /// Calibrated field along the sensor's axes, T; `None` while torquers disturb it.
    pub field_t: Option<[T; 3]>,
    /// Of the torquers, from the instant before until now, Body, A·m².
    pub dipole_am2: [T; 3],
}

/// Why the axes have no name.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum AxesError {
    /// Fewer comparisons of fields than [`MIN_FIELDS`].
    TooFew {
        /// How many there are.
        found: u32,
    },
    /// Two namings miss the readings nearly alike: the body turns too little, or about the field.
    Ambiguous {
        /// Squares that the second best misses, over those of the best.
        ratio: f32,
    },
    /// The torquers' work does not show in the energy.
    NoResponse {
        /// Change of energy over the torquers' work.
        response: f32,
        /// Its standard deviation.
        sigma: f32,
    },
}

impl fmt::Display for AxesError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooFew { found } => {
                write!(f, "{found} turns of the field are too few: it takes {MIN_FIELDS}")
            }
            Self::Ambiguous { ratio } => write!(
                f,
                "the second best naming of the axes is only {ratio} times worse than the best: the \
                 body turned too little, or about the field"
            ),
            Self::NoResponse { response, sigma } => write!(
                f,
                "the work of the torquers does not show in the energy of turning (response {response}, \
                 sigma {sigma}): the sign of all axes together stays open"
            ),
        }
    }
}

impl core::error::Error for AxesError {}

/// What the record says.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Axes<T> {
    /// P.
    pub permutation: SignedPermutation,
    /// Squares that the second best pair misses, over those of the best.
    pub gyro_ratio: T,
    /// Change of energy over the torquers' work with the axes so named: about 1.
    pub response: T,
    /// Its standard deviation, if the errors of the energy were independent.
    pub response_sigma: T,
}

/// One pair P, −P.
#[derive(Debug, Clone, Copy)]
struct Hypothesis<T: RealField + Copy> {
    permutation: SignedPermutation,
    /// The last reading, turned on, Body, T.
    field: Option<Vector3<T>>,
    /// Σ |what is missed|², T².
    missed: T,
    /// Of the torquers so far, and of three unit dipoles along Body's axes; and one.
    work: Work<T>,
    /// Σ w wᵀ, Σ w E, w being the work.
    normal: SMatrix<T, TERMS, TERMS>,
    gradient: Work<T>,
}

/// What the energy is made of.
const TERMS: usize = 5;
type Work<T> = SVector<T, TERMS>;

/// Sums over a record.
#[derive(Debug, Clone, Copy)]
pub struct AxesCheck<T: RealField + Copy> {
    inertia: Matrix3<T>,
    hypotheses: [Hypothesis<T>; PAIRS],
    last_rate: Option<Vector3<T>>,
    /// Whether a field is being turned on; since it was read: time, and the body's turn.
    has_field: bool,
    age_s: T,
    turned_rad: T,
    fields: u32,
    first_energy: Option<T>,
    energies: T,
    sum_energy_squared: T,
}

impl<T: RealField + Copy> AxesCheck<T> {
    /// Begins a record of a body with this tensor, kg·m². Only its part along the rate matters, and
    /// that to a fifth.
    pub fn new(inertia_kg_m2: [[T; 3]; 3]) -> Self {
        let zero = T::zero();
        let mut hypotheses = [Hypothesis {
            permutation: SignedPermutation::IDENTITY,
            field: None,
            missed: zero,
            work: SVector::from([zero, zero, zero, zero, T::one()]),
            normal: SMatrix::zeros(),
            gradient: SVector::zeros(),
        }; PAIRS];
        // Of P and −P one is a rotation.
        let rotations = SignedPermutation::all().filter(|it| it.is_rotation());
        for (hypothesis, permutation) in hypotheses.iter_mut().zip(rotations) {
            hypothesis.permutation = permutation;
        }
        Self {
            inertia: Matrix3::from(inertia_kg_m2),
            hypotheses,
            last_rate: None,
            has_field: false,
            age_s: zero,
            turned_rad: zero,
            fields: 0,
            first_energy: None,
            energies: zero,
            sum_energy_squared: zero,
        }
    }

    /// Takes in an instant. One that is not finite is left out, and the fields before it are not turned
    /// over it.
    pub fn add(&mut self, step: &AxesStep<T>) {
        let AxesStep { dt_s, rate_rad_s, field_t, dipole_am2 } = *step;
        let given = rate_rad_s.iter().chain(&dipole_am2).chain([&dt_s]);
        let finite = given.chain(field_t.iter().flatten()).all(ComplexField::is_finite);
        if !finite || dt_s < T::zero() {
            self.last_rate = None;
            self.has_field = false;
            self.hypotheses.iter_mut().for_each(|hypothesis| hypothesis.field = None);
            return;
        }
        let rate = Vector3::from(rate_rad_s);
        let mean_rate = self.last_rate.map_or(rate, |last| (last + rate) * number::<T>(0.5));
        self.last_rate = Some(rate);
        // A vector at rest in space, seen from Body: turned by −ω dt.
        let turn = Rotation3::new(-mean_rate * dt_s);
        self.age_s += dt_s;
        self.turned_rad += mean_rate.norm() * dt_s;
        let too_old = self.age_s > number(MAX_AGE_S);
        let has_field = self.has_field && !too_old;
        let reading = field_t.filter(|_| !has_field || self.turned_rad >= number(TURN_RAD));

        let energy = rate.dot(&(self.inertia * rate)) * number::<T>(0.5);
        // From the first on, so that single precision keeps its digits.
        let energy = energy - *self.first_energy.get_or_insert(energy);
        self.energies += T::one();
        self.sum_energy_squared += energy * energy;

        let dipole = Vector3::from(dipole_am2);
        for hypothesis in &mut self.hypotheses {
            if let Some(field) = hypothesis.field {
                let middle = field + (turn * field - field) * number::<T>(0.5);
                // ω · (m × B) = m · (B × ω)
                let lever = middle.cross(&mean_rate) * dt_s;
                let [x, y, z] = lever.into();
                hypothesis.work += SVector::from([dipole.dot(&lever), x, y, z, T::zero()]);
            }
            hypothesis.field = hypothesis.field.filter(|_| !too_old).map(|field| turn * field);
            if let Some(reading) = reading {
                let reading = hypothesis.permutation.apply(Vector3::from(reading));
                if let Some(expected) = hypothesis.field {
                    hypothesis.missed += (reading - expected).norm_squared();
                }
                hypothesis.field = Some(reading);
            }
            hypothesis.normal += hypothesis.work * hypothesis.work.transpose();
            hypothesis.gradient += hypothesis.work * energy;
        }
        self.has_field = has_field || reading.is_some();
        if reading.is_some() {
            (self.age_s, self.turned_rad) = (T::zero(), T::zero());
            self.fields = self.fields.saturating_add(u32::from(has_field));
        }
    }

    /// The pair P, −P that the gyros name, and by what factor the next one is worse.
    ///
    /// # Errors
    /// [`AxesError::TooFew`], [`AxesError::Ambiguous`].
    pub fn by_gyros(&self) -> Result<(SignedPermutation, T), AxesError> {
        self.best().map(|(hypothesis, ratio)| (hypothesis.permutation, ratio))
    }

    fn best(&self) -> Result<(&Hypothesis<T>, T), AxesError> {
        if self.fields < MIN_FIELDS {
            return Err(AxesError::TooFew { found: self.fields });
        }
        let [first, rest @ ..] = &self.hypotheses;
        let (mut best, mut second) = (first, None);
        for hypothesis in rest {
            if hypothesis.missed < best.missed {
                second = Some(best.missed);
                best = hypothesis;
            } else if second.is_none_or(|second| hypothesis.missed < second) {
                second = Some(hypothesis.missed);
            }
        }
        let ratio = ratio(second.unwrap_or(best.missed), best.missed);
        if ratio >= number(MIN_GYRO_RATIO) {
            Ok((best, ratio))
        } else {
            Err(AxesError::Ambiguous { ratio: shown(ratio) })
        }
    }

    /// Names the axes.
    ///
    /// # Errors
    /// [`AxesError`]: what the record leaves open.
    pub fn verdict(&self) -> Result<Axes<T>, AxesError> {
        let (best, gyro_ratio) = self.best()?;
        let spectrum = Spectrum::of(&best.normal);
        let fitted = spectrum.step(&-best.gradient, T::zero());
        let left = self.sum_energy_squared - fitted.dot(&best.gradient);
        let freedom = (self.energies - number(TERMS as f64)).max(T::one());
        // Below what rounding leaves of the sum nothing is known.
        let floor = self.sum_energy_squared * T::default_epsilon();
        let variance = left.max(floor) / freedom;
        let (response, response_sigma) =
            (fitted.x, (spectrum.inverse().m11 * variance).max(T::zero()).sqrt());
        let size = response.abs();
        let shows = size > response_sigma * number(MIN_RESPONSE_SIGMAS)
            && size >= number(*RESPONSE.start())
            && size <= number(*RESPONSE.end());
        if !shows {
            let (response, sigma) = (shown(response), shown(response_sigma));
            return Err(AxesError::NoResponse { response, sigma });
        }
        let permutation = match response > T::zero() {
            true => best.permutation,
            false => best.permutation.negated(),
        };
        Ok(Axes { permutation, gyro_ratio, response: size, response_sigma })
    }
}

/// a / b, one where both are zero; never infinite.
fn ratio<T: RealField + Copy>(a: T, b: T) -> T {
    let limit = number(1e6);
    if a <= T::zero() {
        T::one()
    } else if a >= b * limit {
        limit
    } else {
        a / b
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_body_at_rest_names_nothing() {
        let mut check = AxesCheck::new([[0.05, 0.0, 0.0], [0.0, 0.05, 0.0], [0.0, 0.0, 0.05]]);
        let step = AxesStep {
            dt_s: 1.0,
            rate_rad_s: [0.0; 3],
            field_t: Some([2e-5, 1e-5, -3e-5]),
            dipole_am2: [0.0; 3],
        };
        check.add(&step);
        (0..1000).for_each(|_| check.add(&step));
        assert_eq!(check.verdict(), Err(AxesError::TooFew { found: 0 }));
        // About the field along z: x and y may be anything.
        let mut check = AxesCheck::new([[0.05, 0.0, 0.0], [0.0, 0.05, 0.0], [0.0, 0.0, 0.05]]);
        let step =
            AxesStep { rate_rad_s: [0.0, 0.0, 0.3], field_t: Some([0.0, 0.0, 3e-5]), ..step };
        (0..1000).for_each(|_| check.add(&step));
        assert!(matches!(check.verdict(), Err(AxesError::Ambiguous { .. })));
        check.add(&AxesStep { rate_rad_s: [f64::NAN; 3], ..step });
        assert!(matches!(check.verdict(), Err(AxesError::Ambiguous { .. })));
    }
}
