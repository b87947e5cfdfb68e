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
//! * two orders go side by side, since A_n,m+1 is needed for both (`orders.rs`).
//!
//! Several positions are evaluated by the same code: where it computes with one number, it then
//! computes with one for each position (`lanes.rs`). So each has the bits that it has alone.
//!
//! Sources: Cunningham (1970), Celestial Mechanics 2, 207–216, and Montenbruck & Gill (2000),
//! §3.2.4, for solid harmonics in Cartesian form; Pines (1973), AIAA Journal 11, 1508–1511, for
//! derived Legendre functions and E. The scaling and the order of summation are our own.

use crate::lanes::{Four, Lanes, Number};
use crate::{Error, Real, orders};

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
    let place = Place::new(position_km);
    if place.is_within_limits(place.radius_squared) {
        Ok(field_at(degree, scaled, &place))
    } else {
        Err(refusal(position_km))
    }
}

/// [`field_nt`] at several positions. One that is refused does not concern the others.
pub(crate) fn fields_nt<T: Real, const W: usize>(
    degree: usize,
    scaled: &Scaled<T>,
    positions_km: [[T; 3]; W],
) -> [Result<[T; 3], Error>; W] {
    let place = Place::new([
        Lanes(positions_km.map(|[x, _, _]| x)),
        Lanes(positions_km.map(|[_, y, _]| y)),
        Lanes(positions_km.map(|[_, _, z]| z)),
    ]);
    // What comes of a refused position is not looked at.
    let [Lanes(x), Lanes(y), Lanes(z)] = field_at(degree, scaled, &place);
    let Lanes(radii_squared) = place.radius_squared;
    let mut fields = [Err(Error::NotFinite); W];
    let results = fields.iter_mut().zip(positions_km).zip(radii_squared).zip(x).zip(y).zip(z);
    for (((((field, position_km), radius_squared), x), y), z) in results {
        *field = if place.is_within_limits(radius_squared) {
            Ok([x, y, z])
        } else {
            Err(refusal(position_km))
        };
    }
    fields
}

/// A position in units of [`UNIT_KM`].
struct Place<V> {
    x: V,
    y: V,
    z: V,
    radius_squared: V,
}

impl<V: Number> Place<V> {
    #[inline(always)]
    fn new(position_km: [V; 3]) -> Self {
        let unit = V::all(V::Real::from_f64(1.0 / UNIT_KM));
        let [x, y, z] = position_km.map(|coordinate| coordinate * unit);
        Self { x, y, z, radius_squared: x * x + y * y + z * z }
    }

    /// Whether a position with this r² is between the radii that are not refused. NaN is not.
    #[inline(always)]
    fn is_within_limits(&self, radius_squared: V::Real) -> bool {
        let [least, greatest] = [MIN_RADIUS_KM, MAX_RADIUS_KM]
            .map(|radius_km| V::Real::from_f64(in_units_squared(radius_km)));
        (least..=greatest).contains(&radius_squared)
    }
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

/// The field in nT, at one position or at several.
#[inline(always)]
fn field_at<V: Number>(degree: usize, scaled: &Scaled<V::Real>, place: &Place<V>) -> [V; 3] {
    let &Place { x, y, z, radius_squared } = place;
    let t = V::all(V::Real::ONE) / radius_squared;
    let mut steps = [V::zero(); DEGREES];
    for (step, &ratio) in steps.iter_mut().zip(&V::Real::ORDER_RATIO) {
        *step = t * V::all(ratio);
    }
    let [first_step, ..] = steps;
    let a_11 = first_step * (t * radius_squared.square_root());

    let mut column = [V::zero(); DEGREES];
    let (d_zonal, e_zonal) = zonal_sums(degree, &scaled.zonal, &mut column, [a_11, t * z, t]);

    let sums = orders::sums(degree, [x, y], &scaled.rows, &mut column, &steps);

    let e = e_zonal + t * (sums.f + z * sums.d);
    let d = d_zonal + sums.d;
    [x * e - sums.gradient_x, y * e - sums.gradient_y, z * e - d]
}

/// The share of order 0 in D and E; leaves A_n,1 for n = 1 … `degree` in `column`.
#[inline(always)]
fn zonal_sums<V: Number>(
    degree: usize,
    coefficients: &[[V::Real; 2]; DEGREES - 1],
    column: &mut [V; DEGREES],
    [a_11, t_z, t]: [V; 3],
) -> (V, V) {
    let [_, ratios @ ..] = &V::Real::DEGREE_RATIO;
    let [_, ratios_before @ ..] = &V::Real::DEGREE_RATIO_BEFORE;
    let (mut a, mut a_before) = (a_11, V::zero());
    let (mut d, mut e) = (V::zero(), V::zero());
    let degrees = coefficients.iter().zip(column).zip(ratios).zip(ratios_before);
    for (((&[g, g_of_e], slot), &ratio), &ratio_before) in degrees.take(degree) {
        *slot = a;
        let a_next = (t_z * V::all(ratio)) * a - (t * V::all(ratio_before)) * a_before;
        d += V::all(g) * a;
        e += V::all(g_of_e) * a_next;
        (a, a_before) = (a_next, a);
    }
    (d, e)
}
