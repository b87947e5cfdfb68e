//! Many positions at a time: each result is that of the position alone, to the bit.

use igrf::{
    Coefficients, DecimalYear, Error, GeodeticField, GeodeticPosition, HIGHEST_DEGREE,
    MAX_RADIUS_KM, MIN_RADIUS_KM, Real,
};
use proptest::prelude::*;

fn at<T: Real>(degree: u8) -> Coefficients<T> {
    Coefficients::at(DecimalYear(2026.5)).unwrap().with_degree(degree).unwrap()
}

/// Equal in every bit: of zeros also the sign. What is compared is never NaN.
fn bits<T: Real>(results: impl Iterator<Item = Result<[T; 3], Error>>) -> Vec<Outcome> {
    results.map(|result| result.map(|field| field.map(|value| value.to_f64().to_bits()))).collect()
}

type Outcome = Result<[u64; 3], Error>;

fn components<T: Real>(field: GeodeticField<T>) -> [T; 3] {
    [field.north_nt, field.east_nt, field.down_nt]
}

fn assert_same_as_alone<T: Real>(degree: u8, positions_km: &[[f64; 3]]) -> Vec<Outcome> {
    let coefficients = at::<T>(degree);
    let positions_km: Vec<_> =
        positions_km.iter().map(|position| position.map(T::from_f64)).collect();
    let together = bits(coefficients.fields_ecef_nt(positions_km.iter().copied()));
    let alone =
        bits(positions_km.iter().map(|&position_km| coefficients.field_ecef_nt(position_km)));
    assert_eq!(together, alone, "degree {degree}, {positions_km:?}");
    together
}

fn assert_same_as_alone_geodetic<T: Real>(degree: u8, positions: &[[f64; 3]]) -> Vec<Outcome> {
    let coefficients = at::<T>(degree);
    let positions: Vec<_> = positions
        .iter()
        .map(|position| {
            let [latitude_rad, longitude_rad, height_km] = position.map(T::from_f64);
            GeodeticPosition { latitude_rad, longitude_rad, height_km }
        })
        .collect();
    let together = coefficients.fields_geodetic_nt(positions.iter().copied());
    let together = bits(together.map(|field| field.map(components)));
    let alone = positions.iter().map(|&position| coefficients.field_geodetic_nt(position));
    let alone = bits(alone.map(|field| field.map(components)));
    assert_eq!(together, alone, "degree {degree}, {positions:?}");
    together
}

/// Positions in every direction, the poles, the axes and the limits of the radius among them.
fn positions_km() -> Vec<[f64; 3]> {
    let mut positions_km = vec![
        [0.0, 0.0, 6_900.0],
        [0.0, 0.0, -6_900.0],
        [-0.0, -0.0, 6_900.0],
        [1e-9, 0.0, -6_900.0],
        [6_900.0, 0.0, 0.0],
        [-6_900.0, -0.0, 0.0],
        [0.0, 6_900.0, -0.0],
        [0.0, -6_900.0, 0.0],
        [MIN_RADIUS_KM * 1.000_001, 0.0, 0.0],
        [0.0, 0.0, MAX_RADIUS_KM * 0.999_999],
    ];
    for step in 0..41 {
        let (sin_theta, cos_theta) = (0.1 + 0.071 * f64::from(step)).sin_cos();
        let (sin_phi, cos_phi) = (1.9 * f64::from(step)).sin_cos();
        let r_km = 6_371.2 + 120.0 * f64::from(step);
        positions_km.push([sin_theta * cos_phi, sin_theta * sin_phi, cos_theta].map(|d| r_km * d));
    }
    positions_km
}

#[test]
fn every_degree_has_the_bits_of_the_single_evaluation() {
    for degree in 1..=HIGHEST_DEGREE {
        let single = assert_same_as_alone::<f32>(degree, &positions_km());
        let double = assert_same_as_alone::<f64>(degree, &positions_km());
        assert!(single.iter().chain(&double).all(Result::is_ok));
    }
}

#[test]
fn every_number_of_positions_has_as_many_results_in_their_order() {
    for count in 0..=17 {
        let positions_km = &positions_km()[..count];
        assert_eq!(assert_same_as_alone::<f64>(13, positions_km).len(), count);
        assert_eq!(assert_same_as_alone::<f32>(13, positions_km).len(), count);
    }
}

#[test]
fn a_refused_position_has_its_error_and_leaves_the_others_alone() {
    let refused = [
        [0.0; 3],
        [f64::NAN, 4_000.0, 4_000.0],
        [4_000.0, f64::INFINITY, 0.0],
        [MIN_RADIUS_KM * 0.999, 0.0, 0.0],
        [0.0, MAX_RADIUS_KM * 1.001, 0.0],
        [1e300, 0.0, 0.0],
        [1e-300, 0.0, 0.0],
    ];
    // In each place of a block, and alone at the end.
    for bad in refused {
        for place in 0..9 {
            let mut positions_km = positions_km()[10..19].to_vec();
            positions_km[place] = bad;
            for results in [
                assert_same_as_alone::<f32>(13, &positions_km),
                assert_same_as_alone::<f64>(13, &positions_km),
            ] {
                let errors: Vec<_> =
                    (0..results.len()).filter(|&index| results[index].is_err()).collect();
                assert_eq!(errors, [place], "{bad:?}");
            }
        }
    }
    assert!(assert_same_as_alone::<f64>(13, &refused).iter().all(Result::is_err));
}

#[test]
fn geodetic_positions_have_the_bits_of_the_single_evaluation() {
    use core::f64::consts::FRAC_PI_2;

    let mut positions = vec![
        [FRAC_PI_2, 0.0, 500.0],
        [-FRAC_PI_2, 2.5, 0.0],
        [0.3, core::f64::consts::PI, 600.0],
        [0.3, -core::f64::consts::PI, 600.0],
        [1.571, 0.0, 500.0], // beyond the pole
        [0.0, f64::NAN, 500.0],
        [0.0, 0.0, -4_000.0], // in the core
    ];
    for step in 0..40 {
        let step = f64::from(step);
        positions.push([-1.5 + 0.074 * step, -7.0 + 0.4 * step, 30.0 * step]);
    }
    for degree in 1..=HIGHEST_DEGREE {
        let single = assert_same_as_alone_geodetic::<f32>(degree, &positions);
        let double = assert_same_as_alone_geodetic::<f64>(degree, &positions);
        for results in [single, double] {
            assert_eq!(results.iter().filter(|result| result.is_err()).count(), 3);
        }
    }
}

#[test]
fn nothing_is_taken_after_the_last_position() {
    // An iterator that gives something again after its end, as iterators may.
    let mut calls = 0;
    let positions = core::iter::from_fn(|| {
        calls += 1;
        (calls % 6 != 0).then_some([0.0, 0.0, 6_900.0])
    });
    assert_eq!(at::<f64>(13).fields_ecef_nt(positions).count(), 5);
}

proptest! {
    #[test]
    fn any_positions_have_the_bits_of_the_single_evaluation(
        near in prop::collection::vec(prop::array::uniform3(-12_000.0..12_000.0f64), 0..12),
        raw in prop::collection::vec(any::<[u64; 3]>(), 0..3),
        degree in 1..=HIGHEST_DEGREE,
    ) {
        let raw = raw.into_iter().map(|bits| bits.map(f64::from_bits));
        let positions_km: Vec<_> = near.into_iter().chain(raw).collect();
        assert_same_as_alone::<f32>(degree, &positions_km);
        assert_same_as_alone::<f64>(degree, &positions_km);
        assert_same_as_alone_geodetic::<f64>(degree, &positions_km);
    }
}
