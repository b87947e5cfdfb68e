//! The field of prepared coefficients at a position.
#![allow(missing_docs)]

use crate::{Error, Real};

pub(crate) const COLUMN: usize = 14;
pub(crate) const PAIRS: usize = COLUMN * (COLUMN + 1) / 2;
pub(crate) const UNIT_KM: f64 = 1024.0;
pub const MIN_RADIUS_KM: f64 = 3_480.0;
pub const MAX_RADIUS_KM: f64 = 500_000.0;

pub(crate) const fn legendre_ratio(n: usize) -> f64 {
    ((2 * n + 1) * (2 * n + 3)) as f64
}
pub(crate) const fn zonal_ratio(n: usize) -> f64 {
    legendre_ratio(n) / (n + 1) as f64
}

pub(crate) fn field<T: Real>(
    degree: usize,
    pairs: &[[T; 2]; PAIRS],
    position_km: [T; 3],
) -> Result<[T; 3], Error> {
    let unit = T::from_f64(1.0 / UNIT_KM);
    let [x, y, z] = position_km.map(|coordinate| coordinate * unit);
    let radius2 = x * x + y * y + z * z;
    let min = T::from_f64((MIN_RADIUS_KM / UNIT_KM) * (MIN_RADIUS_KM / UNIT_KM));
    let max = T::from_f64((MAX_RADIUS_KM / UNIT_KM) * (MAX_RADIUS_KM / UNIT_KM));
    if !(radius2 >= min && radius2 <= max) {
        return Err(refusal(position_km));
    }
    let t = T::ONE / radius2;
    let tau = T::LEGENDRE_RATIO.map(|ratio| t * ratio);

    let mut column = [T::ZERO; COLUMN];
    let (mut before, mut here) = (T::ZERO, t.sqrt());
    for ((slot, ratio), n) in column.iter_mut().zip(T::ZONAL_RATIO).zip(T::COUNT).take(degree + 1) {
        *slot = here;
        let next = t * ratio * (z * here - n * before);
        (before, here) = (here, next);
    }

    let (mut re, mut im) = (T::ONE, T::ZERO);
    let (mut dx, mut dy, mut dz, mut radial) = (T::ZERO, T::ZERO, T::ZERO, T::ZERO);
    let (mut re_before, mut im_before) = (T::ZERO, T::ZERO);
    let mut rest: &[[T; 2]] = pairs;
    let mut tau: &[T] = &tau;
    for (order, m) in T::COUNT.into_iter().enumerate().take(degree + 1) {
        let Some((coefficients, others)) = rest.split_at_checked(COLUMN - order) else { break };
        let (mut c, mut s, mut cr, mut sr, mut cz, mut sz) =
            (T::ZERO, T::ZERO, T::ZERO, T::ZERO, T::ZERO, T::ZERO);
        let (mut below, mut same) = (T::ZERO, T::ZERO);
        for ((slot, &[g, h]), &tau) in
            column.iter_mut().zip(coefficients).zip(tau).take(degree + 1 - order)
        {
            let a = *slot;
            c += g * a;
            s += h * a;
            cr += c;
            sr += s;
            cz += g * same;
            sz += h * same;
            let next = tau * (below + a);
            *slot = next;
            (below, same) = (same, next);
        }
        let w = T::from_f64((degree + 2) as f64) + m;
        dx += m * (c * re_before + s * im_before);
        dy += m * (s * re_before - c * im_before);
        dz += cz * re + sz * im;
        radial += (w * c - cr) * re + (w * s - sr) * im;
        (re_before, im_before) = (re, im);
        (re, im) = (x * re - y * im, x * im + y * re);
        rest = others;
        tau = tau.get(1..).unwrap_or(&[]);
    }
    let e = t * (radial + z * dz);
    Ok([x * e - dx, y * e - dy, z * e - dz])
}

fn refusal<T: Real>(position_km: [T; 3]) -> Error {
    let [x, y, z] = position_km.map(T::to_f64);
    let radius_km = libm::sqrt(x * x + y * y + z * z);
    if position_km.iter().all(|c| c.is_finite()) {
        Error::Radius { radius_km }
    } else {
        Error::NotFinite
    }
}
