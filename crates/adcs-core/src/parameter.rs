//! What parameters are held against before they fly: a range for every number, and what an inertia tensor
//! must be.

use core::fmt;

use nalgebra::{ComplexField, Matrix3, RealField, convert, convert_unchecked};

/// A number outside its range; what was in force stays.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct OutOfRange {
    /// Which: its field, which ends in its unit.
    pub name: &'static str,
    /// What was given.
    pub found: f32,
    /// The smallest that is accepted.
    pub from: f32,
    /// The largest that is accepted.
    pub to: f32,
}

impl fmt::Display for OutOfRange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { name, found, from, to } = self;
        write!(f, "{name} is {found:e}, it must be from {from:e} to {to:e}")
    }
}

impl core::error::Error for OutOfRange {}

/// Refuses the first number that is outside its range, NaN too. A row is the number's field, what was
/// given, the smallest and the largest that are accepted.
pub(crate) fn check<T: RealField + Copy>(
    numbers: &[(&'static str, T, f64, f64)],
) -> Result<(), OutOfRange> {
    for &(name, found, from, to) in numbers {
        // Both ends in the precision of the number: 0.3 of an f32 is above 0.3 of an f64.
        if !(convert::<f64, T>(from)..=convert(to)).contains(&found) {
            return Err(OutOfRange { name, found: shown(found), from: from as f32, to: to as f32 });
        }
    }
    Ok(())
}

/// A number as an error carries it.
pub(crate) fn shown<T: RealField + Copy>(number: T) -> f32 {
    convert_unchecked::<T, f64>(number) as f32
}

/// The inertia tensor of these rows, and its inverse; `None` when no body has it: not finite, not
/// symmetric, or a principal moment that is not positive.
pub(crate) fn inertia<T: RealField + Copy>(rows: [[T; 3]; 3]) -> Option<[Matrix3<T>; 2]> {
    // Symmetric: rows are columns.
    let tensor = Matrix3::from(rows);
    let is_physical = tensor.iter().all(ComplexField::is_finite)
        && tensor == tensor.transpose()
        && tensor.cholesky().is_some();
    tensor.try_inverse().filter(|_| is_physical).map(|inverse| [tensor, inverse])
}

#[cfg(test)]
mod tests {
    extern crate std;

    use std::string::ToString as _;

    use super::*;

    #[test]
    fn the_first_number_outside_its_range_is_refused_with_all_that_is_known_of_it() {
        let numbers =
            [("a_s", 1.0_f32, 0.0, 2.0), ("b_t", 3e-7, 1e-9, 2e-7), ("c_s", 9.0, 0.0, 2.0)];
        let error = check(&numbers).unwrap_err();
        assert_eq!(error, OutOfRange { name: "b_t", found: 3e-7, from: 1e-9, to: 2e-7 });
        assert_eq!(error.to_string(), "b_t is 3e-7, it must be from 1e-9 to 2e-7");
    }

    #[test]
    fn both_ends_of_a_range_belong_to_it_and_no_nan_does() {
        // Neither end is a number of either precision.
        for end in [0.1, 0.3] {
            assert_eq!(check(&[("x", end as f32, 0.1, 0.3)]), Ok(()));
            assert_eq!(check(&[("x", end, 0.1, 0.3)]), Ok(()));
        }
        for bad in [0.099, 0.301, f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            assert_eq!(check(&[("x", bad, 0.1, 0.3)]).map_err(|it| it.name), Err("x"), "{bad}");
        }
    }

    #[test]
    fn only_the_tensor_of_a_body_is_accepted() {
        let rows = [[0.05, 0.001, 0.0], [0.001, 0.06, 0.0], [0.0, 0.0, 0.07_f32]];
        let [tensor, inverse] = inertia(rows).unwrap();
        assert_eq!(tensor.transpose(), Matrix3::from(rows));
        // Rounding of an f32.
        assert!((tensor * inverse - Matrix3::identity()).amax() < 1e-6);
        for (row, column, bad) in
            [(0, 1, 0.002), (2, 2, -0.07), (2, 2, 0.0), (1, 1, f32::NAN), (0, 0, f32::INFINITY)]
        {
            let mut rows = rows;
            rows[row][column] = bad;
            assert_eq!(inertia(rows), None, "{bad}");
        }
    }
}
