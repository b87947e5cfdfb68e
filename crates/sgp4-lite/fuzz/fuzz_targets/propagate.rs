//! Elements that were read are in their ranges; their orbits have finite states or errors.

use sgp4_lite::{
    Elements, Error, MinutesSinceEpoch, PlausibilityLimits, Propagator, check_plausibility,
};

pub fn at_any_time(elements: &Elements) {
    let _ = check_plausibility(elements, 0.0, &PlausibilityLimits::within_days(1e4));
    match Propagator::new(elements) {
        Ok(propagator) => {
            for minutes in [0.0, 1.0, -1440.0, 1e4, 1e9, -1e300] {
                if let Ok(state) = propagator.propagate(MinutesSinceEpoch(minutes)) {
                    let numbers = state.position_km.into_iter().chain(state.velocity_km_s);
                    assert!(numbers.into_iter().all(f64::is_finite));
                }
            }
        }
        Err(error) => assert!(matches!(error, Error::DragModel { .. }), "{error}"),
    }
}
