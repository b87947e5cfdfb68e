//! Devices that are right at first.

use super::*;

#[test]
fn a_gyro_that_turns_wrong_after_a_quarter_of_an_hour_is_found_in_another() {
    const QUARTER_S: u32 = 900;
    let guard = Guard::new(&PolarityParameters::default()).unwrap();
    let (mut rig, mut state) = (Rig::new(3.0, None), GuardState::default());
    let mirrored = wiring("+x -y +z");
    let mut found = None;
    for second in 0..2 * QUARTER_S {
        if second == QUARTER_S {
            rig.fault = Some((Device::Gyro, mirrored));
        }
        for _ in 0..2 {
            if let GuardVerdict::Stop { suspect, .. } =
                guard.cycle(&mut state, &rig.shown(), Purpose::Despin)
            {
                found.get_or_insert((second, suspect));
            }
            rig.fly(Vector3::zeros());
        }
    }
    let (second, suspect) = found.unwrap();
    assert!(second > QUARTER_S, "{second} s: {suspect}");
}

#[test]
fn a_magnetometer_that_turns_wrong_while_the_satellite_hardly_turns_is_named_within_a_minute() {
    /// When it turns wrong, cycles: after two minutes.
    const CHANGE: u32 = 240;
    const WITHIN: u32 = 120;
    let guard = Guard::new(&PolarityParameters::default()).unwrap();
    for name in ["-x +y +z", "+x +y -z", "-x -y -z", "+x +z -y"] {
        let (mut rig, mut state) = (Rig::new(0.06, None), GuardState::default());
        let wiring = wiring(name);
        let stopped = (0..CHANGE + WITHIN).find_map(|cycle| {
            rig.fault = (cycle >= CHANGE).then_some((Device::Magnetometer, wiring));
            let verdict = guard.cycle(&mut state, &rig.shown(), Purpose::Point);
            // The torquers hold the residual dipole down.
            rig.fly(-RESIDUAL_AM2);
            match verdict {
                GuardVerdict::Stop { suspect, .. } => Some((cycle, suspect)),
                GuardVerdict::Sound(_) => None,
            }
        });
        let (cycle, suspect) = stopped.unwrap();
        assert!(cycle >= CHANGE);
        assert_eq!(suspect, Suspect::Magnetometer(wiring), "{name}: {suspect} at {cycle}");
    }
}

#[test]
fn a_magnetometer_that_is_off_for_two_rests_is_left_alone() {
    const TWO_RESTS: core::ops::Range<u32> = 240..290;
    let guard = Guard::new(&PolarityParameters::default()).unwrap();
    let (mut rig, mut state) = (Rig::new(0.06, None), GuardState::default());
    for cycle in 0..600 {
        let reversed = Some((Device::Magnetometer, SignedPermutation::REVERSED));
        rig.fault = if TWO_RESTS.contains(&cycle) { reversed } else { None };
        let verdict = guard.cycle(&mut state, &rig.shown(), Purpose::Point);
        assert!(matches!(verdict, GuardVerdict::Sound(_)), "{cycle}: {verdict:?}");
        rig.fly(-RESIDUAL_AM2);
    }
}
