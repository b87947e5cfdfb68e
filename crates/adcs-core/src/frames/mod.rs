//! Reference frames in the type system: a vector knows in which axes its components stand.
//!
//! Parameters stand in matrix order, so neighbouring letters cancel as in a book:
//! `Rotation<Body, Eci> * Vector<Eci>` gives `Vector<Body>`. The wrong product does not compile:
//!
//! ```compile_fail
//! use adcs_core::frames::{Body, Eci, Rotation, Vector};
//! let r_bi: Rotation<Body, Eci> = Rotation::identity();
//! let v_b: Vector<Body> = Vector::new(1.0, 0.0, 0.0);
//! let wrong = r_bi * v_b; // r_bi wants a Vector<Eci>
//! ```
//!
//! ```
//! use adcs_core::frames::{Body, Eci, Rotation, Vector};
//! let r_bi: Rotation<Body, Eci> = Rotation::identity();
//! let v_i: Vector<Eci> = Vector::new(1.0, 0.0, 0.0);
//! let v_b: Vector<Body> = r_bi * v_i;
//! # assert_eq!(v_b, Vector::new(1.0, 0.0, 0.0));
//! ```
//!
//! | frame | axes |
//! |---|---|
//! | [`Eci`] | TEME of date, as SGP4 gives it |
//! | [`Ecef`] | Earth fixed, pseudo (PEF): TEME turned by GMST-82 about z |
//! | [`Orbit`] | Z to the Earth's centre, X in the orbit plane on the side of flight, Y against the orbit normal |
//! | [`Body`] | the structure |
//! | [`Target`] | where Body should be |
//! | [`MagnetometerAxes`], [`GyroAxes`], [`TorquerAxes`] | each unit's own axes, before alignment |
//! | [`SunFaceAxes`] | those of one Sun sensor: z out of the face, x and y along its diode |

mod permutation;

use core::fmt;
use core::marker::PhantomData;
use core::ops::{Add, Mul, Neg, Sub};

use nalgebra::{ComplexField, Matrix3, Quaternion, RealField, Unit, UnitQuaternion, Vector3};

pub use permutation::{PermutationError, SignedPermutation};

macro_rules! frames {
    ($($(#[$doc:meta])* $name:ident),* $(,)?) => {
        $($(#[$doc])* #[derive(Debug, Clone, Copy, PartialEq, Eq)] pub enum $name {})*
    };
}

frames! {
    /// True equator, mean equinox of date (TEME): the working inertial frame.
    Eci,
    /// Earth fixed: TEME turned by Greenwich mean sidereal time (PEF; polar motion ignored).
    Ecef,
    /// The paper's reference frame (its fig. 3.2).
    Orbit,
    /// The satellite's structure.
    Body,
    /// The axes that Body should take.
    Target,
    /// The magnetometer's own axes.
    MagnetometerAxes,
    /// The axes along which the three single-axis gyros measure.
    GyroAxes,
    /// The axes of the three magnetic torquers.
    TorquerAxes,
    /// The axes of one Sun sensor: z out of the face, through the pinhole; x and y along its diode.
    SunFaceAxes,
}

/// Three components in the axes of `F`; the unit stands in the doc line of whoever holds one.
#[repr(transparent)]
pub struct Vector<F, T = f32> {
    /// The components, for kernels that work on bare nalgebra.
    pub xyz: Vector3<T>,
    frame: PhantomData<F>,
}

impl<F, T: RealField + Copy> Vector<F, T> {
    /// The vector with these components.
    pub fn new(x: T, y: T, z: T) -> Self {
        Self::from_xyz(Vector3::new(x, y, z))
    }

    /// Wraps bare components; the caller vouches for the frame.
    pub fn from_xyz(xyz: Vector3<T>) -> Self {
        Self { xyz, frame: PhantomData }
    }

    /// The zero vector.
    pub fn zero() -> Self {
        Self::from_xyz(Vector3::zeros())
    }

    /// The components as a plain array, for records and files.
    pub fn to_array(&self) -> [T; 3] {
        [self.xyz.x, self.xyz.y, self.xyz.z]
    }

    /// `self × other`.
    pub fn cross(&self, other: &Self) -> Self {
        Self::from_xyz(self.xyz.cross(&other.xyz))
    }

    /// `self · other`.
    pub fn dot(&self, other: &Self) -> T {
        self.xyz.dot(&other.xyz)
    }

    /// Euclidean length, in the components' unit.
    pub fn norm(&self) -> T {
        self.xyz.norm()
    }

    /// True when no component is NaN or infinite.
    pub fn is_finite(&self) -> bool {
        self.xyz.iter().all(ComplexField::is_finite)
    }

    /// The same components taken to be along the axes of another frame: for units that are mounted
    /// so by construction. Everything else goes through a [`Rotation`].
    pub fn relabel<G>(self) -> Vector<G, T> {
        Vector::from_xyz(self.xyz)
    }

    /// The direction of this vector; `None` when its length is zero or not finite.
    pub fn direction(&self) -> Option<Direction<F, T>> {
        Direction::new(*self)
    }
}

impl<F> Vector<F, f64> {
    /// The same vector in single precision: the one-line border between orbit and attitude.
    pub fn to_f32(&self) -> Vector<F, f32> {
        Vector::new(self.xyz.x as f32, self.xyz.y as f32, self.xyz.z as f32)
    }
}

impl<F> Vector<F, f32> {
    /// The same vector in double precision (exact).
    pub fn to_f64(&self) -> Vector<F, f64> {
        Vector::new(f64::from(self.xyz.x), f64::from(self.xyz.y), f64::from(self.xyz.z))
    }
}

impl<F, T: Copy> Clone for Vector<F, T> {
    fn clone(&self) -> Self {
        *self
    }
}
impl<F, T: Copy> Copy for Vector<F, T> {}
impl<F, T: RealField> PartialEq for Vector<F, T> {
    fn eq(&self, other: &Self) -> bool {
        self.xyz == other.xyz
    }
}
impl<F, T: fmt::Debug> fmt::Debug for Vector<F, T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Vector").field(&self.xyz.as_slice()).finish()
    }
}
impl<F, T: RealField + Copy> Add for Vector<F, T> {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self::from_xyz(self.xyz + other.xyz)
    }
}
impl<F, T: RealField + Copy> Sub for Vector<F, T> {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self::from_xyz(self.xyz - other.xyz)
    }
}
impl<F, T: RealField + Copy> Neg for Vector<F, T> {
    type Output = Self;
    fn neg(self) -> Self {
        Self::from_xyz(-self.xyz)
    }
}
impl<F, T: RealField + Copy> Mul<T> for Vector<F, T> {
    type Output = Self;
    fn mul(self, scale: T) -> Self {
        Self::from_xyz(self.xyz * scale)
    }
}

/// A unit vector in the axes of `F`.
#[derive(Debug)]
#[repr(transparent)]
pub struct Direction<F, T = f32> {
    unit: Vector<F, T>,
}

impl<F, T: RealField + Copy> Direction<F, T> {
    /// Normalises `v`; `None` when its length is zero, subnormal or not finite.
    pub fn new(v: Vector<F, T>) -> Option<Self> {
        let norm = v.norm();
        let usable = norm.is_finite() && norm > T::default_epsilon().powi(4);
        usable.then(|| Self { unit: Vector::from_xyz(v.xyz / norm) })
    }

    /// Wraps components whose length is one by construction; the caller vouches for it.
    pub(crate) fn from_unit(unit: Vector<F, T>) -> Self {
        Self { unit }
    }

    /// The unit vector.
    pub fn vector(&self) -> Vector<F, T> {
        self.unit
    }
}

impl<F, T: Copy> Clone for Direction<F, T> {
    fn clone(&self) -> Self {
        *self
    }
}
impl<F, T: Copy> Copy for Direction<F, T> {}

/// Re-expresses components: `v_a = r_ab * v_b`, `r_ac = r_ab * r_bc`.
///
/// Held as the Hamilton unit quaternion q with `v_to = q ⊗ v_from ⊗ q*`. The attitude is
/// `r_bi: Rotation<Body, Eci>`.
#[repr(transparent)]
pub struct Rotation<To, From, T: nalgebra::Scalar = f32> {
    q: UnitQuaternion<T>,
    frames: PhantomData<(To, From)>,
}

impl<To, From, T: RealField + Copy> Rotation<To, From, T> {
    /// Both frames have the same axes.
    pub fn identity() -> Self {
        Self::from_hamilton(UnitQuaternion::identity())
    }

    /// From the Hamilton quaternion q with `v_to = q ⊗ v_from ⊗ q*`.
    pub fn from_hamilton(q: UnitQuaternion<T>) -> Self {
        Self { q, frames: PhantomData }
    }

    /// The Hamilton quaternion q with `v_to = q ⊗ v_from ⊗ q*`.
    pub fn hamilton(&self) -> UnitQuaternion<T> {
        self.q
    }

    /// From the textbook attitude quaternion `[q_x, q_y, q_z, q_w]`, scalar last, with
    /// `v_to = A(q) v_from` (Markley & Crassidis (2014), eq. (2.125)). It is normalised;
    /// `None` when its norm is zero or not finite.
    ///
    /// The same four numbers as a Hamilton quaternion are the conjugate of [`hamilton`](Self::hamilton).
    pub fn from_attitude_quaternion(xyzw: [T; 4]) -> Option<Self> {
        let [x, y, z, w] = xyzw;
        let q = Quaternion::new(w, x, y, z);
        let norm = q.norm();
        let usable = norm.is_finite() && norm > T::default_epsilon();
        usable.then(|| Self::from_hamilton(Unit::new_normalize(q).conjugate()))
    }

    /// The textbook attitude quaternion `[q_x, q_y, q_z, q_w]`, scalar last, `q_w ≥ 0`.
    pub fn attitude_quaternion(&self) -> [T; 4] {
        let q = self.q.conjugate();
        let sign = if q.w < T::zero() { -T::one() } else { T::one() };
        [q.i * sign, q.j * sign, q.k * sign, q.w * sign]
    }

    /// The way back.
    pub fn inverse(&self) -> Rotation<From, To, T> {
        Rotation::from_hamilton(self.q.conjugate())
    }

    /// The direction-cosine matrix A with `v_to = A v_from`.
    pub fn matrix(&self) -> Matrix3<T> {
        self.q.to_rotation_matrix().into_inner()
    }

    /// The angle by which the frames differ, rad, 0 to π.
    pub fn angle_rad(&self) -> T {
        self.q.angle()
    }
}

impl<To, From, T: RealField + Copy> Clone for Rotation<To, From, T> {
    fn clone(&self) -> Self {
        *self
    }
}
impl<To, From, T: RealField + Copy> Copy for Rotation<To, From, T> {}
impl<To, From, T: RealField> fmt::Debug for Rotation<To, From, T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Rotation").field(&self.q.as_ref().coords).finish()
    }
}
impl<A, B, T: RealField + Copy> Mul<Vector<B, T>> for Rotation<A, B, T> {
    type Output = Vector<A, T>;
    fn mul(self, v: Vector<B, T>) -> Vector<A, T> {
        Vector::from_xyz(self.q * v.xyz)
    }
}
impl<A, B, C, T: RealField + Copy> Mul<Rotation<B, C, T>> for Rotation<A, B, T> {
    type Output = Rotation<A, C, T>;
    fn mul(self, r: Rotation<B, C, T>) -> Rotation<A, C, T> {
        Rotation::from_hamilton(self.q * r.q)
    }
}
impl<A, B, T: RealField + Copy> Mul<Direction<B, T>> for Rotation<A, B, T> {
    type Output = Direction<A, T>;
    fn mul(self, d: Direction<B, T>) -> Direction<A, T> {
        Direction { unit: self * d.unit }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rounding of a few f64 products of order one.
    const ROUNDING: f64 = 1e-15;

    #[test]
    fn a_body_yawed_by_90_deg_sees_inertial_y_along_its_x() {
        let half = core::f64::consts::FRAC_1_SQRT_2;
        let r_bi: Rotation<Body, Eci, f64> =
            Rotation::from_attitude_quaternion([0.0, 0.0, half, half]).unwrap();
        let v_b = r_bi * Vector::new(0.0, 1.0, 0.0);
        assert!((v_b.xyz - Vector3::new(1.0, 0.0, 0.0)).norm() < ROUNDING);
        let exported = r_bi.attitude_quaternion();
        assert!((exported[2] - half).abs() < ROUNDING && (exported[3] - half).abs() < ROUNDING);
    }

    #[test]
    fn the_exported_quaternion_gives_the_textbook_attitude_matrix() {
        let q = [0.1, -0.7, 0.3, -0.4];
        let r: Rotation<Body, Eci, f64> = Rotation::from_attitude_quaternion(q).unwrap();
        let [x, y, z, w] = r.attitude_quaternion();
        assert!(w >= 0.0);
        let e = Vector3::new(x, y, z);
        // A(q) = (w² − |e|²) I + 2 e eᵀ − 2 w [e×]
        let a = Matrix3::identity() * (w * w - e.norm_squared()) + e * e.transpose() * 2.0
            - e.cross_matrix() * (2.0 * w);
        assert!((a - r.matrix()).norm() < 10.0 * ROUNDING);
    }

    #[test]
    fn inverse_undoes_the_rotation() {
        let r: Rotation<Body, Eci, f64> =
            Rotation::from_attitude_quaternion([0.4, 0.1, -0.2, 0.9]).unwrap();
        let v = Vector::new(1.0, -2.0, 3.0);
        assert!(((r.inverse() * (r * v)) - v).norm() < 10.0 * ROUNDING);
    }

    #[test]
    fn zero_and_non_finite_inputs_give_no_direction_and_no_rotation() {
        for bad in [0.0_f32, f32::NAN, f32::INFINITY] {
            assert!(Vector::<Body>::new(bad, 0.0, 0.0).direction().is_none());
            assert!(
                Rotation::<Body, Eci, f32>::from_attitude_quaternion([bad, 0.0, 0.0, 0.0])
                    .is_none()
            );
        }
    }
}
