//! SPROUT in its orbit for as long as one likes: field, Sun and eclipse from the models, an attitude that
//! keeps moving, and sensors that fail now and then.

use adcs_core::attitude::mekf::MekfParameters;
use adcs_core::environment::eclipse::{EarthShape, lit_fraction};
use adcs_core::environment::field::FieldModel;
use adcs_core::environment::sun_track::{SunNodes, SunTrack};
use adcs_core::frames::Rotation;
use adcs_core::orbit::OrbitModel;
use adcs_core::orbit::interpolated::{InterpolatedOrbit, OrbitNodes};
use adcs_core::reading::{MissingReason, Reading};
use adcs_core::time::{LeapSeconds, Utc};
use nalgebra::{UnitQuaternion, Vector3};
use sgp4_lite::Elements;

use super::{Gaussian, Moment};

/// SPROUT on 2015-11-19 (CelesTrak).
const TLE: [&str; 2] = [
    "1 39770U 14029E   15323.12177538  .00004189  00000-0  50368-3 0  9997",
    "2 39770  97.8736  57.8959 0010514  58.6984 301.5230 14.84437654 80617",
];

/// The truth, and sensors with the noise of the default [`MekfParameters`].
pub struct OrbitWorld {
    orbit: InterpolatedOrbit,
    orbit_nodes: OrbitNodes,
    sun: SunTrack,
    sun_nodes: SunNodes,
    field: FieldModel<f64>,
    start: Utc,
    seconds: u32,
    q_bi: UnitQuaternion<f64>,
    bias_b: Vector3<f64>,
    noise: Gaussian,
    sigma: MekfParameters<f64>,
}

impl OrbitWorld {
    pub fn new(seed: u64) -> Self {
        let elements = Elements::from_tle(TLE[0], TLE[1]).expect("a TLE");
        let model = OrbitModel::new(&elements).expect("near the Earth");
        let start = model.epoch();
        let mut noise = Gaussian::new(seed);
        Self {
            orbit: InterpolatedOrbit::new(model),
            orbit_nodes: OrbitNodes::default(),
            sun: SunTrack::new(LeapSeconds::default()),
            sun_nodes: SunNodes::default(),
            field: FieldModel::new(start).expect("a date of IGRF"),
            start,
            seconds: 0,
            q_bi: UnitQuaternion::from_scaled_axis(noise.vector(1.0)),
            bias_b: noise.vector(0.25_f64.to_radians()),
            noise,
            sigma: MekfParameters::default(),
        }
    }

    /// A tumble that decays in 20 min, then wobbling about 0.06 deg/s with slews of 1 deg/s, ten
    /// minutes every two hours.
    fn rate(t_s: f64) -> Vector3<f64> {
        let tumble = Vector3::new(2.0, -5.0, 3.0) * libm::exp(-t_s / 1200.0);
        let wobble = Vector3::new(
            libm::sin(t_s / 97.0),
            libm::sin(t_s / 143.0 + 1.0),
            libm::cos(t_s / 211.0),
        ) * 0.1
            + Vector3::new(0.0, -0.06, 0.0);
        let in_slew = t_s % 7200.0 / 600.0;
        let slew = if in_slew < 1.0 { libm::sin(core::f64::consts::PI * in_slew) } else { 0.0 };
        (tumble + wobble + Vector3::new(0.6, 0.7, -0.4) * slew) * 1_f64.to_radians()
    }

    /// The next second. The magnetometer is heard every fifth (the torquers have the others). Every
    /// quarter of an hour the gyro is silent for 3 s; the Sun sensor once in a while sees
    /// something else, the magnetometer a disturbance of 20 µT.
    pub fn next(&mut self) -> Moment {
        let t_s = f64::from(self.seconds);
        let now = self.start.plus_micros(i64::from(self.seconds) * 1_000_000);
        let position = self.orbit.state(&mut self.orbit_nodes, now).expect("an orbit").position;
        let sun = self.sun.position_m(&mut self.sun_nodes, now).expect("a date");
        let field_i = self.field.eci_t(now, position).expect("a field").xyz;
        let lit = lit_fraction(position, sun, EarthShape::Ellipsoid) > 0.5;
        let sun_i = (sun - position).xyz.normalize();
        if self.seconds > 0 {
            let turn = Self::rate(t_s - 0.5);
            self.q_bi = UnitQuaternion::from_scaled_axis(-turn) * self.q_bi;
            self.q_bi.renormalize();
        }
        self.bias_b += self.noise.vector(self.sigma.bias_walk_rad_s_per_sqrt_s);
        let omega_bi_b = Self::rate(t_s);

        let gyro = omega_bi_b + self.bias_b + self.noise.vector(self.sigma.gyro_noise_rad_s);
        let field_noise =
            libm::hypot(self.sigma.field_noise.sensor_t, self.sigma.field_noise.model_t);
        let mut field_b = self.q_bi * field_i + self.noise.vector(field_noise);
        let mut sun_b = self.noise.direction(self.q_bi * sun_i, self.sigma.sun_noise_rad);
        if self.seconds % 1301 == 1300 {
            sun_b = self.noise.vector(1.0).normalize();
        }
        if self.seconds % 1705 == 1700 {
            field_b += self.noise.vector(1.0).normalize() * 20e-6;
        }
        let gyro_speaks = self.seconds % 900 < 897;
        let moment = Moment {
            attitude: Rotation::from_hamilton(self.q_bi),
            omega_bi_b,
            bias_b: self.bias_b,
            lit,
            field_i,
            sun_i,
            gyro: if gyro_speaks {
                Reading::Fresh(gyro)
            } else {
                Reading::Missing(MissingReason::Bus)
            },
            field_b: self.seconds.is_multiple_of(5).then_some(field_b),
            sun_b: lit.then_some(sun_b),
        };
        self.seconds += 1;
        moment
    }
}
