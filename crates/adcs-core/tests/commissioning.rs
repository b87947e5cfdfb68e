//! The commissioning ladder alone, with what it sees made by hand.

use adcs_core::commissioning::{
    CommissioningError, CommissioningParameters, Commit, Findings, Ladder, LadderState, LadderStep,
    Outcome, RUNGS, Rung, Shortfall, StepTime, Told, Witnessed,
};
use adcs_core::frames::{Direction, Vector};
use adcs_core::identification::Noise;
use adcs_core::polarity::{ActiveCheck, GuardInputs, PolarityParameters, Undecided};
use adcs_core::reading::{MissingReason, Reading};
use adcs_core::schedule::{Phase, Schedule, ScheduleParameters};
use adcs_core::sensing::TriadParameters;
use adcs_core::time::Utc;
use proptest::prelude::*;

const CYCLE_US: u32 = 500_000;
/// Every rung looks for so long, s.
const TIME: StepTime = StepTime { least_s: 120.0, most_s: 240.0 };

fn parameters() -> CommissioningParameters {
    CommissioningParameters {
        magnetometer: TIME,
        coupling: TIME,
        gyro: TIME,
        sun: TIME,
        momentum: TIME,
        ..CommissioningParameters::default()
    }
}

fn told() -> Told {
    Told {
        magnetometer: TriadParameters::default(),
        inertia_kg_m2: PolarityParameters::default().inertia_kg_m2,
        noise: Noise::default(),
        settle_s: 0.5,
    }
}

/// A ladder with a satellite below it that hardly turns, or shows nothing at all.
struct Climb {
    ladder: Ladder,
    check: ActiveCheck,
    schedule: Schedule,
    state: LadderState,
    cycle: u32,
    ended: Vec<(Rung, Outcome)>,
}

impl Climb {
    fn new(findings: Findings) -> Self {
        let schedule =
            ScheduleParameters { on_us: 5_000_000, off_us: 2_500_000, settle_us: 500_000 };
        Self {
            ladder: Ladder::new(&parameters(), &told()).unwrap(),
            check: ActiveCheck::new(&PolarityParameters::default()).unwrap(),
            schedule: Schedule::new(&schedule, CYCLE_US).unwrap(),
            state: LadderState::resumed(findings),
            cycle: 0,
            ended: Vec::new(),
        }
    }

    fn cycle(&mut self, mut witnessed: Witnessed) -> LadderStep {
        witnessed.devices.phase = self.schedule.phase(self.cycle);
        witnessed.devices.now =
            Utc::from_micros_since_2000(i64::from(self.cycle) * i64::from(CYCLE_US));
        let step = self.ladder.cycle(&self.check, &mut self.state, &witnessed);
        self.ended.extend(step.report.ended.map(|it| (it.rung, it.outcome)));
        self.cycle += 1;
        step
    }

    fn seconds(&mut self, seconds: u32, witnessed: &Witnessed) {
        for _ in 0..2 * seconds {
            self.cycle(*witnessed);
        }
    }
}

fn silent() -> Witnessed {
    let bus = MissingReason::Bus;
    Witnessed {
        devices: GuardInputs {
            now: Utc::from_micros_since_2000(0),
            phase: Phase::Settling,
            omega_bi: Reading::Missing(bus),
            field_b: Reading::Missing(bus),
            carried: Vector::zero(),
        },
        reading: Reading::Missing(bus),
        reference_field: None,
        reference_sun: None,
        sun: None,
    }
}

/// Everything speaks, and always says the same: nothing can be told from it.
fn frozen() -> Witnessed {
    Witnessed {
        devices: GuardInputs {
            omega_bi: Reading::Fresh(Vector::new(0.0, 0.0, 0.0)),
            ..silent().devices
        },
        reading: Reading::Fresh(Vector::new(2e-5, 1e-5, -3e-5)),
        reference_field: Some(Vector::new(2e-5, 1e-5, -3e-5)),
        reference_sun: Direction::new(Vector::new(1.0, 0.0, 0.0)),
        sun: Direction::new(Vector::new(1.0, 0.0, 0.0)),
    }
}

/// All rungs up to one have passed.
fn passed_below(rung: Rung) -> Findings {
    let mut findings = Findings::default();
    for below in Rung::ALL.into_iter().take(rung.number()) {
        findings.outcomes[below.number()] = Some(Outcome::Passed);
    }
    findings
}

#[test]
fn a_satellite_that_shows_nothing_ends_every_rung_in_its_time_and_says_why() {
    for witnessed in [silent(), frozen()] {
        let mut climb = Climb::new(Findings::default());
        climb.seconds(300, &witnessed);
        // What rests upon the magnetometer is not tried; that is all of it.
        let rests = Outcome::Failed(Shortfall::RestsOnFailed);
        let mut expected = vec![(Rung::Magnetometer, Outcome::Failed(Shortfall::NotSupported))];
        expected.extend(Rung::ALL.into_iter().skip(1).map(|rung| (rung, rests)));
        assert_eq!(climb.ended, expected);
        assert_eq!(climb.state.findings().next(), None);
    }
}

#[test]
fn each_rung_alone_ends_in_its_time_when_the_readings_do_not_tell() {
    for rung in Rung::ALL {
        let mut climb = Climb::new(passed_below(rung));
        climb.seconds(1_900, &frozen());
        let (first, outcome) = climb.ended[0];
        assert_eq!(first, rung);
        let slow = Outcome::Failed(Shortfall::Undecided(Undecided::TooSlow));
        let expected = match rung {
            Rung::Polarity => slow,
            // A field that is as expected says that torquers which never act do nothing to it, and that
            // nothing turns; how well, is another matter.
            _ => Outcome::Failed(Shortfall::NotSupported),
        };
        let uncertain = Outcome::Failed(Shortfall::Uncertain);
        assert!(outcome == expected || outcome == uncertain, "{rung}: {outcome}");
        assert_eq!(climb.state.findings().next(), None, "{rung}");
    }
}

#[test]
fn a_climb_goes_on_with_the_first_rung_that_has_not_ended() {
    let mut climb = Climb::new(passed_below(Rung::Sun));
    let report = climb.cycle(frozen()).report;
    assert_eq!(report.rung, Some(Rung::Sun));
    climb.seconds(250, &frozen());
    assert_eq!(climb.ended[0].0, Rung::Sun);
    assert!(climb.state.findings().passed(Rung::Coupling));
}

#[test]
fn another_climb_keeps_what_passed_and_after_a_whole_one_begins_anew() {
    let mut findings = passed_below(Rung::Gyro);
    findings.outcomes[Rung::Gyro.number()] = Some(Outcome::Failed(Shortfall::Uncertain));
    findings.committed = true;
    findings.retry();
    assert_eq!(findings, passed_below(Rung::Gyro), "and what flies is what was uplinked");
    let mut all = Findings { outcomes: [Some(Outcome::Passed); RUNGS], ..Findings::default() };
    all.committed = true;
    all.retry();
    assert_eq!(all, Findings::default());
}

#[test]
fn pulses_are_given_for_polarity_and_coupling_alone_and_never_beyond_what_was_told() {
    for rung in Rung::ALL {
        let mut climb = Climb::new(passed_below(rung));
        let mut pulsed = 0.0_f32;
        for _ in 0..60 {
            let step = climb.cycle(frozen());
            if climb.state.findings().next() == Some(rung) {
                pulsed = pulsed.max(step.pulse.norm());
            }
        }
        let pulses = matches!(rung, Rung::Polarity | Rung::Coupling);
        let expected = if pulses { PolarityParameters::default().pulse_am2 } else { 0.0 };
        assert_eq!(pulsed, expected, "{rung}");
    }
}

#[test]
fn parameters_that_no_ladder_can_use_are_refused_by_name() {
    type Change = fn(&mut CommissioningParameters, f32);
    let changes: [(&str, Change); 12] = [
        ("magnetometer", |p, x| p.magnetometer.least_s = x),
        ("coupling", |p, x| p.coupling.most_s = x),
        ("gyro", |p, x| p.gyro.least_s = x),
        ("sun", |p, x| p.sun.most_s = x),
        ("momentum", |p, x| p.momentum.most_s = x),
        ("scale_sigma", |p, x| p.scale_sigma = x),
        ("bias_sigma_t", |p, x| p.bias_sigma_t = x),
        ("coupling_sigma_t_per_am2", |p, x| p.coupling_sigma_t_per_am2 = x),
        ("gyro_sigma_rad_s", |p, x| p.gyro_sigma_rad_s = x),
        ("sun_sigma_rad", |p, x| p.sun_sigma_rad = x),
        ("dipole_sigma_am2", |p, x| p.dipole_sigma_am2 = x),
        ("inertia_sigma", |p, x| p.inertia_sigma = x),
    ];
    assert!(Ladder::new(&parameters(), &told()).is_ok());
    for (expected, change) in changes {
        for bad in [f32::NAN, f32::INFINITY, 0.0, -1.0] {
            let mut wrong = CommissioningParameters { commit: Commit::WhenPassed, ..parameters() };
            change(&mut wrong, bad);
            let error = Ladder::new(&wrong, &told()).unwrap_err();
            let CommissioningError::OutOfRange(error) = error else { panic!("{error}") };
            assert_eq!(error.name, expected, "{bad}");
        }
    }
    // A step that ends before it may.
    let gyro = StepTime { least_s: 100.0, most_s: 50.0 };
    let wrong = CommissioningParameters { gyro, ..parameters() };
    assert!(Ladder::new(&wrong, &told()).is_err());
}

/// Any number that a device or a model could say.
fn any_number() -> impl Strategy<Value = f32> {
    prop_oneof![
        any::<f32>(),
        -1e-4..1e-4_f32,
        Just(0.0),
        Just(f32::NAN),
        Just(f32::INFINITY),
        Just(f32::MAX),
    ]
}

fn any_witnessed() -> impl Strategy<Value = Witnessed> {
    (
        prop::array::uniform3(any_number()),
        prop::array::uniform3(any_number()),
        prop::array::uniform3(any_number()),
        prop::array::uniform3(-0.6..0.6_f32),
        prop::array::uniform3(any_number()),
        any::<bool>(),
    )
        .prop_map(|(rate, reading, field, carried, sun, speaks)| {
            let vector = |[x, y, z]: [f32; 3]| Vector::new(x, y, z);
            let devices = GuardInputs {
                omega_bi: match speaks {
                    true => Reading::Fresh(Vector::new(rate[0], rate[1], rate[2])),
                    false => Reading::Missing(MissingReason::Bus),
                },
                carried: Vector::new(carried[0], carried[1], carried[2]),
                ..silent().devices
            };
            Witnessed {
                devices,
                reading: Reading::Fresh(Vector::new(reading[0], reading[1], reading[2])),
                reference_field: Some(vector(field)),
                reference_sun: Direction::new(Vector::new(1.0, 0.5, 0.0)),
                sun: Direction::new(Vector::new(sun[0], sun[1], sun[2])),
            }
        })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, ..ProptestConfig::default() })]

    #[test]
    fn whatever_the_devices_say_every_rung_ends_and_pulses_stay_finite(
        rung in 0..RUNGS,
        all in prop::collection::vec(any_witnessed(), 1..40),
    ) {
        let mut climb = Climb::new(passed_below(Rung::ALL[rung]));
        for witnessed in all.iter().cycle().take(4_000) {
            let step = climb.cycle(*witnessed);
            let most = PolarityParameters::default().pulse_am2;
            prop_assert!(step.pulse.norm() <= most, "{:?}", step.pulse);
        }
        prop_assert_eq!(climb.state.findings().next(), None);
    }
}
