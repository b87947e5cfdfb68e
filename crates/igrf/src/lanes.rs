//! Four numbers side by side: g and h of two neighbouring orders.

use core::ops::{Add, AddAssign, Mul, Sub};

use crate::Real;

/// What the evaluation does to g and h of an order m and of the order m+1, at once:
/// lanes (g_m, g_m+1, h_m, h_m+1). Operations act on each lane.
///
/// Where a processor has vector registers the compiler uses them; elsewhere the two orders
/// still share their loop and their loads. Either way the bits are the same.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Four<T>(pub(crate) [T; 4]);

impl<T: Real> Four<T> {
    pub(crate) const ZERO: Self = Self([T::ZERO; 4]);

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
        impl<T: Real> $trait for Four<T> {
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

impl<T: Real> AddAssign for Four<T> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

/// A sum over all orders, kept in as many lanes as fill a vector register of 128 bits: a type
/// for f32 and one for f64.
pub trait Total<T>: Copy {
    /// Nothing summed yet.
    const ZERO: Self;

    /// Adds all lanes.
    fn add(&mut self, term: Four<T>);

    /// Adds the lanes of h and subtracts those of g.
    fn add_h_minus_g(&mut self, term: Four<T>);

    /// The sum.
    fn value(&self) -> T;
}

impl<T: Real> Total<T> for Four<T> {
    const ZERO: Self = Self([T::ZERO; 4]);

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

impl<T: Real> Total<T> for Two<T> {
    const ZERO: Self = Self([T::ZERO; 2]);

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
