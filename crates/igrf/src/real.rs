//! The two floating-point types in which the field is evaluated.

use core::ops::{Add, AddAssign, Div, Mul, Neg, Sub};

use crate::evaluate::{DEGREES, degree_ratio, degree_ratio_before, order_ratio};
use crate::lanes::{Four, Number, Total, Two};
use crate::orders::Totals;

/// A floating-point type in which the field can be evaluated: `f32` or `f64`.
///
/// The trait is sealed. Functions come from `libm` on every machine, so a host and a
/// microcontroller give the same bits.
pub trait Real:
    sealed::Sealed
    + Copy
    + Default
    + PartialOrd
    + core::fmt::Debug
    + Add<Output = Self>
    + AddAssign
    + Div<Output = Self>
    + Mul<Output = Self>
    + Neg<Output = Self>
    + Sub<Output = Self>
    + Number<Real = Self>
    + 'static
{
    /// 0.
    const ZERO: Self;
    /// 1.
    const ONE: Self;
    /// π/2, the largest latitude in radians.
    const HALF_PI: Self;
    /// π, the largest colatitude in radians.
    const PI: Self;
    /// (2n+1)(2n+3) for n = 0, 1, …
    #[doc(hidden)]
    const ORDER_RATIO: [Self; DEGREES];
    /// (2n+1)(2n+3)/n for n = 1, 2, …
    #[doc(hidden)]
    const DEGREE_RATIO: [Self; DEGREES];
    /// (2n+1)(2n+3)(n+1)/n for n = 1, 2, …
    #[doc(hidden)]
    const DEGREE_RATIO_BEFORE: [Self; DEGREES];
    /// How sums over all orders are kept.
    #[doc(hidden)]
    type Total<V: Number<Real = Self>>: Total<V>;

    /// The nearest value to `value`.
    fn from_f64(value: f64) -> Self;
    /// This value, without loss.
    fn to_f64(self) -> f64;
    /// Square root.
    fn sqrt(self) -> Self;
    /// Sine and cosine of an angle in radians.
    fn sin_cos(self) -> (Self, Self);
    /// Neither infinite nor NaN.
    fn is_finite(self) -> bool;
}

mod sealed {
    pub trait Sealed {}
    impl Sealed for f32 {}
    impl Sealed for f64 {}
}

macro_rules! real {
    ($type:ident, $sqrt:path, $sincos:path, $total:ident) => {
        impl Number for $type {
            type Real = Self;

            #[inline(always)]
            fn all(value: Self) -> Self {
                value
            }
            // Out of line: in a build for AVX, libm's instruction has the encoding of SSE, and that
            // costs 130 ns amid wide registers. They are left behind at a call.
            #[inline(never)]
            fn square_root(self) -> Self {
                $sqrt(self)
            }
            #[inline(always)]
            fn add_two_orders(
                totals: &mut Totals<Self>,
                rows: &[Four<Self>],
                column: &mut [Self],
                steps: &[Self],
            ) {
                totals.add_at_once(rows, column, steps);
            }
        }

        impl Real for $type {
            const ZERO: Self = 0.0;
            const ONE: Self = 1.0;
            const HALF_PI: Self = core::$type::consts::FRAC_PI_2;
            const PI: Self = core::$type::consts::PI;
            const ORDER_RATIO: [Self; DEGREES] = table!($type, order_ratio);
            const DEGREE_RATIO: [Self; DEGREES] = table!($type, degree_ratio);
            const DEGREE_RATIO_BEFORE: [Self; DEGREES] = table!($type, degree_ratio_before);
            type Total<V: Number<Real = Self>> = $total<V>;

            fn from_f64(value: f64) -> Self {
                value as $type
            }
            fn to_f64(self) -> f64 {
                f64::from(self)
            }
            fn sqrt(self) -> Self {
                $sqrt(self)
            }
            fn sin_cos(self) -> (Self, Self) {
                $sincos(self)
            }
            fn is_finite(self) -> bool {
                $type::is_finite(self)
            }
        }
    };
}

macro_rules! table {
    ($type:ident, $term:path) => {{
        let mut table = [0.0; DEGREES];
        let mut n = 0;
        while n < DEGREES {
            // An index out of range would not compile.
            #[allow(clippy::indexing_slicing)]
            {
                table[n] = $term(n) as $type;
            }
            n += 1;
        }
        table
    }};
}

real!(f32, libm::sqrtf, libm::sincosf, Four);
real!(f64, libm::sqrt, libm::sincos, Two);
