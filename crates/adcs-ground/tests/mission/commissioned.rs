//! What commissioning found, written as a mission and read again.

use adcs_core::commissioning::{
    Ended, Finding, Findings, InertiaFound, MagnetometerFound, Outcome, Rung, Three,
};
use adcs_core::modes::Mode;
use adcs_ground::mission::{Mission, load};
use adcs_ground::report::commissioning::Climb;

use crate::workshop::{Workshop, missions};

/// Decimal and back, and a unit between: two units in the last place of f32.
const ROUNDING: f32 = 2.5e-7;

fn three(value: [f32; 3]) -> Three {
    Three { value, sigma: [1e-3, 2e-3, 1e-3] }
}

/// As of a climb on which every rung passed.
fn findings() -> Findings {
    let found = [
        Finding::Magnetometer(MagnetometerFound {
            scale: three([1.177, 0.909, 1.111]),
            cross_axis: three([0.013, -0.041, 0.027]),
            bias_t: Three { value: [-5.5e-6, 11.9e-6, 14.8e-6], sigma: [3e-8; 3] },
            norm_error_t: 6e-7,
        }),
        Finding::Sun(three([0.026, -0.035, 0.017])),
        Finding::Gyro(three([4.3e-3, -3.1e-3, 2.1e-3])),
        Finding::Dipole(three([0.321, -0.012, 0.004])),
        Finding::Inertia(InertiaFound {
            tensor_kg_m2: [
                [0.0518, 0.0031, -0.0034],
                [0.0031, 0.0490, 0.0033],
                [-0.0034, 0.0033, 0.0598],
            ],
            sigma_kg_m2: [[1e-4; 3]; 3],
        }),
    ];
    let rungs = [Rung::Magnetometer, Rung::Sun, Rung::Gyro, Rung::Dipole, Rung::Inertia];
    let mut findings = Findings::default();
    for (rung, finding) in rungs.into_iter().zip(found) {
        findings.take(&Ended { rung, outcome: Outcome::Passed, finding: Some(finding) });
    }
    findings
}

/// `flown`, knowing what was found.
fn commissioned(workshop: &Workshop, flown: &Mission) -> Mission {
    let climb = Climb { rungs: Vec::new(), committed_ms: Vec::new(), findings: findings() };
    workshop.write("commissioning.toml", climb.toml(flown));
    let path = workshop.folder.join("commissioning.toml");
    load(&path).unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn what_was_found_flies_from_the_ground_as_the_satellite_put_it_in_force() {
    let workshop = Workshop::new();
    let flown = load(missions().join("sprout/commissioning.toml")).unwrap();
    let read = commissioned(&workshop, &flown).scenario.flight;
    let own = flown.scenario.flight.committed(&findings());

    let close = |a: &[f32], b: &[f32]| {
        assert_eq!(a.len(), b.len());
        for (a, b) in a.iter().zip(b) {
            assert!((a - b).abs() <= ROUNDING * b.abs(), "{a} {b}");
        }
    };
    for (a, b) in [(read.magnetometer, own.magnetometer), (read.gyro, own.gyro)] {
        close(&a.scale, &b.scale);
        close(&a.cross_axis, &b.cross_axis);
        close(&a.bias, &b.bias);
        assert_eq!(a.alignment_xyzw, b.alignment_xyzw);
    }
    let faces = |of: &adcs_app::FlightParameters| of.sun_sensors.unwrap().faces;
    for (a, b) in faces(&read).iter().zip(faces(&own)) {
        close(&a.alignment_xyzw, &b.alignment_xyzw);
    }
    let told = |of: &adcs_app::FlightParameters| of.attitude.unwrap().dynamics;
    let (a, b) = (told(&read), told(&own));
    close(&a.dipole_am2, &b.dipole_am2);
    close(a.inertia_kg_m2.as_flattened(), b.inertia_kg_m2.as_flattened());
    close(
        &[
            a.dipole_prior_am2,
            a.product_prior,
            a.sensors.bias_prior_rad_s,
            a.sensors.field_noise.calibration_t,
        ],
        &[
            b.dipole_prior_am2,
            b.product_prior,
            b.sensors.bias_prior_rad_s,
            b.sensors.field_noise.calibration_t,
        ],
    );
    let inertia = |of: &adcs_app::FlightParameters| match of.law {
        adcs_app::LawParameters::Periodic { law, unplanned, .. } => {
            [law.inertia_kg_m2, unplanned.inertia_kg_m2]
        }
        _ => panic!("the mission points by the periodic law"),
    };
    assert_eq!(inertia(&read), inertia(&own));
}

#[test]
fn what_was_found_changes_nothing_in_the_world() {
    let workshop = Workshop::new();
    let flown = load(missions().join("sprout/commissioning.toml")).unwrap();
    let read = commissioned(&workshop, &flown);
    assert_eq!(read.scenario.world, flown.scenario.world);
    assert_eq!(read.scenario.board, flown.scenario.board);
    // It does not climb once more.
    assert_eq!(flown.scenario.flight.modes.unwrap().table.start, Mode::Commissioning);
    assert_eq!(read.scenario.flight.modes.unwrap().table.start, Mode::Detumble);
    assert!(read.title.starts_with("Commissioned: "), "{}", read.title);
}
