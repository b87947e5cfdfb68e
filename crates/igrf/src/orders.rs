//! The sums over all orders from 1. What they are stands in `evaluate.rs`.

use crate::Real;
use crate::evaluate::DEGREES;
use crate::lanes::{Four, Number, Total};

/// Sums over the orders from 1.
pub(crate) struct Sums<V> {
    /// Σ m A_nm (g Re ζᵐ⁻¹ + h Im ζᵐ⁻¹).
    pub(crate) gradient_x: V,
    /// Σ m A_nm (h Re ζᵐ⁻¹ − g Im ζᵐ⁻¹).
    pub(crate) gradient_y: V,
    /// D.
    pub(crate) d: V,
    /// F.
    pub(crate) f: V,
}

/// The sums up to `degree` at x, y, from coefficients as they are in
/// [`Scaled::rows`](crate::evaluate::Scaled), A_n1 in the place n−1 of `column`, and the factors
/// t (2n+1)(2n+3) in the place n of `steps`.
#[inline(always)]
pub(crate) fn sums<V: Number>(
    degree: usize,
    [x, y]: [V; 2],
    mut rows: &[Four<V::Real>],
    mut column: &mut [V],
    steps: &[V; DEGREES],
) -> Sums<V> {
    let mut totals = Totals::new(degree, x, y);
    let mut order = 1;
    while order < degree {
        let Some((here, others)) = rows.split_at_checked(DEGREES - order) else { break };
        let Some(steps) = steps.get(order..) else { break };
        let Some(here) = here.get(..=degree - order) else { break };
        V::add_two_orders(&mut totals, here, column, steps);
        column = column.get_mut(2..).unwrap_or(&mut []);
        rows = others;
        order += 2;
    }
    let mut sums = Sums {
        gradient_x: totals.gradient_x.value(),
        gradient_y: totals.gradient_y.value(),
        d: totals.d.value(),
        f: totals.f.value(),
    };
    // The last order of an odd degree has no partner, and one coefficient.
    if let (true, Some(&Four([g, _, h, _])), Some(&a)) =
        (order == degree, rows.first(), column.first())
    {
        let Four([re_below, _, im_below, _]) = totals.power_below;
        let (c, s) = (V::all(g) * a, V::all(h) * a);
        let along = c * re_below + s * im_below;
        let across = s * re_below - c * im_below;
        sums.gradient_x += V::all(totals.order) * along;
        sums.gradient_y += V::all(totals.order) * across;
        sums.f += V::all(totals.order + V::Real::ONE) * (x * along + y * across);
    }
    sums.f += x * sums.gradient_x + y * sums.gradient_y;
    sums
}

/// Sums over all orders from 1, and where they are.
///
/// In the order in which a compiler can treat the four lanes of each as one vector.
#[repr(C)]
pub struct Totals<V: Number> {
    /// Re ζᵐ⁻¹, Re ζᵐ, Im ζᵐ⁻¹, Im ζᵐ.
    power_below: Four<V>,
    gradient_x: <V::Real as Real>::Total<V>,
    gradient_y: <V::Real as Real>::Total<V>,
    d: <V::Real as Real>::Total<V>,
    f: <V::Real as Real>::Total<V>,
    /// ζ², by which the powers go from one pair of orders to the next.
    square: [V; 2],
    /// m of the next pair of orders m, m+1.
    order: V::Real,
    /// N+2.
    degree_plus_2: V::Real,
}

impl<V: Number> Totals<V> {
    #[inline(always)]
    fn new(degree: usize, x: V, y: V) -> Self {
        Self {
            power_below: Four([V::all(V::Real::ONE), x, V::zero(), y]),
            gradient_x: Total::zero(),
            gradient_y: Total::zero(),
            d: Total::zero(),
            f: Total::zero(),
            square: [x * x - y * y, (x + x) * y],
            order: V::Real::ONE,
            degree_plus_2: V::Real::from_f64((degree + 2) as f64),
        }
    }

    /// Multiplies the sums over n of two orders by ζᵐ, and adds them.
    #[inline(always)]
    fn add(&mut self, sums: &OrderSums<V>) {
        let [re, im] = self.square;
        let below = self.power_below;
        let next = Four::all(re) * below + Four([-im, -im, im, im]) * below.swapped();
        let (Four([_, re_0, _, im_0]), Four([re_1, _, im_1, _])) = (below, next);
        let here = Four([re_0, re_1, im_0, im_1]);
        let (m, m_plus_1) = (self.order, self.order + V::Real::ONE);
        let m_below = Four::of(Four([m, m_plus_1, m, m_plus_1])) * below;

        self.gradient_x.add(sums.plain * m_below);
        self.gradient_y.add_h_minus_g(sums.plain * m_below.swapped());
        self.d.add(sums.raised * here);
        self.f.add((Four::all(V::all(self.degree_plus_2)) * sums.plain - sums.partial) * here);

        self.power_below = next;
        self.order = m_plus_1 + V::Real::ONE;
    }

    /// Adds the orders m and m+1, and replaces A_nm for n = m, m+1, … in `column` by A_n,m+2: both
    /// orders in one loop.
    ///
    /// Out of line: once in memory, the totals are what the compiler forms its vectors from.
    #[inline(never)]
    pub(crate) fn add_at_once(&mut self, rows: &[Four<V::Real>], column: &mut [V], steps: &[V]) {
        let zero = Four::zero();
        let mut sums = OrderSums { plain: zero, partial: zero, raised: zero };
        // A_n,m+1 and A_n,m+2, and the same for the n before.
        let (mut next, mut before) = ([V::zero(); 2], [V::zero(); 2]);
        for ((&row, slot), &step) in rows.iter().zip(column).zip(steps) {
            let row = Four::of(row);
            let (a, [a_1, a_2], [before_1, before_2]) = (*slot, next, before);
            sums.plain += row * Four([a, a_1, a, a_1]);
            sums.partial += sums.plain;
            sums.raised += row * Four([a_1, a_2, a_1, a_2]);
            *slot = a_2;
            (next, before) = ([step * (before_1 + a), step * (before_2 + a_1)], next);
        }
        self.add(&sums);
    }

    /// The same, one order after the other: of several positions, the sums of one order are all
    /// that there are registers for.
    #[inline(never)]
    pub(crate) fn add_in_turn(&mut self, rows: &[Four<V::Real>], column: &mut [V], steps: &[V]) {
        let [mut first, mut second] = [OneOrder::zero(), OneOrder::zero()];
        for ((&Four([g, _, h, _]), slot), &step) in rows.iter().zip(&mut *column).zip(steps) {
            *slot = first.add([g, h], step, *slot);
        }
        for ((&Four([_, g, _, h]), slot), &step) in rows.iter().zip(column).zip(steps) {
            *slot = second.add([g, h], step, *slot);
        }
        let pair = |[g, h]: [V; 2], [g_next, h_next]: [V; 2]| Four([g, g_next, h, h_next]);
        self.add(&OrderSums {
            plain: pair(first.plain, second.plain),
            partial: pair(first.partial, second.partial),
            raised: pair(first.raised, second.raised),
        });
    }
}

/// Sums over n of two orders m, m+1, for g and for h.
struct OrderSums<V> {
    /// Σ g A_nm.
    plain: Four<V>,
    /// Sum of the partial sums of g A_nm.
    partial: Four<V>,
    /// Σ g A_n,m+1.
    raised: Four<V>,
}

/// The same of one order.
struct OneOrder<V> {
    plain: [V; 2],
    partial: [V; 2],
    raised: [V; 2],
    /// A_n,m+1, and the same for the n before.
    next: V,
    before: V,
}

impl<V: Number> OneOrder<V> {
    #[inline(always)]
    fn zero() -> Self {
        let none = [V::zero(); 2];
        Self { plain: none, partial: none, raised: none, next: V::zero(), before: V::zero() }
    }

    /// Adds one n, given A_nm, and returns A_n,m+1.
    #[inline(always)]
    fn add(&mut self, row: [V::Real; 2], step: V, a: V) -> V {
        let [g, h] = row.map(V::all);
        let a_1 = self.next;
        let add = |[of_g, of_h]: &mut [V; 2], [p, q]: [V; 2]| {
            *of_g += p;
            *of_h += q;
        };
        add(&mut self.plain, [g * a, h * a]);
        add(&mut self.partial, self.plain);
        add(&mut self.raised, [g * a_1, h * a_1]);
        self.next = step * (self.before + a);
        self.before = a_1;
        a_1
    }
}
