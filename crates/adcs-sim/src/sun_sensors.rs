//! What the six Sun sensors truly show: the Sun, and beside it the Earth, through six pinholes.
//!
//! A pinhole of height h throws light from u (face axes) to the spot (−h u_x/u_z, −h u_y/u_z) of the
//! diode. A source of irradiance E (relative to the Sun's at one astronomical unit) that stands θ
//! off the axis gives the current I_full E cos θ; beyond the half-cone the rim of the sensor keeps
//! it off. The diode shows the centre of gravity of all light: each electrode gets
//! Σ Iⱼ (½ ∓ xⱼ/L).
//!
//! Errors, each with a stream of its own: the direction in which a face sees the Sun is off by a
//! normal deviate about both axes across it, drawn once an instant (it stands for all that turns the
//! spot: edge of the pinhole, nonlinear diode, reflections); every conversion has its noise.

use adcs_core::environment::sun::ASTRONOMICAL_UNIT_M;
use adcs_core::frames::{Body, Eci, Rotation, SunFaceAxes, Vector};
use adcs_hal::psd_face::FACES;
use nalgebra::Vector3;

use crate::earth_light::{self, PATCHES, Patch};
use crate::noise::Gaussian;
use crate::scenario::{SunFaceFault, SunFaceTruth, SunSensorsTruth};
use crate::surroundings::Sunlight;

/// Photocurrents X1, X2, Y1, Y2 of all faces, A.
pub type Currents = [[f64; 4]; FACES];

/// The six faces, at one instant.
#[derive(Debug, Clone)]
pub struct SunSensors {
    faces: [Face; FACES],
    noise_rad: f64,
    current_noise_a: f64,
    albedo: f64,
    direction_noise: Gaussian,
    current_noise: Gaussian,
    exact: Currents,
    shown: Currents,
}

/// One face as it really is.
#[derive(Debug, Clone, Copy)]
struct Face {
    to_face: Rotation<SunFaceAxes, Body, f64>,
    active_length_m: f64,
    height_m: f64,
    full_sun_a: f64,
    cos_half_cone: f64,
    fault: Option<SunFaceFault>,
}

impl Face {
    fn new(truth: &SunFaceTruth) -> Option<Self> {
        let to_body =
            Rotation::<Body, SunFaceAxes, f64>::from_attitude_quaternion(truth.alignment_xyzw)?;
        Some(Self {
            to_face: to_body.inverse(),
            active_length_m: truth.active_length_m,
            height_m: truth.height_m,
            full_sun_a: truth.full_sun_a,
            cos_half_cone: libm::cos(truth.half_cone_rad),
            fault: truth.fault,
        })
    }

    /// What light from `u` (face axes, unit) adds whose total is `current_a`.
    fn add(&self, currents: &mut [f64; 4], u: &Vector3<f64>, current_a: f64) {
        let [x_1, x_2, y_1, y_2] = currents;
        for (along, first, second) in [(u.x, x_1, x_2), (u.y, y_1, y_2)] {
            // The diode ends at ±L/2.
            let place = (-self.height_m * along / u.z / self.active_length_m).clamp(-0.5, 0.5);
            *first += current_a * (0.5 - place);
            *second += current_a * (0.5 + place);
        }
    }

    /// The currents of a source in direction `u` that is seen as in direction `seen`.
    fn add_source(
        &self,
        currents: &mut [f64; 4],
        u: &Vector3<f64>,
        seen: &Vector3<f64>,
        irradiance: f64,
    ) {
        if irradiance > 0.0 && u.z >= self.cos_half_cone {
            self.add(currents, seen, self.full_sun_a * irradiance * u.z);
        }
    }

    fn faulty(&self, currents: [f64; 4]) -> [f64; 4] {
        match self.fault {
            None => currents,
            Some(SunFaceFault::Dark) => [0.0; 4],
            Some(SunFaceFault::Stuck) => [self.full_sun_a / 2.0; 4],
        }
    }
}

impl SunSensors {
    /// The sensors described by `truth`; `None` when an alignment has no direction.
    pub fn new(
        truth: &SunSensorsTruth,
        direction_noise: Gaussian,
        current_noise: Gaussian,
    ) -> Option<Self> {
        let [a, b, c, d, e, f] = truth.faces.each_ref().map(Face::new);
        Some(Self {
            faces: [a?, b?, c?, d?, e?, f?],
            noise_rad: truth.noise_rad,
            current_noise_a: truth.current_noise_a,
            albedo: truth.albedo,
            direction_noise,
            current_noise,
            exact: Currents::default(),
            shown: Currents::default(),
        })
    }

    /// A new instant: the Sun and the Earth from `position` (Eci, m), in this attitude.
    pub fn expose(
        &mut self,
        r_bi: Rotation<Body, Eci, f64>,
        sunlight: &Sunlight,
        position: Vector<Eci, f64>,
    ) {
        let Some(to_sun) = sunlight.to_sun.direction() else { return };
        let distance_au = sunlight.to_sun.norm() / ASTRONOMICAL_UNIT_M;
        let strength = 1.0 / (distance_au * distance_au);
        let earth = (self.albedo > 0.0)
            .then(|| earth_light::patches(position, to_sun, self.albedo * strength));
        for ((face, exact), shown) in self.faces.iter().zip(&mut self.exact).zip(&mut self.shown) {
            let to_face = face.to_face * r_bi;
            let sun = (to_face * to_sun.vector()).xyz;
            // Two draws a face, lit or not, so that the noise of the others stays the same.
            let deviates = [self.direction_noise.sample(), self.direction_noise.sample()];
            let seen = turned(&sun, deviates.map(|deviate| deviate * self.noise_rad));
            let irradiance = strength * sunlight.lit;
            *exact = [0.0; 4];
            face.add_source(exact, &sun, &sun, irradiance);
            let mut currents = [0.0; 4];
            face.add_source(&mut currents, &sun, &seen, irradiance);
            add_earth(face, &mut currents, &to_face, earth.as_ref());
            *shown = face.faulty(currents);
        }
    }

    /// The photocurrents of the Sun alone, without noise or fault, A.
    pub fn exact(&self) -> Currents {
        self.exact
    }

    /// What electrode `electrode` (0 to 3: X1, X2, Y1, Y2) of a face shows, A: one conversion, one
    /// draw of noise.
    pub fn shown(&mut self, face: usize, electrode: usize) -> f64 {
        let noise_a = self.current_noise_a * self.current_noise.sample();
        let current = self.shown.get(face).and_then(|currents| currents.get(electrode));
        current.map_or(0.0, |current| current + noise_a)
    }
}

fn add_earth(
    face: &Face,
    currents: &mut [f64; 4],
    to_face: &Rotation<SunFaceAxes, Eci, f64>,
    earth: Option<&[Patch; PATCHES]>,
) {
    let matrix = to_face.matrix();
    for patch in earth.into_iter().flatten() {
        let u = matrix * patch.towards.xyz;
        face.add_source(currents, &u, &u, patch.irradiance);
    }
}

/// `u` turned by small angles about two axes across it.
fn turned(u: &Vector3<f64>, angles_rad: [f64; 2]) -> Vector3<f64> {
    let [first, second] = angles_rad;
    // Across u, and defined for every u with u_z > 0; elsewhere nothing is seen.
    let across = Vector3::new(u.z, 0.0, -u.x);
    let norm = across.norm();
    if norm == 0.0 {
        return *u;
    }
    let across = across / norm;
    (u + across * first + u.cross(&across) * second).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;
    use adcs_core::sensing::SunFacesParameters;

    const FULL_SUN_A: f64 = 80e-6;
    /// f32 parameters in f64, relative.
    const ROUNDING: f64 = 1e-6;

    fn sensors(truth: &SunSensorsTruth) -> SunSensors {
        SunSensors::new(truth, Gaussian::new(1, 1), Gaussian::new(1, 2)).unwrap()
    }

    /// Face +z with the Sun `off_axis_deg` towards +x, far from a black Earth.
    fn face_z(sensors: &mut SunSensors, off_axis_deg: f64, au: f64, lit: f64) -> [f64; 4] {
        let (sin, cos) = libm::sincos(off_axis_deg.to_radians());
        let to_sun = Vector::new(sin, 0.0, cos) * (ASTRONOMICAL_UNIT_M * au);
        sensors.expose(Rotation::identity(), &Sunlight { to_sun, lit }, Vector::new(7e6, 0.0, 0.0));
        [0, 1, 2, 3].map(|electrode| sensors.shown(4, electrode))
    }

    fn perfect() -> SunSensorsTruth {
        SunSensorsTruth::perfect(&SunFacesParameters::SPROUT)
    }

    #[test]
    fn the_current_falls_with_the_cosine_and_ends_at_the_rim() {
        let mut sensors = sensors(&perfect());
        for (off_axis_deg, expected) in [(0.0, 1.0), (30.0, 0.866_025), (54.99, 0.573_720)] {
            let [x_1, x_2, y_1, y_2] = face_z(&mut sensors, off_axis_deg, 1.0, 1.0);
            assert!(((x_1 + x_2) / FULL_SUN_A - expected).abs() < 10.0 * ROUNDING);
            assert!(((y_1 + y_2) / FULL_SUN_A - expected).abs() < 10.0 * ROUNDING && y_1 == y_2);
        }
        for off_axis_deg in [55.01, 90.0, 180.0] {
            assert_eq!(face_z(&mut sensors, off_axis_deg, 1.0, 1.0), [0.0; 4]);
        }
    }

    #[test]
    fn a_sun_towards_x_lights_the_electrode_on_the_other_side() {
        let [x_1, x_2, ..] = face_z(&mut sensors(&perfect()), 45.0, 1.0, 1.0);
        // The spot is 3.4 of 5 mm off the middle.
        assert!(((x_1 - x_2) / (x_1 + x_2) - 0.68).abs() < 10.0 * ROUNDING);
    }

    #[test]
    fn distance_and_shadow_take_their_part() {
        let mut sensors = sensors(&perfect());
        let total = |[x_1, x_2, ..]: [f64; 4]| (x_1 + x_2) / FULL_SUN_A;
        let far = total(face_z(&mut sensors, 0.0, 2.0, 1.0));
        assert!((far - 0.25).abs() < ROUNDING);
        assert!((total(face_z(&mut sensors, 0.0, 1.0, 0.3)) - 0.3).abs() < ROUNDING);
        assert_eq!(face_z(&mut sensors, 0.0, 1.0, 0.0), [0.0; 4]);
    }

    #[test]
    fn faults_show_nothing_or_always_the_same_and_exact_readings_have_none() {
        let mut truth = perfect();
        truth.faces[4].fault = Some(SunFaceFault::Dark);
        let mut dark = sensors(&truth);
        assert_eq!(face_z(&mut dark, 20.0, 1.0, 1.0), [0.0; 4]);
        assert!(dark.exact()[4].iter().all(|current_a| *current_a > 0.0));
        truth.faces[4].fault = Some(SunFaceFault::Stuck);
        let mut stuck = sensors(&truth);
        let shown = face_z(&mut stuck, 20.0, 1.0, 0.0);
        assert!(shown.iter().all(|current_a| (current_a / FULL_SUN_A - 0.5).abs() < ROUNDING));
    }

    #[test]
    fn noise_of_the_direction_moves_the_spot_and_keeps_the_light() {
        let mut noisy = sensors(&SunSensorsTruth { noise_rad: 0.02, ..perfect() });
        let mut still = sensors(&perfect());
        let (moved, rest) =
            (face_z(&mut noisy, 20.0, 1.0, 1.0), face_z(&mut still, 20.0, 1.0, 1.0));
        assert_ne!(moved, rest);
        assert!((moved[0] + moved[1] - rest[0] - rest[1]).abs() < ROUNDING * FULL_SUN_A);
        assert_eq!(noisy.exact(), still.exact());
    }
}
