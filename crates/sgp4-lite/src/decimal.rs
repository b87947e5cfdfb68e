//! Decimal digits to `f64`, correctly rounded, without the standard library's full parser.

/// Powers of ten that a double holds exactly, as far as they are needed here.
const EXACT_POWERS_OF_TEN: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16,
    1e17, 1e18, 1e19, 1e20, 1e21, 1e22,
];

/// `digits · 10^exponent`.
///
/// The double nearest to the true value when `digits` is below 2⁵³ and the exponent within ±22:
/// both factors are then exact and there is one rounding (Clinger 1990). All numbers of a TLE are.
pub(crate) fn scaled(digits: u64, exponent: i32) -> f64 {
    let power =
        EXACT_POWERS_OF_TEN.get(exponent.unsigned_abs() as usize).copied().unwrap_or(f64::INFINITY);
    if exponent < 0 { digits as f64 / power } else { digits as f64 * power }
}
