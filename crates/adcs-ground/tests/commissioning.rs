//! Random satellites on the commissioning ladder: what they report of themselves is true, and they can
//! fly with it. The whole campaign, 200 of them in two worlds, is `adcs study commissioning`.

use adcs_core::commissioning::Rung;
use adcs_ground::study::campaign::fly_all;
use adcs_ground::study::commissioning::{Quantity, Summary, World, fly};

/// Of 40 satellites: 95 %, less three standard deviations of a share of 120 numbers, which are not all
/// independent.
const LEAST_INSIDE: f64 = 0.86;
/// Root mean square of error over σ: 1, and so far from it by chance.
const RATIO: core::ops::Range<f64> = 0.75..1.35;

#[test]
fn what_they_report_of_themselves_holds() {
    let satellites = fly_all(40, |seed| fly(World::Plain, false, seed), || ()).unwrap();
    let summary = Summary::new(satellites);
    for rung in Rung::ALL {
        let (passed, at_s) = summary.rung(rung);
        println!("{rung}: {:.1} % passed, at {at_s:.0} s", 100.0 * passed);
        assert!(passed >= 0.9, "{rung}: {passed}");
    }
    for quantity in Quantity::ALL {
        let it = summary.coverage(quantity);
        let (name, ..) = quantity.shown();
        println!("{name}: {:.1} % inside, ratio {:.2}", 100.0 * it.inside, it.ratio);
        assert!(it.count >= 100, "{name}: {} numbers", it.count);
        assert!(it.inside >= LEAST_INSIDE, "{name}: {}", it.inside);
        assert!(RATIO.contains(&it.ratio), "{name}: {}", it.ratio);
    }
}

#[test]
fn with_what_they_found_they_despin_and_point() {
    let satellites = fly_all(4, |seed| fly(World::Wrong, true, seed), || ()).unwrap();
    let summary = Summary::new(satellites);
    // The bars of despin: below 0.5 deg/s after two orbits, below 0.3 deg/s after three.
    assert!(summary.below(0.5_f64.to_radians(), 2) > 0.99);
    assert!(summary.below(0.3_f64.to_radians(), 3) > 0.99);
    // And of pointing with everything wrong at once, 5.5 deg in the mean, for four satellites of which one may
    // be slow to be captured.
    let (mean, p95, worst) = summary.pointing_deg();
    println!("{mean:.2} deg mean, {p95:.2} deg 95 %, worst {worst:.2} deg");
    assert!(mean < 8.0, "{mean}");
    assert_eq!(summary.lost(), 0);
}
