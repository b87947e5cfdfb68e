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
//! Order 0 comes from the three-term recursion of the Legendre polynomials, each higher order
//! from the one below by P′_n+1 = P′_n−1 + (2n+1) P_n, differentiated m−1 times:
//!
//! ```text
//! A_n+1,0 = t (2n+1)(2n+3)/(n+1) (z A_n,0 − n A_n−1,0)
//! A_n+1,m = t (2n+1)(2n+3) (A_n−1,m + A_n,m−1)
//! ```
//!
//! The factor (2n+1)!! is chosen so that the second needs one sum and one product. Its terms
//! never grow from cancellation: errors of order n−1 enter with weight one.
//!
//! The field is B = −∇V. From ∂A_nm/∂z at constant r, and Euler's identity for the rest,
//!
//! ```text
//! B_x = x E − Σ m A_nm (g Re ζᵐ⁻¹ + h Im ζᵐ⁻¹)       E = t (F + z D)
//! B_y = y E − Σ m A_nm (h Re ζᵐ⁻¹ − g Im ζᵐ⁻¹)       F = Σ (n+m+1) A_nm (g Re ζᵐ + h Im ζᵐ)
//! B_z = z E − D                                      D = Σ A_n,m+1 (g Re ζᵐ + h Im ζᵐ)
//! ```
//!
//! Sums over n come first, so that ζᵐ is multiplied once an order. The weight n in F costs one
//! addition: Σ_n (N+1−n) p_n is the sum of the partial sums of p.
//!
//! Sources: Cunningham (1970), Celestial Mechanics 2, 207–216, and Montenbruck & Gill (2000),
//! §3.2.4, for solid harmonics in Cartesian form; Pines (1973), AIAA Journal 11, 1508–1511, for
//! derived Legendre functions and E. The scaling and the order of summation are our own.

use crate::{Error, Real};

/// Degrees 0 to 13.
pub(crate) const DEGREES: usize = 14;
/// Pairs (g, h) with 1 ≤ n ≤ 13, 0 ≤ m ≤ n.
pub(crate) const PAIRS: usize = DEGREES * (DEGREES + 1) / 2 - 1;

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
/// The Moon is nearer. The main field is below 0.1 nT there, a thousandth of that of the solar
/// wind; a position above it is rather one in metres.
pub const MAX_RADIUS_KM: f64 = 500_000.0;

/// (2n+1)(2n+3), the ratio (2n+3)!!/(2n−1)!! of the recursion in n.
pub(crate) const fn legendre_ratio(n: usize) -> f64 {
    ((2 * n + 1) * (2 * n + 3)) as f64
}

/// (2n+1)(2n+3)/(n+1), the same for order zero.
pub(crate) const fn zonal_ratio(n: usize) -> f64 {
    legendre_ratio(n) / (n + 1) as f64
}

/// Gauss coefficients (g, h) scaled as in the module documentation: by order, then by degree.
pub(crate) type Pairs<T> = [[T; 2]; PAIRS];

/// The field in nT, Earth-fixed, up to `degree` ≤ 13, at an Earth-fixed position in km.
pub(crate) fn field_nt<T: Real>(
    degree: usize,
    pairs: &Pairs<T>,
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
    let steps = T::LEGENDRE_RATIO.map(|ratio| t * ratio);

    let mut column = [T::ZERO; DEGREES];
    let (zonal_pairs, mut pairs) = pairs.split_at(DEGREES - 1);
    let zonal = zonal_sums(degree, zonal_pairs, &mut column, &steps, t, z);

    let (mut d, mut f) = (zonal.d, zonal.f);
    let (mut gradient_x, mut gradient_y) = (T::ZERO, T::ZERO);
    let (mut re_below, mut im_below) = (T::ONE, T::ZERO); // ζᵐ⁻¹
    let (mut re, mut im) = (x, y); // ζᵐ
    let mut steps = steps.as_slice();
    let mut order = 1;
    let mut m = T::ONE;
    // n+m+1 = (N+2) + m − (N+1−n); the term m is Euler's identity for ζᵐ, added at the end.
    let n_plus_2 = T::from_f64((degree + 2) as f64);
    while order <= degree {
        let Some((order_pairs, other_pairs)) = pairs.split_at_checked(DEGREES - order) else {
            break;
        };
        let Some((_, order_steps)) = steps.split_first() else { break };
        let Some(sums) = order_sums(degree - order, order_pairs, &mut column, order_steps) else {
            break;
        };
        let [c, s] = sums.plain;
        let [c_partial, s_partial] = sums.partial;
        let [c_raised, s_raised] = sums.raised;
        gradient_x += m * (c * re_below + s * im_below);
        gradient_y += m * (s * re_below - c * im_below);
        d += c_raised * re + s_raised * im;
        f += (n_plus_2 * c - c_partial) * re + (n_plus_2 * s - s_partial) * im;

        (re_below, im_below) = (re, im);
        (re, im) = (x * re - y * im, x * im + y * re);
        (pairs, steps) = (other_pairs, order_steps);
        order += 1;
        m += T::ONE;
    }
    f += x * gradient_x + y * gradient_y;
    let e = t * (f + z * d);
    Ok([x * e - gradient_x, y * e - gradient_y, z * e - d])
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

/// The share of order zero in D and F.
struct ZonalSums<T> {
    d: T,
    f: T,
}

/// Sums order zero over n, and leaves A_n,1 for n = 1, 2, … in `column`.
#[inline(always)]
fn zonal_sums<T: Real>(
    degree: usize,
    pairs: &[[T; 2]],
    column: &mut [T; DEGREES],
    steps: &[T; DEGREES],
    t: T,
    z: T,
) -> ZonalSums<T> {
    let [first_slot, slots @ ..] = column;
    let [first_step, steps @ ..] = steps;
    let [_, zonal_ratios @ ..] = &T::ZONAL_RATIO;
    let mut a_before = t.sqrt(); // A_00 = 1/r
    let mut raised = *first_step * a_before; // A_11
    let mut raised_before = T::ZERO; // A_01
    let mut a = z * raised; // A_10
    *first_slot = raised;

    let (mut d, mut f) = (T::ZERO, T::ZERO);
    let mut n = T::ONE;
    let rows = pairs.iter().zip(slots).zip(steps).zip(zonal_ratios);
    for (((&[g, _], slot), &step), &zonal_ratio) in rows.take(degree) {
        let n_plus_1 = n + T::ONE;
        d += g * raised;
        f += n_plus_1 * (g * a);
        let raised_next = step * (raised_before + a);
        *slot = raised_next;
        (raised_before, raised) = (raised, raised_next);
        (a_before, a) = (a, t * zonal_ratio * (z * a - n * a_before));
        n = n_plus_1;
    }
    ZonalSums { d, f }
}

/// Sums over n for one order, for g and for h.
struct OrderSums<T> {
    /// Σ g A_nm.
    plain: [T; 2],
    /// Sum of the partial sums of g A_nm.
    partial: [T; 2],
    /// Σ g A_n,m+1.
    raised: [T; 2],
}

/// Sums one order m ≥ 1 over n = m to m + `count`, and replaces A_nm for n = m, m+1, … in
/// `column` by A_n,m+1 for n = m+1, m+2, …
#[inline(always)]
fn order_sums<T: Real>(
    count: usize,
    pairs: &[[T; 2]],
    column: &mut [T; DEGREES],
    steps: &[T],
) -> Option<OrderSums<T>> {
    let [first_slot, slots @ ..] = column;
    let (&[g, h], pairs) = pairs.split_first()?;
    let (&first_step, steps) = steps.split_first()?;
    let a = *first_slot;
    let mut raised_before = T::ZERO;
    let mut raised = first_step * a;
    *first_slot = raised;

    let (mut c, mut s) = (g * a, h * a);
    let (mut c_partial, mut s_partial) = (c, s);
    let (mut c_raised, mut s_raised) = (T::ZERO, T::ZERO);
    for ((&[g, h], slot), &step) in pairs.iter().zip(slots).zip(steps).take(count) {
        let a = *slot;
        c += g * a;
        s += h * a;
        c_partial += c;
        s_partial += s;
        c_raised += g * raised;
        s_raised += h * raised;
        let raised_next = step * (raised_before + a);
        *slot = raised_next;
        (raised_before, raised) = (raised, raised_next);
    }
    Some(OrderSums { plain: [c, s], partial: [c_partial, s_partial], raised: [c_raised, s_raised] })
}
