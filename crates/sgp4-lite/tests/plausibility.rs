//! Which elements an uplink may bring.

mod common;

use common::{GOOD, with_text};
use sgp4_lite::{Element, Elements, Epoch, Implausible, PlausibilityLimits, check_plausibility};

const LIMITS: PlausibilityLimits = PlausibilityLimits::within_days(14.0);

fn good() -> Elements {
    Elements::from_tle(GOOD[0], GOOD[1]).unwrap()
}

/// An instant as the days that `check_plausibility` takes.
fn days(epoch: Epoch) -> f64 {
    f64::from(epoch.days_since_j2000_midnight()) + epoch.fraction_of_day()
}

#[test]
fn fresh_elements_of_a_real_orbit_are_plausible() {
    let now = days(good().epoch);
    for ahead in [-14.0, -1.0, 0.0, 1.0, 14.0] {
        assert_eq!(check_plausibility(&good(), now + ahead, &LIMITS), Ok(()));
    }
}

#[test]
fn an_epoch_far_from_the_clock_is_refused_either_way() {
    let now = days(good().epoch);
    for ahead in [-14.5, 14.5, f64::INFINITY] {
        assert_eq!(
            check_plausibility(&good(), now - ahead, &LIMITS),
            Err(Implausible::Epoch { days_ahead: ahead, limit: 14.0 })
        );
    }
}

#[test]
fn a_clock_that_is_not_a_number_is_refused() {
    let refused = check_plausibility(&good(), f64::NAN, &LIMITS);
    assert!(matches!(refused, Err(Implausible::Epoch { days_ahead, .. }) if days_ahead.is_nan()));
}

#[test]
fn an_orbit_through_the_earth_is_refused() {
    // 14.457 rev/day has a semi-major axis of 7110 km: the perigee is at the surface for e = 0.103.
    let with_eccentricity = |text: &str| {
        let elements = Elements::from_tle(GOOD[0], with_text(GOOD[1], 27, text)).unwrap();
        check_plausibility(&elements, days(elements.epoch), &LIMITS)
    };
    assert_eq!(with_eccentricity("1000000"), Ok(()));
    let refused = with_eccentricity("1100000");
    assert!(matches!(refused, Err(Implausible::Perigee { height_km, .. }) if height_km < 0.0));
}

#[test]
fn the_lowest_perigee_is_the_missions_choice() {
    let limits = PlausibilityLimits { min_perigee_height_km: 800.0, ..LIMITS };
    let refused = check_plausibility(&good(), days(good().epoch), &limits);
    // Kepler's third law gives a = 7118 km and so 734 km; Brouwer's semi-major axis differs by less
    // than 10 km.
    assert!(
        matches!(refused, Err(Implausible::Perigee { height_km, limit_km: 800.0 })
            if (725.0..745.0).contains(&height_km)),
        "{refused:?}"
    );
}

#[test]
fn a_mean_motion_outside_the_limits_is_refused() {
    for (text, rev_per_day) in [("17.05000000", 17.05), (" 0.04000000", 0.04)] {
        let elements = Elements::from_tle(GOOD[0], with_text(GOOD[1], 53, text)).unwrap();
        assert_eq!(
            check_plausibility(&elements, days(elements.epoch), &LIMITS),
            Err(Implausible::MeanMotion { rev_per_day })
        );
    }
}

#[test]
fn elements_out_of_range_are_refused_first() {
    let elements = Elements { eccentricity: 1.5, ..good() };
    assert_eq!(
        check_plausibility(&elements, f64::NAN, &LIMITS),
        Err(Implausible::Element { element: Element::Eccentricity, value: 1.5 })
    );
}
