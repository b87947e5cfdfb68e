//! SGP4 proper: orbits with a period below 225 minutes.

use crate::angle::SinCos;
use crate::drag::{Drag, HigherDrag, drag_terms};
use crate::mean_orbit::{MeanOrbit, SecularRates};
use crate::periodic::{MeanState, position_and_velocity};
use crate::{Error, State};

/// Lowest mean eccentricity that is taken for a rounding of zero …
pub(crate) const LEAST_MEAN_ECCENTRICITY: f64 = -0.001;
/// … and what the theory goes on with below this value.
pub(crate) const LEAST_USED_ECCENTRICITY: f64 = 1e-6;

/// Everything about a near-Earth orbit that does not depend on time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct NearEarth {
    orbit: MeanOrbit,
    sqrt_semi_major_axis: f64,
    rates: SecularRates,
    drag: Drag,
    higher: Option<HigherDrag>,
}

impl NearEarth {
    pub fn new(orbit: MeanOrbit, bstar: f64) -> Result<Self, Error> {
        let rates = orbit.secular_rates();
        let (drag, higher) = drag_terms(&orbit, &rates, bstar)?;
        let sqrt_semi_major_axis = libm::sqrt(orbit.semi_major_axis);
        Ok(Self { orbit, sqrt_semi_major_axis, rates, drag, higher })
    }

    /// Position and velocity (TEME) at `t` minutes from the epoch.
    pub fn propagate(&self, t: f64) -> Result<State, Error> {
        let (orbit, rates, drag) = (&self.orbit, &self.rates, &self.drag);
        let t2 = t * t;
        // Secular changes by the zonal harmonics, and Ω by drag.
        let mut anomaly = SinCos::of(orbit.mean_anomaly + rates.mean_anomaly * t);
        let mut perigee = orbit.argument_of_perigee + rates.argument_of_perigee * t;
        let raan = SinCos::of(orbit.raan + rates.raan * t + drag.raan_t2 * t2);

        // Drag: a = a₀ (1 − C₁t − …)², e = e₀ − B*C₄t − …, and the mean longitude.
        let mut sqrt_a_factor = 1.0 - drag.c1 * t;
        let mut eccentricity = orbit.eccentricity - drag.bstar_c4 * t;
        let mut longitude = drag.longitude_t2 * t2;
        if let Some(higher) = &self.higher {
            // δM = −δω = B*C₃ cos ω₀ t − ⅔ … [(1 + η cos M)³ − (1 + η cos M₀)³]
            let at_perigee = 1.0 + higher.eta * anomaly.cos;
            let perigee_drag = at_perigee * at_perigee * at_perigee;
            let shift = higher.anomaly_t * t
                + higher.anomaly_perigee * (perigee_drag - higher.perigee_drag_at_epoch);
            anomaly = anomaly.turned_by(shift);
            perigee -= shift;
            // 1 − C₁t − D₂t² − D₃t³ − D₄t⁴
            sqrt_a_factor -= t2 * (higher.d2 + t * (higher.d3 + t * higher.d4));
            // e₀ − B*C₄t − B*C₅ (sin M − sin M₀)
            eccentricity -= higher.bstar_c5 * (anomaly.sin - higher.sin_mean_anomaly_at_epoch);
            // 3/2 C₁t² + … t³ + … t⁴ + … t⁵
            longitude += t2
                * t
                * (higher.longitude_t3 + t * (higher.longitude_t4 + t * higher.longitude_t5));
        }
        if !(LEAST_MEAN_ECCENTRICITY..1.0).contains(&eccentricity) {
            return Err(Error::MeanEccentricity { eccentricity, minutes_since_epoch: t });
        }

        let perigee = SinCos::of(perigee);
        let mean = MeanState {
            sqrt_semi_major_axis: self.sqrt_semi_major_axis * sqrt_a_factor.abs(),
            eccentricity: eccentricity.max(LEAST_USED_ECCENTRICITY),
            argument_of_perigee: perigee,
            latitude: anomaly.plus(perigee),
            latitude_change: orbit.mean_motion * longitude,
            raan,
        };
        position_and_velocity(&mean, &orbit.inclination, t)
    }
}
