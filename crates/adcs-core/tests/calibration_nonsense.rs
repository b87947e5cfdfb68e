//! Calibrations and identifications that are handed what is broken: a reason, or something finite.

mod nonsense;

use adcs_core::calibration::axes::{AxesCheck, AxesStep};
use adcs_core::calibration::{
    CoupledSample, DataSheet, Extended, NoiseShift, Sample, Start, Sums, calibrate_extended,
    twostep,
};
use adcs_core::identification::coupling::{CouplingSample, TorquerCoupling};
use adcs_core::identification::gyro::GyroBias;
use adcs_core::identification::momentum::MomentumFit;
use adcs_core::identification::sun::SunAlignment;
use adcs_core::identification::torque::DipoleByDifferences;
use adcs_core::identification::{Noise, Recorded};
use nonsense::anything;
use proptest::prelude::*;

const INERTIA: [[f32; 3]; 3] = [[0.05, 0.001, 0.0], [0.001, 0.055, 0.0], [0.0, 0.0, 0.06]];

fn rows<const N: usize>() -> impl Strategy<Value = Vec<[f32; N]>> {
    let tame = prop::array::uniform(-1.0..1.0_f32);
    let row = prop_oneof![20 => tame, 1 => prop::array::uniform(anything())];
    prop::collection::vec(row, 0..80)
}

fn all_finite<'a>(values: impl IntoIterator<Item = &'a f32>) -> bool {
    values.into_iter().all(|value| value.is_finite())
}

proptest! {
    #[test]
    fn nonsense_gives_a_calibration_a_reason_or_a_finite_result(
        rows in rows::<5>(),
        sensitivity in prop_oneof![3 => Just(1.0_f32), 1 => anything()],
        zero in prop_oneof![3 => Just(0.0_f32), 1 => anything()],
    ) {
        let sheet = DataSheet { sensitivity, zero };
        let samples = rows.iter().map(|&[x, y, z, i, current]| CoupledSample {
            sample: Sample { reading: [x, y, z], intensity: i.abs() },
            currents: [current],
        });
        let plain = samples.clone().map(|coupled| coupled.sample);
        for start in [Start::DataSheet(sheet), Start::Linear { zero }] {
            for shift in [NoiseShift::Kept, NoiseShift::Removed] {
                let found: Result<Extended<f32, 12>, _> =
                    calibrate_extended(samples.clone(), &start, shift);
                match found {
                    Ok(found) => {
                        let values = found.parameters.0.iter().chain(found.covariance.iter());
                        prop_assert!(all_finite(values), "{found:?}");
                    }
                    Err(reason) => prop_assert!(!reason.to_string().is_empty()),
                }
            }
        }
        match twostep(plain.clone(), sheet) {
            Ok(found) => {
                prop_assert!(all_finite(found.parameters.0.iter().chain(found.covariance.iter())));
            }
            Err(reason) => prop_assert!(!reason.to_string().is_empty()),
        }
        if let Ok(mut sums) = Sums::new(sheet, 1.0) {
            for sample in plain {
                // What is refused leaves the sums as they are.
                let before = sums;
                if sums.add(sample).is_err() {
                    prop_assert_eq!(sums, before);
                }
            }
            if let Ok(found) = sums.calibration::<9>() {
                prop_assert!(all_finite(found.parameters.0.iter().chain(found.covariance.iter())));
            }
        }
    }

    #[test]
    fn nonsense_gives_an_identification_a_reason_or_a_finite_result(rows in rows::<11>()) {
        let mut axes = AxesCheck::new(INERTIA);
        let mut differences = DipoleByDifferences::new(INERTIA).unwrap();
        let mut ratios = MomentumFit::ratios(INERTIA, Noise::default()).unwrap();
        let mut gains = MomentumFit::gains(INERTIA, Noise::default()).unwrap();
        let mut bias = GyroBias::with_temperature(Noise::default(), 0.0);
        let mut sun = SunAlignment::default();
        let mut coupling = TorquerCoupling::default();
        for &[dt, a, b, c, x, y, z, m, n, o, warm] in &rows {
            let recorded = Recorded {
                dt_s: dt.abs(),
                rate_rad_s: [a, b, c],
                field_t: (m > -0.5).then_some([x, y, z]),
                dipole_am2: [m, n, o],
            };
            let Recorded { dt_s, rate_rad_s, field_t, dipole_am2 } = recorded;
            axes.add(&AxesStep { dt_s, rate_rad_s, field_t, dipole_am2 });
            differences.add(&recorded);
            ratios.add(&recorded);
            gains.add(&recorded);
            bias.add(&recorded, warm, (a > 0.0).then_some([x, m, o]));
            sun.add([a, b, c], [x, y, z], warm);
            let field_t = [x, y, z];
            coupling.add(&CouplingSample { dt_s, rate_rad_s, field_t, dipole_am2 });
        }
        if let Ok(found) = axes.verdict() {
            prop_assert!(all_finite(&[found.gyro_ratio, found.response, found.response_sigma]));
        }
        let three = [differences.solve(), sun.solve()];
        for found in three.into_iter().flatten() {
            prop_assert!(all_finite(found.x.iter().chain(found.covariance.iter())));
        }
        if let Ok(found) = ratios.solve() {
            prop_assert!(all_finite(found.x.iter().chain(found.covariance.iter())));
        }
        if let Ok(found) = coupling.solve() {
            prop_assert!(all_finite(found.x.iter().chain(found.covariance.iter())));
        }
        if let Ok(found) = gains.solve() {
            prop_assert!(all_finite(found.x.iter().chain(found.covariance.iter())));
        }
        if let Ok(found) = bias.solve() {
            prop_assert!(all_finite(found.x.iter().chain(found.covariance.iter())));
        }
    }
}
