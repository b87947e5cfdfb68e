//! SDP4: orbits with a period of 225 minutes and more, which Sun, Moon and the tesseral harmonics
//! of the Earth's field disturb.
//!
//! Source: Hoots & Roehrich, Spacetrack Report No. 3, sections 7 and 10; Vallado et al.,
//! AIAA 2006-6753 (opsmode "improved").

mod geopotential;
mod lunisolar;
mod resonance;

pub use resonance::ResonanceState;

use crate::angle::SinCos;
use crate::drag::{Drag, drag_terms};
use crate::gravity::KE;
use crate::mean_orbit::{Inclination, MeanOrbit, SecularRates};
use crate::near_earth::{LEAST_MEAN_ECCENTRICITY, LEAST_USED_ECCENTRICITY};
use crate::periodic::{MeanState, position_and_velocity};
use crate::{Epoch, Error, State};
use core::f64::consts::{PI, TAU};
use geopotential::{HalfDay, Synchronous};
use lunisolar::{ElementChanges, Lunisolar, PeriodicChanges};
use resonance::{Motion, PerigeeMotion, Pull, Resonance, Solution};

/// Julian date of 1900 January 0.5, from which the places of Sun and Moon are counted in days.
const JULIAN_DATE_1900: f64 = 2_415_020.0;

/// Rotation of the Earth with respect to the equinox, rad/min.
const EARTH_RATE_RAD_PER_MIN: f64 = 4.375_269_088_011_3e-3;

/// Mean motions (rad/min) of orbits in resonance once a day …
const SYNCHRONOUS_ABOVE: f64 = 0.003_490_658_5;
const SYNCHRONOUS_BELOW: f64 = 0.005_235_987_7;
/// … and twice a day, where only eccentric orbits are.
const HALF_DAY_FROM: f64 = 8.26e-3;
const HALF_DAY_TO: f64 = 9.24e-3;
const HALF_DAY_LEAST_ECCENTRICITY: f64 = 0.5;

/// From this perturbed inclination on (rad), the periodic changes of node and perigee are applied
/// as such; below it, sin i is too small to divide by.
const LYDDANE_BELOW_RAD: f64 = 0.2;

/// Below this relative change of the mean motion, a series gives the cube root to rounding: the
/// first neglected term is 22/729 · 1e-15. Resonance changes it by some 1e-4.
const SMALL_MEAN_MOTION_CHANGE: f64 = 1e-3;

/// Everything about a deep-space orbit that does not depend on time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct DeepSpace {
    orbit: MeanOrbit,
    sqrt_semi_major_axis_at_epoch: f64,
    rates: SecularRates,
    drag: Drag,
    lunisolar: Lunisolar,
    greenwich_at_epoch: f64,
    resonance: Option<Resonance>,
}

/// Mean elements at one time.
#[derive(Debug, Clone, Copy)]
struct ElementsAt {
    eccentricity: f64,
    inclination: f64,
    raan: f64,
    argument_of_perigee: f64,
    mean_anomaly: f64,
}

impl DeepSpace {
    pub fn new(orbit: MeanOrbit, bstar: f64, epoch: Epoch) -> Result<Self, Error> {
        let rates = orbit.secular_rates();
        let (drag, _) = drag_terms(&orbit, &rates, bstar)?;
        // In one double, 40 µs coarse, on purpose: the reference does so, and states then agree to
        // 1e-7 km instead of 4e-6 km. The rounding moves Sun, Moon and
        // Greenwich only, not the satellite along its orbit.
        let (midnight, fraction) = epoch.julian_date();
        let julian_date = midnight + fraction;
        let lunisolar = Lunisolar::new(&orbit, julian_date - JULIAN_DATE_1900);
        let greenwich_at_epoch = greenwich_sidereal_time(julian_date);
        let resonance = resonance_of(&orbit, &rates, &lunisolar.rates, greenwich_at_epoch);
        Ok(Self {
            orbit,
            sqrt_semi_major_axis_at_epoch: libm::sqrt(orbit.semi_major_axis),
            rates,
            drag,
            lunisolar,
            greenwich_at_epoch,
            resonance,
        })
    }

    /// Position and velocity (TEME) at `t` minutes from the epoch.
    pub fn propagate(&self, t: f64, resume: &mut ResonanceState) -> Result<State, Error> {
        let (orbit, drag) = (&self.orbit, &self.drag);
        let mut mean = self.secular(t);
        let mut mean_motion = orbit.mean_motion;
        if let Some(resonance) = &self.resonance {
            if t.abs() > resonance::MAX_MINUTES {
                return Err(Error::ResonanceTime { minutes_since_epoch: t });
            }
            let resonant = resonance.at(t, resume);
            mean_motion = resonant.mean_motion;
            let greenwich = self.greenwich_at_epoch + EARTH_RATE_RAD_PER_MIN * t;
            mean.mean_anomaly = match resonance.pull() {
                // M = λ − Ω − ω + Θ
                Pull::Synchronous(_) => {
                    resonant.longitude - mean.raan - mean.argument_of_perigee + greenwich
                }
                // M = λ − 2Ω + 2Θ
                Pull::HalfDay(..) => resonant.longitude + 2.0 * (greenwich - mean.raan),
            };
        }
        if !(f64::MIN_POSITIVE..).contains(&mean_motion) {
            return Err(Error::MeanMotion { rad_per_min: mean_motion, minutes_since_epoch: t });
        }

        // Drag: √a = (kₑ/n)^⅓ |1 − C₁t|, e falls by B*C₄t, M grows by n₀ 3/2 C₁t².
        let a_factor = 1.0 - drag.c1 * t;
        let sqrt_semi_major_axis = self.sqrt_semi_major_axis(mean_motion) * a_factor.abs();
        let eccentricity = mean.eccentricity - drag.bstar_c4 * t;
        if !(LEAST_MEAN_ECCENTRICITY..1.0).contains(&eccentricity) {
            return Err(Error::MeanEccentricity { eccentricity, minutes_since_epoch: t });
        }
        mean.eccentricity = eccentricity.max(LEAST_USED_ECCENTRICITY);
        mean.mean_anomaly += orbit.mean_motion * drag.longitude_t2 * t * t;

        let perturbed = with_periodic_changes(&mean, &self.lunisolar.periodic(t));
        if !(0.0..=1.0).contains(&perturbed.eccentricity) {
            return Err(Error::PerturbedEccentricity {
                eccentricity: perturbed.eccentricity,
                minutes_since_epoch: t,
            });
        }
        let state = MeanState {
            sqrt_semi_major_axis,
            eccentricity: perturbed.eccentricity,
            argument_of_perigee: SinCos::of(perturbed.argument_of_perigee),
            latitude: SinCos::of(perturbed.mean_anomaly + perturbed.argument_of_perigee),
            latitude_change: 0.0,
            raan: SinCos::of(perturbed.raan),
        };
        position_and_velocity(&state, &Inclination::new(perturbed.inclination), t)
    }

    /// √a = (kₑ/n)^⅓, which is √a₀ where there is no resonance, and near it where there is.
    fn sqrt_semi_major_axis(&self, mean_motion: f64) -> f64 {
        // (n₀/n)^⅓ = (1 + x)^⅓ = 1 + x/3 − x²/9 + 5x³/81 − 10x⁴/243 + …
        let x = self.orbit.mean_motion / mean_motion - 1.0;
        if x.abs() < SMALL_MEAN_MOTION_CHANGE {
            let series = 1.0 / 3.0 - x * (1.0 / 9.0 - x * (5.0 / 81.0 - x * (10.0 / 243.0)));
            self.sqrt_semi_major_axis_at_epoch * (1.0 + x * series)
        } else {
            libm::cbrt(KE / mean_motion)
        }
    }

    /// The mean elements after the secular changes by zonal harmonics, Sun, Moon, and Ω by drag.
    fn secular(&self, t: f64) -> ElementsAt {
        let (orbit, zonal, third_bodies) = (&self.orbit, &self.rates, &self.lunisolar.rates);
        ElementsAt {
            eccentricity: orbit.eccentricity + third_bodies.eccentricity * t,
            inclination: orbit.inclination_rad + third_bodies.inclination * t,
            raan: orbit.raan + (zonal.raan + third_bodies.raan) * t + self.drag.raan_t2 * t * t,
            argument_of_perigee: orbit.argument_of_perigee
                + (zonal.argument_of_perigee + third_bodies.argument_of_perigee) * t,
            mean_anomaly: orbit.mean_anomaly + (zonal.mean_anomaly + third_bodies.mean_anomaly) * t,
        }
    }
}

/// The resonance that an orbit is in, if any.
fn resonance_of(
    orbit: &MeanOrbit,
    zonal: &SecularRates,
    third_bodies: &ElementChanges,
    greenwich_at_epoch: f64,
) -> Option<Resonance> {
    let n = orbit.mean_motion;
    let anomaly_rate = zonal.mean_anomaly + third_bodies.mean_anomaly;
    let raan_rate = zonal.raan + third_bodies.raan;
    let perigee_rate = zonal.argument_of_perigee + third_bodies.argument_of_perigee;
    let (longitude, longitude_rate, pull) = if n > SYNCHRONOUS_ABOVE && n < SYNCHRONOUS_BELOW {
        // λ = M + Ω + ω − Θ
        let longitude =
            orbit.mean_anomaly + orbit.raan + orbit.argument_of_perigee - greenwich_at_epoch;
        let rate = anomaly_rate + raan_rate + perigee_rate - EARTH_RATE_RAD_PER_MIN;
        (longitude, rate, Pull::Synchronous(Synchronous::new(orbit)))
    } else if (HALF_DAY_FROM..=HALF_DAY_TO).contains(&n)
        && orbit.eccentricity >= HALF_DAY_LEAST_ECCENTRICITY
    {
        // λ = M + 2Ω − 2Θ
        let longitude = orbit.mean_anomaly + 2.0 * (orbit.raan - greenwich_at_epoch);
        let rate = anomaly_rate + 2.0 * (raan_rate - EARTH_RATE_RAD_PER_MIN);
        let perigee =
            PerigeeMotion { at_epoch: orbit.argument_of_perigee, rate: zonal.argument_of_perigee };
        (longitude, rate, Pull::HalfDay(HalfDay::new(orbit), perigee))
    } else {
        return None;
    };
    let at_epoch = Solution { longitude, mean_motion: n };
    Some(Resonance::new(at_epoch, Motion { pull, longitude_rate_without_n: longitude_rate - n }))
}

/// Mean elements with periodic changes.
#[derive(Debug, Clone, Copy)]
struct Perturbed {
    eccentricity: f64,
    inclination: SinCos,
    raan: f64,
    argument_of_perigee: f64,
    mean_anomaly: f64,
}

/// The mean elements with the lunar and solar periodic changes, inclination not negative.
fn with_periodic_changes(mean: &ElementsAt, changes: &PeriodicChanges) -> Perturbed {
    let inclination = mean.inclination + changes.inclination;
    let eccentricity = mean.eccentricity + changes.eccentricity;
    let mean_anomaly = mean.mean_anomaly + changes.mean_anomaly;
    let SinCos { sin: sin_i, cos: cos_i } = SinCos::of(inclination);
    // The sign of Ω is kept in the reduction to one turn, as in the reference: it enters below.
    let raan = within_one_turn(mean.raan, TAU);
    let mut perturbed = if inclination >= LYDDANE_BELOW_RAD {
        let raan_change = changes.sin_i_node / sin_i;
        Perturbed {
            eccentricity,
            inclination: SinCos { sin: sin_i, cos: cos_i },
            raan: raan + raan_change,
            argument_of_perigee: mean.argument_of_perigee + changes.perigee_and_node
                - cos_i * raan_change,
            mean_anomaly,
        }
    } else {
        // Lyddane: change sin i sin Ω, sin i cos Ω and the mean longitude M + ω + cos i Ω instead.
        let SinCos { sin: sin_raan, cos: cos_raan } = SinCos::of(raan);
        let alpha = sin_i * sin_raan
            + changes.sin_i_node * cos_raan
            + changes.inclination * cos_i * sin_raan;
        let beta = sin_i * cos_raan - changes.sin_i_node * sin_raan
            + changes.inclination * cos_i * cos_raan;
        let longitude = mean.mean_anomaly
            + mean.argument_of_perigee
            + cos_i * raan
            + changes.mean_anomaly
            + changes.perigee_and_node
            - changes.inclination * raan * sin_i;
        let perturbed_raan = on_the_turn_of(raan, libm::atan2(alpha, beta));
        Perturbed {
            eccentricity,
            inclination: SinCos { sin: sin_i, cos: cos_i },
            raan: perturbed_raan,
            argument_of_perigee: longitude - mean_anomaly - cos_i * perturbed_raan,
            mean_anomaly,
        }
    };
    if inclination < 0.0 {
        perturbed.inclination.sin = -sin_i;
        perturbed.raan += PI;
        perturbed.argument_of_perigee -= PI;
    }
    perturbed
}

/// The angle less its whole turns, with its sign.
fn within_one_turn(angle: f64, turn: f64) -> f64 {
    angle - turn * libm::trunc(angle / turn)
}

/// The angle, moved by one turn when it is more than half a turn from the other.
fn on_the_turn_of(other: f64, angle: f64) -> f64 {
    if (other - angle).abs() <= PI {
        angle
    } else if angle < other {
        angle + TAU
    } else {
        angle - TAU
    }
}

/// Greenwich mean sidereal time (1982), radians, with UT1 taken to be UTC.
///
/// Source: Vallado et al., AIAA 2006-6753, `gstime`; Aoki et al., Astron. Astrophys. 105 (1982).
fn greenwich_sidereal_time(julian_date: f64) -> f64 {
    let centuries = (julian_date - 2_451_545.0) / 36_525.0;
    let seconds = 67_310.548_41
        + centuries
            * (876_600.0 * 3600.0
                + 8_640_184.812_866
                + centuries * (0.093_104 - centuries * 6.2e-6));
    // 240 s of time are one degree.
    within_one_turn(seconds / 240.0, 360.0).to_radians()
}
