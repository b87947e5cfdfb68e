//! Despin from random starts; `adcs study despin` is the same with hundreds.

use adcs_ground::study::campaign::fly_all;
use adcs_ground::study::despin::{Despin, Summary, fly};

/// Enough for what every flight does; figures need hundreds.
const FEW: u64 = 4;

fn flown(despin: Despin) -> Summary {
    Summary::new(fly_all(FEW, |seed| fly(despin, seed), || ()).unwrap())
}

#[test]
fn without_control_the_rate_stays() {
    let ratio = flown(Despin::Off).median_ratio();
    assert!((0.98..1.02).contains(&ratio), "{ratio}");
}

#[test]
fn b_dot_takes_energy_out_of_every_tumble() {
    let flights = flown(Despin::Uncorrected);
    assert_eq!(flights.energy_fell(), 1.0);
    assert_eq!(flights.below(1.0, 2), 1.0);
}

#[test]
fn with_the_residual_dipole_estimated_on_the_way_it_comes_to_rest() {
    let flights = flown(Despin::Estimated);
    assert_eq!(flights.energy_fell(), 1.0);
    assert_eq!(flights.below(0.5, 2), 1.0);
}
