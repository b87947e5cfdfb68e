//! What a propagator does at its edges.

mod common;

use common::GOOD;
use sgp4_lite::{Element, Elements, Error, MinutesSinceEpoch, Propagator};

fn good() -> Elements {
    Elements::from_tle(GOOD[0], GOOD[1]).unwrap()
}

#[test]
fn elements_out_of_range_are_refused() {
    for (elements, element) in [
        (Elements { bstar_per_earth_radius: f64::NAN, ..good() }, Element::Bstar),
        (Elements { inclination_deg: -0.1, ..good() }, Element::Inclination),
        (Elements { raan_deg: f64::INFINITY, ..good() }, Element::Raan),
        (Elements { eccentricity: 1.0, ..good() }, Element::Eccentricity),
        (Elements { argument_of_perigee_deg: 361.0, ..good() }, Element::ArgumentOfPerigee),
        (Elements { mean_anomaly_deg: f64::NAN, ..good() }, Element::MeanAnomaly),
        (Elements { mean_motion_rev_per_day: 0.0, ..good() }, Element::MeanMotion),
    ] {
        let refused = Propagator::new(&elements);
        assert!(
            matches!(refused, Err(Error::Element { element: named, .. }) if named == element),
            "{refused:?}"
        );
    }
}

#[test]
fn a_time_that_is_not_finite_is_an_error() {
    let propagator = Propagator::new(&good()).unwrap();
    for minutes in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let refused = propagator.propagate(MinutesSinceEpoch(minutes));
        assert!(matches!(refused, Err(Error::Time { .. })), "{refused:?}");
    }
}

#[test]
fn any_finite_time_has_a_finite_state_or_an_error() {
    let propagator = Propagator::new(&good()).unwrap();
    for exponent in -300..308 {
        for sign in [-1.0, 1.0] {
            let minutes = sign * 10_f64.powi(exponent);
            if let Ok(state) = propagator.propagate(MinutesSinceEpoch(minutes)) {
                let numbers = state.position_km.into_iter().chain(state.velocity_km_s);
                assert!(numbers.into_iter().all(f64::is_finite), "{minutes}: {state:?}");
            }
        }
    }
}

#[test]
fn states_agree_with_kepler_between_neighbouring_times() {
    const STEP_MIN: f64 = 1e-3;
    // Acceleration times half the step, 8e-3 km/s² × 0.03 s, and periodic terms that SGP4's
    // velocity leaves out, both far below this.
    const TOLERANCE_KM_S: f64 = 0.01;
    let propagator = Propagator::new(&good()).unwrap();
    for minutes in 0..1440 {
        let at =
            |offset| propagator.propagate(MinutesSinceEpoch(f64::from(minutes) + offset)).unwrap();
        let (before, after) = (at(-STEP_MIN), at(STEP_MIN));
        for axis in 0..3 {
            let slope = (after.position_km[axis] - before.position_km[axis]) / (120.0 * STEP_MIN);
            let difference = (slope - at(0.0).velocity_km_s[axis]).abs();
            assert!(difference < TOLERANCE_KM_S, "{minutes} min, axis {axis}: {difference} km/s");
        }
    }
}

#[test]
fn codes_are_those_of_the_reference_implementation() {
    let (value, minutes_since_epoch) = (0.0, 0.0);
    for (error, code) in [
        (Error::MeanEccentricity { eccentricity: value, minutes_since_epoch }, Some(1)),
        (Error::MeanMotion { rad_per_min: value, minutes_since_epoch }, Some(2)),
        (Error::PerturbedEccentricity { eccentricity: value, minutes_since_epoch }, Some(3)),
        (Error::SemiLatusRectum { earth_radii: value, minutes_since_epoch }, Some(4)),
        (Error::Decayed { radius_earth_radii: value, minutes_since_epoch }, Some(6)),
        (Error::Time { minutes_since_epoch }, None),
        (Error::DeepSpace { period_min: value }, None),
    ] {
        assert_eq!(error.code(), code, "{error}");
    }
}

#[cfg(feature = "deep-space")]
mod deep_space {
    use super::common;
    use sgp4_lite::{Error, MinutesSinceEpoch, Propagator, ResonanceState};

    const TWENTY_YEARS_MIN: f64 = 20.0 * 365.25 * 1440.0;

    fn propagators() -> impl Iterator<Item = (u32, Propagator)> {
        common::satellites(common::VALLADO_TLE)
            .into_iter()
            .chain(common::satellites(common::DEEP_TLE))
            .filter(|satellite| satellite.deep)
            .map(|satellite| {
                (satellite.elements.norad_id, Propagator::new(&satellite.elements).unwrap())
            })
    }

    #[test]
    fn a_resumed_integration_gives_the_same_bits() {
        let times =
            [0.0, 100.0, 719.9, 720.0, 5000.0, 4999.0, -1.0, -5000.0, 721.0, -720.0, 0.0, 30_000.0];
        for (number, propagator) in propagators() {
            let mut resume = ResonanceState::default();
            for minutes in times {
                let time = MinutesSinceEpoch(minutes);
                let resumed = propagator.propagate_resumed(time, &mut resume);
                assert_eq!(resumed, propagator.propagate(time), "{number} at {minutes}");
            }
        }
    }

    #[test]
    fn the_state_of_another_satellite_is_not_resumed() {
        let mut resume = ResonanceState::default();
        let time = MinutesSinceEpoch(10_000.0);
        for (number, propagator) in propagators() {
            let resumed = propagator.propagate_resumed(time, &mut resume);
            assert_eq!(resumed, propagator.propagate(time), "{number}");
        }
    }

    #[test]
    fn resonant_orbits_end_twenty_years_from_the_epoch() {
        let mut resonant = 0;
        for (number, propagator) in propagators() {
            for sign in [-1.0, 1.0] {
                let last = propagator.propagate(MinutesSinceEpoch(sign * TWENTY_YEARS_MIN));
                assert!(!matches!(last, Err(Error::ResonanceTime { .. })), "{number}: {last:?}");
            }
            let far = propagator.propagate(MinutesSinceEpoch(1e300));
            assert!(far.is_err(), "{number}: {far:?}");
            let beyond = propagator.propagate(MinutesSinceEpoch(-TWENTY_YEARS_MIN - 1.0));
            resonant += usize::from(matches!(beyond, Err(Error::ResonanceTime { .. })));
        }
        assert_eq!(resonant, RESONANT_SATELLITES);
    }

    /// In the verification set and the synthetic set together, counted from their TLEs: between 0.8
    /// and 1.2 rev/day, or between 1.893 and 2.118 rev/day with an eccentricity of at least 0.5.
    const RESONANT_SATELLITES: usize = 27;
}
