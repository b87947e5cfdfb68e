//! The mean orbit at the epoch, as the theory wants it: radians, minutes, Earth radii, and the mean
//! motion of Brouwer instead of Kozai's. Its secular rates under J₂ and J₄.
//!
//! | symbol | code |
//! |---|---|
//! | n₀ | `mean_motion` (rad/min) |
//! | a₀ | `semi_major_axis` (Earth radii) |
//! | e₀ | `eccentricity` |
//! | β₀² | `beta2` = 1 − e₀² |
//! | i₀ | `inclination` |
//! | θ | `inclination.angle.cos` |
//! | Ω₀ | `raan` |
//! | ω₀ | `argument_of_perigee` |
//! | M₀ | `mean_anomaly` |
//! | p₀ | `semi_latus_rectum` = a₀ β₀² |
//!
//! Source: Hoots & Roehrich, Spacetrack Report No. 3, section 6; Hoots, Schumacher & Glover,
//! "History of Analytical Orbit Modeling in the U.S. Space Surveillance System", J. Guidance 27(2),
//! 2004, appendix B.

use crate::Elements;
use crate::angle::SinCos;
use crate::gravity::{J2, J3_OVER_J2, J4, KE, RAD_PER_MIN_PER_REV_PER_DAY, two_thirds_power};

/// Below this value of 1 + cos i the long-period term of the mean longitude, which has it in its
/// denominator, is held: the orbit is exactly retrograde.
const LEAST_ONE_PLUS_COS_INCLINATION: f64 = 1.5e-12;

/// The mean elements at the epoch, in the units of the theory.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct MeanOrbit {
    pub mean_motion: f64,
    pub semi_major_axis: f64,
    pub eccentricity: f64,
    pub beta2: f64,
    pub semi_latus_rectum: f64,
    pub inclination_rad: f64,
    pub inclination: Inclination,
    pub raan: f64,
    pub argument_of_perigee: f64,
    pub mean_anomaly: f64,
}

impl MeanOrbit {
    /// The mean orbit that published elements, all in their ranges, stand for.
    pub fn new(elements: &Elements) -> Self {
        let kozai_mean_motion = elements.mean_motion_rev_per_day * RAD_PER_MIN_PER_REV_PER_DAY;
        let eccentricity = elements.eccentricity;
        let beta2 = 1.0 - eccentricity * eccentricity;
        let inclination_rad = elements.inclination_deg.to_radians();
        let inclination = Inclination::new(SinCos::of(inclination_rad));

        // a₁ = (kₑ / n)^⅔
        let a1 = two_thirds_power(KE / kozai_mean_motion);
        // δ(a) = ¾ J₂ (3θ² − 1) / (a² β₀³)
        let delta = 0.75 * J2 * inclination.three_theta2_minus_1 / (beta2 * libm::sqrt(beta2));
        let delta1 = delta / (a1 * a1);
        // a₂ = a₁ (1 − ⅓δ₁ − δ₁² − 134/81 δ₁³)
        let a2 = a1 * (1.0 - delta1 * (1.0 / 3.0 + delta1 * (1.0 + 134.0 / 81.0 * delta1)));
        // n₀ = n / (1 + δ₀), δ₀ = δ(a₂)
        let mean_motion = kozai_mean_motion / (1.0 + delta / (a2 * a2));
        // a₀ = (kₑ / n₀)^⅔
        let semi_major_axis = two_thirds_power(KE / mean_motion);

        Self {
            mean_motion,
            semi_major_axis,
            eccentricity,
            beta2,
            semi_latus_rectum: semi_major_axis * beta2,
            inclination_rad,
            inclination,
            raan: elements.raan_deg.to_radians(),
            argument_of_perigee: elements.argument_of_perigee_deg.to_radians(),
            mean_anomaly: elements.mean_anomaly_deg.to_radians(),
        }
    }

    /// Radius of the mean perigee, Earth radii.
    pub fn perigee_radius(&self) -> f64 {
        self.semi_major_axis * (1.0 - self.eccentricity)
    }

    /// The rates which J₂, J₂² and J₄ give to the mean angles.
    pub fn secular_rates(&self) -> SecularRates {
        let n = self.mean_motion;
        let p2_inverse = 1.0 / (self.semi_latus_rectum * self.semi_latus_rectum);
        let theta = self.inclination.angle.cos;
        let theta2 = theta * theta;
        let theta4 = theta2 * theta2;
        let beta = libm::sqrt(self.beta2);
        // k₁ = 3/2 J₂ n₀ / p₀², k₂ = ½ k₁ J₂ / p₀², k₄ = −15/32 J₄ n₀ / p₀⁴
        let k1 = 1.5 * J2 * p2_inverse * n;
        let k2 = 0.5 * k1 * J2 * p2_inverse;
        let k4 = -0.46875 * J4 * p2_inverse * p2_inverse * n;
        // Ṁ = n₀ + ½k₁β₀(3θ² − 1) + k₂β₀(13 − 78θ² + 137θ⁴)/16
        let mean_anomaly = n
            + 0.5 * k1 * beta * self.inclination.three_theta2_minus_1
            + 0.0625 * k2 * beta * (13.0 - 78.0 * theta2 + 137.0 * theta4);
        // ω̇ = −½k₁(1 − 5θ²) + k₂(7 − 114θ² + 395θ⁴)/16 + k₄(3 − 36θ² + 49θ⁴)
        let argument_of_perigee = -0.5 * k1 * (1.0 - 5.0 * theta2)
            + 0.0625 * k2 * (7.0 - 114.0 * theta2 + 395.0 * theta4)
            + k4 * (3.0 - 36.0 * theta2 + 49.0 * theta4);
        // Ω̇ = −k₁θ + (½k₂(4 − 19θ²) + 2k₄(3 − 7θ²))θ
        let raan_first_order = -k1 * theta;
        let raan = raan_first_order
            + (0.5 * k2 * (4.0 - 19.0 * theta2) + 2.0 * k4 * (3.0 - 7.0 * theta2)) * theta;
        SecularRates { mean_anomaly, argument_of_perigee, raan, raan_first_order }
    }
}

/// Secular rates of the mean angles, rad/min.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct SecularRates {
    pub mean_anomaly: f64,
    pub argument_of_perigee: f64,
    pub raan: f64,
    /// The part of `raan` that is linear in J₂.
    pub raan_first_order: f64,
}

/// An inclination with the functions of it that the periodic terms use.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Inclination {
    pub angle: SinCos,
    /// 3θ² − 1
    pub three_theta2_minus_1: f64,
    /// 1 − θ²
    pub one_minus_theta2: f64,
    /// 7θ² − 1
    pub seven_theta2_minus_1: f64,
    /// −½ (J₃/J₂) sin i, the long-period term of e sin ω.
    pub long_period_ay: f64,
    /// −¼ (J₃/J₂) sin i (3 + 5θ)/(1 + θ), the long-period term of the mean longitude.
    pub long_period_longitude: f64,
}

impl Inclination {
    pub fn new(angle: SinCos) -> Self {
        let SinCos { sin, cos: theta } = angle;
        let theta2 = theta * theta;
        let one_plus_theta = if (1.0 + theta).abs() > LEAST_ONE_PLUS_COS_INCLINATION {
            1.0 + theta
        } else {
            LEAST_ONE_PLUS_COS_INCLINATION
        };
        Self {
            angle,
            three_theta2_minus_1: 3.0 * theta2 - 1.0,
            one_minus_theta2: 1.0 - theta2,
            seven_theta2_minus_1: 7.0 * theta2 - 1.0,
            long_period_ay: -0.5 * J3_OVER_J2 * sin,
            long_period_longitude: -0.25 * J3_OVER_J2 * sin * (3.0 + 5.0 * theta) / one_plus_theta,
        }
    }
}
