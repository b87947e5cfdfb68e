//! From mean elements at one time to position and velocity: long-period terms, Kepler's equation,
//! short-period terms.
//!
//! | symbol | code |
//! |---|---|
//! | a, √a | `semi_major_axis`, `sqrt_semi_major_axis` (Earth radii) |
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

/// Newton's method for Kepler's equation stops when it moves less than this, radians.
const KEPLER_TOLERANCE_RAD: f64 = 1e-12;
/// Iterations of Newton's method, and the longest step it may take: those of the reference
/// implementation, because a few orbits of its test set depend on them.
const KEPLER_MAX_ITERATIONS: u8 = 10;
const KEPLER_MAX_STEP_RAD: f64 = 0.95;

/// Mean elements after secular (and lunar and solar) changes, before zonal periodic terms.
#[derive(Debug, Clone, Copy)]
pub(crate) struct MeanState {
    pub semi_major_axis: f64,
    pub sqrt_semi_major_axis: f64,
    pub eccentricity: f64,
    pub argument_of_perigee: SinCos,
    pub latitude: SinCos,
    pub raan: SinCos,
}

/// Position and velocity (TEME) from the mean elements.
pub(crate) fn position_and_velocity(
    mean: &MeanState,
    inclination: &Inclination,
    minutes_since_epoch: f64,
) -> Result<State, Error> {
    let a = mean.semi_major_axis;
    let e = mean.eccentricity;

    // Long-period terms, with 1/p = 1 / (a (1 − e²)):
    // a_x = e cos ω, a_y = e sin ω − ½ (J₃/J₂) sin i / p
    let p_inverse = 1.0 / (a * (1.0 - e * e));
    let ax = e * mean.argument_of_perigee.cos;
    let ay = e * mean.argument_of_perigee.sin + p_inverse * inclination.long_period_ay;
    // U grows by −¼ (J₃/J₂) sin i (3 + 5θ)/(1 + θ) a_x / p
    let latitude = mean.latitude.turned_by(p_inverse * inclination.long_period_longitude * ax);

    let kepler = solve_kepler(latitude, ax, ay);

    // p = a (1 − e²), now with the long-period terms in e
    let e2 = ax * ax + ay * ay;
    let beta2 = 1.0 - e2;
    let semi_latus_rectum = a * beta2;
    if !(0.0..).contains(&semi_latus_rectum) {
        return Err(Error::SemiLatusRectum { earth_radii: semi_latus_rectum, minutes_since_epoch });
    }
    let beta = libm::sqrt(beta2);
    let sqrt_a = mean.sqrt_semi_major_axis;
    // r = a (1 − e cos E), ṙ = √a e sin E / r, rν̇ = √p / r
    let a_over_r = 1.0 / kepler.one_minus_e_cos;
    let radius = a * kepler.one_minus_e_cos;
    let unit_speed = a_over_r / sqrt_a;
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
    let p_inverse = 1.0 / semi_latus_rectum;
    let k1 = 0.5 * J2 * p_inverse;
    let k2 = k1 * p_inverse;
    let theta = inclination.angle.cos;
    // rₖ = r (1 − 3/2 k₂β(3θ² − 1)) + ½ k₁ (1 − θ²) cos 2u
    let three_theta2_minus_1 = inclination.three_theta2_minus_1;
    let k1_sin2_i = k1 * inclination.one_minus_theta2;
    let radius = radius * (1.0 - 1.5 * k2 * beta * three_theta2_minus_1) + 0.5 * k1_sin2_i * cos_2u;
    // uₖ = u − ¼ k₂ (7θ² − 1) sin 2u
    let u = u.turned_by(-0.25 * k2 * inclination.seven_theta2_minus_1 * sin_2u);
    // Ωₖ = Ω + 3/2 k₂ θ sin 2u, iₖ = i + 3/2 k₂ θ sin i cos 2u
    let k2_theta = 1.5 * k2 * theta;
    let raan = mean.raan.turned_by(k2_theta * sin_2u);
    let incl = inclination.angle.turned_by(k2_theta * inclination.angle.sin * cos_2u);
    // ṙₖ = ṙ − n k₁ (1 − θ²) sin 2u, rν̇ₖ = rν̇ + n k₁ ((1 − θ²) cos 2u + 3/2 (3θ² − 1)),
    // in units of kₑ: n / kₑ = a^(−3/2)
    let n_over_ke = 1.0 / (a * sqrt_a);
    let radial_speed = radial_speed - n_over_ke * k1_sin2_i * sin_2u;
    let transverse_speed =
        transverse_speed + n_over_ke * (k1_sin2_i * cos_2u + 1.5 * k1 * three_theta2_minus_1);

    // A NaN anywhere above ends here or earlier, because no range contains it.
    if !(1.0..f64::INFINITY).contains(&radius) {
        return Err(Error::Decayed { radius_earth_radii: radius, minutes_since_epoch });
    }

    // Unit vectors outwards (U) and along the motion (V):
    // M = (−sin Ω cos i, cos Ω cos i, sin i), N = (cos Ω, sin Ω, 0),
    // U = M sin u + N cos u, V = M cos u − N sin u
    let m = [-raan.sin * incl.cos, raan.cos * incl.cos, incl.sin];
    let n = [raan.cos, raan.sin, 0.0];
    let outwards = [m[0] * u.sin + n[0] * u.cos, m[1] * u.sin + n[1] * u.cos, m[2] * u.sin];
    let along = [m[0] * u.cos - n[0] * u.sin, m[1] * u.cos - n[1] * u.sin, m[2] * u.cos];
    let radius_km = radius * EARTH_RADIUS_KM;
    let radial_km_s = radial_speed * KM_S_PER_UNIT_VELOCITY;
    let transverse_km_s = transverse_speed * KM_S_PER_UNIT_VELOCITY;
    Ok(State {
        position_km: outwards.map(|component| radius_km * component),
        velocity_km_s: [
            radial_km_s * outwards[0] + transverse_km_s * along[0],
            radial_km_s * outwards[1] + transverse_km_s * along[1],
            radial_km_s * outwards[2] + transverse_km_s * along[2],
        ],
    })
}

/// What the solution of Kepler's equation is used for.
struct Kepler {
    /// E + ω
    eccentric: SinCos,
    /// e sin E
    e_sin: f64,
    /// 1 − e cos E
    one_minus_e_cos: f64,
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
        let step =
            ((e_sin - ahead) / one_minus_e_cos).clamp(-KEPLER_MAX_STEP_RAD, KEPLER_MAX_STEP_RAD);
        iterations_left -= 1;
        if step.abs() < KEPLER_TOLERANCE_RAD || iterations_left == 0 {
            return Kepler { eccentric, e_sin, one_minus_e_cos };
        }
        ahead += step;
        eccentric = eccentric.turned_by(step);
    }
}
