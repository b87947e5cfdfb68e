//! What holds everywhere: a field without sources and curls, continuity where coordinates are
//! singular, and no input that gives NaN or panics.

use igrf::{
    Coefficients, DecimalYear, Error, GeocentricPosition, GeodeticPosition, MAX_RADIUS_KM,
    MIN_RADIUS_KM, Real,
};
use proptest::prelude::*;

fn at<T: Real>(year: f64) -> Coefficients<T> {
    Coefficients::at(DecimalYear(year)).unwrap()
}

/// A point by angles that cover the sphere, the exact poles and the date line included.
fn position() -> impl Strategy<Value = [f64; 3]> {
    let special = prop_oneof![Just(0.0), Just(180.0), -1e-6..1e-6, 179.999..180.0, 0.0..180.0];
    (special.clone(), special, 6_371.2..9_000.0).prop_map(|(theta, phi, r): (f64, f64, f64)| {
        let (sin_theta, cos_theta) = theta.to_radians().sin_cos();
        let (sin_phi, cos_phi) = (2.0 * phi).to_radians().sin_cos();
        [r * sin_theta * cos_phi, r * sin_theta * sin_phi, r * cos_theta]
    })
}

proptest! {
    #[test]
    fn field_has_neither_divergence_nor_curl(position in position(), year in 2010.0..2030.0) {
        /// Central difference over ± 1 km.
        const STEP_KM: f64 = 1.0;
        /// Third derivatives are below 1e-3 nT/km³; gradients are about 20 nT/km.
        const TOLERANCE_NT_PER_KM: f64 = 1e-3;

        let coefficients = at::<f64>(year);
        let gradient: [[f64; 3]; 3] = core::array::from_fn(|axis| {
            let shifted = |step| {
                let mut position = position;
                position[axis] += step;
                coefficients.field_ecef_nt(position).unwrap()
            };
            let (after, before) = (shifted(STEP_KM), shifted(-STEP_KM));
            core::array::from_fn(|i| (after[i] - before[i]) / (2.0 * STEP_KM))
        });
        let [x, y, z] = gradient;
        for value in [x[0] + y[1] + z[2], y[2] - z[1], z[0] - x[2], x[1] - y[0]] {
            prop_assert!(value.abs() < TOLERANCE_NT_PER_KM, "{value} nT/km");
        }
    }

    #[test]
    fn f32_is_the_rounded_f64(position in position(), year in 2010.0..2030.0, degree in 1u8..=13) {
        /// Rounding of the arithmetic alone: both see the same position.
        const TOLERANCE_NT: f64 = 0.1;

        let position = position.map(|coordinate| coordinate as f32);
        let single = at::<f32>(year).with_degree(degree).unwrap();
        let double = at::<f64>(year).with_degree(degree).unwrap();
        let found = single.field_ecef_nt(position).unwrap();
        let expected = double.field_ecef_nt(position.map(f64::from)).unwrap();
        for (found, expected) in found.into_iter().zip(expected) {
            let difference = f64::from(found) - expected;
            prop_assert!(difference.abs() < TOLERANCE_NT, "{difference} nT");
        }
    }

    #[test]
    fn any_position_gives_a_finite_field_or_an_error(
        bits in any::<[u64; 3]>(),
        near in prop::array::uniform3(-600_000.0..600_000.0f64),
        degree in 1u8..=13,
    ) {
        for position in [bits.map(f64::from_bits), near] {
            finite_or_error::<f64>(position, degree)?;
        }
        let position = bits.map(|bits| f32::from_bits(bits as u32));
        finite_or_error::<f32>(position, degree)?;
        finite_or_error::<f32>(near.map(|coordinate| coordinate as f32), degree)?;
    }

    #[test]
    fn any_angles_give_a_finite_field_or_an_error(
        bits in any::<[u64; 3]>(),
        near in prop::array::uniform3(-4.0..4.0f64),
        height_km in -4_000.0..600_000.0,
    ) {
        let coefficients = at::<f64>(2020.0);
        let [a, b, c] = bits.map(f64::from_bits);
        let [latitude, longitude, _] = near;
        for (angle, longitude_rad, height_km) in [(a, b, c), (latitude, longitude, height_km)] {
            let geodetic = GeodeticPosition { latitude_rad: angle, longitude_rad, height_km };
            if let Ok(field) = coefficients.field_geodetic_nt(geodetic) {
                prop_assert!((field.north_nt + field.east_nt + field.down_nt).is_finite());
            }
            let geocentric = GeocentricPosition {
                radius_km: height_km,
                colatitude_rad: angle,
                longitude_rad,
            };
            if let Ok(field) = coefficients.field_geocentric_nt(geocentric) {
                prop_assert!((field.radial_nt + field.theta_nt + field.phi_nt).is_finite());
            }
        }
    }

    #[test]
    fn any_date_gives_coefficients_exactly_within_validity(bits: u64, near in 1890.0..2040.0) {
        let first = if cfg!(feature = "history") { 1900.0 } else { 2010.0 };
        for year in [f64::from_bits(bits), near] {
            let coefficients = Coefficients::<f64>::at(DecimalYear(year));
            prop_assert_eq!(coefficients.is_ok(), (first..=2030.0).contains(&year), "{}", year);
        }
    }
}

fn finite_or_error<T: Real>(position_km: [T; 3], degree: u8) -> Result<(), TestCaseError> {
    let coefficients = at::<T>(2020.0).with_degree(degree).unwrap();
    match coefficients.field_ecef_nt(position_km) {
        Ok(field) => prop_assert!(field.into_iter().all(T::is_finite), "{position_km:?}"),
        Err(Error::NotFinite) => prop_assert!(!position_km.into_iter().all(T::is_finite)),
        Err(Error::Radius { radius_km }) => {
            prop_assert!(!(MIN_RADIUS_KM * 1.001..MAX_RADIUS_KM * 0.999).contains(&radius_km));
        }
        Err(other) => prop_assert!(false, "{other}"),
    }
    Ok(())
}

#[test]
fn the_limits_of_the_radius_are_where_they_are_said_to_be() {
    let coefficients = at::<f64>(2020.0);
    for direction in [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0], [0.6, 0.0, -0.8]] {
        let field = |radius_km: f64| coefficients.field_ecef_nt(direction.map(|d| d * radius_km));
        assert!(field(MIN_RADIUS_KM * 1.000_001).is_ok());
        assert!(field(MAX_RADIUS_KM * 0.999_999).is_ok());
        for radius_km in [0.0, 1.0, MIN_RADIUS_KM * 0.999_999, MAX_RADIUS_KM * 1.000_001, 6.9e6] {
            let Err(Error::Radius { radius_km: found }) = field(radius_km) else {
                panic!("{radius_km} km is not refused")
            };
            assert!((found - radius_km).abs() <= 1e-12 * radius_km);
        }
    }
}

#[test]
fn coordinates_that_are_no_numbers_are_refused() {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for axis in 0..3 {
            let mut position_km = [4_000.0, 4_000.0, 4_000.0];
            position_km[axis] = bad;
            assert_eq!(at::<f64>(2020.0).field_ecef_nt(position_km), Err(Error::NotFinite));
            let single = position_km.map(|coordinate| coordinate as f32);
            assert_eq!(at::<f32>(2020.0).field_ecef_nt(single), Err(Error::NotFinite));
        }
    }
}

#[test]
fn angles_beyond_a_pole_are_refused_with_their_value() {
    let coefficients = at::<f64>(2020.0);
    let latitude_rad = 1.571;
    let position = GeodeticPosition { latitude_rad, longitude_rad: 0.0, height_km: 500.0 };
    assert_eq!(coefficients.field_geodetic_nt(position), Err(Error::Latitude { latitude_rad }));
    let colatitude_rad = -1e-9;
    let position = GeocentricPosition { radius_km: 7e3, colatitude_rad, longitude_rad: 0.0 };
    let refused = Err(Error::Colatitude { colatitude_rad });
    assert_eq!(coefficients.field_geocentric_nt(position), refused);
    let position = GeocentricPosition { radius_km: -7e3, colatitude_rad: 1.0, longitude_rad: 0.0 };
    let refused = Err(Error::Radius { radius_km: -7e3 });
    assert_eq!(coefficients.field_geocentric_nt(position), refused);
}

#[test]
fn field_beside_a_pole_tends_to_the_field_at_the_pole() {
    /// 1e-7 rad are 0.7 m, and 0.7 m are below 0.03 nT.
    const TOLERANCE_NT: f64 = 0.05;

    let coefficients = at::<f64>(2015.88);
    for pole in [-1.0, 1.0] {
        for longitude_rad in [0.0, 1.0, 2.5, -3.0] {
            let field = |beside: f64| {
                let latitude_rad = pole * (core::f64::consts::FRAC_PI_2 - beside);
                let position = GeodeticPosition { latitude_rad, longitude_rad, height_km: 480.0 };
                let field = coefficients.field_geodetic_nt(position).unwrap();
                [field.north_nt, field.east_nt, field.down_nt]
            };
            for (beside, at_pole) in field(1e-7).into_iter().zip(field(0.0)) {
                assert!((beside - at_pole).abs() < TOLERANCE_NT, "{beside} {at_pole}");
            }
        }
    }
}

#[test]
fn north_and_east_turn_with_the_meridian_at_a_pole() {
    /// nT; f64 rounding of a field of 60000 nT.
    const TOLERANCE_NT: f64 = 1e-9;

    let coefficients = at::<f64>(2015.88);
    let field = |longitude_deg: f64| {
        let position = GeodeticPosition {
            latitude_rad: core::f64::consts::FRAC_PI_2,
            longitude_rad: longitude_deg.to_radians(),
            height_km: 480.0,
        };
        coefficients.field_geodetic_nt(position).unwrap()
    };
    // A quarter turn eastwards makes the old east the new south.
    let (before, after) = (field(20.0), field(110.0));
    assert!((after.north_nt - -before.east_nt).abs() < TOLERANCE_NT);
    assert!((after.east_nt - before.north_nt).abs() < TOLERANCE_NT);
    assert!((after.down_nt - before.down_nt).abs() < TOLERANCE_NT);
}

#[test]
fn both_sides_of_the_date_line_have_one_field() {
    /// nT; π is rounded, which moves the point by less than 1e-9 m.
    const TOLERANCE_NT: f64 = 1e-9;

    let coefficients = at::<f64>(2022.2);
    for latitude_deg in [-80.0_f64, -10.0, 0.0, 45.0, 90.0] {
        let field = |longitude_deg: f64| {
            let position = GeodeticPosition {
                latitude_rad: latitude_deg.to_radians(),
                longitude_rad: longitude_deg.to_radians(),
                height_km: 600.0,
            };
            let field = coefficients.field_geodetic_nt(position).unwrap();
            [field.north_nt, field.east_nt, field.down_nt]
        };
        let west = field(-180.0);
        for longitude_deg in [180.0, 540.0] {
            for (west, east) in west.into_iter().zip(field(longitude_deg)) {
                assert!((west - east).abs() < TOLERANCE_NT, "{west} {east}");
            }
        }
    }
}

#[test]
fn field_is_continuous_in_time_at_the_nodes() {
    /// 1e-9 years of 200 nT a year.
    const TOLERANCE_NT: f64 = 1e-6;

    let first = if cfg!(feature = "history") { 1905 } else { 2015 };
    for node in (first..=2025).step_by(5).map(f64::from) {
        let field = |year| at::<f64>(year).field_ecef_nt([5_000.0, -3_000.0, 3_500.0]).unwrap();
        for (before, after) in field(node - 1e-9).into_iter().zip(field(node)) {
            assert!((before - after).abs() < TOLERANCE_NT, "{node}: {before} {after}");
        }
    }
}

#[test]
fn dates_outside_are_refused_with_the_limits() {
    let first = if cfg!(feature = "history") { 1900.0 } else { 2010.0 };
    for decimal_year in [first - 1e-9, 2030.0 + 1e-9, -5.0, f64::INFINITY] {
        assert_eq!(
            Coefficients::<f32>::at(DecimalYear(decimal_year)),
            Err(Error::Date { decimal_year, first, last: 2030.0 })
        );
    }
    let nan = Coefficients::<f64>::at(DecimalYear(f64::NAN));
    assert!(matches!(nan, Err(Error::Date { decimal_year, .. }) if decimal_year.is_nan()));
    assert!(Coefficients::<f64>::at(DecimalYear(first)).is_ok());
    assert!(Coefficients::<f64>::at(DecimalYear(2030.0)).is_ok());
}
