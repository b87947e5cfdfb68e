//! How strongly the tesseral harmonics of the Earth's field pull on orbits in resonance with its
//! rotation.
//!
//! | symbol | code | meaning |
//! |---|---|---|
//! | Fₗₘₚ(i) | `f220` … | Kaula's inclination functions |
//! | Gₗₚq(e) | `g200` … | Hansen's eccentricity functions, as polynomials fitted in the source |
//! | Qₗₘ, λₗₘ | `Q…`, `PHASE_…` | amplitude and longitude of the harmonic l, m |
//!
//! Source: Hoots & Roehrich, Spacetrack Report No. 3, section 10 (subroutine DEEP).

use crate::gravity::KE;
use crate::gravity::two_thirds_power;
use crate::mean_orbit::MeanOrbit;

// Amplitudes: normalised coefficients of the harmonic times its factors in the disturbing function.
const Q22: f64 = 1.789_167_9e-6;
const Q31: f64 = 2.146_074_8e-6;
const Q33: f64 = 2.212_301_5e-7;
const Q32: f64 = 3.739_379_2e-7;
const Q44: f64 = 7.363_695_3e-9;
const Q52: f64 = 1.142_863_9e-7;
const Q54: f64 = 2.176_580_3e-9;

// Phases in radians: of the synchronous terms …
const PHASE_31: f64 = 0.131_309_08;
const PHASE_22: f64 = 2.884_319_8;
const PHASE_33: f64 = 0.374_480_87;
// … and of the half-day terms, where they are multiplied by m already.
const HALF_DAY_PHASE_22: f64 = 5.768_639_6;
const HALF_DAY_PHASE_32: f64 = 0.952_408_98;
const HALF_DAY_PHASE_44: f64 = 1.801_499_8;
const HALF_DAY_PHASE_52: f64 = 1.050_833_0;
const HALF_DAY_PHASE_54: f64 = 4.410_889_8;

/// A pull that varies as D sin(α − phase), written as A sin α + B cos α.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Harmonic {
    pub sin: f64,
    pub cos: f64,
}

impl Harmonic {
    fn new(amplitude: f64, phase: f64) -> Self {
        let (sin, cos) = libm::sincos(phase);
        Self { sin: amplitude * cos, cos: -amplitude * sin }
    }

    fn plus(self, other: Self) -> Self {
        Self { sin: self.sin + other.sin, cos: self.cos + other.cos }
    }
}

/// Harmonics of a synchronous orbit: the k-th acts with kλ.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Synchronous {
    pub once: Harmonic,
    pub twice: Harmonic,
    pub thrice: Harmonic,
}

impl Synchronous {
    pub fn new(orbit: &MeanOrbit) -> Self {
        let e2 = orbit.eccentricity * orbit.eccentricity;
        let theta = orbit.inclination.angle.cos;
        let sin2_i = orbit.inclination.angle.sin * orbit.inclination.angle.sin;
        let g200 = 1.0 + e2 * (-2.5 + 0.8125 * e2);
        let g310 = 1.0 + 2.0 * e2;
        let g300 = 1.0 + e2 * (-6.0 + 6.60937 * e2);
        let one_plus_theta = 1.0 + theta;
        let f220 = 0.75 * one_plus_theta * one_plus_theta;
        let f311 = 0.9375 * sin2_i * (1.0 + 3.0 * theta) - 0.75 * one_plus_theta;
        let f330 = 1.875 * one_plus_theta * one_plus_theta * one_plus_theta;
        // δ = 3 n₀²/a² …, one more 1/a for degree 3
        let (strength, a_inverse) = strength(orbit);
        let d2 = 2.0 * strength * f220 * g200 * Q22;
        let d3 = 3.0 * strength * f330 * g300 * Q33 * a_inverse;
        let d1 = strength * f311 * g310 * Q31 * a_inverse;
        Self {
            once: Harmonic::new(d1, PHASE_31),
            twice: Harmonic::new(d2, 2.0 * PHASE_22),
            thrice: Harmonic::new(d3, 3.0 * PHASE_33),
        }
    }
}

/// Harmonics of an eccentric half-day orbit, by the multiples of λ and ω that they act with.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct HalfDay {
    /// λ
    pub l: Harmonic,
    /// λ + ω
    pub l_plus_w: Harmonic,
    /// λ − ω
    pub l_minus_w: Harmonic,
    /// λ + 2ω
    pub l_plus_2w: Harmonic,
    /// 2λ
    pub l2: Harmonic,
    /// 2λ + ω
    pub l2_plus_w: Harmonic,
    /// 2λ − ω
    pub l2_minus_w: Harmonic,
    /// 2λ + 2ω
    pub l2_plus_2w: Harmonic,
}

impl HalfDay {
    pub fn new(orbit: &MeanOrbit) -> Self {
        let f = InclinationFunctions::new(orbit.inclination.angle.sin, orbit.inclination.angle.cos);
        let g = EccentricityFunctions::new(orbit.eccentricity);
        // D = 3 n₀²/a² · Q F G, one more 1/a for each degree above 2; doubled for order 4
        let (degree2, a_inverse) = strength(orbit);
        let degree3 = degree2 * a_inverse;
        let degree4 = degree3 * a_inverse;
        let degree5 = degree4 * a_inverse;
        let d22 = |f, g| Harmonic::new(degree2 * Q22 * f * g, HALF_DAY_PHASE_22);
        let d32 = |f, g| Harmonic::new(degree3 * Q32 * f * g, HALF_DAY_PHASE_32);
        let d44 = |f, g| Harmonic::new(2.0 * degree4 * Q44 * f * g, HALF_DAY_PHASE_44);
        let d52 = |f, g| Harmonic::new(degree5 * Q52 * f * g, HALF_DAY_PHASE_52);
        let d54 = |f, g| Harmonic::new(2.0 * degree5 * Q54 * f * g, HALF_DAY_PHASE_54);
        Self {
            l: d22(f.f221, g.g211),
            l_plus_w: d32(f.f321, g.g310).plus(d52(f.f522, g.g520)),
            l_minus_w: d32(f.f322, g.g322).plus(d52(f.f523, g.g532)),
            l_plus_2w: d22(f.f220, g.g201),
            l2: d44(f.f442, g.g422),
            l2_plus_w: d54(f.f542, g.g521),
            l2_minus_w: d54(f.f543, g.g533),
            l2_plus_2w: d44(f.f441, g.g410),
        }
    }
}

/// 3 n₀² / a², and 1 / a.
fn strength(orbit: &MeanOrbit) -> (f64, f64) {
    // 1/a = (n₀ / kₑ)^⅔
    let a_inverse = two_thirds_power(orbit.mean_motion / KE);
    (3.0 * orbit.mean_motion * orbit.mean_motion * a_inverse * a_inverse, a_inverse)
}

struct InclinationFunctions {
    f220: f64,
    f221: f64,
    f321: f64,
    f322: f64,
    f441: f64,
    f442: f64,
    f522: f64,
    f523: f64,
    f542: f64,
    f543: f64,
}

impl InclinationFunctions {
    fn new(sin: f64, theta: f64) -> Self {
        let theta2 = theta * theta;
        let sin2 = sin * sin;
        let f220 = 0.75 * (1.0 + 2.0 * theta + theta2);
        Self {
            f220,
            f221: 1.5 * sin2,
            f321: 1.875 * sin * (1.0 - 2.0 * theta - 3.0 * theta2),
            f322: -1.875 * sin * (1.0 + 2.0 * theta - 3.0 * theta2),
            f441: 35.0 * sin2 * f220,
            f442: 39.375 * sin2 * sin2,
            f522: 9.84375
                * sin
                * (sin2 * (1.0 - 2.0 * theta - 5.0 * theta2)
                    + 0.333_333_33 * (-2.0 + 4.0 * theta + 6.0 * theta2)),
            f523: sin
                * (4.921_875_12 * sin2 * (-2.0 - 4.0 * theta + 10.0 * theta2)
                    + 6.562_500_12 * (1.0 + 2.0 * theta - 3.0 * theta2)),
            f542: 29.53125
                * sin
                * (2.0 - 8.0 * theta + theta2 * (-12.0 + 8.0 * theta + 10.0 * theta2)),
            f543: 29.53125
                * sin
                * (-2.0 - 8.0 * theta + theta2 * (12.0 + 8.0 * theta - 10.0 * theta2)),
        }
    }
}

struct EccentricityFunctions {
    g201: f64,
    g211: f64,
    g310: f64,
    g322: f64,
    g410: f64,
    g422: f64,
    g520: f64,
    g521: f64,
    g532: f64,
    g533: f64,
}

impl EccentricityFunctions {
    fn new(e: f64) -> Self {
        let cubic = |c: [f64; 4]| c[0] + c[1] * e + c[2] * (e * e) + c[3] * (e * e * e);
        let [g211, g310, g322, g410, g422] = if e <= 0.65 {
            [
                [3.616, -13.247, 16.29, 0.0],
                [-19.302, 117.39, -228.419, 156.591],
                [-18.9068, 109.7927, -214.6334, 146.5816],
                [-41.122, 242.694, -471.094, 313.953],
                [-146.407, 841.88, -1629.014, 1083.435],
            ]
        } else {
            [
                [-72.099, 331.819, -508.738, 266.724],
                [-346.844, 1582.851, -2415.925, 1246.113],
                [-342.585, 1554.908, -2366.899, 1215.972],
                [-1052.797, 4758.686, -7193.992, 3651.957],
                [-3581.69, 16178.11, -24462.77, 12422.52],
            ]
        };
        let g520 = if e <= 0.65 {
            [-532.114, 3017.977, -5740.032, 3708.276]
        } else if e <= 0.715 {
            [1464.74, -4664.75, 3763.64, 0.0]
        } else {
            [-5149.66, 29936.92, -54087.36, 31324.56]
        };
        let [g521, g532, g533] = if e < 0.7 {
            [
                [-822.71072, 4568.6173, -8491.4146, 5337.524],
                [-853.666, 4690.25, -8624.77, 5341.4],
                [-919.2277, 4988.61, -9064.77, 5542.21],
            ]
        } else {
            [
                [-51752.104, 218913.95, -309468.16, 146349.42],
                [-40023.88, 170470.89, -242699.48, 115605.82],
                [-37995.78, 161616.52, -229838.2, 109377.94],
            ]
        };
        Self {
            g201: -0.306 - (e - 0.64) * 0.44,
            g211: cubic(g211),
            g310: cubic(g310),
            g322: cubic(g322),
            g410: cubic(g410),
            g422: cubic(g422),
            g520: cubic(g520),
            g521: cubic(g521),
            g532: cubic(g532),
            g533: cubic(g533),
        }
    }
}
