//! The mode machine alone, with sights made by hand.

use adcs_core::commissioning::Witnessed;
use adcs_core::control::b_dot::{BDot, BDotGain};
use adcs_core::frames::{Body, Vector};
use adcs_core::modes::{
    Cause, Flown, Mode, ModeParameters, ModeReport, ModeTable, Modes, ModesState, Needs, Polarity,
    Sensor, Sight, Transition,
};
use adcs_core::pipeline::{Law, RateFrom, Steering};
use adcs_core::polarity::{ActiveCheck, Guard, GuardInputs, PolarityParameters, Undecided};
use adcs_core::reading::{MissingReason, Reading};
use adcs_core::schedule::{Phase, Round, Schedule, ScheduleParameters};
use adcs_core::time::Utc;
use proptest::prelude::*;

const CYCLE_US: u32 = 500_000;
const DEG: f32 = core::f32::consts::PI / 180.0;

fn flown() -> Flown {
    let steering = Steering {
        rate: RateFrom::Gyro,
        cut_hold: false,
        feed_forward: None,
        round: Round { on_s: 5.0, off_s: 2.5 },
    };
    let gain = BDotGain::Plain { gain_am2_s_per_t: 1e5 };
    Flown { law: Law::BDot(BDot::new(gain).unwrap()), steering }
}

fn machine(change: impl FnOnce(&mut ModeParameters)) -> Modes {
    let mut parameters = ModeParameters::default();
    change(&mut parameters);
    let table = ModeTable::new(&parameters, true, true).unwrap();
    let despin = flown();
    let check = PolarityParameters::default();
    let polarity =
        Polarity { guard: Guard::new(&check).unwrap(), check: ActiveCheck::new(&check).unwrap() };
    Modes {
        table,
        despin,
        acquire: despin.steering,
        experiment: Some(flown()),
        polarity: Some(polarity),
        ladder: None,
    }
}

/// Devices from which nothing can be learned of their wiring.
fn silent_devices(now: Utc, phase: Phase) -> Witnessed {
    let nothing = Reading::Missing(MissingReason::Bus);
    let devices =
        GuardInputs { now, phase, omega_bi: nothing, field_b: nothing, carried: Vector::zero() };
    Witnessed {
        devices,
        reading: Reading::Missing(MissingReason::Bus),
        reference_field: None,
        reference_sun: None,
        sun: None,
    }
}

/// A mode machine in flight, beside a world that is as it is told.
struct Flight {
    modes: Modes,
    state: ModesState,
    schedule: Schedule,
    cycle: u32,
    /// What the next cycles see.
    sight: Sight,
    /// Whether the magnetometer speaks when the torquers let it.
    magnetometer: bool,
    transitions: Vec<(f32, Transition)>,
    last: Option<ModeReport>,
}

impl Flight {
    /// All is well: no rate to speak of, a good attitude, on target.
    fn new(modes: Modes) -> Self {
        let schedule =
            ScheduleParameters { on_us: 5_000_000, off_us: 2_500_000, settle_us: 500_000 };
        let sight = Sight {
            now: Utc::from_micros_since_2000(0),
            phase: Phase::Settling,
            commanded: None,
            rate: Some(Vector::new(0.05 * DEG, 0.0, 0.0)),
            gyro_speaks: true,
            magnetometer_speaks: None,
            sun_speaks: true,
            torquers_obey: true,
            attitude_sigma_rad: Some(0.2 * DEG),
            filtered: true,
            dipole_sigma_am2: Some(0.005),
            pointing_error_rad: Some(2.0 * DEG),
            witnessed: silent_devices(Utc::from_micros_since_2000(0), Phase::Settling),
        };
        Self {
            modes,
            state: ModesState::default(),
            schedule: Schedule::new(&schedule, CYCLE_US).unwrap(),
            cycle: 0,
            sight,
            magnetometer: true,
            transitions: Vec::new(),
            last: None,
        }
    }

    /// In this mode, by command, with everything well.
    fn within(mode: Mode, change: impl FnOnce(&mut ModeParameters)) -> Self {
        let mut flight = Self::new(machine(change));
        flight.fly(1.0);
        flight.command(mode);
        flight.transitions.clear();
        flight
    }

    fn seconds(&self) -> f32 {
        self.cycle as f32 * CYCLE_US as f32 * 1e-6
    }

    fn cycle(&mut self) -> ModeReport {
        let phase = self.schedule.phase(self.cycle);
        let rests = matches!(phase, Phase::Settled | Phase::Measuring);
        let magnetometer_speaks = rests.then_some(self.magnetometer);
        let witnessed = silent_devices(self.sight.now, phase);
        let sight = Sight { phase, magnetometer_speaks, witnessed, ..self.sight };
        let report = self.modes.cycle(&mut self.state, &sight);
        let at = self.seconds();
        self.transitions.extend(report.transition.map(|transition| (at, transition)));
        self.cycle += 1;
        self.sight.now = self.sight.now.plus_micros(CYCLE_US.into());
        self.sight.commanded = None;
        self.last = Some(report);
        report
    }

    fn fly(&mut self, seconds: f32) {
        let end = self.seconds() + seconds;
        while self.seconds() < end {
            self.cycle();
        }
    }

    fn command(&mut self, mode: Mode) -> ModeReport {
        self.sight.commanded = Some(mode);
        self.cycle()
    }

    fn turns_at(&mut self, deg_s: f32) {
        self.sight.rate = Some(Vector::new(0.0, deg_s * DEG, 0.0));
    }

    fn mode(&self) -> Mode {
        self.last.unwrap().mode
    }

    fn causes(&self) -> Vec<(Mode, Cause)> {
        self.transitions.iter().map(|(_, it)| (it.to, it.cause)).collect()
    }
}

#[test]
fn from_power_on_to_pointing_each_step_waits_for_its_condition() {
    let mut flight = Flight::new(machine(|_| {}));
    flight.turns_at(8.0);
    flight.sight.attitude_sigma_rad = None;
    flight.fly(3_000.0);
    assert_eq!(flight.mode(), Mode::Detumble);
    flight.turns_at(0.6);
    flight.fly(600.0);
    // Slow enough to be despun, but too fast, and too little is known, to point.
    assert_eq!(flight.mode(), Mode::Acquire);
    flight.turns_at(0.2);
    flight.fly(600.0);
    flight.sight.attitude_sigma_rad = Some(0.5 * DEG);
    flight.sight.dipole_sigma_am2 = Some(0.2);
    flight.fly(600.0);
    assert_eq!(flight.mode(), Mode::Acquire);
    flight.sight.dipole_sigma_am2 = Some(0.01);
    let known = flight.seconds();
    flight.fly(600.0);
    let expected = [
        (Mode::Detumble, Cause::PowerOn),
        (Mode::Acquire, Cause::Despun),
        (Mode::Point, Cause::Trusted),
    ];
    assert_eq!(flight.causes(), expected);
    let (at, _) = flight.transitions[2];
    assert!((at - known - 300.0).abs() <= 1.0, "trusted for its time: {at} {known}");
    flight.fly(20_000.0);
    assert_eq!(flight.transitions.len(), 3, "and there it stays");
}

#[test]
fn each_sensor_that_fails_in_each_mode_ends_in_safety_with_its_reason() {
    use Sensor::{Gyro, Magnetometer, SunSensors};
    for mode in [Mode::Detumble, Mode::Acquire, Mode::Point, Mode::Experiment] {
        for sensor in [Gyro, Magnetometer, SunSensors] {
            // A mode that lasts, so that only the sensor can end it.
            let mut flight = Flight::within(mode, |p| {
                p.trusted_for_s = 20_000.0;
                p.experiment_s = 1e5;
                p.despin_needs = Needs { gyro: true, sun: true };
            });
            flight.turns_at(1.5);
            match sensor {
                Gyro => flight.sight.gyro_speaks = false,
                Magnetometer => flight.magnetometer = false,
                SunSensors => flight.sight.sun_speaks = false,
            }
            let failed = flight.seconds();
            flight.fly(3_000.0);
            assert_eq!(flight.causes(), [(Mode::Safe, Cause::Silent(sensor))], "{mode} {sensor:?}");
            let after = flight.transitions[0].0 - failed;
            let gap_s = if sensor == SunSensors { 600.0 } else { 60.0 };
            // The magnetometer is only heard in the rests.
            assert!((gap_s - 1.0..gap_s + 8.0).contains(&after), "{mode} {sensor:?}: {after}");
        }
    }
}

#[test]
fn a_sensor_that_fails_in_a_mode_without_torquers_keeps_it_there() {
    for mode in [Mode::Off, Mode::Safe] {
        let mut flight = Flight::within(mode, |_| {});
        flight.sight.gyro_speaks = false;
        flight.magnetometer = false;
        flight.sight.sun_speaks = false;
        flight.fly(5_000.0);
        assert_eq!((flight.mode(), flight.transitions.len()), (mode, 0));
    }
}

#[test]
fn torquers_that_refuse_end_every_mode_with_torquers_in_safety_until_they_obey() {
    for mode in [Mode::Detumble, Mode::Acquire, Mode::Point, Mode::Experiment] {
        let mut flight = Flight::within(mode, |p| {
            p.actuator_gap_s = 90.0;
            p.trusted_for_s = 20_000.0;
            p.experiment_s = 1e5;
        });
        flight.turns_at(1.5);
        let failed = flight.seconds();
        flight.sight.torquers_obey = false;
        flight.fly(1_000.0);
        assert_eq!(flight.causes(), [(Mode::Safe, Cause::TorquersRefuse)], "{mode}");
        let after = flight.transitions[0].0 - failed;
        assert!((89.0..=91.0).contains(&after), "{mode}: {after}");
        // There it stays for as long as they refuse, and for its time after that.
        flight.sight.torquers_obey = true;
        let again = flight.seconds();
        flight.fly(400.0);
        assert_eq!(flight.causes()[1], (Mode::Detumble, Cause::Recovered), "{mode}");
        assert!((flight.transitions[1].0 - again - 300.0).abs() <= 1.0, "{mode}");
    }
}

#[test]
fn blind_sun_sensors_do_not_stop_the_despin_but_what_comes_after_it() {
    let mut flight = Flight::new(machine(|_| {}));
    flight.turns_at(8.0);
    flight.sight.sun_speaks = false;
    flight.fly(4_000.0);
    assert_eq!(flight.mode(), Mode::Detumble);
    flight.turns_at(0.3);
    flight.fly(400.0);
    assert_eq!(flight.causes()[1], (Mode::Safe, Cause::Silent(Sensor::SunSensors)));
}

#[test]
fn short_gaps_are_ridden_out() {
    for mode in [Mode::Detumble, Mode::Acquire, Mode::Point, Mode::Experiment] {
        let mut flight = Flight::within(mode, |p| {
            p.trusted_for_s = 20_000.0;
            p.experiment_s = 1e5;
        });
        flight.turns_at(1.5);
        for _ in 0..20 {
            flight.sight.gyro_speaks = false;
            flight.magnetometer = false;
            flight.sight.sun_speaks = false;
            flight.sight.torquers_obey = false;
            flight.sight.attitude_sigma_rad = None;
            flight.fly(50.0);
            flight.sight.gyro_speaks = true;
            flight.magnetometer = true;
            flight.sight.sun_speaks = true;
            flight.sight.torquers_obey = true;
            flight.sight.attitude_sigma_rad = Some(0.01);
            flight.fly(20.0);
        }
        assert_eq!((flight.mode(), flight.transitions.len()), (mode, 0), "{mode}");
    }
}

#[test]
fn between_the_limits_nothing_alternates() {
    let mut flight = Flight::within(Mode::Acquire, |p| p.acquire_limit_s = 1e6);
    // Between despun (1 deg/s) and tumbling (2 deg/s), and above either for a moment only.
    for k in 0..200 {
        flight.turns_at(if k % 2 == 0 { 0.7 } else { 1.8 });
        flight.fly(90.0);
        flight.turns_at(2.6);
        flight.fly(40.0);
    }
    assert!(flight.transitions.is_empty(), "{:?}", flight.transitions);
    flight.turns_at(2.6);
    flight.fly(150.0);
    assert_eq!(flight.causes(), [(Mode::Detumble, Cause::Tumbling)]);
}

#[test]
fn noise_on_the_gyro_does_not_keep_a_slow_satellite_from_being_despun() {
    let mut flight = Flight::within(Mode::Detumble, |p| p.despun_rad_s = 0.5 * DEG);
    for k in 0..1_200_u32 {
        // ±0.5 deg/s on each axis in turn, about a rate of 0.3 deg/s.
        let noise = |axis: u32| if (k * 7 + axis * 3) % 5 < 2 { 0.6 } else { -0.4 } * DEG;
        flight.sight.rate = Some(Vector::new(noise(0) + 0.3 * DEG, noise(1), noise(2)));
        flight.cycle();
    }
    assert_eq!(flight.causes()[0], (Mode::Acquire, Cause::Despun));
}

#[test]
fn without_an_attitude_pointing_falls_back_to_acquisition() {
    let mut flight = Flight::within(Mode::Point, |_| {});
    flight.sight.attitude_sigma_rad = None;
    flight.fly(200.0);
    assert_eq!(flight.causes(), [(Mode::Acquire, Cause::AttitudeLost)]);
    flight.sight.attitude_sigma_rad = Some(0.01);
    flight.fly(400.0);
    assert_eq!(flight.mode(), Mode::Point);
    flight.turns_at(4.0);
    flight.fly(200.0);
    assert_eq!(flight.mode(), Mode::Detumble);
}

#[test]
fn a_rate_that_grows_ends_in_safety_in_every_mode_with_torquers() {
    for mode in [Mode::Detumble, Mode::Acquire, Mode::Point, Mode::Experiment] {
        let mut flight = Flight::within(mode, |p| {
            // That a tumble leads back to detumbling is another test.
            p.tumbling_for_s = 1e5;
            p.experiment_s = 1e5;
        });
        for k in 0..200 {
            flight.turns_at(1.5 + 0.05 * k as f32);
            flight.fly(7.5);
        }
        assert_eq!(flight.causes()[0], (Mode::Safe, Cause::RateGrows), "{mode}");
        assert!(flight.transitions[0].0 < 400.0, "{:?}", flight.transitions);
    }
}

#[test]
fn an_error_that_grows_counts_once_it_had_been_small() {
    let grow = |flight: &mut Flight| {
        for k in 0..100 {
            flight.sight.pointing_error_rad = Some((5.0 + k as f32) * DEG);
            flight.fly(7.5);
        }
    };
    let mut captured = Flight::within(Mode::Point, |_| {});
    captured.fly(700.0);
    grow(&mut captured);
    assert_eq!(captured.causes()[0], (Mode::Safe, Cause::ErrorGrows));
    // While it is being captured the error may swing as it likes; but not for ever.
    let mut far = Flight::within(Mode::Point, |p| p.capture_limit_s = 5_000.0);
    far.sight.pointing_error_rad = Some(100.0 * DEG);
    grow(&mut far);
    assert!(far.transitions.is_empty());
    far.fly(5_000.0);
    assert_eq!(far.causes()[0], (Mode::Safe, Cause::NotCaptured));
}

#[test]
fn every_mode_on_the_way_has_its_time_limit() {
    let mut flight = Flight::within(Mode::Detumble, |p| p.detumble_limit_s = 3_000.0);
    flight.turns_at(1.5);
    flight.fly(3_010.0);
    assert_eq!(flight.causes(), [(Mode::Safe, Cause::TooLong)]);
    let mut flight = Flight::within(Mode::Acquire, |p| p.acquire_limit_s = 3_000.0);
    flight.sight.filtered = false;
    flight.fly(3_010.0);
    assert_eq!(flight.causes(), [(Mode::Safe, Cause::TooLong)]);
    let mut flight = Flight::within(Mode::Experiment, |p| p.experiment_next = Mode::Off);
    flight.fly(1_210.0);
    assert_eq!(flight.causes(), [(Mode::Off, Cause::Over)]);
    assert!((flight.transitions[0].0 - 1_201.0).abs() <= 1.0);
}

#[test]
fn safety_is_left_as_often_as_the_retries_allow_and_then_no_more() {
    let mut flight = Flight::within(Mode::Detumble, |p| p.retries = 2);
    flight.turns_at(8.0);
    for _ in 0..5 {
        flight.magnetometer = false;
        flight.fly(100.0);
        assert_eq!(flight.mode(), Mode::Safe);
        flight.magnetometer = true;
        flight.fly(400.0);
    }
    let silent = (Mode::Safe, Cause::Silent(Sensor::Magnetometer));
    let again = (Mode::Detumble, Cause::Recovered);
    assert_eq!(flight.causes(), [silent, again, silent, again, silent]);
    assert_eq!(flight.last.unwrap().retries, 2);
    // A command begins the count anew.
    assert_eq!(flight.command(Mode::Detumble).retries, 0);
}

#[test]
fn pointing_well_forgets_the_retries() {
    let mut flight = Flight::within(Mode::Detumble, |_| {});
    flight.magnetometer = false;
    flight.fly(100.0);
    flight.magnetometer = true;
    flight.fly(310.0);
    assert_eq!(flight.last.unwrap().retries, 1);
    flight.fly(2_000.0);
    assert_eq!((flight.mode(), flight.last.unwrap().retries), (Mode::Point, 0));
}

#[test]
fn what_was_commanded_to_be_safe_or_off_stays_so() {
    for mode in [Mode::Safe, Mode::Off] {
        let mut flight = Flight::within(mode, |_| {});
        flight.fly(50_000.0);
        assert_eq!((flight.mode(), flight.transitions.len()), (mode, 0));
    }
}

#[test]
fn a_command_without_a_law_is_refused_and_the_mode_stays() {
    let mut modes = machine(|_| {});
    modes.experiment = None;
    let mut flight = Flight::new(modes);
    flight.fly(10.0);
    let report = flight.command(Mode::Experiment);
    assert_eq!((report.mode, report.refused), (Mode::Detumble, Some(Mode::Experiment)));
    assert_eq!(report.transition, None);
    let report = flight.command(Mode::Off);
    assert_eq!((report.mode, report.refused), (Mode::Off, None));
}

#[test]
fn commissioning_that_hears_nothing_ends_in_safety_and_without_parameters_is_refused() {
    let mut flight = Flight::within(Mode::Commissioning, |_| {});
    flight.fly(1_300.0);
    let expected = (Mode::Safe, Cause::Unchecked(Undecided::NoRate));
    assert_eq!(flight.causes()[0], expected);
    let mut modes = machine(|_| {});
    modes.polarity = None;
    let mut flight = Flight::new(modes);
    flight.fly(1.0);
    assert_eq!(flight.command(Mode::Commissioning).refused, Some(Mode::Commissioning));
}

#[test]
fn setting_the_clock_ends_no_mode() {
    let mut flight = Flight::within(Mode::Detumble, |_| {});
    flight.turns_at(8.0);
    for jump_s in [1_000_000_i64, -2_000_000, 50_000] {
        flight.sight.now = flight.sight.now.plus_micros(jump_s * 1_000_000);
        flight.fly(100.0);
        assert_eq!((flight.mode(), flight.transitions.len()), (Mode::Detumble, 0));
    }
}

#[test]
fn only_modes_with_torquers_have_a_law() {
    let modes = machine(|_| {});
    let Flown { law, steering } = flown();
    for mode in
        [Mode::Off, Mode::Safe, Mode::Detumble, Mode::Acquire, Mode::Point, Mode::Experiment]
    {
        let (law, _) = modes.flown(mode, (&law, &steering));
        assert_eq!(!matches!(law, Law::Off), mode.drives(), "{mode}");
    }
}

fn any_mode() -> impl Strategy<Value = Option<Mode>> {
    use Mode::{Acquire, Detumble, Experiment, Off, Point, Safe};
    let modes = prop::sample::select(vec![Off, Safe, Detumble, Acquire, Point, Experiment]);
    prop_oneof![30 => Just(None), 1 => modes.prop_map(Some)]
}

fn any_number() -> impl Strategy<Value = Option<f32>> {
    prop_oneof![
        2 => Just(None),
        4 => (0.0..0.2_f32).prop_map(Some),
        1 => any::<f32>().prop_map(Some),
        1 => Just(Some(f32::NAN)),
    ]
}

proptest! {
    #[test]
    fn whatever_is_seen_no_law_flies_on_a_magnetometer_that_has_been_silent_for_too_long(
        sights in prop::collection::vec(
            (any_mode(), any_number(), any_number(), any_number(), any::<[bool; 3]>(), 0..50_u32),
            1..400,
        ),
        speaks in prop::collection::vec(any::<bool>(), 10),
    ) {
        const GAP_CYCLES: u32 = 20;
        let modes = machine(|p| p.sensor_gap_s = GAP_CYCLES as f32 * CYCLE_US as f32 * 1e-6);
        let mut state = ModesState::default();
        let mut now = Utc::from_micros_since_2000(0);
        let mut silent_for = 0;
        for (k, (commanded, rate, sigma, error, flags, jump)) in sights.into_iter().enumerate() {
            // Mostly half a second, now and then a year.
            now = now.plus_micros(if jump == 0 { 31_557_600_000_000 } else { CYCLE_US.into() });
            let [gyro_speaks, sun_speaks, filtered] = flags;
            // Silent for long stretches.
            let magnetometer = speaks[k / 40];
            silent_for = if magnetometer { 0 } else { silent_for + 1 };
            let report = modes.cycle(&mut state, &Sight {
                now,
                phase: Phase::Measuring,
                commanded,
                rate: rate.map(|x| Vector::<Body>::new(x, 0.01, 0.0)).filter(Vector::is_finite),
                gyro_speaks,
                magnetometer_speaks: Some(magnetometer),
                sun_speaks,
                torquers_obey: true,
                attitude_sigma_rad: sigma,
                filtered,
                dipole_sigma_am2: error,
                pointing_error_rad: error,
                witnessed: silent_devices(now, Phase::Measuring),
            });
            prop_assert_eq!(report.transition.map_or(report.mode, |it| it.to), report.mode);
            // A mode that a command has just entered sees the silence in the next cycle.
            let is_new = report.transition.is_some();
            prop_assert!(
                silent_for <= GAP_CYCLES || !report.mode.drives() || is_new,
                "{report:?} after {silent_for} silent cycles"
            );
        }
    }
}
