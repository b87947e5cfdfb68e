//! The field of prepared coefficients at a Cartesian position.
//!
//! With (x, y, z) Earth fixed in units of [`UNIT_KM`], r² = x² + y² + z², t = 1/r² and
//! ζ = x + iy, the potential of the main field is a sum of solid harmonics
//!
//! ```text
//! V = Σ_nm  A_nm (g_nm Re ζᵐ + h_nm Im ζᵐ),     A_nm = (2n+1)!! r^-(n+m+1) P_n⁽ᵐ⁾(z/r),
//! ```
//!
//! where P_n⁽ᵐ⁾ is the m-th derivative of the Legendre polynomial; the Schmidt normalisation, the
//! reference radius and 1/(2n+1)!! are in the prepared g, h. No angle occurs, so nothing is
//! singular at the poles.
//!
//! Order 1 comes from the three-term recursion of P′_n, each higher order from the one below by
//! P′_n+1 = P′_n−1 + (2n+1) P_n, differentiated m times:
//!
//! ```text
//! A_n+1,1   = t (2n+1)(2n+3)/n (z A_n,1 − (n+1) A_n−1,1)
//! A_n+1,m+1 = t (2n+1)(2n+3) (A_n−1,m+1 + A_n,m)
//! ```
//!
//! The factor (2n+1)!! is chosen so that the second needs one sum and one product.
//!
//! The field is B = −∇V. From ∂A_nm/∂z at constant r, and Euler's identity for the rest,
//!
//! ```text
//! B_x = x E − Σ m A_nm (g Re ζᵐ⁻¹ + h Im ζᵐ⁻¹)       E = t (F + z D)
//! B_y = y E − Σ m A_nm (h Re ζᵐ⁻¹ − g Im ζᵐ⁻¹)       F = Σ (n+m+1) A_nm (g Re ζᵐ + h Im ζᵐ)
//! B_z = z E − D                                      D = Σ A_n,m+1 (g Re ζᵐ + h Im ζᵐ)
//! ```
//!
//! For order 0, E is summed directly: its terms are g A_n+1,1 / (2n+3). For the others,
//! * sums over n come first, so that ζᵐ is multiplied once an order;
//! * the weight n in F costs one addition a term: Σ_n (N+1−n) p_n is the sum of the partial
//!   sums of p_m … p_N, and n+m+1 = (N+2) − (N+1−n) + m, where the m is Euler's identity for ζᵐ:
//!   Σ m A_nm (g Re ζᵐ + h Im ζᵐ) = x Σ m A_nm (g Re ζᵐ⁻¹ + …) + y Σ m A_nm (h Re ζᵐ⁻¹ − …);
//! * two orders go side by side, since A_n,m+1 is needed for both.
//!
//! Sources: Cunningham (1970), Celestial Mechanics 2, 207–216, and Montenbruck & Gill (2000),
//! §3.2.4, for solid harmonics in Cartesian form; Pines (1973), AIAA Journal 11, 1508–1511, for
//! derived Legendre functions and E. The scaling and the order of summation are our own.

use crate::lanes::{Four, Total};
use crate::{Error, Real};

/// Degrees 0 to 13.
pub(crate) const DEGREES: usize = 14;

/// Rows of coefficients: n = 1 … 13 for the orders 1 and 2, n = 3 … 13 for 3 and 4, …
pub(crate) const ROWS: usize = 13 + 11 + 9 + 7 + 5 + 3 + 1;

/// Unit of length of the evaluation, km. A power of two, so that scaling a position is exact;
/// near the Earth's radius, so that f32 neither overflows nor loses digits up to degree 13.
pub(crate) const UNIT_KM: f64 = 1024.0;

/// Positions below this distance from the Earth's centre are refused, km.
///
/// It is the radius of the core (PREM: Dziewonski & Anderson, 1981, Phys. Earth Planet. Inter.
/// 25, 297–356): inside, among the sources, the field is no gradient and the series diverges.
pub const MIN_RADIUS_KM: f64 = 3_480.0;

/// Positions above this distance from the Earth's centre are refused, km.
///
/// The Moon is nearer. The main field is below 0.1 nT there, a hundredth of that of the solar
/// wind; what is above is rather a position in metres.
pub const MAX_RADIUS_KM: f64 = 500_000.0;

/// (2n+1)(2n+3), by which the recursion from order to order is multiplied.
pub(crate) const fn order_ratio(n: usize) -> f64 {
    ((2 * n + 1) * (2 * n + 3)) as f64
}

/// (2n+1)(2n+3)/n, the factor of z A_n,1 in the recursion of order 1, from n = 1.
pub(crate) const fn degree_ratio(n: usize) -> f64 {
    if n == 0 { 0.0 } else { order_ratio(n) / n as f64 }
}

/// (2n+1)(2n+3)(n+1)/n, the factor of A_n−1,1 in the recursion of order 1, from n = 1.
pub(crate) const fn degree_ratio_before(n: usize) -> f64 {
    degree_ratio(n) * (n + 1) as f64
}

/// Gauss coefficients, scaled as in the module documentation, in the order of their use.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Scaled<T> {
    /// g_n0 and g_n0 / (2n+3) for n = 1 … 13.
    pub(crate) zonal: [[T; 2]; DEGREES - 1],
    /// (g_nm, g_n,m+1, h_nm, h_n,m+1) for m = 1, 3, … and n = m … 13.
    pub(crate) rows: [Four<T>; ROWS],
}

/// The field in nT, Earth-fixed, up to `degree` ≤ 13, at an Earth-fixed position in km.
pub(crate) fn field_nt<T: Real>(
    degree: usize,
    scaled: &Scaled<T>,
    position_km: [T; 3],
) -> Result<[T; 3], Error> {
    let [x, y, z] = position_km.map(|coordinate| coordinate * T::from_f64(1.0 / UNIT_KM));
    let radius_squared = x * x + y * y + z * z;
    if !(T::from_f64(in_units_squared(MIN_RADIUS_KM))
        ..=T::from_f64(in_units_squared(MAX_RADIUS_KM)))
        .contains(&radius_squared)
    {
        return Err(refusal(position_km));
    }
    let t = T::ONE / radius_squared;
    // Twice each: one for each of two orders.
    let steps = T::ORDER_RATIO.map(|ratio| [t * ratio; 2]);
    let [first_ratio, ..] = T::ORDER_RATIO;
    let a_00 = t * radius_squared.sqrt();

    let mut column = [T::ZERO; DEGREES];
    let (d_zonal, e_zonal) =
        zonal_sums(degree, &scaled.zonal, &mut column, [(t * first_ratio) * a_00, t * z, t]);

    let mut totals = Totals::new(degree, x, y);
    let mut rows = scaled.rows.as_slice();
    let mut column = column.as_mut_slice();
    let mut order = 1;
    while order < degree {
        let Some((here, others)) = rows.split_at_checked(DEGREES - order) else { break };
        let Some(steps) = steps.get(order..) else { break };
        let Some(here) = here.get(..=degree - order) else { break };
        add_two_orders(&mut totals, here, column, steps);
        column = column.get_mut(1..).unwrap_or(&mut []);
        rows = others;
        order += 2;
    }
    let mut sums = totals.values();
    // The last order of an odd degree has no partner, and one coefficient.
    if let (true, Some(Four([g, _, h, _])), Some(a)) =
        (order == degree, rows.first(), column.first())
    {
        let Four([re_below, _, im_below, _]) = totals.power_below;
        let (c, s) = (*g * *a, *h * *a);
        let along = c * re_below + s * im_below;
        let across = s * re_below - c * im_below;
        sums.gradient_x += totals.order * along;
        sums.gradient_y += totals.order * across;
        sums.f += (totals.order + T::ONE) * (x * along + y * across);
    }

    let f = sums.f + (x * sums.gradient_x + y * sums.gradient_y);
    let e = e_zonal + t * (f + z * sums.d);
    let d = d_zonal + sums.d;
    Ok([x * e - sums.gradient_x, y * e - sums.gradient_y, z * e - d])
}

const fn in_units_squared(radius_km: f64) -> f64 {
    (radius_km / UNIT_KM) * (radius_km / UNIT_KM)
}

#[cold]
#[inline(never)]
fn refusal<T: Real>(position_km: [T; 3]) -> Error {
    if !position_km.into_iter().all(T::is_finite) {
        return Error::NotFinite;
    }
    let [x, y, z] = position_km.map(T::to_f64);
    Error::Radius { radius_km: libm::hypot(libm::hypot(x, y), z) }
}

/// The share of order 0 in D and E; leaves A_n,1 for n = 1 … `degree` in `column`.
#[inline(always)]
fn zonal_sums<T: Real>(
    degree: usize,
    coefficients: &[[T; 2]; DEGREES - 1],
    column: &mut [T; DEGREES],
    [a_11, t_z, t]: [T; 3],
) -> (T, T) {
    let [_, ratios @ ..] = &T::DEGREE_RATIO;
    let [_, ratios_before @ ..] = &T::DEGREE_RATIO_BEFORE;
    let (mut a, mut a_before) = (a_11, T::ZERO);
    let (mut d, mut e) = (T::ZERO, T::ZERO);
    let degrees = coefficients.iter().zip(column).zip(ratios).zip(ratios_before);
    for (((&[g, g_of_e], slot), &ratio), &ratio_before) in degrees.take(degree) {
        *slot = a;
        let a_next = (t_z * ratio) * a - (t * ratio_before) * a_before;
        d += g * a;
        e += g_of_e * a_next;
        (a, a_before) = (a_next, a);
    }
    (d, e)
}

/// Sums over all orders from 1, and where they are.
///
/// In the order in which a compiler can treat the four lanes of each as one vector.
#[repr(C)]
struct Totals<T: Real> {
    /// Re ζᵐ⁻¹, Re ζᵐ, Im ζᵐ⁻¹, Im ζᵐ.
    power_below: Four<T>,
    gradient_x: T::Total,
    gradient_y: T::Total,
    d: T::Total,
    f: T::Total,
    /// ζ², by which the powers go from one pair of orders to the next.
    square: [T; 2],
    /// m of the next pair of orders m, m+1.
    order: T,
    /// N+2.
    degree_plus_2: T,
}

/// The sums of [`Totals`] over their lanes.
struct Sums<T> {
    gradient_x: T,
    gradient_y: T,
    d: T,
    f: T,
}

impl<T: Real> Totals<T> {
    #[inline(always)]
    fn new(degree: usize, x: T, y: T) -> Self {
        Self {
            power_below: Four([T::ONE, x, T::ZERO, y]),
            gradient_x: T::Total::ZERO,
            gradient_y: T::Total::ZERO,
            d: T::Total::ZERO,
            f: T::Total::ZERO,
            square: [x * x - y * y, (x + x) * y],
            order: T::ONE,
            degree_plus_2: T::from_f64((degree + 2) as f64),
        }
    }

    /// Multiplies the sums over n of two orders by ζᵐ, and adds them.
    #[inline(always)]
    fn add(&mut self, sums: &OrderSums<T>) {
        let [re, im] = self.square;
        let below = self.power_below;
        let next = Four::all(re) * below + Four([-im, -im, im, im]) * below.swapped();
        let (Four([_, re_0, _, im_0]), Four([re_1, _, im_1, _])) = (below, next);
        let here = Four([re_0, re_1, im_0, im_1]);
        let (m, m_plus_1) = (self.order, self.order + T::ONE);
        let m_below = Four([m, m_plus_1, m, m_plus_1]) * below;

        self.gradient_x.add(sums.plain * m_below);
        self.gradient_y.add_h_minus_g(sums.plain * m_below.swapped());
        self.d.add(sums.raised * here);
        self.f.add((Four::all(self.degree_plus_2) * sums.plain - sums.partial) * here);

        self.power_below = next;
        self.order = m_plus_1 + T::ONE;
    }

    #[inline(always)]
    fn values(&self) -> Sums<T> {
        Sums {
            gradient_x: self.gradient_x.value(),
            gradient_y: self.gradient_y.value(),
            d: self.d.value(),
            f: self.f.value(),
        }
    }
}

/// Sums over n of two orders m, m+1, for g and for h.
struct OrderSums<T> {
    /// Σ g A_nm.
    plain: Four<T>,
    /// Sum of the partial sums of g A_nm.
    partial: Four<T>,
    /// Σ g A_n,m+1.
    raised: Four<T>,
    /// A_n,m+1 and A_n,m+2 for the next n.
    next: [T; 2],
    /// The same for the n before.
    before: [T; 2],
}

impl<T: Real> OrderSums<T> {
    const ZERO: Self = Self {
        plain: Four::ZERO,
        partial: Four::ZERO,
        raised: Four::ZERO,
        next: [T::ZERO; 2],
        before: [T::ZERO; 2],
    };

    /// Adds one n, given A_nm, and returns A_n+1,m+2.
    #[inline(always)]
    fn add(&mut self, row: Four<T>, [step_1, step_2]: [T; 2], a: T) -> T {
        let ([a_1, a_2], [before_1, before_2]) = (self.next, self.before);
        self.plain += row * Four([a, a_1, a, a_1]);
        self.partial += self.plain;
        self.raised += row * Four([a_1, a_2, a_1, a_2]);
        self.before = self.next;
        self.next = [step_1 * (before_1 + a), step_2 * (before_2 + a_1)];
        let [_, raised_twice] = self.next;
        raised_twice
    }
}

/// Adds the orders m and m+1 to `totals`, and replaces A_nm for n = m, m+1, … in `column` by
/// A_n+1,m+2, so that the next pair of orders begins one place further on.
///
/// Out of line: once in memory, the totals are what the compiler forms its vectors from.
#[inline(never)]
fn add_two_orders<T: Real>(
    totals: &mut Totals<T>,
    rows: &[Four<T>],
    column: &mut [T],
    steps: &[[T; 2]],
) {
    let mut sums = OrderSums::ZERO;
    for ((&row, slot), &step) in rows.iter().zip(column).zip(steps) {
        *slot = sums.add(row, step, *slot);
    }
    totals.add(&sums);
}
