//! What field and Sun say about the attitude error θ (Body): innovation and Jacobian.
//!
//! A true attitude A = (I − [θ×]) Â sees a reference vector r as
//!
//! b = A r = h + h × θ, h = Â r, hence H = [h×].
//!
//! | measurement | rows | noise |
//! |---|---|---|
//! | field, three axes | b − h, along Body's axes | white, the same on each axis, T |
//! | Sun, a unit vector | the two components across h (QUEST measurement model) | σ across the line of sight, rad |
//!
//! A unit vector has two degrees of freedom: the third row would measure its own length. Across h the
//! innovation is taken stereographically, 2 (b − h (h·b)) / (1 + h·b), whose length is 2 tan(α/2) for a
//! Sun that stands an angle α away: α for what is measured in a converged filter, still growing where
//! b − h would come back to zero for a Sun on the wrong side, and for an error about an axis across h
//! exactly the Gibbs vector by which the filter turns its attitude.
//!
//! Source: Markley & Crassidis (2014), §6.2.3; Shuster (1981) for the noise of unit vectors.

use nalgebra::{Matrix3, RealField, Vector3, convert};

use super::update::Row;

/// Rows of a field `measured`, Body, where `expected` was; `variance` per axis. Any unit.
pub(crate) fn field<T: RealField + Copy, const N: usize>(
    expected: Vector3<T>,
    measured: Vector3<T>,
    variance: T,
) -> [Row<T, N>; 3] {
    let innovation = measured - expected;
    let h: Matrix3<T> = expected.cross_matrix();
    [
        Row::of_attitude(h.row(0).transpose(), innovation.x, variance),
        Row::of_attitude(h.row(1).transpose(), innovation.y, variance),
        Row::of_attitude(h.row(2).transpose(), innovation.z, variance),
    ]
}

/// Rows of a direction `measured`, Body, where `expected` was, both of unit length; `variance` across
/// the line of sight, rad². `None` when it points the opposite way: no direction of turning is then
/// better than any other.
pub(crate) fn direction<T: RealField + Copy, const N: usize>(
    expected: Vector3<T>,
    measured: Vector3<T>,
    variance: T,
) -> Option<[Row<T, N>; 2]> {
    let closeness = T::one() + expected.dot(&measured);
    // Half a degree from opposite: 2 tan(α/2) is 460 there.
    let opposite: T = convert(4e-5);
    if closeness <= opposite {
        return None;
    }
    let scale = convert::<f64, T>(2.0) / closeness;
    let (first, second) = across(expected);
    // (first, second, expected) is right-handed; eᵀ[h×] = (e × h)ᵀ.
    Some([
        Row::of_attitude(-second, first.dot(&measured) * scale, variance),
        Row::of_attitude(first, second.dot(&measured) * scale, variance),
    ])
}

/// Two unit vectors across the unit vector `h` and each other, right-handed with it.
fn across<T: RealField + Copy>(h: Vector3<T>) -> (Vector3<T>, Vector3<T>) {
    // The axis least along h is at least 54 deg away from it: the product is never short.
    let (x, y, z) = (h.x.abs(), h.y.abs(), h.z.abs());
    let far = if x <= y && x <= z {
        Vector3::x()
    } else if y <= z {
        Vector3::y()
    } else {
        Vector3::z()
    };
    let first = far.cross(&h);
    let first = first / first.norm();
    (first, h.cross(&first))
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::UnitQuaternion;

    /// Central differences of 1e-5 leave 1e-10 of the third derivative and 1e-11 of rounding.
    const STEP: f64 = 1e-5;
    const TOLERANCE: f64 = 1e-9;

    fn turned(theta: Vector3<f64>, h: Vector3<f64>) -> Vector3<f64> {
        UnitQuaternion::from_scaled_axis(-theta) * h
    }

    fn directions() -> [Vector3<f64>; 4] {
        [
            Vector3::new(0.3, -0.5, 0.8).normalize(),
            Vector3::new(-0.9, 0.1, 0.05).normalize(),
            Vector3::x(),
            -Vector3::z(),
        ]
    }

    /// The rows' h beside the change of their innovation with θ.
    fn jacobian_is_numerical<const M: usize>(rows: impl Fn(Vector3<f64>) -> [Row<f64, 3>; M]) {
        let at_rest = rows(Vector3::zeros());
        for axis in 0..3 {
            let mut theta = Vector3::zeros();
            theta[axis] = STEP;
            let (plus, minus) = (rows(theta), rows(-theta));
            for (row, (plus, minus)) in at_rest.iter().zip(plus.iter().zip(&minus)) {
                let numerical = (plus.innovation - minus.innovation) / (2.0 * STEP);
                assert!((numerical - row.h[axis]).abs() < TOLERANCE);
            }
        }
    }

    #[test]
    fn h_of_the_field_is_the_numerical_jacobian() {
        for h in directions() {
            jacobian_is_numerical(|theta| field(h, turned(theta, h), 1.0));
        }
    }

    #[test]
    fn h_of_a_direction_is_the_numerical_jacobian() {
        for h in directions() {
            jacobian_is_numerical(|theta| direction(h, turned(theta, h), 1.0).unwrap());
        }
    }

    #[test]
    fn a_direction_measures_any_turn_across_it_exactly() {
        for h in directions() {
            let (axis, _) = across(h);
            for angle in [0.01_f64, 0.5, 2.0, 3.0] {
                let rows: [Row<f64, 3>; 2] = direction(h, turned(axis * angle, h), 1.0).unwrap();
                let measured: Vector3<f64> = rows.iter().map(|row| row.h * row.innovation).sum();
                let gibbs = axis * (2.0 * libm::tan(0.5 * angle));
                assert!((measured - gibbs).norm() < 1e-12 * gibbs.norm(), "{angle}");
            }
            assert!(direction::<f64, 3>(h, -h, 1.0).is_none());
        }
    }
}
