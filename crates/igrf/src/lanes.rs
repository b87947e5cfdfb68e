//! Numbers side by side: of several positions, and g and h of two neighbouring orders.

use core::ops::{Add, AddAssign, Div, Mul, Neg, Sub};

use crate::Real;
use crate::orders::Totals;

/// What the evaluation computes with: one number, or one for each of several positions.
pub trait Number:
    Copy
    + Add<Output = Self>
    + AddAssign
    + Div<Output = Self>
    + Mul<Output = Self>
    + Neg<Output = Self>
    + Sub<Output = Self>
{
    /// The type of one number, and of the coefficients.
    type Real: Real;

    /// The same number for each position.
    fn all(value: Self::Real) -> Self;

    /// Square root.
    fn square_root(self) -> Self;

    /// What [`Totals`] does for each pair of orders, in the way that suits the registers.
    fn add_two_orders(
        totals: &mut Totals<Self>,
        rows: &[Four<Self::Real>],
        column: &mut [Self],
        steps: &[Self],
    );

    /// 0 for each position.
    #[inline(always)]
    fn zero() -> Self {
        Self::all(Self::Real::ZERO)
    }
}

/// Numbers of `W` positions. Operations act on each lane as they do on a number alone, so each
/// lane has the bits that it would have alone.
#[derive(Clone, Copy)]
#[repr(align(16))]
pub struct Lanes<T, const W: usize>(pub(crate) [T; W]);

impl<T: Real, const W: usize> Number for Lanes<T, W> {
    type Real = T;

    #[inline(always)]
    fn all(value: T) -> Self {
        Self([value; W])
    }

    #[inline(always)]
    fn square_root(self) -> Self {
        Self(self.0.map(T::square_root))
    }

    #[inline(always)]
    fn add_two_orders(
        totals: &mut Totals<Self>,
        rows: &[Four<Self::Real>],
        column: &mut [Self],
        steps: &[Self],
    ) {
        totals.add_in_turn(rows, column, steps);
    }
}

impl<T: Real, const W: usize> Neg for Lanes<T, W> {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self(self.0.map(T::neg))
    }
}

impl<T: Real, const W: usize> AddAssign for Lanes<T, W> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

macro_rules! position_by_position {
    ($trait:ident, $method:ident, $operator:tt) => {
        impl<T: Real, const W: usize> $trait for Lanes<T, W> {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                let Self(mut lanes) = self;
                for (lane, (a, b)) in lanes.iter_mut().zip(self.0.into_iter().zip(other.0)) {
                    *lane = a $operator b;
                }
                Self(lanes)
            }
        }
    };
}

position_by_position!(Add, add, +);
position_by_position!(Sub, sub, -);
position_by_position!(Mul, mul, *);
position_by_position!(Div, div, /);

/// What the evaluation does to g and h of an order m and of the order m+1, at once:
/// lanes (g_m, g_m+1, h_m, h_m+1). Operations act on each lane.
///
/// Where a processor has vector registers the compiler uses them; elsewhere the two orders
/// still share their loop and their loads. Either way the bits are the same.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Four<T>(pub(crate) [T; 4]);

impl<T: Number> Four<T> {
    /// All lanes zero.
    #[inline(always)]
    pub(crate) fn zero() -> Self {
        Self([T::zero(); 4])
    }

    /// The same coefficients for each position.
    #[inline(always)]
    pub(crate) fn of(Four(row): Four<T::Real>) -> Self {
        Self(row.map(T::all))
    }

    /// All lanes the same.
    #[inline(always)]
    pub(crate) fn all(value: T) -> Self {
        Self([value; 4])
    }

    /// (h, g) instead of (g, h).
    #[inline(always)]
    pub(crate) fn swapped(self) -> Self {
        let Self([a, b, c, d]) = self;
        Self([c, d, a, b])
    }
}

macro_rules! lane_by_lane {
    ($trait:ident, $method:ident, $operator:tt) => {
        impl<T: Number> $trait for Four<T> {
            type Output = Self;

            #[inline(always)]
            fn $method(self, Self([e, f, g, h]): Self) -> Self {
                let Self([a, b, c, d]) = self;
                Self([a $operator e, b $operator f, c $operator g, d $operator h])
            }
        }
    };
}

lane_by_lane!(Add, add, +);
lane_by_lane!(Sub, sub, -);
lane_by_lane!(Mul, mul, *);

impl<T: Number> AddAssign for Four<T> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

/// A sum over all orders, kept in as many lanes as fill a vector register of 128 bits: a type
/// for f32 and one for f64.
pub trait Total<T>: Copy {
    /// Nothing summed yet.
    fn zero() -> Self;

    /// Adds all lanes.
    fn add(&mut self, term: Four<T>);

    /// Adds the lanes of h and subtracts those of g.
    fn add_h_minus_g(&mut self, term: Four<T>);

    /// The sum.
    fn value(&self) -> T;
}

impl<T: Number> Total<T> for Four<T> {
    #[inline(always)]
    fn zero() -> Self {
        Self::zero()
    }

    #[inline(always)]
    fn add(&mut self, term: Four<T>) {
        *self += term;
    }

    #[inline(always)]
    fn add_h_minus_g(&mut self, Four([a, b, c, d]): Four<T>) {
        *self += Four([-a, -b, c, d]);
    }

    #[inline(always)]
    fn value(&self) -> T {
        let Self([a, b, c, d]) = *self;
        (a + b) + (c + d)
    }
}

/// A sum in two lanes: of the order m and of the order m+1.
#[derive(Clone, Copy)]
pub struct Two<T>([T; 2]);

impl<T: Number> Total<T> for Two<T> {
    #[inline(always)]
    fn zero() -> Self {
        Self([T::zero(); 2])
    }

    #[inline(always)]
    fn add(&mut self, Four([a, b, c, d]): Four<T>) {
        let Self([first, second]) = *self;
        *self = Self([first + (a + c), second + (b + d)]);
    }

    #[inline(always)]
    fn add_h_minus_g(&mut self, Four([a, b, c, d]): Four<T>) {
        let Self([first, second]) = *self;
        *self = Self([first + (c - a), second + (d - b)]);
    }

    #[inline(always)]
    fn value(&self) -> T {
        let Self([first, second]) = *self;
        first + second
    }
}
