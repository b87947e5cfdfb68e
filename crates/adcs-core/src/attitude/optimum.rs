//! The last digits, and the proof: from a method's attitude to the certified minimum of the loss.
//!
//! Each method finds the attitude from B, whose components are rounded at ε; that turns its answer
//! by about ε / margin, which is nothing for Sun and field (margin 0.03) and everything for a star
//! tracker beside a magnetometer (margin 10⁻⁸, in f32). Here the loss itself is followed downhill from
//! there, on residuals that do not cancel, in axes in which no weight drowns another
//! ([`information`](super::information)).
//!
//! A step solves H δ = g for the small rotation δ, but takes the part about the weak direction n as
//! the angle φ of (cos φ, sin φ) ∝ (nᵀHn, nᵀg), which is exact for a turn about a single axis, from
//! however far away. From a good start one step is made, and it is of the size of rounding.
//!
//! The result is reported only if it is proved: what remains of the step is rounding and H is positive
//! beyond rounding. On the sphere of quaternions the loss 1 − qᵀKq has no minimum but the global one,
//! so this is the optimum of Wahba's problem wherever the climb began. If it cannot be proved, or if
//! the method found nothing, a climb begins from an attitude under which the sharpest pair agrees; if
//! that fails too, the attitude is not unique in this precision.

use nalgebra::{ComplexField, Matrix3, Quaternion, RealField, UnitQuaternion, Vector2, Vector3};

use super::information::{Eliminated, Information};
use super::problem::{Pair, Problem};
use super::{Estimate, NoAttitude, number, quaternion};
use crate::frames::Rotation;

/// An attitude counts as unique if rounding of the unit vectors' components can turn it by no more
/// than this: 0.06 deg, a tenth of what a Sun sensor of this class is wrong by.
///
/// A component carries an error ε. It shifts nᵀg by up to ε W, W = Σ a_i (|n × b_i| + |n × c_i|), and thus
/// turns the attitude by ε W / nᵀHn. The bar is on that angle and not on the margin nᵀHn itself, because a
/// small margin has two causes: parallel pairs, where W / nᵀHn is large, and a light weight, where it
/// is not.
///
/// - Pairs that agree and stand an angle s apart: 2 to 4 ε / s, whatever the weights. f32 accepts from
///   s = 4e-4 rad (0.02 deg), f64 from 1e-12 rad.
/// - Pairs that contradict each other: some ε / margin. f32 accepts margins from 3e-4, f64 from 1e-12.
/// - Pairs that are parallel but for rounding: about 1 rad in either precision, a thousand times the bar.
pub(super) const MAX_TURN_BY_ROUNDING_RAD: f64 = 1e-3;

/// A step about n that is no longer than this many times the effect of rounding is rounding.
const STEP_IN_ROUNDINGS: f64 = 16.0;

/// How well nᵀHn, on which uniqueness is judged, is to be known.
const ROLL_RELATIVE: f64 = 0.01;

/// One step is made as a rule. Pairs that are both close together and noisier than they are apart take
/// more, in f32 up to this many; where that is not enough, rounding rules.
const MAX_STEPS: usize = 12;

/// The minimum of the loss, from the attitude that a method found, if it found one.
pub(super) fn find<T: RealField + Copy>(
    problem: &Problem<'_, T>,
    start: Option<UnitQuaternion<T>>,
) -> Result<Estimate<T>, NoAttitude> {
    let climb = Climb {
        problem,
        axes: problem.sharpest_body_axes(),
        smallest_information: T::default_epsilon() / number(MAX_TURN_BY_ROUNDING_RAD),
    };
    let found = start.and_then(|start| climb.from(start).ok());
    found.map_or_else(|| climb.from(quaternion(&problem.aligned_with_sharpest())), Ok)
}

struct Climb<'p, 'a, T: RealField + Copy> {
    problem: &'p Problem<'a, T>,
    /// From Body to axes along the sharpest measurement, in which everything here is expressed.
    axes: Matrix3<T>,
    /// What stands above rounding, relative to weights of sum one.
    smallest_information: T,
}

/// A pair in the axes of the climb.
struct Sight<T> {
    weight: T,
    b: Vector3<T>,
    c: Vector3<T>,
    is_sharpest: bool,
}

impl<T: RealField + Copy> Climb<'_, '_, T> {
    /// Steps until one is no more than rounding, and then the proof.
    fn from(&self, start: UnitQuaternion<T>) -> Result<Estimate<T>, NoAttitude> {
        let flat = NoAttitude::NotUnique { margin: 0.0 };
        let mut attitude = start;
        for _ in 0..MAX_STEPS {
            let a = self.axes * attitude.to_rotation_matrix().into_inner();
            let (gradient, information) = self.slope(&a);
            let eliminated = information.eliminate(self.smallest_information).ok_or(flat)?;
            let step = Step::new(&gradient, &eliminated).ok_or(flat)?;
            let amplification = self.amplification(&a, &eliminated);
            attitude = self.turned(&attitude, &step);
            if eliminated.roll > T::zero() && step.is_last(amplification) {
                let margin = information.smallest_eigenvalue(&eliminated);
                let turn_by_rounding = T::default_epsilon() * amplification;
                let unique = turn_by_rounding <= number(MAX_TURN_BY_ROUNDING_RAD);
                let covariance_rad2 = self.covariance().filter(|_| unique);
                return Ok(Estimate {
                    attitude: Rotation::from_hamilton(attitude),
                    loss: self.problem.loss(&attitude),
                    covariance_rad2: covariance_rad2.ok_or(NoAttitude::not_unique(margin))?,
                    margin,
                });
            }
        }
        Err(flat)
    }

    /// b of a pair; of the sharpest exactly the first axis.
    fn body(&self, pair: &Pair<T>) -> Vector3<T> {
        if pair.is_sharpest { Vector3::x() } else { self.axes * pair.body }
    }

    /// Every pair, under the attitude matrix `a` from Eci to the axes of the climb.
    fn sights(&self, a: &Matrix3<T>) -> impl Iterator<Item = Sight<T>> {
        self.problem.pairs().map(move |pair| {
            let (b, c) = (self.body(&pair), a * pair.reference);
            Sight { weight: pair.weight, b, c, is_sharpest: pair.is_sharpest }
        })
    }

    /// g and H.
    fn slope(&self, a: &Matrix3<T>) -> (Vector3<T>, Information<T>) {
        let nothing = (Vector3::zeros(), Information::zero());
        self.sights(a).fold(nothing, |(g, h), Sight { weight, b, c, .. }| {
            (g + c.cross(&b) * weight, h.plus(weight, &b, &c))
        })
    }

    /// W / nᵀHn, W = Σ a_i (|n × b_i| + |n × c_i|) in the sum norm: how far an error of all
    /// components turns the attitude about n. The sharpest pair lacks the second term: an error of
    /// its measurement turns the axes of the climb, not the attitude in them.
    fn amplification(&self, a: &Matrix3<T>, eliminated: &Eliminated<T>) -> T {
        let n = eliminated.weak_direction();
        let spread = self.sights(a).fold(T::zero(), |spread, sight| {
            let Sight { weight, b, c, is_sharpest } = sight;
            let reference = n.cross(&b).abs().sum();
            let body = if is_sharpest { T::zero() } else { n.cross(&c).abs().sum() };
            spread + weight * (reference + body)
        });
        spread / eliminated.roll.abs()
    }

    /// [Σ σ_i⁻² (I − b_i b_iᵀ)]⁻¹, Body, rad².
    fn covariance(&self) -> Option<Matrix3<T>> {
        let information = self.problem.pairs().fold(Information::zero(), |information, pair| {
            let b = self.body(&pair);
            information.plus(pair.weight, &b, &b)
        });
        let eliminated = information
            .eliminate(self.smallest_information)
            .filter(|eliminated| eliminated.roll > T::zero())?;
        let covariance = eliminated.inverse_in(&self.axes) * self.problem.variance_rad2();
        covariance.iter().all(ComplexField::is_finite).then_some(covariance)
    }

    fn turned(&self, attitude: &UnitQuaternion<T>, step: &Step<T>) -> UnitQuaternion<T> {
        let axis = self.axes.tr_mul(&step.vector);
        let turn = Quaternion::from_parts(step.scalar, axis);
        UnitQuaternion::new_normalize(turn * attitude.into_inner())
    }
}

/// A small rotation δ that follows the loss downhill.
struct Step<T> {
    /// Scalar part of its quaternion, which is not yet of unit length.
    scalar: T,
    vector: Vector3<T>,
    /// tan φ/2, φ the part about the weak direction.
    about_weak: T,
    /// The part across it, rad.
    across: T,
}

impl<T: RealField + Copy> Step<T> {
    /// `None` when the loss is flat about the weak direction, or something is not finite.
    fn new(gradient: &Vector3<T>, eliminated: &Eliminated<T>) -> Option<Self> {
        let (one, two) = (T::one(), number::<T>(2.0));
        let transverse = gradient.yz();
        let along = gradient.x - eliminated.u.dot(&transverse);
        let across: Vector2<T> = eliminated.transverse_inverse * transverse;
        // (cos φ, sin φ) ∝ (nᵀHn, nᵀg), scaled first: both may be as small as the lightest weight.
        let scale = along.abs().max(eliminated.roll.abs());
        if scale <= T::zero() {
            return None;
        }
        let (x, y) = (eliminated.roll / scale, along / scale);
        let length = (x * x + y * y).sqrt();
        let (cosine, sine) = (x / length, y / length);
        // (cos φ/2, sin φ/2) up to a factor, by the half-angle formula that does not cancel.
        let (scalar, about_n) = if cosine >= T::zero() {
            (one + cosine, sine)
        } else {
            (sine.abs(), (one - cosine).copysign(sine))
        };
        let vector = eliminated.weak_direction() * about_n
            + Vector3::new(T::zero(), across.x, across.y) * (scalar / two);
        let finite = (scalar + vector.x + vector.y + vector.z).is_finite();
        finite.then(|| Self { scalar, vector, about_weak: about_n / scalar, across: across.norm() })
    }

    /// Whether, once this step is made, the next would be rounding: what is left of it is its square.
    /// And whether nᵀHn is known, on which a step across n has the effect W `across`; where pairs are
    /// parallel nothing else is in nᵀHn.
    fn is_last(&self, amplification: T) -> bool {
        let quadratic = T::default_epsilon().sqrt();
        let rounding = T::default_epsilon() * number(STEP_IN_ROUNDINGS) * amplification;
        self.about_weak.abs() <= quadratic.max(rounding)
            && self.across <= quadratic
            && self.across * amplification <= number(ROLL_RELATIVE)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::attitude::Observation;
    use crate::frames::Vector;
    use proptest::prelude::*;

    const DIRECTION: [core::ops::Range<f64>; 3] = [0.05..1.0, -1.0..1.0, -1.0..1.0];
    /// Step of the differences, rad.
    const STEP_RAD: f64 = 1e-4;
    /// Second differences of a function of order one: rounding over the step squared, and fourth-order
    /// terms.
    const NUMERICAL: f64 = 1e-6;

    proptest! {
        /// Numerical Jacobian and Hessian of the loss over small rotations of Body.
        #[test]
        fn gradient_and_curvature_are_those_of_the_loss(
            bodies in [DIRECTION, DIRECTION, DIRECTION],
            references in [DIRECTION, DIRECTION, DIRECTION],
            sigmas in [0.1..1.0, 0.1..1.0, 0.1..1.0_f64],
            start in DIRECTION,
        ) {
            let pairs: [_; 3] = core::array::from_fn(|i| {
                let (body, eci) = (Vector::from_xyz(bodies[i].into()), Vector::from_xyz(references[i].into()));
                Observation::new(body, eci, sigmas[i]).unwrap()
            });
            let problem = Problem::new(&pairs).unwrap();
            let climb = Climb { problem: &problem, axes: problem.sharpest_body_axes(), smallest_information: 1e-12 };
            let loss = |attitude: &UnitQuaternion<f64>, delta: Vector3<f64>| {
                problem.loss(&(UnitQuaternion::from_scaled_axis(climb.axes.tr_mul(&delta)) * attitude))
            };
            let axes = [Vector3::x(), Vector3::y(), Vector3::z()].map(|axis| axis * STEP_RAD);
            let slope = |attitude: &UnitQuaternion<f64>| {
                climb.slope(&(climb.axes * attitude.to_rotation_matrix().into_inner()))
            };

            // The gradient anywhere, g = −∂L/∂δ.
            let anywhere = UnitQuaternion::from_scaled_axis(start.into());
            let (gradient, _) = slope(&anywhere);
            for (g, axis) in gradient.iter().zip(axes) {
                let numerical = (loss(&anywhere, axis) - loss(&anywhere, -axis)) / (2.0 * STEP_RAD);
                prop_assert!((g + numerical).abs() < NUMERICAL, "{g} {numerical}");
            }

            // The curvature at the optimum, where the coupling is complete: through its inverse.
            let Ok(best) = find(&problem, None) else {
                return Err(TestCaseError::reject("not unique"));
            };
            prop_assume!(best.margin > 1e-2);
            let best_attitude = best.attitude.hamilton();
            let at = |delta| loss(&best_attitude, delta);
            let numerical = Matrix3::from_fn(|i, j| {
                let (a, b) = (axes[i], axes[j]);
                (at(a + b) - at(a - b) - at(b - a) + at(-a - b)) / (4.0 * STEP_RAD * STEP_RAD)
            });
            let inverse = slope(&best_attitude).1.eliminate(1e-12).unwrap().inverse_in(&Matrix3::identity());
            let product = inverse * numerical - Matrix3::identity();
            prop_assert!(product.amax() < NUMERICAL / (best.margin * best.margin), "{product}");
            let smallest = numerical.symmetric_eigenvalues().min();
            prop_assert!((best.margin - smallest).abs() < NUMERICAL, "{} {smallest}", best.margin);
        }
    }
}
