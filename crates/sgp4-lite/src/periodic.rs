//! From mean elements at one time to position and velocity: long-period terms, Kepler's equation,
//! short-period terms.
//!
//! | symbol | code |
//! |---|---|
//! | √a | `sqrt_semi_major_axis` (Earth radii^½) |
//! | e cos ω, e sin ω | `ax`, `ay` |
//! | U = M + ω | `latitude`: mean argument of latitude |
//! | E + ω | `eccentric`: eccentric argument of latitude |
//! | u | `u`: true argument of latitude |
//! | r, ṙ, rν̇ | `radius`, `radial_speed`, `transverse_speed` |
//! | p | `semi_latus_rectum` |
//!
//! Source: Hoots & Roehrich, Spacetrack Report No. 3, section 6.

use crate::angle::SinCos;
use crate::gravity::{EARTH_RADIUS_KM, J2, KE};
use crate::mean_orbit::Inclination;
use crate::{Error, State};

/// Kilometres per second in one Earth radius · kₑ per minute, the theory's unit of velocity.
const KM_S_PER_UNIT_VELOCITY: f64 = EARTH_RADIUS_KM * KE / 60.0;

/// Iterations of Newton's method for Kepler's equation, and the longest step it may take: those of
/// the reference implementation, so that hopeless cases come out as they do there.
const KEPLER_MAX_ITERATIONS: u8 = 10;
const KEPLER_MAX_STEP_RAD: f64 = 0.95;
/// Below this step, a first-order turn finishes the solution: the neglected second order is 5e-15.
const KEPLER_LAST_STEP_RAD: f64 = 1e-7;
/// Below this step the solution is near and the step is made exact to second order, which saves an
/// iteration for orbits with little eccentricity.
const KEPLER_SECOND_ORDER_BELOW_RAD: f64 = 1.0 / 64.0;

/// Mean elements after secular (and lunar and solar) changes, before zonal periodic terms.
#[derive(Debug, Clone, Copy)]
pub(crate) struct MeanState {
    pub sqrt_semi_major_axis: f64,
    pub eccentricity: f64,
    pub argument_of_perigee: SinCos,
    pub latitude: SinCos,
    /// What `latitude` has still to grow by, radians.
    pub latitude_change: f64,
    pub raan: SinCos,
}

/// Position and velocity (TEME) from the mean elements.
pub(crate) fn position_and_velocity(
    mean: &MeanState,
    inclination: &Inclination,
    minutes_since_epoch: f64,
) -> Result<State, Error> {
    let e = mean.eccentricity;
    let sqrt_a = mean.sqrt_semi_major_axis;
    let sqrt_a_inverse = 1.0 / sqrt_a;
    let a_inverse = sqrt_a_inverse * sqrt_a_inverse;

    // Long-period terms, with 1/p = 1 / (a (1 − e²)):
    // a_x = e cos ω, a_y = e sin ω − ½ (J₃/J₂) sin i / p
    let p_inverse = a_inverse / (1.0 - e * e);
    let ax = e * mean.argument_of_perigee.cos;
    let ay = e * mean.argument_of_perigee.sin + p_inverse * inclination.long_period_ay;
    // U grows by −¼ (J₃/J₂) sin i (3 + 5θ)/(1 + θ) a_x / p
    let latitude = mean
        .latitude
        .turned_by(mean.latitude_change + p_inverse * inclination.long_period_longitude * ax);

    let kepler = solve_kepler(latitude, ax, ay);

    // p = a β², now with the long-period terms in e = √(1 − β²)
    let beta2 = 1.0 - (ax * ax + ay * ay);
    if !(0.0..).contains(&beta2) {
        let earth_radii = sqrt_a * sqrt_a * beta2;
        return Err(Error::SemiLatusRectum { earth_radii, minutes_since_epoch });
    }
    let beta = libm::sqrt(beta2);
    // ṙ = √a e sin E / r, rν̇ = √p / r
    let a_over_r = kepler.a_over_r;
    let unit_speed = a_over_r * sqrt_a_inverse;
    let radial_speed = unit_speed * kepler.e_sin;
    let transverse_speed = unit_speed * beta;
    // sin u = a/r [sin(E+ω) − a_y − a_x e sin E / (1 + β)]
    // cos u = a/r [cos(E+ω) − a_x + a_y e sin E / (1 + β)]
    let e_sin_over = kepler.e_sin / (1.0 + beta);
    let u = SinCos {
        sin: a_over_r * (kepler.eccentric.sin - ay - ax * e_sin_over),
        cos: a_over_r * (kepler.eccentric.cos - ax + ay * e_sin_over),
    };
    let sin_2u = 2.0 * u.sin * u.cos;
    let cos_2u = 1.0 - 2.0 * u.sin * u.sin;

    // Short-period terms, with k₁ = ½ J₂ / p and k₂ = k₁ / p.
    let p_inverse = a_inverse / beta2;
    let k1 = 0.5 * J2 * p_inverse;
    let k2 = k1 * p_inverse;
    let k1_sin2_i = k1 * inclination.one_minus_theta2;
    let k1_cos_2u = k1_sin2_i * cos_2u;
    let k1_zonal = 1.5 * k1 * inclination.three_theta2_minus_1;
    // rₖ = a (1 − e cos E) (1 − 3/2 k₂β(3θ² − 1)) + ½ k₁ (1 − θ²) cos 2u
    let radius = sqrt_a * sqrt_a * kepler.one_minus_e_cos * (1.0 - k1_zonal * p_inverse * beta)
        + 0.5 * k1_cos_2u;
    // uₖ = u − ¼ k₂ (7θ² − 1) sin 2u
    let u = u.turned_by(-0.25 * k2 * inclination.seven_theta2_minus_1 * sin_2u);
    // Ωₖ = Ω + 3/2 k₂ θ sin 2u, iₖ = i + 3/2 k₂ θ sin i cos 2u
    let k2_theta = 1.5 * k2 * inclination.angle.cos;
    let raan = mean.raan.turned_by(k2_theta * sin_2u);
    let incl = inclination.angle.turned_by(k2_theta * inclination.angle.sin * cos_2u);
    // ṙₖ = ṙ − n k₁ (1 − θ²) sin 2u, rν̇ₖ = rν̇ + n k₁ ((1 − θ²) cos 2u + 3/2 (3θ² − 1)),
    // in units of kₑ: n / kₑ = a^(−3/2)
    let n_over_ke = a_inverse * sqrt_a_inverse;
    let radial_speed = radial_speed - n_over_ke * k1_sin2_i * sin_2u;
    let transverse_speed = transverse_speed + n_over_ke * (k1_cos_2u + k1_zonal);

    // A NaN anywhere above ends here or earlier, because no range contains it.
    if !(1.0..f64::INFINITY).contains(&radius) {
        return Err(Error::Decayed { radius_earth_radii: radius, minutes_since_epoch });
    }

    // In the orbit plane, N towards the node and M ahead of it:
    // position r (M sin u + N cos u), velocity ṙ (M sin u + N cos u) + rν̇ (M cos u − N sin u)
    let radius_km = radius * EARTH_RADIUS_KM;
    let radial_km_s = radial_speed * KM_S_PER_UNIT_VELOCITY;
    let transverse_km_s = transverse_speed * KM_S_PER_UNIT_VELOCITY;
    let plane = OrbitPlane::new(raan, incl);
    Ok(State {
        position_km: plane.vector(radius_km * u.cos, radius_km * u.sin),
        velocity_km_s: plane.vector(
            radial_km_s * u.cos - transverse_km_s * u.sin,
            radial_km_s * u.sin + transverse_km_s * u.cos,
        ),
    })
}

/// Two axes of the orbit plane: N = (cos Ω, sin Ω, 0), M = (−sin Ω cos i, cos Ω cos i, sin i).
struct OrbitPlane {
    node: [f64; 2],
    ahead: [f64; 3],
}

impl OrbitPlane {
    fn new(raan: SinCos, inclination: SinCos) -> Self {
        Self {
            node: [raan.cos, raan.sin],
            ahead: [-raan.sin * inclination.cos, raan.cos * inclination.cos, inclination.sin],
        }
    }

    /// `to_node` N + `ahead` M
    fn vector(&self, to_node: f64, ahead: f64) -> [f64; 3] {
        [
            to_node * self.node[0] + ahead * self.ahead[0],
            to_node * self.node[1] + ahead * self.ahead[1],
            ahead * self.ahead[2],
        ]
    }
}

/// What the solution of Kepler's equation is used for.
struct Kepler {
    /// E + ω
    eccentric: SinCos,
    /// e sin E
    e_sin: f64,
    /// 1 − e cos E
    one_minus_e_cos: f64,
    /// 1 / (1 − e cos E)
    a_over_r: f64,
}

/// Kepler's equation for E + ω, given U = M + ω:
/// U = (E + ω) + a_y cos(E + ω) − a_x sin(E + ω)
fn solve_kepler(latitude: SinCos, ax: f64, ay: f64) -> Kepler {
    let mut eccentric = latitude;
    // (E + ω) − U
    let mut ahead = 0.0;
    let mut iterations_left = KEPLER_MAX_ITERATIONS;
    loop {
        // e cos E = a_x cos(E+ω) + a_y sin(E+ω), e sin E = a_x sin(E+ω) − a_y cos(E+ω)
        let e_cos = ax * eccentric.cos + ay * eccentric.sin;
        let e_sin = ax * eccentric.sin - ay * eccentric.cos;
        let one_minus_e_cos = 1.0 - e_cos;
        let a_over_r = 1.0 / one_minus_e_cos;
        let newton = ((e_sin - ahead) * a_over_r).clamp(-KEPLER_MAX_STEP_RAD, KEPLER_MAX_STEP_RAD);
        iterations_left -= 1;
        if newton.abs() < KEPLER_LAST_STEP_RAD {
            return Kepler {
                eccentric: SinCos {
                    sin: eccentric.sin + newton * eccentric.cos,
                    cos: eccentric.cos - newton * eccentric.sin,
                },
                e_sin: e_sin + newton * e_cos,
                one_minus_e_cos: one_minus_e_cos + newton * e_sin,
                a_over_r: a_over_r * (1.0 - newton * e_sin * a_over_r),
            };
        }
        if iterations_left == 0 {
            return Kepler { eccentric, e_sin, one_minus_e_cos, a_over_r };
        }
        let step = if newton.abs() < KEPLER_SECOND_ORDER_BELOW_RAD {
            // f = E − e sin E − M: the next order of the step is −½ f″/f′ · step²
            newton - 0.5 * newton * newton * e_sin * a_over_r
        } else {
            newton
        };
        ahead += step;
        eccentric = eccentric.turned_by(step);
    }
}
