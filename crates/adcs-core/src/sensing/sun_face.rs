//! One Sun sensor: four currents of a position-sensitive diode behind a pinhole, to a direction.
//!
//! ```text
//!        Sun  \                     z, out of the face
//!              \                    │
//!   ────────────●──────── pinhole ──┤ at height h above the diode
//!                \                  │
//!   X1 ───────────◆──── diode ──────┼──────────── X2, + x        active length L
//!                 spot at x < 0     │
//! ```
//!
//! | symbol | code | meaning |
//! |---|---|---|
//! | X1, X2 | `currents[0]`, `[1]` | photocurrents at the electrodes on the side of −x and of +x, A |
//! | Y1, Y2 | `currents[2]`, `[3]` | the same along y; positive as the driver gives them |
//! | L | `active_length_m` | distance of the two electrodes of an axis |
//! | h | `height_m` | of the pinhole above the diode |
//! | I | `light` · `full_sun_a` | total photocurrent |
//!
//! A duo-lateral diode divides its whole photocurrent in one resistive layer between X1 and X2 and
//! in the other between Y1 and Y2, in proportion to how near the centre of gravity of the light is:
//!
//! x = (L/2) (X2 − X1)/(X2 + X1), y = (L/2) (Y2 − Y1)/(Y2 + Y1), I = X1 + X2 = Y1 + Y2
//!
//! The last equation is a check that costs nothing: what breaks one electrode breaks it. Light that
//! falls through the pinhole to (x, y) comes from the opposite side,
//!
//! u ∝ (−x, −y, h) in the face's axes.
//!
//! Source of the position formula: Hamamatsu Photonics, Opto-semiconductor Handbook, chapter on
//! PSDs (two-dimensional, improved and duo-lateral types); the lateral photo-effect is Wallmark
//! (1957). The geometry of pinhole and diode: Wertz (1978), §6.1.

use core::f32::consts::FRAC_PI_2;
use core::fmt;

use serde::{Deserialize, Serialize};

use crate::frames::{Body, Direction, Rotation, SunFaceAxes, Vector};
use crate::reading::Reading;
use crate::sensing::sun_faces::FaceVerdict;

/// By how much X1 + X2 and Y1 + Y2 may differ, as a fraction of the larger: amplifiers of 1 %
/// resistors and two of their noises at the faintest light that counts stay below.
const SUM_TOLERANCE: f32 = 0.1;
/// Rounding of a diode that is exactly as long as its half-cone needs.
const LENGTH_ROUNDING: f32 = 1e-5;

/// One Sun sensor as it is stored, uplinked and written in mission files.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SunFaceParameters {
    /// Attitude quaternion `[q_x, q_y, q_z, q_w]` from the face's axes to Body.
    pub alignment_xyzw: [f32; 4],
    /// L, m.
    pub active_length_m: f32,
    /// h, m.
    pub height_m: f32,
    /// Photocurrent of the unhidden Sun at one astronomical unit, straight ahead, A.
    pub full_sun_a: f32,
    /// Fraction of `full_sun_a` below which the face counts as dark.
    pub threshold: f32,
    /// Light from further off the axis than this is not taken for the Sun, rad.
    pub half_cone_rad: f32,
}

impl SunFaceParameters {
    /// SPROUT's, with z of the face along Body z. Published: ±55 deg, and that it is a
    /// two-dimensional position-sensitive diode in 40 × 40 × 13 mm. Assumed: a diode of 10 mm, as
    /// several makers have it, and the height at which ±55 deg just fill it; 80 µA, which is what a
    /// pinhole of 0.5 mm lets through of 1361 W/m² at 0.3 A/W; dark below 5 % of it.
    pub const SPROUT: Self = Self {
        alignment_xyzw: [0.0, 0.0, 0.0, 1.0],
        active_length_m: 10e-3,
        height_m: 3.4e-3,
        full_sun_a: 80e-6,
        threshold: 0.05,
        half_cone_rad: 0.959_931_1,
    };
}

/// Why the parameters of a Sun sensor are refused.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum SunFaceError {
    /// The diode's length is not positive and finite.
    ActiveLength {
        /// What was given, m.
        found_m: f32,
    },
    /// The pinhole's height is not positive and finite.
    Height {
        /// What was given, m.
        found_m: f32,
    },
    /// The full-Sun current is not positive and normal.
    FullSun {
        /// What was given, A.
        found_a: f32,
    },
    /// The threshold is not between 0 and 1, both excluded.
    Threshold {
        /// What was given.
        found: f32,
    },
    /// The half-cone is not between 0 and 90 deg, or its edge falls beside the diode.
    HalfCone {
        /// What was given, rad.
        found_rad: f32,
    },
    /// The alignment quaternion has no direction.
    Alignment,
}

impl fmt::Display for SunFaceError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::ActiveLength { found_m } => {
                write!(f, "an active length of {found_m} m is not positive")
            }
            Self::Height { found_m } => write!(f, "a pinhole {found_m} m high is not positive"),
            Self::FullSun { found_a } => {
                write!(f, "a full-Sun current of {found_a} A is not positive")
            }
            Self::Threshold { found } => write!(f, "a threshold of {found} is not between 0 and 1"),
            Self::HalfCone { found_rad } => write!(
                f,
                "a half-cone of {found_rad} rad is not between 0 and pi/2, or wider than the diode \
                 sees"
            ),
            Self::Alignment => write!(f, "the alignment quaternion must not be zero"),
        }
    }
}

impl core::error::Error for SunFaceError {}

/// The light that one face sees, taken as one spot.
#[derive(Debug, Clone, Copy)]
pub struct Spot {
    /// Where the light comes from.
    pub direction: Direction<Body>,
    /// Cosine of the angle off the face's axis.
    pub cos_off_axis: f32,
    /// Total photocurrent as a fraction of that of the full Sun straight ahead.
    pub light: f32,
}

/// One Sun sensor with its parameters checked.
#[derive(Debug, Clone, Copy)]
pub struct SunFace {
    alignment: Rotation<Body, SunFaceAxes>,
    half_length_m: f32,
    height_m: f32,
    full_sun_a: f32,
    threshold: f32,
    half_cone_rad: f32,
    cos_half_cone: f32,
}

impl SunFace {
    /// Accepts parameters.
    ///
    /// # Errors
    /// [`SunFaceError`] with the value; the previous parameters should stay in force.
    pub fn new(parameters: &SunFaceParameters) -> Result<Self, SunFaceError> {
        let p = parameters;
        if !(p.active_length_m.is_normal() && p.active_length_m > 0.0) {
            return Err(SunFaceError::ActiveLength { found_m: p.active_length_m });
        }
        if !(p.height_m.is_normal() && p.height_m > 0.0) {
            return Err(SunFaceError::Height { found_m: p.height_m });
        }
        if !(p.full_sun_a.is_normal() && p.full_sun_a > 0.0) {
            return Err(SunFaceError::FullSun { found_a: p.full_sun_a });
        }
        if !(p.threshold > 0.0 && p.threshold < 1.0) {
            return Err(SunFaceError::Threshold { found: p.threshold });
        }
        let half_length_m = p.active_length_m / 2.0;
        // The circle of the cone's edge must lie on the square diode.
        let fits = p.half_cone_rad > 0.0
            && p.half_cone_rad < FRAC_PI_2
            && p.height_m * libm::tanf(p.half_cone_rad) <= half_length_m * (1.0 + LENGTH_ROUNDING);
        if !fits {
            return Err(SunFaceError::HalfCone { found_rad: p.half_cone_rad });
        }
        Ok(Self {
            alignment: Rotation::from_attitude_quaternion(p.alignment_xyzw)
                .ok_or(SunFaceError::Alignment)?,
            half_length_m,
            height_m: p.height_m,
            full_sun_a: p.full_sun_a,
            threshold: p.threshold,
            half_cone_rad: p.half_cone_rad,
            cos_half_cone: libm::cosf(p.half_cone_rad),
        })
    }

    /// The spot of light that `[X1, X2, Y1, Y2]` (A) tell of.
    ///
    /// # Errors
    /// The verdict on a face that shows none: missing, dark, broken, or lit from outside its cone.
    pub fn spot(&self, currents: Reading<[f32; 4]>) -> Result<Spot, FaceVerdict> {
        let [x_1, x_2, y_1, y_2] = match currents {
            Reading::Fresh(currents) => currents,
            Reading::Missing(reason) => return Err(FaceVerdict::Missing(reason)),
        };
        let (sum_x, sum_y) = (x_1 + x_2, y_1 + y_2);
        let light = (sum_x + sum_y) / 2.0 / self.full_sun_a;
        // Written so that NaN fails.
        let balanced = (sum_x - sum_y).abs() <= self.sum_tolerance_a(sum_x, sum_y);
        if !(balanced && light.is_finite()) {
            return Err(FaceVerdict::Broken);
        }
        if light < self.threshold {
            return Err(FaceVerdict::Dark);
        }
        // Above the threshold and nearly equal, neither sum is near zero.
        let x_m = self.half_length_m * (x_2 - x_1) / sum_x;
        let y_m = self.half_length_m * (y_2 - y_1) / sum_y;
        let u: Vector<SunFaceAxes> = Vector::new(-x_m, -y_m, self.height_m);
        let u = u.direction().ok_or(FaceVerdict::Broken)?;
        let cos_off_axis = u.vector().xyz.z;
        if cos_off_axis < self.cos_half_cone {
            return Err(FaceVerdict::OutsideCone);
        }
        Ok(Spot { direction: self.alignment * u, cos_off_axis, light })
    }

    /// Near the threshold the noise counts, above it the matching of the amplifiers.
    fn sum_tolerance_a(&self, sum_x: f32, sum_y: f32) -> f32 {
        SUM_TOLERANCE * sum_x.abs().max(sum_y.abs()).max(self.threshold * self.full_sun_a)
    }

    /// The direction out of the face.
    pub fn boresight(&self) -> Direction<Body> {
        self.alignment * Direction::from_unit(Vector::new(0.0, 0.0, 1.0))
    }

    /// Half the angle of the cone in which the face sees, rad.
    pub fn half_cone_rad(&self) -> f32 {
        self.half_cone_rad
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use crate::reading::MissingReason;
    use proptest::prelude::*;
    use std::string::ToString;

    /// f32 rounding of a direction through currents and back.
    const ROUNDING: f32 = 3e-6;

    fn face() -> SunFace {
        SunFace::new(&SunFaceParameters::SPROUT).unwrap()
    }

    /// What a diode makes of light from `u` (face axes): Kirchhoff on the resistive layers, from the
    /// other side.
    fn currents(u: [f32; 3], total_a: f32) -> [f32; 4] {
        let SunFaceParameters { active_length_m, height_m, .. } = SunFaceParameters::SPROUT;
        let share = |along: f32| {
            let position_m = -height_m * along / u[2];
            // The current to an electrode is in proportion to the distance from the other one.
            let to_second = (position_m + active_length_m / 2.0) / active_length_m;
            [total_a * (1.0 - to_second), total_a * to_second]
        };
        let ([x_1, x_2], [y_1, y_2]) = (share(u[0]), share(u[1]));
        [x_1, x_2, y_1, y_2]
    }

    fn refused(change: impl Fn(&mut SunFaceParameters)) -> SunFaceError {
        let mut parameters = SunFaceParameters::SPROUT;
        change(&mut parameters);
        SunFace::new(&parameters).unwrap_err()
    }

    #[test]
    fn equal_currents_are_light_from_straight_ahead() {
        let spot = face().spot(Reading::Fresh([40e-6; 4])).unwrap();
        assert_eq!(spot.direction.vector(), Vector::new(0.0, 0.0, 1.0));
        assert!((spot.light - 1.0).abs() < ROUNDING && spot.cos_off_axis == 1.0);
    }

    #[test]
    fn more_current_at_plus_x_is_light_from_minus_x() {
        // x = 5 mm · (50 − 30)/80 = 1.25 mm, so the light comes from atan(1.25/3.4) = 20.2 deg.
        let spot = face().spot(Reading::Fresh([30e-6, 50e-6, 40e-6, 40e-6])).unwrap();
        let [x, y, z] = spot.direction.vector().to_array();
        assert!((libm::atan2f(x, z).to_degrees() + 20.186).abs() < 1e-3 && y == 0.0, "{x} {z}");
    }

    #[test]
    fn a_face_without_a_spot_says_why() {
        let verdict = |currents| face().spot(Reading::Fresh(currents)).unwrap_err();
        assert_eq!(verdict([1e-6; 4]), FaceVerdict::Dark);
        assert_eq!(verdict([0.0; 4]), FaceVerdict::Dark);
        assert_eq!(verdict([-1e-6, 1e-7, -1e-6, 1e-7]), FaceVerdict::Dark);
        // A broken wire at X2, and one amplifier at twice its gain.
        assert_eq!(verdict([40e-6, 0.0, 40e-6, 40e-6]), FaceVerdict::Broken);
        assert_eq!(verdict([40e-6, 40e-6, 80e-6, 40e-6]), FaceVerdict::Broken);
        assert_eq!(verdict([f32::NAN, 40e-6, 40e-6, 40e-6]), FaceVerdict::Broken);
        assert_eq!(verdict([f32::INFINITY; 4]), FaceVerdict::Broken);
        // The corner of the diode is 64 deg off.
        assert_eq!(verdict([80e-6, 0.0, 80e-6, 0.0]), FaceVerdict::OutsideCone);
        let missing = face().spot(Reading::Missing(MissingReason::Bus)).unwrap_err();
        assert_eq!(missing, FaceVerdict::Missing(MissingReason::Bus));
    }

    #[test]
    fn impossible_parameters_are_refused_with_the_value() {
        for found in [0.0, -1e-3, f32::NAN, f32::INFINITY] {
            let error = refused(|p| p.active_length_m = found);
            assert!(matches!(error, SunFaceError::ActiveLength { .. }), "{error}");
            let error = refused(|p| p.height_m = found);
            assert!(matches!(error, SunFaceError::Height { .. }), "{error}");
            let error = refused(|p| p.full_sun_a = found);
            assert!(matches!(error, SunFaceError::FullSun { .. }), "{error}");
            let error = refused(|p| p.threshold = found);
            assert!(matches!(error, SunFaceError::Threshold { .. }), "{error}");
        }
        // 1.05 rad (60 deg) fall beside a diode that sees 55.8 deg along its axes.
        for found_rad in [0.0, -0.5, f32::NAN, 1.05, 1.6] {
            let error = refused(|p| p.half_cone_rad = found_rad);
            assert!(matches!(error, SunFaceError::HalfCone { .. }), "{error}");
        }
        assert_eq!(refused(|p| p.alignment_xyzw = [0.0; 4]), SunFaceError::Alignment);
        assert_eq!(
            refused(|p| p.height_m = -1.0).to_string(),
            "a pinhole -1 m high is not positive"
        );
    }

    proptest! {
        #[test]
        fn light_from_anywhere_in_the_cone_comes_back(
            off_axis_deg in 0.0_f32..54.99, azimuth_deg in 0.0_f32..360.0, light in 0.06_f32..1.5,
        ) {
            let (off_axis, azimuth) = (off_axis_deg.to_radians(), azimuth_deg.to_radians());
            let sin = libm::sinf(off_axis);
            let u = [sin * libm::cosf(azimuth), sin * libm::sinf(azimuth), libm::cosf(off_axis)];
            let spot = face().spot(Reading::Fresh(currents(u, light * 80e-6))).unwrap();
            let found = spot.direction.vector().to_array();
            for (found, expected) in found.into_iter().zip(u) {
                prop_assert!((found - expected).abs() < ROUNDING, "{found} {expected}");
            }
            prop_assert!((spot.light - light).abs() < ROUNDING);
        }

        #[test]
        fn no_currents_make_a_spot_that_is_not_finite(currents in prop::array::uniform4(any::<f32>())) {
            if let Ok(spot) = face().spot(Reading::Fresh(currents)) {
                prop_assert!(spot.direction.vector().is_finite() && spot.light.is_finite());
                prop_assert!(spot.cos_off_axis > 0.57);
            }
        }
    }
}
