//! Guard and check against a rigid body in a field that turns slowly.

mod dead;
mod turned_wrong;

use nalgebra::{Matrix3, Vector3};
use proptest::prelude::*;
use rand_core::Rng;
use rand_pcg::Pcg32;

use super::*;
use crate::frames::{Body, Vector};
use crate::reading::{MissingReason, Reading};
use crate::schedule::{Phase, Schedule, ScheduleParameters};
use crate::time::Utc;

const CYCLE_US: u32 = 500_000;
const CYCLE_S: f64 = 0.5;
/// Sub-steps of the integration in a cycle: 50 ms, with the midpoint rule good for 1e-6 of a turn.
const SUB_STEPS: u32 = 10;
const DEG: f64 = core::f64::consts::PI / 180.0;
const GYRO_NOISE_RAD_S: f64 = 0.163 * DEG;
const FIELD_NOISE_T: f64 = 5e-7;
/// 20 minutes.
const FLIGHT_CYCLES: u32 = 2400;
/// SPROUT's residual dipole, Body, A·m².
const RESIDUAL_AM2: Vector3<f64> = Vector3::new(-0.3211, -0.2094, -0.0201);
const SILENT: MissingReason = MissingReason::Bus;

/// SPROUT's moments, products left out, each 5 % from what guard and check are told.
fn inertia() -> Matrix3<f64> {
    Matrix3::from_diagonal(&Vector3::new(0.05184 * 0.95, 0.05416 * 1.05, 0.05978 * 0.95))
}

#[derive(Clone, Copy, PartialEq)]
enum Device {
    Gyro,
    Magnetometer,
    Torquers,
}

/// A satellite, and what it shows.
struct Rig {
    rate: Vector3<f64>,
    field: Vector3<f64>,
    cycle: u32,
    carried: Vector3<f64>,
    fault: Option<(Device, SignedPermutation)>,
    /// Torquers that do nothing.
    dead: [bool; 3],
    schedule: Schedule,
    noise: Pcg32,
}

impl Rig {
    fn new(rate_deg_s: f64, fault: Option<(Device, SignedPermutation)>) -> Self {
        let parameters =
            ScheduleParameters { on_us: 10_000_000, off_us: 2_500_000, settle_us: 500_000 };
        Self {
            rate: Vector3::new(0.48, -0.6, 0.64) * (rate_deg_s * DEG),
            field: Vector3::new(2.2e-5, 1.5e-5, -2.4e-5),
            cycle: 0,
            carried: Vector3::zeros(),
            fault,
            dead: [false; 3],
            schedule: Schedule::new(&parameters, CYCLE_US).unwrap(),
            noise: Pcg32::new(7, 11),
        }
    }

    fn wired(&self, device: Device, v: Vector3<f64>) -> Vector3<f64> {
        match self.fault {
            Some((at, wiring)) if at == device => wiring.matrix().cast::<f64>() * v,
            _ => v,
        }
    }

    /// Sum of twelve uniform numbers less six: normal but for its tails.
    fn deviates(&mut self) -> Vector3<f64> {
        let mut one = || f64::from(self.noise.next_u32()) / f64::from(u32::MAX);
        Vector3::from_fn(|_, _| (0..12).map(|_| one()).sum::<f64>() - 6.0)
    }

    fn shown(&mut self) -> GuardInputs {
        let phase = self.schedule.phase(self.cycle);
        let rate = self.wired(Device::Gyro, self.rate) + self.deviates() * GYRO_NOISE_RAD_S;
        let field = self.wired(Device::Magnetometer, self.field) + self.deviates() * FIELD_NOISE_T;
        let at_rest = matches!(phase, Phase::Settled | Phase::Measuring);
        GuardInputs {
            now: Utc::from_micros_since_2000(i64::from(self.cycle) * i64::from(CYCLE_US)),
            phase,
            omega_bi: Reading::Fresh(Vector::from_xyz(rate.cast())),
            field_b: if at_rest {
                Reading::Fresh(Vector::from_xyz(field.cast()))
            } else {
                Reading::Missing(MissingReason::TorquersOn)
            },
            carried: Vector::from_xyz(self.carried.cast()),
        }
    }

    fn fly(&mut self, dipole: Vector3<f64>) {
        self.carried = dipole;
        let alive = self.dead.map(|dead| if dead { 0.0 } else { 1.0 });
        let done = dipole.component_mul(&Vector3::from(alive));
        let total = RESIDUAL_AM2 + self.wired(Device::Torquers, done);
        let inertia = inertia();
        let inverse = inertia.try_inverse().unwrap();
        let slope = |rate: Vector3<f64>, field: Vector3<f64>| {
            let torque = total.cross(&field) - rate.cross(&(inertia * rate));
            // The field's own turn along the orbit, in an axis of Body: 0.1 deg/s.
            let own = Vector3::new(0.0, 0.0, 0.1 * DEG);
            (inverse * torque, field.cross(&(rate - own)))
        };
        let step_s = CYCLE_S / f64::from(SUB_STEPS);
        for _ in 0..SUB_STEPS {
            let (rate, field) = slope(self.rate, self.field);
            let half = 0.5 * step_s;
            let (rate, field) = slope(self.rate + rate * half, self.field + field * half);
            self.rate += rate * step_s;
            self.field += field * step_s;
        }
        self.cycle += 1;
    }

    fn energy(&self) -> f64 {
        0.5 * self.rate.dot(&(inertia() * self.rate))
    }
}

/// Gain of B-dot, A·m²·s/T.
const GAIN: f64 = 1e5;

/// B-dot under the guard: when and why it was stopped, and the largest energy over the first.
fn guarded(rig: Rig, spoil: impl Fn(u32, &mut GuardInputs)) -> (Option<(f64, Suspect)>, f64) {
    guarded_with(rig, GAIN, Purpose::Despin, spoil)
}

/// The same with another gain, and what it is meant to do.
fn guarded_with(
    mut rig: Rig,
    gain: f64,
    purpose: Purpose,
    spoil: impl Fn(u32, &mut GuardInputs),
) -> (Option<(f64, Suspect)>, f64) {
    let guard = Guard::new(&PolarityParameters::default()).unwrap();
    let mut state = GuardState::default();
    let (start, mut largest) = (rig.energy(), 1.0_f64);
    let mut command = Vector3::zeros();
    for cycle in 0..FLIGHT_CYCLES {
        let shown = rig.shown();
        let mut said = shown;
        spoil(cycle, &mut said);
        if let GuardVerdict::Stop { suspect, .. } = guard.cycle(&mut state, &said, purpose) {
            return (Some((f64::from(cycle) * CYCLE_S, suspect)), largest);
        }
        command = match shown.phase {
            Phase::Settling | Phase::Settled => Vector3::zeros(),
            Phase::Acting => command,
            Phase::Measuring => {
                let (rate, field) = (shown.omega_bi.value(), shown.field_b.value());
                let dipole = rate.unwrap().cross(&field.unwrap()).xyz.cast::<f64>() * gain;
                dipole.map(|m| m.clamp(-0.6, 0.6))
            }
        };
        rig.fly(command);
        largest = largest.max(rig.energy() / start);
    }
    (None, largest)
}

fn checked(mut rig: Rig, spoil: impl Fn(u32, &mut GuardInputs)) -> (CheckReport, u32) {
    let check = ActiveCheck::new(&PolarityParameters::default()).unwrap();
    let mut state = CheckState::default();
    for cycle in 0..=u32::from(LONGEST_CYCLES) {
        let mut said = rig.shown();
        spoil(cycle, &mut said);
        match check.cycle(&mut state, &said) {
            CheckStep::Done(report) => return (report, cycle),
            CheckStep::Carry(dipole) => rig.fly(dipole.xyz.cast()),
        }
    }
    panic!("the check has not ended");
}

fn wiring(name: &str) -> SignedPermutation {
    extern crate std;
    use std::string::ToString as _;
    SignedPermutation::all().find(|it| it.to_string() == name).unwrap()
}

fn nothing(_: u32, _: &mut GuardInputs) {}

#[test]
fn a_satellite_that_is_wired_well_is_left_alone_and_comes_to_rest() {
    for rate_deg_s in [0.0, 0.3, 2.0, 5.0, 12.0] {
        let (stopped, largest) = guarded(Rig::new(rate_deg_s, None), nothing);
        assert_eq!(stopped, None, "{rate_deg_s}");
        // The residual dipole moves up to 3.8e-5 J: a sixth of the energy at 5 deg/s.
        assert!(rate_deg_s < 5.0 || largest < 1.3, "{largest}");
    }
}

#[test]
fn wrong_sensors_are_stopped_within_two_rounds_and_wrong_torquers_within_five_minutes() {
    let mirrored = wiring("+x -y +z");
    let turned = wiring("+y -x +z");
    for (device, wiring, expected, within_s) in [
        (Device::Gyro, mirrored, Suspect::Gyro(mirrored), 40.0),
        (Device::Gyro, turned, Suspect::GyroOrMagnetometer(turned), 40.0),
        (Device::Magnetometer, turned, Suspect::GyroOrMagnetometer(turned.inverse()), 40.0),
        (
            Device::Torquers,
            SignedPermutation::REVERSED,
            Suspect::ReversedTorquersOrMagnetometer,
            300.0,
        ),
        (
            Device::Magnetometer,
            SignedPermutation::REVERSED,
            Suspect::ReversedTorquersOrMagnetometer,
            300.0,
        ),
    ] {
        let (stopped, largest) = guarded(Rig::new(5.0, Some((device, wiring))), nothing);
        let (t_s, suspect) = stopped.unwrap();
        // What the torquers' wiring is takes longer than that it is wrong.
        let torquers = expected == Suspect::ReversedTorquersOrMagnetometer;
        let class = [expected, Suspect::TorquersOrReversedMagnetometer];
        assert!(suspect == expected || torquers && class.contains(&suspect), "{suspect}");
        assert!(t_s <= within_s && largest < 1.3, "{suspect}: {t_s} s, {largest}");
    }
}

#[test]
fn what_spins_up_is_stopped_in_a_despin_and_left_alone_where_it_may_be_on_purpose() {
    let spun_up = |purpose| guarded_with(Rig::new(3.0, None), -GAIN, purpose, nothing);
    let (stopped, largest) = spun_up(Purpose::Despin);
    assert_eq!(stopped.map(|(_, suspect)| suspect), Some(Suspect::Unknown), "{largest}");
    let (stopped, largest) = spun_up(Purpose::Point);
    // Three times the energy: it does spin up.
    assert!(stopped.is_none() && largest > 3.0, "{stopped:?} {largest}");
}

#[test]
fn the_active_check_names_the_device_and_its_wiring() {
    for name in ["+x -y +z", "+y -x +z", "-z +y -x", "-x -y +z"] {
        let wiring = wiring(name);
        for (device, expected) in [
            (Device::Gyro, Suspect::Gyro(wiring)),
            (Device::Magnetometer, Suspect::Magnetometer(wiring)),
            (Device::Torquers, Suspect::Torquers(wiring)),
        ] {
            let (report, _) = checked(Rig::new(5.0, Some((device, wiring))), nothing);
            assert_eq!(report, CheckReport::Wrong(expected), "{report}");
        }
    }
    for device in [Device::Torquers, Device::Magnetometer] {
        let fault = (device, SignedPermutation::REVERSED);
        let (report, _) = checked(Rig::new(5.0, Some(fault)), nothing);
        assert_eq!(report, CheckReport::Wrong(Suspect::ReversedTorquersOrMagnetometer));
    }
    for rate_deg_s in [2.0, 5.0, 10.0] {
        assert_eq!(checked(Rig::new(rate_deg_s, None), nothing).0, CheckReport::Sound);
    }
}

#[test]
fn what_cannot_be_told_is_said_and_why_in_bounded_time() {
    let silent_gyro = |_, said: &mut GuardInputs| said.omega_bi = Reading::Missing(SILENT);
    let silent_field = |_, said: &mut GuardInputs| said.field_b = Reading::Missing(SILENT);
    let stuck_phase = |_, said: &mut GuardInputs| said.phase = Phase::Acting;
    let stopped_clock = |_, said: &mut GuardInputs| said.now = Utc::from_micros_since_2000(0);
    let undecided = |why| CheckReport::Undecided(why);
    let (report, _) = checked(Rig::new(5.0, None), silent_gyro);
    assert_eq!(report, undecided(Undecided::NoRate));
    let (report, _) = checked(Rig::new(5.0, None), silent_field);
    assert_eq!(report, undecided(Undecided::NoField));
    for spoil in [stuck_phase, stopped_clock] {
        let (report, _) = checked(Rig::new(5.0, None), spoil);
        assert_eq!(report, undecided(Undecided::TooSlow));
    }
    let (report, cycle) = checked(Rig::new(5.0, None), stuck_phase);
    assert_eq!((report, cycle), (undecided(Undecided::TooSlow), u32::from(LONGEST_CYCLES) - 1));
}

#[test]
fn readings_that_are_none_neither_alarm_nor_hide_a_fault() {
    let bad = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, 0.0, 1e-38];
    let spoil = |cycle: u32, said: &mut GuardInputs| {
        let value = bad[(cycle / 7) as usize % bad.len()];
        let vector = Vector::<Body>::new(value, 1e-5, value);
        match cycle % 7 {
            // A gyro that shows 0 for once is no gyro that has failed, but its noise is wrong: left out.
            0 if value.abs() > 1.0 || value.is_nan() => said.omega_bi = Reading::Fresh(vector),
            2 if value != 0.0 && value != 1e-38 => said.field_b = Reading::Fresh(vector),
            4 => said.field_b = Reading::Fresh(Vector::new(value, 0.0, 0.0)),
            _ => (),
        }
    };
    assert_eq!(guarded(Rig::new(5.0, None), spoil).0, None);
    let mirrored = wiring("+x -y +z");
    let (stopped, _) = guarded(Rig::new(5.0, Some((Device::Gyro, mirrored))), spoil);
    assert_eq!(stopped.unwrap().1, Suspect::Gyro(mirrored));
}

fn number() -> impl Strategy<Value = f32> {
    let special = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MIN_POSITIVE, f32::MAX, 0.0];
    prop_oneof![
        any::<f32>(),
        -6.0_f32..6.0,
        -6e-5_f32..6e-5,
        prop::sample::select(special.to_vec())
    ]
}

fn vector() -> impl Strategy<Value = Vector<Body>> {
    [number(), number(), number()].prop_map(|[x, y, z]| Vector::new(x, y, z))
}

fn inputs() -> impl Strategy<Value = GuardInputs> {
    let phases = [Phase::Settling, Phase::Settled, Phase::Measuring, Phase::Acting];
    let clock = prop_oneof![-2_000_000_i64..20_000_000, any::<i64>()];
    (clock, prop::sample::select(phases.to_vec()), vector(), vector(), vector(), 0_u8..4).prop_map(
        |(micros, phase, rate, field, carried, missing)| {
            let reading = |v, bit| {
                if missing & bit == 0 { Reading::Fresh(v) } else { Reading::Missing(SILENT) }
            };
            GuardInputs {
                now: Utc::from_micros_since_2000(micros),
                phase,
                omega_bi: reading(rate, 1),
                field_b: reading(field, 2),
                carried,
            }
        },
    )
}

proptest! {
    #[test]
    fn nothing_makes_guard_or_check_panic_and_no_pulse_is_beyond_the_limit(
        said in prop::collection::vec(inputs(), 1..60),
    ) {
        let parameters = PolarityParameters::default();
        let (guard, check) =
            (Guard::new(&parameters).unwrap(), ActiveCheck::new(&parameters).unwrap());
        let (mut guarding, mut checking) = (GuardState::default(), CheckState::default());
        for said in &said {
            let purpose = if said.phase == Phase::Acting { Purpose::Acquire } else { Purpose::Point };
            let evidence = match guard.cycle(&mut guarding, said, purpose) {
                GuardVerdict::Sound(evidence) | GuardVerdict::Stop { evidence, .. } => evidence,
            };
            let Evidence { turning, response, dead, energy } = evidence;
            prop_assert!([turning, response, dead, energy].iter().all(|it| !it.is_nan()));
            if let CheckStep::Carry(dipole) = check.cycle(&mut checking, said) {
                prop_assert!(dipole.xyz.iter().all(|m| m.abs() <= parameters.pulse_am2));
            }
        }
    }

    #[test]
    fn readings_that_are_not_numbers_alone_never_alarm(
        phases in prop::collection::vec(0_u32..25, 1..60),
        bad in prop::sample::select([f32::NAN, f32::INFINITY, f32::NEG_INFINITY].to_vec()),
    ) {
        let guard = Guard::new(&PolarityParameters::default()).unwrap();
        let mut state = GuardState::default();
        let rig = Rig::new(5.0, None);
        for (cycle, phase) in (0_i64..).zip(&phases) {
            let reading = Reading::Fresh(Vector::new(bad, bad, bad));
            let verdict = guard.cycle(&mut state, &GuardInputs {
                now: Utc::from_micros_since_2000(cycle * i64::from(CYCLE_US)),
                phase: rig.schedule.phase(*phase),
                omega_bi: reading,
                field_b: reading,
                carried: Vector::new(bad, bad, bad),
            }, if phase % 2 == 0 { Purpose::Despin } else { Purpose::Point });
            prop_assert_eq!(verdict, GuardVerdict::Sound(Evidence::NONE));
        }
    }
}
