//! Torquers that obey and do nothing.

use super::*;

const X: [bool; 3] = [true, false, false];
const SETS: [[bool; 3]; 4] = [X, [false, true, false], [false, false, true], [true; 3]];

fn with_dead(rate_deg_s: f64, dead: [bool; 3]) -> Rig {
    Rig { dead, ..Rig::new(rate_deg_s, None) }
}

#[test]
fn the_active_check_names_the_torquer_that_does_nothing() {
    for rate_deg_s in [2.0, 5.0] {
        for dead in SETS {
            let (report, _) = checked(with_dead(rate_deg_s, dead), nothing);
            assert_eq!(report, CheckReport::Wrong(Suspect::DeadTorquers(dead)), "{rate_deg_s}");
        }
    }
}

#[test]
fn a_despin_goes_on_with_two_torquers_and_is_stopped_with_none() {
    let (stopped, _) = guarded(with_dead(5.0, X), nothing);
    assert_eq!(stopped, None);
    let (stopped, _) = guarded(with_dead(5.0, [true; 3]), nothing);
    let (_, suspect) = stopped.unwrap();
    let open = Suspect::TorquersOrReversedMagnetometer;
    assert!([open, Suspect::DeadTorquers([true; 3])].contains(&suspect), "{suspect}");
}

#[test]
fn where_each_torquer_has_its_part_one_that_is_dead_is_found() {
    for purpose in [Purpose::Acquire, Purpose::Point] {
        for dead in SETS {
            let (stopped, _) = guarded_with(with_dead(5.0, dead), GAIN, purpose, nothing);
            let (_, suspect) = stopped.unwrap();
            let open = Suspect::TorquersOrReversedMagnetometer;
            assert!([open, Suspect::DeadTorquers(dead)].contains(&suspect), "{suspect}");
        }
    }
}

#[test]
fn the_dead_are_called_by_their_axes() {
    extern crate std;
    use std::string::ToString as _;
    let name = |dead| Suspect::DeadTorquers(dead).to_string();
    assert_eq!(name([true, false, true]), "torquer dead: x z");
    assert_eq!(name([true; 3]), "all torquers dead");
}
