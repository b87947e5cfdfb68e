//! The dynamics-aided filter beside the MEKF and beside what no filter can beat, over many flights.
//!
//! `cargo test -p adcs-ground --test study -- --nocapture` prints the figures; `adcs study filters` all of
//! them.

use adcs_ground::study::campaign::{eclipse_ratio, fly, pooled};
use adcs_ground::study::run::Flight;
use adcs_ground::study::scene::Scene;

/// As many as the figures asked for.
const FLIGHTS: u64 = 20;
/// Enough for what is far from its limit.
const FEW: u64 = 8;

struct Flown {
    all: Flight,
    /// Eclipse rms over the MEKF's.
    ratio: f64,
}

fn flown(name: &str, flights: u64) -> Flown {
    let scene = Scene::named(name).expect("a scene");
    let flights = fly(&scene, flights, || ()).expect("the scene can be flown");
    let (ratio, interval) = eclipse_ratio(&flights);
    let all = pooled(&flights);
    let deg = |rms: f64| rms.to_degrees();
    println!(
        "{name}: eclipse {:.3} of {:.3} deg, ratio {ratio:.3} {interval:.2?}; sunlit {:.3} deg, rate {:.4} \
         deg/s, NEES {:.2}, dipole {:.4?}; over the bounds {:.3} and {:.3}",
        deg(all.dynamic.eclipse.rms()),
        deg(all.mekf.eclipse.rms()),
        deg(all.dynamic.sunlit.rms()),
        deg(all.dynamic.rate.rms()),
        all.dynamic.nees.mean(),
        all.dynamic.dipole.map(|dipole| dipole.largest_am2),
        all.dynamic.eclipse.rms() / all.dynamic_bound.eclipse.rms(),
        all.mekf.eclipse.rms() / all.mekf_bound.eclipse.rms(),
    );
    // Neither filter is ever without an estimate, and what is believed is no worse than the MEKF.
    assert_eq!((all.mekf.without, all.dynamic.without, all.believed.without), (0, 0, 0));
    assert_eq!(all.dynamic.not_positive, 0);
    assert!(all.believed.eclipse.rms() <= 1.1 * all.mekf.eclipse.rms());
    Flown { all, ratio }
}

fn figures_hold(name: &str, ratio: f64, sunlit_deg: f64) {
    let Flown { all, ratio: found } = flown(name, FLIGHTS);
    let Flight { dynamic, dynamic_bound, mekf, mekf_bound, .. } = all;
    assert!(found <= ratio, "{found}");
    assert!(dynamic.sunlit.rms().to_degrees() <= sunlit_deg);
    assert!(dynamic.rate.rms().to_degrees() <= 0.010);
    assert!((2.0..=4.0).contains(&dynamic.nees.mean()));
    // Within a quarter of what any filter could do with the same states on the same measurements.
    assert!(dynamic.eclipse.rms() <= 1.25 * dynamic_bound.eclipse.rms());
    assert!(mekf.eclipse.rms() <= 1.25 * mekf_bound.eclipse.rms());
    // rms of an axis, and no axis of any flight beyond three of that.
    let [early, late] = dynamic.dipole;
    assert!(early.axis.rms() <= 0.005 && early.largest_am2 <= 0.015, "{early:?}");
    assert!(late.axis.rms() <= 0.0025 && late.largest_am2 <= 0.005, "{late:?}");
}

#[test]
fn from_the_tumble_the_dynamics_halve_the_error_in_eclipse() {
    figures_hold("tumble", 0.50, 0.45);
}

#[test]
fn in_nadir_pointing_the_dynamics_take_a_fifth_of_it() {
    figures_hold("nadir", 0.80, 0.60);
}

#[test]
fn a_wrong_inertia_costs_nothing() {
    assert!(flown("tumble-inertia", FEW).ratio <= 0.6);
    assert!(flown("nadir-inertia", FEW).ratio <= 1.0);
}

#[test]
fn with_the_same_tuning_ten_times_the_torque_or_a_jumping_dipole_is_no_worse_than_the_mekf() {
    for name in ["tumble-torque", "nadir-torque", "nadir-dipole"] {
        assert!(flown(name, FEW).ratio <= 1.1);
    }
    assert!(flown("tumble-dipole", FEW).ratio <= 0.6);
}

#[test]
fn the_result_does_not_depend_on_how_many_flights_are_flown_beside() {
    let scene = Scene { orbits: 0.3, ..Scene::named("tumble").expect("a scene") };
    let three = fly(&scene, 3, || ()).unwrap();
    let two = fly(&scene, 2, || ()).unwrap();
    let figure = |flight: &Flight| flight.dynamic.sunlit.rms().to_bits();
    assert_eq!(figure(&three[1]), figure(&two[1]));
    assert_ne!(figure(&three[0]), figure(&three[1]));
}
