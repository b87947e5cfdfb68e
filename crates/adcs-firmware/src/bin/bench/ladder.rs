//! The commissioning ladder, rung by rung: the costliest cycle of 70 s, in which its result is looked at once.

use adcs_core::commissioning::{
    CommissioningParameters, Findings, Ladder, LadderState, Outcome, Rung, StepTime, Told,
    Witnessed,
};
use adcs_core::frames::{Body, Direction, Vector};
use adcs_core::identification::Noise;
use adcs_core::polarity::{ActiveCheck, GuardInputs, PolarityParameters};
use adcs_core::reading::Reading;
use adcs_core::schedule::Phase;
use adcs_core::sensing::TriadParameters;
use adcs_core::time::Utc;
use semihosting::eprintln;

use crate::counter::Counter;
use crate::stages::print;

const NAMES: [&str; adcs_core::commissioning::RUNGS] = [
    "ladder_magnetometer",
    "ladder_polarity",
    "ladder_coupling",
    "ladder_sun",
    "ladder_gyro",
    "ladder_dipole",
    "ladder_inertia",
];
const CYCLES: u32 = 140;
const CYCLE_US: i64 = 500_000;
/// Of the turn in a cycle, 0.025 rad.
const SINE: f32 = 0.024_997_4;
const COSINE: f32 = 0.999_687_5;

/// Counts the costliest cycle of every rung.
#[inline(never)]
pub fn run(counter: &Counter) {
    let usual = CommissioningParameters::default();
    let time = StepTime { least_s: 30.0, ..usual.sun };
    // Gates that nothing passes, so that the rung is not left.
    let parameters = CommissioningParameters {
        magnetometer: time,
        coupling: time,
        gyro: time,
        sun: time,
        momentum: time,
        scale_sigma: 1e-6,
        coupling_sigma_t_per_am2: 1e-10,
        gyro_sigma_rad_s: 1e-8,
        sun_sigma_rad: 1e-6,
        dipole_sigma_am2: 1e-6,
        inertia_sigma: 1e-6,
        ..usual
    };
    let polarity = PolarityParameters::default();
    let told = Told {
        magnetometer: TriadParameters::default(),
        inertia_kg_m2: polarity.inertia_kg_m2,
        noise: Noise::default(),
        settle_s: 0.5,
    };
    let ladder = Ladder::new(&parameters, &told).expect("accepted");
    let check = ActiveCheck::new(&polarity).expect("accepted");
    for (rung, name) in Rung::ALL.into_iter().zip(NAMES) {
        let mut findings = Findings::default();
        for below in Rung::ALL.into_iter().take(rung.number()) {
            findings.outcomes[below.number()] = Some(Outcome::Passed);
        }
        let mut state = LadderState::resumed(findings);
        let mut carried = Vector::zero();
        let (mut worst, mut sine, mut cosine) = (0, 0.0, 1.0);
        for cycle in 0..CYCLES {
            let witnessed = at(cycle, (sine, cosine), carried);
            (sine, cosine) = (sine * COSINE + cosine * SINE, cosine * COSINE - sine * SINE);
            let mut pulse = Vector::zero();
            let count = counter.count(|| {
                pulse = ladder.cycle(&check, &mut state, &witnessed).pulse;
            });
            carried = pulse;
            worst = worst.max(count);
        }
        print(name, worst);
    }
    eprintln!("bytes ladder_state {}", size_of::<LadderState>());
}

/// A tumble about a skew axis in a field that is at rest in space.
fn at(cycle: u32, (sine, cosine): (f32, f32), carried: Vector<Body>) -> Witnessed {
    let field = [3e-5 * cosine + 1e-5 * sine, -3e-5 * sine + 1e-5 * cosine, 2e-5];
    let phase = match cycle % 15 {
        0 => Phase::Settling,
        1..5 => Phase::Settled,
        5 => Phase::Measuring,
        _ => Phase::Acting,
    };
    let [x, y, z] = field;
    Witnessed {
        devices: GuardInputs {
            now: Utc::from_micros_since_2000(i64::from(cycle) * CYCLE_US),
            phase,
            omega_bi: Reading::Fresh(Vector::new(0.001, -0.002, 0.05)),
            field_b: Reading::Fresh(Vector::new(x, y, z)),
            carried,
        },
        reading: Reading::Fresh(Vector::new(x, y, z)),
        reference_field: Some(Vector::new(3e-5, 1e-5, 2e-5)),
        reference_sun: Direction::new(Vector::new(1.0, 0.0, 0.0)),
        sun: Direction::new(Vector::new(cosine, -sine, 0.1 * sine)),
    }
}
