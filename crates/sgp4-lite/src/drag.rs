//! Atmospheric drag: the power law of density and the secular terms that follow from it.
//!
//! | symbol | code | meaning |
//! |---|---|---|
//! | s | `fit.s` | height parameter of the density law, Earth radii |
//! | (q₀ − s)⁴ | `fit.q0_minus_s_4` | the same law's other parameter |
//! | ξ | `xi` | 1 / (a₀ − s) |
//! | η | `eta` | a₀ e₀ ξ |
//! | B* | `bstar` | drag coefficient, per Earth radius |
//! | C₁ … C₅ | `c1` … `c5` | drag coefficients; C₁, C₄ and C₅ hold no B* until they are used |
//! | D₂ … D₄ | `d2` … `d4` | higher orders of C₁ |
//!
//! Source: Hoots & Roehrich, Spacetrack Report No. 3, section 6.

use crate::Error;
use crate::angle::SinCos;
use crate::gravity::{EARTH_RADIUS_KM, J2, J3_OVER_J2};
use crate::mean_orbit::{MeanOrbit, SecularRates};

/// Below this perigee height the terms of higher order in time are left out.
const SIMPLE_BELOW_PERIGEE_KM: f64 = 220.0;

/// Up to this eccentricity, terms with e₀ in the denominator are left out.
const LEAST_ECCENTRICITY: f64 = 1e-4;

/// What drag does to every orbit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Drag {
    /// C₁: a falls by the factor (1 − C₁t)².
    pub c1: f64,
    /// B*C₄: e falls by B*C₄t.
    pub bstar_c4: f64,
    /// 3/2 C₁: the mean longitude grows by n₀ · 3/2 C₁t².
    pub longitude_t2: f64,
    /// 7/2 β₀² times the first-order rate of Ω, times C₁: Ω grows by this times t².
    pub raan_t2: f64,
}

/// What drag does besides, when the perigee is at least 220 km high and the period below 225 min.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct HigherDrag {
    pub eta: f64,
    /// (1 + η cos M₀)³
    pub perigee_drag_at_epoch: f64,
    pub sin_mean_anomaly_at_epoch: f64,
    /// M grows, and ω falls, by this times t …
    pub anomaly_t: f64,
    /// … and by this times (1 + η cos M)³ − (1 + η cos M₀)³.
    pub anomaly_perigee: f64,
    pub bstar_c5: f64,
    pub d2: f64,
    pub d3: f64,
    pub d4: f64,
    pub longitude_t3: f64,
    pub longitude_t4: f64,
    pub longitude_t5: f64,
}

/// The density law ρ = ρ₀ ((q₀ − s)/(r − s))⁴, fitted to the height of the perigee.
///
/// q₀ is 120 km high. s is 78 km high, for perigees below 156 km 78 km below the perigee, and for
/// perigees below 98 km 20 km high.
#[derive(Debug, Clone, Copy, PartialEq)]
struct DensityFit {
    s: f64,
    q0_minus_s_4: f64,
}

impl DensityFit {
    fn at_perigee(perigee_radius: f64) -> Self {
        let height_km = (perigee_radius - 1.0) * EARTH_RADIUS_KM;
        let s_height_km = if height_km < 98.0 {
            20.0
        } else if height_km < 156.0 {
            height_km - 78.0
        } else {
            78.0
        };
        let q0_minus_s = (120.0 - s_height_km) / EARTH_RADIUS_KM;
        let squared = q0_minus_s * q0_minus_s;
        Self { s: s_height_km / EARTH_RADIUS_KM + 1.0, q0_minus_s_4: squared * squared }
    }
}

/// Both sets of drag terms of an orbit.
pub(crate) fn drag_terms(
    orbit: &MeanOrbit,
    rates: &SecularRates,
    bstar: f64,
) -> Result<(Drag, Option<HigherDrag>), Error> {
    let fit = DensityFit::at_perigee(orbit.perigee_radius());
    let n0 = orbit.mean_motion;
    let a0 = orbit.semi_major_axis;
    let e0 = orbit.eccentricity;
    let inclination = &orbit.inclination;

    let xi = 1.0 / (a0 - fit.s);
    let eta = a0 * e0 * xi;
    let eta2 = eta * eta;
    let e_eta = e0 * eta;
    let psi2 = (1.0 - eta2).abs();
    let xi2 = xi * xi;
    // (q₀ − s)⁴ ξ⁴ and the same over |1 − η²|^(7/2)
    let density = fit.q0_minus_s_4 * xi2 * xi2;
    let density_psi = density / (psi2 * psi2 * psi2 * libm::sqrt(psi2));

    // C₂ = (q₀−s)⁴ξ⁴ n₀ |1−η²|^(−7/2)
    //      [a₀(1 + 3/2 η² + 4eη + eη³) + ⅜ J₂ ξ/|1−η²| (3θ²−1)(8 + 24η² + 3η⁴)]
    let c2 = density_psi
        * n0
        * (a0 * (1.0 + 1.5 * eta2 + e_eta * (4.0 + eta2))
            + 0.375 * J2 * xi / psi2
                * inclination.three_theta2_minus_1
                * (8.0 + 3.0 * eta2 * (8.0 + eta2)));
    let c1 = bstar * c2;

    // C₄ = 2n₀ (q₀−s)⁴ξ⁴ a₀β₀² |1−η²|^(−7/2) {η(2 + ½η²) + e(½ + 2η²) − J₂ξ/(a₀|1−η²|) ×
    //      [−3(3θ²−1)(1 − 2eη + 3/2 η² − ½eη³) + ¾(1−θ²)(2η² − eη − eη³) cos 2ω₀]}
    let perigee = SinCos::of(orbit.argument_of_perigee);
    let cos_2w = perigee.plus(perigee).cos;
    let c4 = 2.0
        * n0
        * density_psi
        * a0
        * orbit.beta2
        * (eta * (2.0 + 0.5 * eta2) + e0 * (0.5 + 2.0 * eta2)
            - J2 * xi / (a0 * psi2)
                * (-3.0
                    * inclination.three_theta2_minus_1
                    * (1.0 - 2.0 * e_eta + eta2 * (1.5 - 0.5 * e_eta))
                    + 0.75
                        * inclination.one_minus_theta2
                        * (2.0 * eta2 - e_eta * (1.0 + eta2))
                        * cos_2w));

    let drag = Drag {
        c1,
        bstar_c4: bstar * c4,
        longitude_t2: 1.5 * c1,
        // 7/2 β₀² · (first-order Ω̇) · C₁
        raan_t2: 3.5 * orbit.beta2 * rates.raan_first_order * c1,
    };
    if !(drag.c1.is_finite() && drag.bstar_c4.is_finite()) {
        let perigee_height_km = (orbit.perigee_radius() - 1.0) * EARTH_RADIUS_KM;
        return Err(Error::DragModel { perigee_height_km });
    }
    if orbit.perigee_radius() < SIMPLE_BELOW_PERIGEE_KM / EARTH_RADIUS_KM + 1.0 {
        return Ok((drag, None));
    }

    // C₃ = −2 (q₀−s)⁴ξ⁵ (J₃/J₂) n₀ sin i₀ / e₀
    let c3 = if e0 > LEAST_ECCENTRICITY {
        -2.0 * density * xi * J3_OVER_J2 * n0 * inclination.angle.sin / e0
    } else {
        0.0
    };
    // C₅ = 2 (q₀−s)⁴ξ⁴ a₀β₀² |1−η²|^(−7/2) [1 + 11/4 η(η + e) + eη³]
    let c5 = 2.0 * density_psi * a0 * orbit.beta2 * (1.0 + 2.75 * (eta2 + e_eta) + e_eta * eta2);
    let c1_2 = c1 * c1;
    // D₂ = 4a₀ξC₁², D₃ = 4/3 a₀ξ²(17a₀ + s)C₁³, D₄ = ⅔ a₀²ξ³(221a₀ + 31s)C₁⁴
    let d2 = 4.0 * a0 * xi * c1_2;
    let d2_xi_c1_third = d2 * xi * c1 / 3.0;
    let d3 = (17.0 * a0 + fit.s) * d2_xi_c1_third;
    let d4 = 0.5 * d2_xi_c1_third * a0 * xi * (221.0 * a0 + 31.0 * fit.s) * c1;
    let mean_anomaly = SinCos::of(orbit.mean_anomaly);
    let at_epoch = 1.0 + eta * mean_anomaly.cos;
    let higher = HigherDrag {
        eta,
        perigee_drag_at_epoch: at_epoch * at_epoch * at_epoch,
        sin_mean_anomaly_at_epoch: mean_anomaly.sin,
        // B*C₃ cos ω₀
        anomaly_t: bstar * c3 * perigee.cos,
        // −⅔ (q₀−s)⁴ξ⁴ B* / (eη)
        anomaly_perigee: if e0 > LEAST_ECCENTRICITY {
            -2.0 / 3.0 * density * bstar / e_eta
        } else {
            0.0
        },
        bstar_c5: bstar * c5,
        d2,
        d3,
        d4,
        // D₂ + 2C₁²
        longitude_t3: d2 + 2.0 * c1_2,
        // ¼ (3D₃ + 12C₁D₂ + 10C₁³)
        longitude_t4: 0.25 * (3.0 * d3 + c1 * (12.0 * d2 + 10.0 * c1_2)),
        // ⅕ (3D₄ + 12C₁D₃ + 6D₂² + 15C₁²(2D₂ + C₁²))
        longitude_t5: 0.2
            * (3.0 * d4 + 12.0 * c1 * d3 + 6.0 * d2 * d2 + 15.0 * c1_2 * (2.0 * d2 + c1_2)),
    };
    Ok((drag, Some(higher)))
}
