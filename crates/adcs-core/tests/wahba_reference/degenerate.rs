//! Geometry that leaves a rotation open is refused, in both precisions, by every method.

use adcs_core::attitude::{Method, NoAttitude};
use nalgebra::{Matrix3, Rotation3, Vector3};

use crate::OPTIMAL;
use crate::noise::Noise;
use crate::problem::{Pair, solve, solve_f32};

const DRAWS: u32 = 2_000;
const ALL: [Method; 4] = [Method::Triad, Method::Foam, Method::QMethod, Method::Quest];

fn refused<T: nalgebra::RealField + Copy>(
    result: &Result<adcs_core::attitude::Estimate<T>, NoAttitude>,
) -> bool {
    matches!(result, Err(NoAttitude::NotUnique { .. }))
}

/// Draws problems and wants every method to refuse them.
fn all_refuse(
    what: &str,
    methods: &[Method],
    seed: u64,
    mut draw: impl FnMut(&mut Noise) -> Vec<Pair>,
) {
    let mut noise = Noise::new(seed);
    for _ in 0..DRAWS {
        let pairs = draw(&mut noise);
        for &method in methods {
            let in_f64 = solve(method, &pairs);
            assert!(refused(&in_f64), "{what}: {method:?} in f64: {in_f64:?} for {pairs:?}");
            let in_f32 = solve_f32(method, &pairs);
            assert!(refused(&in_f32), "{what}: {method:?} in f32: {in_f32:?} for {pairs:?}");
        }
    }
}

fn sigma(noise: &mut Noise) -> f64 {
    noise.log_uniform(1e-6, 0.1)
}

fn count(noise: &mut Noise) -> u32 {
    2 + (noise.uniform() * 4.0) as u32
}

/// Along `v`, of any length, either way.
fn along(v: &Vector3<f64>, noise: &mut Noise) -> f64 {
    let sign = if noise.uniform() < 0.5 { -1.0 } else { 1.0 };
    sign * noise.log_uniform(1e-3, 1e3) * v.norm()
}

#[test]
fn parallel_and_antiparallel_pairs() {
    all_refuse("parallel", &ALL, 1, |noise| {
        let (a, r) = (noise.rotation(), noise.direction());
        (0..count(noise))
            .map(|_| {
                let reference = r * along(&r, noise);
                Pair { body: a * reference, reference, sigma_rad: sigma(noise) }
            })
            .collect()
    });
}

#[test]
fn parallel_references_with_noisy_measurements() {
    all_refuse("parallel references", &ALL, 2, |noise| {
        let (a, r) = (noise.rotation(), noise.direction());
        let spread = noise.log_uniform(1e-6, 0.5);
        (0..count(noise))
            .map(|_| Pair {
                body: noise.disturbed(&(a * r), spread),
                reference: r * noise.log_uniform(1e-3, 1e3),
                sigma_rad: sigma(noise),
            })
            .collect()
    });
}

#[test]
fn parallel_measurements_of_different_references() {
    all_refuse("parallel measurements", &ALL, 3, |noise| {
        let b = noise.direction();
        (0..count(noise))
            .map(|_| Pair {
                body: b * noise.log_uniform(1e-3, 1e3),
                reference: noise.direction(),
                sigma_rad: sigma(noise),
            })
            .collect()
    });
}

#[test]
fn pairs_that_contradict_each_other_so_that_two_attitudes_are_as_good() {
    // B = U diag(s₁, s₂, −s₂) Vᵀ: s₂ + d s₃ = 0. Three orthogonal pairs, the last mirrored.
    all_refuse("mirrored", &OPTIMAL, 4, |noise| {
        let (u, v) = (noise.rotation(), noise.rotation());
        let sharp = sigma(noise);
        let blunt = sharp * (1.0 + 3.0 * noise.uniform());
        [(0, sharp, 1.0), (1, blunt, 1.0), (2, blunt, -1.0)]
            .map(|(axis, sigma_rad, sign)| Pair {
                body: u.matrix().column(axis) * sign,
                reference: v.matrix().column(axis).into_owned(),
                sigma_rad,
            })
            .to_vec()
    });
}

#[test]
fn a_second_pair_whose_weight_vanishes() {
    // In f64, weights below ε⁴ of the heaviest still count; in f32 as well, down to its smallest
    // number: only what underflows is gone. σ of 1e-11 and 1e13 is that in f32.
    let pairs = [
        Pair { body: Vector3::x(), reference: Vector3::x(), sigma_rad: 1e-11 },
        Pair { body: Vector3::y(), reference: Vector3::y(), sigma_rad: 1e13 },
    ];
    for method in OPTIMAL {
        assert!(refused(&solve_f32(method, &pairs)), "{method:?}");
    }
}

#[test]
fn a_single_pair_and_none() {
    let pair = Pair { body: Vector3::x(), reference: Vector3::y(), sigma_rad: 0.01 };
    for method in ALL {
        for pairs in [&[][..], &[pair]] {
            let too_few = NoAttitude::TooFew { found: pairs.len() };
            assert_eq!(solve(method, pairs).unwrap_err(), too_few);
        }
    }
}

/// Just beyond where uniqueness ends, what is reported is right.
#[test]
fn nearly_parallel_pairs_are_refused_or_right() {
    /// What rounding may do to an accepted attitude, with the reference's own rounding (f32: the
    /// input is rounded too).
    const ACCEPTED_RAD: f64 = 2e-3;
    let mut noise = Noise::new(5);
    let (mut accepted, mut refusals) = ([0; 2], [0; 2]);
    for _ in 0..4 * DRAWS {
        let (a, r) = (noise.rotation(), noise.direction());
        let apart = noise.log_uniform(1e-15, 1e-1);
        let pairs: Vec<_> = (0..count(&mut noise))
            .map(|_| {
                let reference = noise.disturbed(&r, apart);
                let sigma_rad = noise.log_uniform(1e-6, 1e-1);
                Pair { body: a * reference, reference, sigma_rad }
            })
            .collect();
        for method in ALL {
            let truth = adcs_core::frames::Rotation::from_hamilton(a.into());
            let found = [
                solve(method, &pairs).map(|e| e.attitude),
                solve_f32(method, &pairs).map(|e| crate::problem::widened(e.attitude)),
            ];
            for (precision, found) in found.into_iter().enumerate() {
                match found {
                    Ok(attitude) => {
                        let error = crate::problem::angle_rad(attitude, truth);
                        assert!(error < ACCEPTED_RAD, "{method:?} {precision}: {error} {pairs:?}");
                        accepted[precision] += 1;
                    }
                    Err(_) => refusals[precision] += 1,
                }
            }
        }
    }
    println!("nearly parallel, f64 and f32: accepted {accepted:?}, refused {refusals:?}");
    assert!(accepted.iter().chain(&refusals).all(|n| *n > 100));
}

/// A weight 10¹² times the others' does not drown them, in either precision.
#[test]
fn weight_ratios_of_1e12_cost_no_accuracy() {
    const F64_RAD: f64 = 1e-12;
    const F32_RAD: f64 = 1e-5;
    let mut noise = Noise::new(6);
    let mut worst = [0.0_f64; 2];
    for _ in 0..DRAWS {
        let a: Rotation3<f64> = noise.rotation();
        let mut references = Matrix3::<f64>::zeros();
        while references.determinant().abs() < 0.1 {
            references = Matrix3::from_columns(&[(); 3].map(|()| noise.direction()));
        }
        let pairs: Vec<_> = references
            .column_iter()
            .zip([1e-7, 0.1, noise.log_uniform(1e-7, 0.1)])
            .map(|(r, sigma_rad)| Pair { body: a * r, reference: r.into_owned(), sigma_rad })
            .collect();
        let truth = adcs_core::frames::Rotation::from_hamilton(a.into());
        for method in ALL {
            let found = solve(method, &pairs).expect("unique");
            worst[0] = worst[0].max(crate::problem::angle_rad(found.attitude, truth));
            let found = solve_f32(method, &pairs).expect("unique");
            let error = crate::problem::angle_rad(crate::problem::widened(found.attitude), truth);
            worst[1] = worst[1].max(error);
        }
    }
    println!("weights 1e12: f64 {:.1e} rad, f32 {:.1e} rad", worst[0], worst[1]);
    assert!(worst[0] < F64_RAD && worst[1] < F32_RAD, "{worst:?}");
}
