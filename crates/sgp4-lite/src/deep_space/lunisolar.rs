//! What the Sun and the Moon do to an orbit: secular rates and periodic terms.
//!
//! The disturbing body moves on a fixed ellipse. Averaging its pull over one revolution of the
//! satellite gives terms that are constant (secular rates) and terms with twice the body's true
//! anomaly (periodic terms).
//!
//! | symbol | code | meaning |
//! |---|---|---|
//! | nₓ, eₓ, Cₓ | `Body` | mean motion, eccentricity, strength of the body |
//! | g, i, h | `perigee`, `inclination`, `node` | the body's orbit; h is the satellite's node from the body's |
//! | a₁ … a₁₀, X₁ … X₈, Z | `a1` … `x8`, `z…` | geometry, as in the source |
//! | s₁ … s₇ | `s1` … `s7` | strength times powers of β and e, as in the source |
//!
//! Source: Hoots & Roehrich, Spacetrack Report No. 3, section 10 (subroutine DEEP); the theory is
//! Hujsak, "A Restricted Four Body Solution for Resonating Satellites Without Drag", Spacetrack
//! Report No. 1 (1979).

use crate::angle::SinCos;
use crate::mean_orbit::MeanOrbit;

/// Closer than this to an inclination of 0 or 180 degrees (3 degrees, in radians), the secular rate
/// of the node is left out.
const LEAST_NODE_INCLINATION_RAD: f64 = 5.235_987_7e-2;

/// A disturbing body.
struct Body {
    /// nₓ, rad/min
    mean_motion: f64,
    /// eₓ
    eccentricity: f64,
    /// Cₓ, rad/min
    strength: f64,
}

const SUN: Body =
    Body { mean_motion: 1.194_59e-5, eccentricity: 0.01675, strength: 2.986_479_7e-6 };
const MOON: Body =
    Body { mean_motion: 1.583_521_8e-4, eccentricity: 0.05490, strength: 4.796_806_5e-7 };

/// Sine and cosine of the obliquity of the ecliptic.
const ECLIPTIC: SinCos = SinCos { sin: 0.397_854_16, cos: 0.917_448_67 };
/// Sine and cosine of the argument of the Sun's perigee, 281.2208 degrees.
const SUN_PERIGEE: SinCos = SinCos { sin: -0.980_884_58, cos: 0.194_590_5 };

/// Where the body's orbit lies, seen from the satellite's, at the epoch.
struct BodyOrbit {
    perigee: SinCos,
    inclination: SinCos,
    node: SinCos,
    mean_anomaly: f64,
}

impl BodyOrbit {
    fn of_sun(days_since_1900: f64, raan: SinCos) -> Self {
        Self {
            perigee: SUN_PERIGEE,
            inclination: ECLIPTIC,
            node: raan,
            mean_anomaly: 6.256_583_7 + 0.017_201_977 * days_since_1900,
        }
    }

    fn of_moon(days_since_1900: f64, raan: SinCos) -> Self {
        // The Moon's node on the ecliptic goes round in 18.6 years.
        let node_on_ecliptic = 4.523_602_0 - 9.242_202_9e-4 * days_since_1900;
        let SinCos { sin: sin_node, cos: cos_node } = SinCos::of(node_on_ecliptic);
        // Its inclination to the equator …
        let cos_i = 0.913_751_64 - 0.035_680_96 * cos_node;
        let sin_i = libm::sqrt(1.0 - cos_i * cos_i);
        // … its node on the equator …
        let sin_h = 0.089_683_511 * sin_node / sin_i;
        let cos_h = libm::sqrt(1.0 - sin_h * sin_h);
        // … and from there its perigee.
        let perigee_longitude = 5.835_151_4 + 0.001_944_368_0 * days_since_1900;
        let from_node = libm::atan2(
            ECLIPTIC.sin * sin_node / sin_i,
            cos_h * cos_node + ECLIPTIC.cos * sin_h * sin_node,
        );
        let perigee = perigee_longitude + from_node - node_on_ecliptic;
        Self {
            perigee: SinCos::of(perigee),
            inclination: SinCos { sin: sin_i, cos: cos_i },
            node: raan.plus(SinCos { sin: -sin_h, cos: cos_h }),
            mean_anomaly: 4.719_967_2 + 0.229_971_50 * days_since_1900 - perigee_longitude,
        }
    }
}

/// Rates of the mean elements, per minute, or their changes.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct ElementChanges {
    pub eccentricity: f64,
    pub inclination: f64,
    pub mean_anomaly: f64,
    pub argument_of_perigee: f64,
    pub raan: f64,
}

impl ElementChanges {
    fn plus(self, other: Self) -> Self {
        Self {
            eccentricity: self.eccentricity + other.eccentricity,
            inclination: self.inclination + other.inclination,
            mean_anomaly: self.mean_anomaly + other.mean_anomaly,
            argument_of_perigee: self.argument_of_perigee + other.argument_of_perigee,
            raan: self.raan + other.raan,
        }
    }
}

/// Periodic changes, with those of node and perigee still in the form that has no sin i below it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct PeriodicChanges {
    pub eccentricity: f64,
    pub inclination: f64,
    pub mean_anomaly: f64,
    /// δω + cos i δΩ
    pub perigee_and_node: f64,
    /// sin i δΩ
    pub sin_i_node: f64,
}

/// Coefficients of the periodic terms: f₂ = ½ sin²f − ¼, f₃ = −½ sin f cos f, and sin f, where f is
/// the body's true anomaly.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Coefficients {
    f2: f64,
    f3: f64,
    sin_f: f64,
}

impl Coefficients {
    fn times(&self, f2: f64, f3: f64, sin_f: f64) -> f64 {
        self.f2 * f2 + self.f3 * f3 + self.sin_f * sin_f
    }
}

/// The periodic terms of one body.
#[derive(Debug, Clone, Copy, PartialEq)]
struct PeriodicTerms {
    mean_motion: f64,
    body_eccentricity: f64,
    mean_anomaly_at_epoch: f64,
    eccentricity: Coefficients,
    inclination: Coefficients,
    mean_anomaly: Coefficients,
    perigee_and_node: Coefficients,
    sin_i_node: Coefficients,
}

impl PeriodicTerms {
    fn at(&self, t: f64) -> PeriodicChanges {
        // f = M + 2eₓ sin M
        let mean_anomaly = SinCos::of(self.mean_anomaly_at_epoch + self.mean_motion * t);
        let equation_of_centre = 2.0 * self.body_eccentricity * mean_anomaly.sin;
        let SinCos { sin: sin_f, cos: cos_f } = mean_anomaly.turned_by(equation_of_centre);
        let f2 = 0.5 * sin_f * sin_f - 0.25;
        let f3 = -0.5 * sin_f * cos_f;
        PeriodicChanges {
            eccentricity: self.eccentricity.times(f2, f3, sin_f),
            inclination: self.inclination.times(f2, f3, sin_f),
            mean_anomaly: self.mean_anomaly.times(f2, f3, sin_f),
            perigee_and_node: self.perigee_and_node.times(f2, f3, sin_f),
            sin_i_node: self.sin_i_node.times(f2, f3, sin_f),
        }
    }
}

/// What Sun and Moon do to one orbit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Lunisolar {
    /// Secular rates of the mean elements, per minute.
    pub rates: ElementChanges,
    sun: PeriodicTerms,
    moon: PeriodicTerms,
}

impl Lunisolar {
    /// The terms of an orbit; days are counted from 1900 January 0.5 (Julian date 2415020.0).
    pub fn new(orbit: &MeanOrbit, days_since_1900: f64) -> Self {
        let raan = SinCos::of(orbit.raan);
        let (sun_rates, sun) = terms(orbit, &SUN, &BodyOrbit::of_sun(days_since_1900, raan));
        let (moon_rates, moon) = terms(orbit, &MOON, &BodyOrbit::of_moon(days_since_1900, raan));
        Self { rates: sun_rates.plus(moon_rates), sun, moon }
    }

    /// The periodic changes at `t` minutes from the epoch.
    pub fn periodic(&self, t: f64) -> PeriodicChanges {
        let (sun, moon) = (self.sun.at(t), self.moon.at(t));
        PeriodicChanges {
            eccentricity: sun.eccentricity + moon.eccentricity,
            inclination: sun.inclination + moon.inclination,
            mean_anomaly: sun.mean_anomaly + moon.mean_anomaly,
            perigee_and_node: sun.perigee_and_node + moon.perigee_and_node,
            sin_i_node: sun.sin_i_node + moon.sin_i_node,
        }
    }
}

/// Secular rates and periodic terms by one body.
fn terms(orbit: &MeanOrbit, body: &Body, place: &BodyOrbit) -> (ElementChanges, PeriodicTerms) {
    let SinCos { sin: sin_g, cos: cos_g } = place.perigee;
    let SinCos { sin: sin_ix, cos: cos_ix } = place.inclination;
    let SinCos { sin: sin_h, cos: cos_h } = place.node;
    let SinCos { sin: sin_i, cos: cos_i } = orbit.inclination.angle;
    let SinCos { sin: sin_w, cos: cos_w } = SinCos::of(orbit.argument_of_perigee);
    let e = orbit.eccentricity;
    let e2 = e * e;
    let beta2 = orbit.beta2;
    let beta = libm::sqrt(beta2);

    // The body's perigee and latus rectum directions in the axes of the satellite's node.
    let a1 = cos_g * cos_h + sin_g * cos_ix * sin_h;
    let a3 = -sin_g * cos_h + cos_g * cos_ix * sin_h;
    let a7 = -cos_g * sin_h + sin_g * cos_ix * cos_h;
    let a8 = sin_g * sin_ix;
    let a9 = sin_g * sin_h + cos_g * cos_ix * cos_h;
    let a10 = cos_g * sin_ix;
    // … turned into the satellite's orbit plane
    let a2 = cos_i * a7 + sin_i * a8;
    let a4 = cos_i * a9 + sin_i * a10;
    let a5 = -sin_i * a7 + cos_i * a8;
    let a6 = -sin_i * a9 + cos_i * a10;
    // … and to the satellite's perigee.
    let x1 = a1 * cos_w + a2 * sin_w;
    let x2 = a3 * cos_w + a4 * sin_w;
    let x3 = -a1 * sin_w + a2 * cos_w;
    let x4 = -a3 * sin_w + a4 * cos_w;
    let x5 = a5 * sin_w;
    let x6 = a6 * sin_w;
    let x7 = a5 * cos_w;
    let x8 = a6 * cos_w;

    let z31 = 12.0 * x1 * x1 - 3.0 * x3 * x3;
    let z32 = 24.0 * x1 * x2 - 6.0 * x3 * x4;
    let z33 = 12.0 * x2 * x2 - 3.0 * x4 * x4;
    let z1 = 6.0 * (a1 * a1 + a2 * a2) + (1.0 + e2) * z31;
    let z2 = 12.0 * (a1 * a3 + a2 * a4) + (1.0 + e2) * z32;
    let z3 = 6.0 * (a3 * a3 + a4 * a4) + (1.0 + e2) * z33;
    let z11 = -6.0 * a1 * a5 + e2 * (-24.0 * x1 * x7 - 6.0 * x3 * x5);
    let z12 =
        -6.0 * (a1 * a6 + a3 * a5) + e2 * (-24.0 * (x2 * x7 + x1 * x8) - 6.0 * (x3 * x6 + x4 * x5));
    let z13 = -6.0 * a3 * a6 + e2 * (-24.0 * x2 * x8 - 6.0 * x4 * x6);
    let z21 = 6.0 * a2 * a5 + e2 * (24.0 * x1 * x5 - 6.0 * x3 * x7);
    let z22 =
        6.0 * (a4 * a5 + a2 * a6) + e2 * (24.0 * (x2 * x5 + x1 * x6) - 6.0 * (x4 * x7 + x3 * x8));
    let z23 = 6.0 * a4 * a6 + e2 * (24.0 * x2 * x6 - 6.0 * x4 * x8);

    // s₃ = Cₓ/n₀, s₂ = −½ s₃/β, s₄ = s₃β, s₁ = −15 e s₄
    let s3 = body.strength / orbit.mean_motion;
    let s2 = -0.5 * s3 / beta;
    let s4 = s3 * beta;
    let s1 = -15.0 * e * s4;
    let s5 = x1 * x3 + x2 * x4;
    let s6 = x2 * x3 + x1 * x4;
    let s7 = x2 * x4 - x1 * x3;

    let n = body.mean_motion;
    // sin i Ω̇ = −nₓs₂(Z₂₁ + Z₂₃), left out near the equator
    let from_pole = core::f64::consts::PI - LEAST_NODE_INCLINATION_RAD;
    let node_moves = (LEAST_NODE_INCLINATION_RAD..=from_pole).contains(&orbit.inclination_rad);
    let raan = if node_moves { -n * s2 * (z21 + z23) / sin_i } else { 0.0 };
    let rates = ElementChanges {
        eccentricity: n * s1 * s5,
        inclination: n * s2 * (z11 + z13),
        mean_anomaly: -n * s3 * (z1 + z3 - 14.0 - 6.0 * e2),
        // nₓs₄(Z₃₁ + Z₃₃ − 6) − cos i Ω̇
        argument_of_perigee: n * s4 * (z31 + z33 - 6.0) - cos_i * raan,
        raan,
    };
    let periodic = PeriodicTerms {
        mean_motion: n,
        body_eccentricity: body.eccentricity,
        mean_anomaly_at_epoch: place.mean_anomaly,
        eccentricity: Coefficients { f2: 2.0 * s1 * s6, f3: 2.0 * s1 * s7, sin_f: 0.0 },
        inclination: Coefficients { f2: 2.0 * s2 * z12, f3: 2.0 * s2 * (z13 - z11), sin_f: 0.0 },
        mean_anomaly: Coefficients {
            f2: -2.0 * s3 * z2,
            f3: -2.0 * s3 * (z3 - z1),
            sin_f: -2.0 * s3 * (-21.0 - 9.0 * e2) * body.eccentricity,
        },
        perigee_and_node: Coefficients {
            f2: 2.0 * s4 * z32,
            f3: 2.0 * s4 * (z33 - z31),
            sin_f: -18.0 * s4 * body.eccentricity,
        },
        sin_i_node: Coefficients { f2: -2.0 * s2 * z22, f3: -2.0 * s2 * (z23 - z21), sin_f: 0.0 },
    };
    (rates, periodic)
}
