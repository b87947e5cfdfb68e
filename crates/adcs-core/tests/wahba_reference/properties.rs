//! For any rotation, and for any numbers whatever.

use adcs_core::attitude::{Method, Observation};
use adcs_core::frames::{Rotation, Vector};
use nalgebra::{Matrix3, Quaternion, Rotation3, UnitQuaternion, Vector3};
use proptest::prelude::*;

use crate::OPTIMAL;
use crate::problem::{Pair, angle_rad, solve};

/// A known rotation comes back, f64.
const RECOVERED_RAD: f64 = 1e-9;
/// The methods agree, f64: rounding of a problem of margin 1e-3 and more.
const AGREED_RAD: f64 = 1e-10;
/// Covariance, relative to its largest component.
const COVARIANCE: f64 = 1e-9;

const UNIT_CUBE: [core::ops::Range<f64>; 3] = [-1.0..1.0, -1.0..1.0, -1.0..1.0];

fn direction() -> impl Strategy<Value = Vector3<f64>> {
    UNIT_CUBE.prop_map(Vector3::from).prop_filter("too short", |v| v.norm() > 1e-2)
}

/// Any rotation, and often exactly 0, 90 or 180 deg about axes and diagonals.
fn rotation() -> impl Strategy<Value = UnitQuaternion<f64>> {
    let any = [-1.0..1.0, -1.0..1.0, -1.0..1.0, -1.0..1.0_f64];
    let special = [-1..=1_i8, -1..=1, -1..=1, -1..=1].prop_map(|q| q.map(f64::from));
    prop_oneof![any, special]
        .prop_map(|[w, x, y, z]| Quaternion::new(w, x, y, z))
        .prop_filter("no rotation", |q| q.norm() > 1e-2)
        .prop_map(UnitQuaternion::new_normalize)
}

/// 180 deg about any axis.
fn half_turn() -> impl Strategy<Value = UnitQuaternion<f64>> {
    direction().prop_map(|v| UnitQuaternion::new_normalize(Quaternion::from_imag(v)))
}

fn sigma() -> impl Strategy<Value = f64> {
    (-6.0..-0.5_f64).prop_map(|exponent| libm::pow(10.0, exponent))
}

fn separated(references: &[Vector3<f64>]) -> bool {
    let [first, rest @ ..] = references else { return false };
    rest.iter().all(|r| first.cross(r).norm() > 0.05 * first.norm() * r.norm())
}

fn recovered(
    q: UnitQuaternion<f64>,
    references: &[Vector3<f64>],
    sigmas: &[f64],
) -> Result<(), TestCaseError> {
    let pairs: Vec<_> = references
        .iter()
        .zip(sigmas)
        .map(|(r, &sigma_rad)| Pair { body: q * r, reference: *r, sigma_rad })
        .collect();
    for method in [Method::Triad, Method::Foam, Method::QMethod, Method::Quest] {
        let found = solve(method, &pairs).unwrap();
        let error = angle_rad(found.attitude, Rotation::from_hamilton(q));
        prop_assert!(error < RECOVERED_RAD, "{method:?}: {error}");
        prop_assert!(found.loss < RECOVERED_RAD * RECOVERED_RAD);
    }
    Ok(())
}

proptest! {
    #[test]
    fn a_known_rotation_is_recovered(
        q in rotation(),
        references in prop::collection::vec(direction(), 2..7).prop_filter("parallel", |r| separated(r)),
        sigmas in prop::collection::vec(sigma(), 6),
    ) {
        recovered(q, &references, &sigmas)?;
    }

    #[test]
    fn a_rotation_by_180_deg_about_any_axis_is_recovered(
        q in half_turn(),
        references in prop::collection::vec(direction(), 2..4).prop_filter("parallel", |r| separated(r)),
        sigmas in prop::collection::vec(sigma(), 3),
    ) {
        recovered(q, &references, &sigmas)?;
    }

    /// Pairs that agree with nothing: whatever the optimum is, it is the same for all methods, no
    /// neighbour is better, and it is not better than the reported loss.
    #[test]
    fn the_methods_agree_on_arbitrary_pairs_and_no_other_attitude_is_better(
        vectors in prop::collection::vec((direction(), direction(), 0.1..1.0_f64), 2..6),
        elsewhere in prop::collection::vec(rotation(), 20),
    ) {
        let pairs: Vec<_> = vectors
            .iter()
            .map(|&(body, reference, sigma_rad)| Pair { body, reference, sigma_rad })
            .collect();
        let found = OPTIMAL.map(|method| solve(method, &pairs));
        let total: f64 = pairs.iter().map(|pair| pair.sigma_rad.powi(-2)).sum();
        let loss = |a: &Rotation3<f64>| {
            let term = |pair: &Pair| {
                let residual = pair.body.normalize() - a * pair.reference.normalize();
                pair.sigma_rad.powi(-2) / total * residual.norm_squared() / 2.0
            };
            pairs.iter().map(term).sum::<f64>()
        };
        if let [Ok(foam), Ok(q_method), Ok(quest)] = &found {
            prop_assume!(foam.margin > 1e-3);
            for other in [q_method, quest] {
                prop_assert!(angle_rad(foam.attitude, other.attitude) < AGREED_RAD);
            }
            let best = loss(&foam.attitude.hamilton().to_rotation_matrix());
            prop_assert!((best - foam.loss).abs() < 1e-14);
            for a in elsewhere {
                prop_assert!(loss(&a.to_rotation_matrix()) > best - 1e-14);
            }
        } else {
            // All refuse, or none.
            prop_assert!(found.iter().all(Result::is_err), "{found:?}");
        }
    }

    #[test]
    fn the_covariance_is_the_inverse_of_the_information(
        q in rotation(),
        references in prop::collection::vec(direction(), 2..7).prop_filter("parallel", |r| separated(r)),
        sigmas in prop::collection::vec((-3.0..-1.0_f64).prop_map(|x| libm::pow(10.0, x)), 6),
    ) {
        let pairs: Vec<_> = references
            .iter()
            .zip(&sigmas)
            .map(|(r, &sigma_rad)| Pair { body: q * r, reference: *r, sigma_rad })
            .collect();
        let information = pairs.iter().fold(Matrix3::zeros(), |sum, pair| {
            let b = pair.body.normalize();
            sum + (Matrix3::identity() - b * b.transpose()) * pair.sigma_rad.powi(-2)
        });
        let expected = information.try_inverse().unwrap();
        for method in OPTIMAL {
            let found = solve(method, &pairs).unwrap().covariance_rad2;
            prop_assert!((found - expected).amax() < COVARIANCE * expected.amax(), "{found} {expected}");
            prop_assert_eq!(found, found.transpose());
            prop_assert!(found.cholesky().is_some());
        }
    }

    /// Numerical Jacobian of every method, for errors of each measurement about each axis.
    #[test]
    fn the_covariance_is_what_errors_of_the_measurements_make_of_the_attitude(
        q in rotation(),
        references in prop::collection::vec(direction(), 2..5).prop_filter("parallel", |r| separated(r)),
        sigmas in prop::collection::vec(1e-3..1e-1_f64, 4),
    ) {
        const STEP_RAD: f64 = 1e-6;
        /// Terms of second order, relative.
        const NUMERICAL: f64 = 1e-3;
        for method in [Method::Triad, Method::Foam, Method::QMethod, Method::Quest] {
            let used = if method == Method::Triad { 2 } else { references.len() };
            let moved = |moved: usize, turn: UnitQuaternion<f64>| {
                let pairs: Vec<_> = (0..used)
                    .map(|i| Pair {
                        body: if i == moved { turn * (q * references[i]) } else { q * references[i] },
                        reference: references[i],
                        sigma_rad: sigmas[i],
                    })
                    .collect();
                solve(method, &pairs).unwrap()
            };
            let nominal = moved(0, UnitQuaternion::identity());
            let mut expected = Matrix3::zeros();
            for (i, sigma_rad) in sigmas.iter().enumerate().take(used) {
                for axis in [Vector3::x(), Vector3::y(), Vector3::z()] {
                    let turned = moved(i, UnitQuaternion::from_scaled_axis(axis * STEP_RAD));
                    let error = (turned.attitude * nominal.attitude.inverse()).hamilton().scaled_axis();
                    expected += error * error.transpose() * (sigma_rad / STEP_RAD).powi(2);
                }
            }
            let difference = (nominal.covariance_rad2 - expected).amax();
            prop_assert!(difference < NUMERICAL * expected.amax(), "{method:?} {nominal:?} {expected}");
        }
    }

    #[test]
    fn whatever_comes_in_no_number_that_is_none_comes_out(
        numbers in prop::collection::vec([any::<f32>(), any::<f32>(), any::<f32>(), any::<f32>(), any::<f32>(), any::<f32>(), any::<f32>()], 0..6),
    ) {
        let observations: Vec<_> = numbers
            .into_iter()
            .filter_map(|[b_x, b_y, b_z, r_x, r_y, r_z, sigma]| {
                Observation::new(Vector::new(b_x, b_y, b_z), Vector::new(r_x, r_y, r_z), sigma).ok()
            })
            .collect();
        for method in [Method::Triad, Method::Foam, Method::QMethod, Method::Quest] {
            if let Ok(found) = method.solve(&observations) {
                let q = found.attitude.hamilton();
                prop_assert!((q.norm() - 1.0).abs() < 1e-5);
                prop_assert!(found.covariance_rad2.iter().all(|x| x.is_finite()));
                prop_assert!(found.covariance_rad2.diagonal().min() > 0.0, "{found:?} {observations:?}");
                prop_assert!(found.loss.is_finite() && found.margin.is_finite());
            }
        }
    }
}
