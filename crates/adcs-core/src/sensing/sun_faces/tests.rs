//! Suns, Earths and faults as six diodes see them.

extern crate std;
use super::*;
use crate::frames::Direction;
use crate::sensing::sun_face::{SunFaceError, SunFaceParameters};
use proptest::prelude::*;

const DARK: Reading<[f32; 4]> = Reading::Fresh([0.0; 4]);
/// f32 rounding of a direction through currents and back, rad.
const ROUNDING_RAD: f32 = 3e-6;
/// σ of the faces.
const SIGMA_RAD: f32 = SunFacesParameters::SPROUT.sigma_rad;
/// f32 rounding of a σ, and of the excess of light in it.
const RELATIVE_ROUNDING: f32 = 1e-4;

/// σ of a face under nothing but a Sun whose tan θ is given.
fn sigma_off_axis_rad(tan: f32) -> f32 {
    libm::hypotf(SIGMA_RAD, tan * UNNOTICED_RAD)
}

fn faces() -> SunFaces {
    SunFaces::new(&SunFacesParameters::SPROUT).unwrap()
}

fn direction(x: f32, y: f32, z: f32) -> Direction<Body> {
    Vector::new(x, y, z).direction().unwrap()
}

/// What `face` makes of a source of `light` (times the full Sun, facing it) in `direction`.
fn currents_of(face: usize, direction: Direction<Body>, light: f32) -> [f32; 4] {
    let SunFaceParameters { active_length_m, height_m, full_sun_a, half_cone_rad, .. } =
        SunFaceParameters::SPROUT;
    let to_face =
        crate::frames::Rotation::<Body, crate::frames::SunFaceAxes>::from_attitude_quaternion(
            CUBE_XYZW[face],
        )
        .unwrap()
        .inverse();
    let [x, y, z] = (to_face * direction.vector()).to_array();
    if z < libm::cosf(half_cone_rad) {
        return [0.0; 4];
    }
    let total = light * z * full_sun_a;
    let part = |along: f32| -height_m * along / z / active_length_m;
    let (x, y) = (part(x), part(y));
    [total * (0.5 - x), total * (0.5 + x), total * (0.5 - y), total * (0.5 + y)]
}

/// All six faces under several sources.
fn under(sources: &[(Direction<Body>, f32)]) -> [Reading<[f32; 4]>; FACES] {
    core::array::from_fn(|face| {
        let mut sum = [0.0; 4];
        for &(direction, light) in sources {
            for (sum, more) in sum.iter_mut().zip(currents_of(face, direction, light)) {
                *sum += more;
            }
        }
        Reading::Fresh(sum)
    })
}

fn sight(currents: [Reading<[f32; 4]>; FACES], expected: &Expected) -> SunSighting {
    faces().sight(&currents, expected)
}

fn distance(a: Direction<Body>, b: Direction<Body>) -> f32 {
    (a.vector() - b.vector()).norm()
}

fn predicting(direction: Direction<Body>, sigma_rad: f32) -> Expected {
    Expected { sun: Some(SunPrediction { direction, sigma_rad }), ..Expected::default() }
}

fn with_earth(nadir: Direction<Body>) -> Expected {
    // From 615 km.
    Expected { earth: Some(EarthDisc { nadir, radius_rad: 1.148 }), ..Expected::default() }
}

#[test]
fn the_faces_of_a_cube_look_along_its_six_normals() {
    let normals = [
        [1.0, 0.0, 0.0],
        [-1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, -1.0, 0.0],
        [0.0, 0.0, 1.0],
        [0.0, 0.0, -1.0],
    ];
    for (face, normal) in faces().faces.iter().zip(normals) {
        let [x, y, z] = normal;
        assert!(distance(face.boresight(), direction(x, y, z)) < ROUNDING_RAD, "{normal:?}");
    }
}

#[test]
fn a_sun_before_one_face_is_seen_by_that_face() {
    let sun = direction(1.0, 0.2, -0.3);
    let sighting = sight(under(&[(sun, 1.0)]), &Expected::default());
    let found = sighting.sun.value().unwrap();
    assert!(distance(found.direction, sun) < ROUNDING_RAD);
    let sigma_rad = sigma_off_axis_rad(libm::hypotf(0.2, 0.3));
    assert!((found.sigma_rad / sigma_rad - 1.0).abs() < RELATIVE_ROUNDING);
    assert_eq!(sighting.used(), 0b00_0001);
    assert_eq!(sighting.faces[1..], [FaceVerdict::Dark; 5]);
}

#[test]
fn two_faces_that_agree_halve_the_variance() {
    let sun = direction(0.0, -1.0, 1.0);
    let sighting = sight(under(&[(sun, 1.0)]), &Expected::default());
    assert_eq!(sighting.used(), 0b01_1000);
    let found = sighting.sun.value().unwrap();
    let sigma_rad = sigma_off_axis_rad(1.0) / core::f32::consts::SQRT_2;
    assert!((found.sigma_rad / sigma_rad - 1.0).abs() < RELATIVE_ROUNDING);
    assert!(distance(found.direction, sun) < ROUNDING_RAD);
}

#[test]
fn the_mean_leans_towards_the_face_without_foreign_light() {
    // Face +z sees the Earth as well: a fifth of the Sun's light from 50 deg beside it.
    let (sun, earth) = (direction(1.0, 0.0, 1.0), direction(-0.1, 0.0, 1.0));
    let mut currents = under(&[(sun, 1.0)]);
    let both = under(&[(sun, 1.0), (earth, 0.1)]);
    currents[4] = both[4];
    let alone = |face: usize| {
        let mut only = [DARK; FACES];
        only[face] = currents[face];
        sight(only, &Expected::default()).sun.value().unwrap()
    };
    let (clean, pulled) = (alone(0), alone(4));
    assert!(pulled.sigma_rad > 1.5 * clean.sigma_rad, "{pulled:?}");
    let error_rad = distance(pulled.direction, sun);
    assert!(error_rad > 2.0 * SIGMA_RAD && error_rad < 3.0 * pulled.sigma_rad, "{error_rad}");
    let sighting = sight(currents, &Expected::default());
    let mean = sighting.sun.value().unwrap();
    assert_eq!(sighting.used(), 0b01_0001);
    assert!(distance(mean.direction, sun) < 0.2 * error_rad);
    assert!(mean.worst_residual_rad > 0.8 * error_rad);
}

#[test]
fn where_the_earth_is_not_in_view_all_light_is_the_suns() {
    let sun = direction(0.3, 1.0, 0.4);
    let sighting = sight(under(&[(sun, 1.1)]), &with_earth(direction(0.0, -1.0, 0.0)));
    let found = sighting.sun.value().unwrap();
    assert!((found.sigma_rad / SIGMA_RAD - 1.0).abs() < RELATIVE_ROUNDING);
}

#[test]
fn all_faces_dark_is_dark() {
    let sighting = sight([DARK; FACES], &Expected::default());
    assert_eq!(sighting.sun.missing(), Some(MissingReason::Dark));
    assert_eq!((sighting.faces, sighting.used()), ([FaceVerdict::Dark; FACES], 0));
}

#[test]
fn the_earth_is_not_taken_for_the_sun() {
    // Bright clouds straight ahead: three fifths of the Sun.
    let down = direction(0.0, 0.0, 1.0);
    let sighting = sight(under(&[(down, 0.6)]), &Expected::default());
    assert_eq!(sighting.sun.missing(), Some(MissingReason::NotTheSun));
    assert_eq!(sighting.faces[4], FaceVerdict::Faint);
    let knowing = sight(under(&[(down, 0.6)]), &with_earth(down));
    assert_eq!(knowing.faces[4], FaceVerdict::Earth);
    let wrong_side = sight(under(&[(down, 0.6)]), &with_earth(direction(0.0, 0.0, -1.0)));
    assert_eq!(wrong_side.faces[4], FaceVerdict::Faint);
}

#[test]
fn the_sun_counts_beside_a_face_that_sees_the_earth() {
    let (sun, down) = (direction(-1.0, 0.1, 0.1), direction(0.0, 0.0, 1.0));
    let sighting = sight(under(&[(sun, 1.0), (down, 0.3)]), &with_earth(down));
    assert_eq!(sighting.used(), 0b00_0010);
    assert_eq!(sighting.faces[4], FaceVerdict::Earth);
}

#[test]
fn too_much_light_is_a_fault() {
    let sighting = sight(under(&[(direction(0.0, 1.0, 0.0), 1.6)]), &Expected::default());
    assert_eq!(sighting.sun.missing(), Some(MissingReason::NotTheSun));
    assert_eq!(sighting.faces[2], FaceVerdict::Bright);
}

#[test]
fn in_january_the_sun_is_brighter_and_known_to_be() {
    let sun = direction(0.0, 1.0, 0.0);
    let expected = Expected { irradiance: 1.034, ..Expected::default() };
    let knowing = sight(under(&[(sun, 1.034)]), &expected).sun.value().unwrap();
    let unknowing = sight(under(&[(sun, 1.034)]), &Expected::default()).sun.value().unwrap();
    assert!((knowing.sigma_rad / SIGMA_RAD - 1.0).abs() < RELATIVE_ROUNDING);
    assert!(unknowing.sigma_rad > 1.2 * SIGMA_RAD);
}

/// A face that shows the Sun straight ahead whatever is there.
fn stuck(mut currents: [Reading<[f32; 4]>; FACES], face: usize) -> [Reading<[f32; 4]>; FACES] {
    currents[face] = Reading::Fresh([40e-6; 4]);
    currents
}

#[test]
fn two_faces_that_disagree_give_no_sun() {
    let sun = direction(1.0, 0.1, 0.0);
    let sighting = sight(stuck(under(&[(sun, 1.0)]), 3), &Expected::default());
    assert_eq!(sighting.sun.missing(), Some(MissingReason::Disagree));
    assert_eq!(sighting.faces[0], FaceVerdict::Disagrees);
    assert_eq!(sighting.faces[3], FaceVerdict::Disagrees);
}

#[test]
fn a_prediction_decides_between_two_that_disagree() {
    let sun = direction(1.0, 0.1, 0.0);
    let expected = predicting(direction(1.0, 0.0, 0.05), 0.05);
    let sighting = sight(stuck(under(&[(sun, 1.0)]), 3), &expected);
    assert!(distance(sighting.sun.value().unwrap().direction, sun) < ROUNDING_RAD);
    assert_eq!(sighting.faces[3], FaceVerdict::Unpredicted);
    // One so vague that both may be right still says which is nearer.
    let vague = sight(stuck(under(&[(sun, 1.0)]), 3), &predicting(sun, 1.0));
    assert_eq!((vague.used(), vague.faces[3]), (0b1, FaceVerdict::Disagrees));
}

#[test]
fn two_of_three_outvote_the_third() {
    let sun = direction(1.0, 0.0, 1.0);
    let sighting = sight(stuck(under(&[(sun, 1.0)]), 3), &Expected::default());
    assert_eq!(sighting.used(), 0b01_0001);
    assert_eq!(sighting.faces[3], FaceVerdict::Disagrees);
}

#[test]
fn of_two_that_disagree_the_one_that_looks_away_from_the_earth_is_believed() {
    let (sun, down) = (direction(1.0, 0.1, 0.0), direction(0.0, -1.0, 0.0));
    // Face −y looks down and shows as much light as the Sun would give there.
    let currents = stuck(under(&[(sun, 1.0)]), 3);
    assert_eq!(sight(currents, &with_earth(down)).sun.missing(), Some(MissingReason::Disagree));
    // From further out the Earth is small, and face +x does not see it.
    let far = EarthDisc { nadir: down, radius_rad: 0.5 };
    let expected = Expected { earth: Some(far), ..Expected::default() };
    let sighting = sight(currents, &expected);
    assert_eq!((sighting.used(), sighting.faces[3]), (0b1, FaceVerdict::Disagrees));
}

#[test]
fn a_sun_where_none_was_predicted_says_so() {
    let sun = direction(0.0, 0.0, 1.0);
    let sighting = sight(under(&[(sun, 1.0)]), &predicting(direction(0.0, 1.0, 1.0), 0.1));
    assert_eq!(sighting.sun.missing(), Some(MissingReason::Unpredicted));
    assert_eq!(sighting.faces[4], FaceVerdict::Unpredicted);
}

#[test]
fn a_silent_face_is_a_reason_only_when_no_other_sees_the_sun() {
    let sun = direction(0.0, 0.0, 1.0);
    let mut currents = under(&[(sun, 1.0)]);
    currents[0] = Reading::Missing(MissingReason::Bus);
    assert_eq!(sight(currents, &Expected::default()).used(), 0b01_0000);
    currents[4] = DARK;
    let sighting = sight(currents, &Expected::default());
    assert_eq!(sighting.sun.missing(), Some(MissingReason::Bus));
}

#[test]
fn refused_parameters_name_the_face_and_the_value() {
    let refused = |change: &dyn Fn(&mut SunFacesParameters)| {
        let mut parameters = SunFacesParameters::SPROUT;
        change(&mut parameters);
        SunFaces::new(&parameters).unwrap_err()
    };
    let error = refused(&|p| p.faces[3].height_m = 0.0);
    let height = SunFaceError::Height { found_m: 0.0 };
    assert_eq!(error, SunFacesError::Face { face: 3, error: height });
    assert_eq!(std::format!("{error}"), "face 3: a pinhole 0 m high is not positive");
    for bad in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        assert!(matches!(refused(&|p| p.sigma_rad = bad), SunFacesError::Sigma { .. }));
        assert!(matches!(refused(&|p| p.brightest = bad), SunFacesError::Brightest { .. }));
        assert!(matches!(refused(&|p| p.gate = bad), SunFacesError::Gate { .. }));
    }
    for bad in [-0.1, 1.1, f32::NAN] {
        assert!(matches!(refused(&|p| p.faintest = bad), SunFacesError::Faintest { .. }));
    }
}

fn any_currents() -> impl Strategy<Value = Reading<[f32; 4]>> {
    prop_oneof![
        prop::array::uniform4(any::<f32>()).prop_map(Reading::Fresh),
        prop::array::uniform4(0.0_f32..1e-4).prop_map(Reading::Fresh),
        Just(Reading::Missing(MissingReason::OutOfRange)),
    ]
}

proptest! {
    #[test]
    fn the_sun_anywhere_in_sight_is_found_by_every_face_that_sees_it(
        x in -1.0_f32..1.0, y in -1.0_f32..1.0, z in -1.0_f32..1.0,
    ) {
        prop_assume!(Vector::<Body>::new(x, y, z).norm() > 0.1);
        let sun = direction(x, y, z);
        let off_axis = |face: &SunFace| face.boresight().vector().dot(&sun.vector());
        // Away from the edge of any cone, where rounding decides.
        let edge = libm::cosf(SunFaceParameters::SPROUT.half_cone_rad);
        prop_assume!(faces().faces.iter().all(|face| (off_axis(face) - edge).abs() > 1e-5));
        let sighting = sight(under(&[(sun, 1.0)]), &Expected::default());
        for (bit, face) in faces().faces.iter().enumerate() {
            prop_assert_eq!(sighting.used() >> bit & 1 == 1, off_axis(face) > edge);
        }
        match sighting.sun {
            Reading::Fresh(found) => prop_assert!(distance(found.direction, sun) < ROUNDING_RAD),
            Reading::Missing(reason) => prop_assert_eq!(reason, MissingReason::Dark),
        }
    }

    #[test]
    fn whatever_the_currents_the_answer_is_finite_or_has_a_reason(
        currents in prop::collection::vec(any_currents(), FACES),
        sigma in any::<f32>(), irradiance in any::<f32>(), predicted in any::<bool>(),
    ) {
        let mut expected = with_earth(direction(0.3, -0.2, 0.9));
        expected.irradiance = irradiance;
        let prediction = SunPrediction { direction: direction(0.0, 0.6, 0.8), sigma_rad: sigma };
        expected.sun = predicted.then_some(prediction);
        let currents = core::array::from_fn(|face| currents[face]);
        let sighting = sight(currents, &expected);
        prop_assert_eq!(sighting.sun.value().is_some(), sighting.used() != 0);
        if let Reading::Fresh(found) = sighting.sun {
            prop_assert!(found.direction.vector().is_finite());
            prop_assert!(found.sigma_rad > 0.0 && found.worst_residual_rad.is_finite());
        }
    }
}
