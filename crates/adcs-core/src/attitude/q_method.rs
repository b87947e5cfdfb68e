//! Davenport's q-method: the eigenvector of K for its largest eigenvalue.
//!
//! λ comes from the characteristic polynomial ([`davenport`](super::davenport)), and the vector
//! from the adjugate: as (K − λI) adj(K − λI) = det(K − λI) I = 0, each column of adj(K − λI) is a
//! multiple of the eigenvector. The longest is taken, so that no rotation is singular.
//!
//! Why no general eigen-solver: on the flight core, in f32, nalgebra's for symmetric 4×4 matrices
//! takes some 4,600 instructions, for four eigenvectors of which three are thrown away; the whole of
//! this method, with the proof of its optimum and the covariance, takes 2,000. λ lies just below 1,
//! where Newton's method needs two or three steps of a dozen operations, and the adjugate is eleven
//! 2×2 minors. Nothing is lost: either way q is good to about ε / margin, which is what rounding of K
//! itself does to it.
//!
//! Source: Davenport's method after Markley & Crassidis (2014), §5.3.1.

use nalgebra::{Matrix4, Quaternion, RealField, UnitQuaternion, Vector4};

use super::davenport::Profile;
use super::number;

/// The adjugate's diagonal is a product of three gaps between eigenvalues: below this many ε it is
/// rounding.
const ROUNDINGS: f64 = 8.0;

/// The attitude, from Eci to Body; `None` when K does not contain one in this precision.
pub(super) fn attitude<T: RealField + Copy>(profile: &Profile<T>) -> Option<UnitQuaternion<T>> {
    let m = profile.k() - Matrix4::identity() * profile.lambda;
    let longest = columns_of_adjugate(&m)
        .into_iter()
        .reduce(|best, next| if next.norm_squared() > best.norm_squared() { next } else { best })?;
    let norm = longest.norm();
    if norm <= number::<T>(ROUNDINGS) * T::default_epsilon() {
        return None;
    }
    // The eigenvector is the textbook attitude quaternion; Hamilton's is its conjugate.
    let [x, y, z, w] = (longest / norm).into();
    Some(UnitQuaternion::new_unchecked(Quaternion::new(w, -x, -y, -z)))
}

/// The adjugate of a symmetric matrix, column by column, by Laplace expansion along its first two
/// and last two rows: `u` holds 2×2 minors of rows 1, 2 and `l` those of rows 3, 4.
fn columns_of_adjugate<T: RealField + Copy>(m: &Matrix4<T>) -> [Vector4<T>; 4] {
    let u12 = m.m11 * m.m22 - m.m12 * m.m21;
    let u13 = m.m11 * m.m23 - m.m13 * m.m21;
    let u14 = m.m11 * m.m24 - m.m14 * m.m21;
    let u23 = m.m12 * m.m23 - m.m13 * m.m22;
    let u24 = m.m12 * m.m24 - m.m14 * m.m22;
    let u34 = m.m13 * m.m24 - m.m14 * m.m23;
    let l13 = m.m31 * m.m43 - m.m33 * m.m41;
    let l14 = m.m31 * m.m44 - m.m34 * m.m41;
    let l23 = m.m32 * m.m43 - m.m33 * m.m42;
    let l24 = m.m32 * m.m44 - m.m34 * m.m42;
    let l34 = m.m33 * m.m44 - m.m34 * m.m43;
    let a12 = m.m13 * l24 - m.m12 * l34 - m.m14 * l23;
    let a13 = m.m42 * u34 - m.m43 * u24 + m.m44 * u23;
    let a14 = m.m33 * u24 - m.m32 * u34 - m.m34 * u23;
    let a23 = m.m43 * u14 - m.m41 * u34 - m.m44 * u13;
    let a24 = m.m31 * u34 - m.m33 * u14 + m.m34 * u13;
    let a34 = m.m32 * u14 - m.m31 * u24 - m.m34 * u12;
    [
        Vector4::new(m.m22 * l34 - m.m23 * l24 + m.m24 * l23, a12, a13, a14),
        Vector4::new(a12, m.m11 * l34 - m.m13 * l14 + m.m14 * l13, a23, a24),
        Vector4::new(a13, a23, m.m41 * u24 - m.m42 * u14 + m.m44 * u12, a34),
        Vector4::new(a14, a24, a34, m.m31 * u23 - m.m32 * u13 + m.m33 * u12),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Rounding of sums of products of four numbers below one.
    const ROUNDING: f64 = 1e-14;

    proptest! {
        #[test]
        fn a_symmetric_matrix_times_its_adjugate_is_its_determinant(
            x in [-1.0..1.0_f64, -1.0..1.0, -1.0..1.0, -1.0..1.0, -1.0..1.0],
            y in [-1.0..1.0_f64, -1.0..1.0, -1.0..1.0, -1.0..1.0, -1.0..1.0],
        ) {
            let ([a, b, c, d, e], [f, g, h, i, j]) = (x, y);
            let m = Matrix4::new(a, b, c, d, b, e, f, g, c, f, h, i, d, g, i, j);
            let adjugate = Matrix4::from_columns(&columns_of_adjugate(&m));
            let product = m * adjugate - Matrix4::identity() * m.determinant();
            prop_assert!(product.norm() < ROUNDING, "{product}");
        }
    }
}
