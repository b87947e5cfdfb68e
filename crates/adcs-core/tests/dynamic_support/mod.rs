//! A satellite that moves by Euler's equations in a field that turns, with sensors as the filters expect
//! them, and both filters beside it.
#![allow(dead_code)] // each test uses its part

use adcs_core::attitude::dynamic::{
    DynamicFilter, DynamicInputs, DynamicOutput, DynamicParameters, DynamicState,
};
use adcs_core::attitude::mekf::{self, FieldPair, Mekf, MekfState, SunPair};
use adcs_core::frames::{Body, Direction, Eci, Rotation, Vector};
use adcs_core::reading::Reading;
use nalgebra::{Matrix3, UnitQuaternion, Vector3};
use rand_core::Rng;
use rand_pcg::Pcg32;

/// rad/s at 660 km.
const ORBIT_RATE: f64 = 1.07e-3;
const ORBIT_RADIUS_M: f64 = 7.03e6;
const SUN: [f64; 3] = [0.6, 0.64, 0.48];

/// The truth, stepped by Runge–Kutta of its own.
pub struct World {
    pub q_bi: UnitQuaternion<f64>,
    pub omega: Vector3<f64>,
    pub bias: Vector3<f64>,
    pub residual: Vector3<f64>,
    /// What the torquers carry, A·m².
    pub torquers: Vector3<f64>,
    pub lit: bool,
    inertia: Matrix3<f64>,
    t_s: f64,
    noise: Pcg32,
    sensors: mekf::MekfParameters<f64>,
}

impl World {
    /// Rate in deg/s; 5 % more inertia about x and less about z than the filter is told.
    pub fn new(seed: u64, rate_deg_s: [f64; 3]) -> Self {
        let told = DynamicParameters::<f64>::default().inertia_kg_m2;
        let told = Matrix3::from_fn(|i, j| told[i][j]);
        let more = Matrix3::from_diagonal(&Vector3::new(0.05, 0.0, -0.05)) * told.trace() / 3.0;
        Self {
            q_bi: UnitQuaternion::from_euler_angles(0.3, -0.8, 1.7),
            omega: Vector3::from(rate_deg_s) * 1_f64.to_radians(),
            bias: Vector3::new(0.2, -0.3, 0.1) * 1_f64.to_radians(),
            residual: Vector3::new(0.03, -0.05, 0.04),
            torquers: Vector3::zeros(),
            lit: true,
            inertia: told + more,
            t_s: 0.0,
            noise: Pcg32::new(seed, 0),
            sensors: mekf::MekfParameters::default(),
        }
    }

    /// A dipole field along a polar orbit.
    fn field(t_s: f64) -> Vector3<f64> {
        let up = Self::up(t_s);
        let axis = Vector3::new(0.17, 0.0, -0.985);
        (up * (3.0 * axis.dot(&up)) - axis) * 2.3e-5
    }

    fn up(t_s: f64) -> Vector3<f64> {
        let angle = ORBIT_RATE * t_s;
        Vector3::new(libm::cos(angle), 0.0, libm::sin(angle))
    }

    fn slope(
        &self,
        q: UnitQuaternion<f64>,
        omega: Vector3<f64>,
        t_s: f64,
        torquers: Vector3<f64>,
    ) -> Vector3<f64> {
        let up = q * Self::up(t_s);
        let gradient = 3.0 * ORBIT_RATE * ORBIT_RATE;
        let torque = (self.residual + torquers).cross(&(q * Self::field(t_s)))
            + up.cross(&(self.inertia * up)) * gradient
            - omega.cross(&(self.inertia * omega));
        self.inertia.try_inverse().expect("a body") * torque
    }

    fn sigma(&mut self, sigma: f64) -> Vector3<f64> {
        Vector3::from_fn(|_, _| {
            let uniform: f64 = (0..12).map(|_| f64::from(self.noise.next_u32())).sum();
            (uniform / 4_294_967_296.0 - 6.0) * sigma
        })
    }

    /// One second on: twenty steps of the midpoint rule.
    fn step(&mut self) {
        const STEP_S: f64 = 0.05;
        for _ in 0..20 {
            let half = self.omega
                + self.slope(self.q_bi, self.omega, self.t_s, self.torquers) * (0.5 * STEP_S);
            let q_half = UnitQuaternion::from_scaled_axis(-self.omega * (0.5 * STEP_S)) * self.q_bi;
            let slope = self.slope(q_half, half, self.t_s + 0.5 * STEP_S, self.torquers);
            self.q_bi = UnitQuaternion::from_scaled_axis(-half * STEP_S) * self.q_bi;
            self.omega += slope * STEP_S;
            self.t_s += STEP_S;
        }
        let walk = self.sigma(self.sensors.bias_walk_rad_s_per_sqrt_s);
        self.bias += walk;
    }

    /// The next second as sensors and models tell it.
    pub fn next(&mut self) -> DynamicInputs {
        self.step();
        let (field, sun) = (Self::field(self.t_s), Vector3::from(SUN));
        let gyro = self.omega + self.bias + self.sigma(self.sensors.gyro_noise_rad_s);
        let field_b = self.q_bi * field + self.sigma(self.sensors.field_noise.sensor_t);
        let sun_b = self.q_bi * sun + self.sigma(self.sensors.sun_noise_rad);
        DynamicInputs {
            sensors: mekf::Inputs {
                dt_s: 1.0,
                gyro: Reading::Fresh(vector(gyro)),
                field: Some(FieldPair { body: vector(field_b), eci: vector(field) }),
                sun: self.lit.then(|| SunPair {
                    body: direction(sun_b),
                    eci: direction(sun),
                    sigma_rad: None,
                }),
            },
            reference_field: Some(vector(field)),
            position: Some(vector(Self::up(self.t_s) * ORBIT_RADIUS_M)),
            torquer_dipole: vector(self.torquers),
            sunlit: Some(self.lit),
        }
    }

    /// How far `r_bi` is from the truth, deg.
    pub fn error_deg(&self, r_bi: &Rotation<Body, Eci>) -> f64 {
        let [x, y, z, w] = r_bi.attitude_quaternion().map(f64::from);
        let estimated =
            Rotation::<Body, Eci, f64>::from_attitude_quaternion([x, y, z, w]).expect("unit");
        (Rotation::<Body, Eci, f64>::from_hamilton(self.q_bi) * estimated.inverse())
            .angle_rad()
            .to_degrees()
    }
}

fn vector<F>(xyz: Vector3<f64>) -> Vector<F> {
    Vector::from_xyz(xyz.cast())
}

fn direction<F>(xyz: Vector3<f64>) -> Direction<F> {
    vector(xyz).direction().expect("not zero")
}

/// MEKF and dynamic filter on the same inputs.
pub struct Filters {
    mekf: Mekf,
    pub kinematic: MekfState,
    filter: DynamicFilter,
    pub dynamic: DynamicState,
}

impl Default for Filters {
    fn default() -> Self {
        Self::new(&DynamicParameters::default())
    }
}

impl Filters {
    pub fn new(parameters: &DynamicParameters<f32>) -> Self {
        Self {
            mekf: Mekf::new(&parameters.sensors).expect("accepted"),
            kinematic: MekfState::default(),
            filter: DynamicFilter::new(parameters).expect("accepted"),
            dynamic: DynamicState::default(),
        }
    }

    pub fn cycle(&mut self, inputs: &DynamicInputs) -> (mekf::Output, DynamicOutput) {
        let kinematic = self.mekf.cycle(&mut self.kinematic, &inputs.sensors);
        (kinematic, self.filter.cycle(&mut self.dynamic, inputs, &kinematic))
    }

    /// `seconds` of the world, changed by `fault`; calls `see` after each.
    pub fn fly(
        &mut self,
        world: &mut World,
        seconds: u32,
        fault: impl Fn(&mut DynamicInputs),
        mut see: impl FnMut(u32, &World, &mekf::Output, &DynamicOutput),
    ) {
        for second in 0..seconds {
            let mut inputs = world.next();
            fault(&mut inputs);
            let (kinematic, dynamic) = self.cycle(&inputs);
            see(second, world, &kinematic, &dynamic);
        }
    }
}
