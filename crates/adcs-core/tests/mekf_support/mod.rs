//! Runs of the MEKF with the truth beside them: inputs, outputs, and how far they are apart.
#![allow(dead_code)] // each test uses its part

pub mod orbit_world;
pub mod reference_run;

use adcs_core::attitude::mekf::{
    FieldPair, FilterEstimate, Inputs, Mekf, MekfParameters, MekfState, Output, SunPair,
};
use adcs_core::frames::{Body, Eci, Rotation, Vector};
use adcs_core::reading::Reading;
use nalgebra::{Matrix3, RealField, UnitQuaternion, Vector3, convert};
use rand_core::Rng;
use rand_pcg::Pcg32;

/// One instant: what is true, and what is measured of it.
#[derive(Debug, Clone, Copy)]
pub struct Moment {
    pub attitude: Rotation<Body, Eci, f64>,
    pub omega_bi_b: Vector3<f64>,
    pub bias_b: Vector3<f64>,
    /// Outside eclipse.
    pub lit: bool,
    /// T.
    pub field_i: Vector3<f64>,
    pub sun_i: Vector3<f64>,
    pub gyro: Reading<Vector3<f64>>,
    pub field_b: Option<Vector3<f64>>,
    pub sun_b: Option<Vector3<f64>>,
}

pub fn vector<F, T: RealField + Copy>(xyz: Vector3<f64>) -> Vector<F, T> {
    Vector::from_xyz(xyz.map(convert))
}

pub fn f64_of<T: RealField + Copy>(value: T) -> f64 {
    value.to_subset_unchecked()
}

impl Moment {
    /// As the filter sees it, `dt_s` after the one before.
    pub fn inputs<T: RealField + Copy>(&self, dt_s: f64) -> Inputs<T> {
        let sun = self.sun_b.filter(|_| self.lit).map(|sun_b| SunPair {
            body: vector(sun_b).direction().expect("not zero"),
            eci: vector(self.sun_i).direction().expect("not zero"),
            sigma_rad: None,
        });
        let field = self
            .field_b
            .map(|field_b| FieldPair { body: vector(field_b), eci: vector(self.field_i) });
        Inputs { dt_s: convert(dt_s), gyro: self.gyro.map(vector), field, sun }
    }
}

/// Cycles at 1 Hz from a state, the first at its own instant.
pub fn outputs<T: RealField + Copy>(
    parameters: &MekfParameters<T>,
    mut state: MekfState<T>,
    moments: &[Moment],
) -> Vec<Output<T>> {
    let mekf = Mekf::new(parameters).expect("accepted");
    let steps = core::iter::once(0.0).chain(core::iter::repeat(1.0));
    let cycle = |(moment, dt_s): (&Moment, f64)| mekf.cycle(&mut state, &moment.inputs(dt_s));
    moments.iter().zip(steps).map(cycle).collect()
}

/// Errors of one estimate.
#[derive(Debug, Clone, Copy)]
pub struct Errors {
    /// Attitude, Body, rad.
    pub theta: Vector3<f64>,
    /// Gyro bias, Body, rad/s.
    pub bias: Vector3<f64>,
    /// θᵀ P⁻¹ θ, expected 3.
    pub nees_attitude: f64,
    /// (θ, Δβ)ᵀ P⁻¹ (θ, Δβ), expected 6.
    pub nees: f64,
}

impl Errors {
    pub fn of<T: RealField + Copy>(moment: &Moment, estimate: &FilterEstimate<T>) -> Self {
        let xyzw = estimate.r_bi.attitude_quaternion().map(f64_of);
        let estimated = Rotation::<Body, Eci, f64>::from_attitude_quaternion(xyzw).expect("unit");
        let theta = -(moment.attitude * estimated.inverse()).hamilton().scaled_axis();
        let bias = moment.bias_b - estimate.gyro_bias.xyz.map(f64_of);
        let p = estimate.covariance.map(f64_of);
        let p_attitude: Matrix3<f64> = p.fixed_view::<3, 3>(0, 0).into_owned();
        let mut both = nalgebra::Vector6::zeros();
        both.fixed_rows_mut::<3>(0).copy_from(&theta);
        both.fixed_rows_mut::<3>(3).copy_from(&bias);
        Self {
            theta,
            bias,
            nees_attitude: theta.dot(&(p_attitude.try_inverse().expect("regular") * theta)),
            nees: both.dot(&(p.try_inverse().expect("regular") * both)),
        }
    }
}

/// A mean that grows.
#[derive(Debug, Clone, Copy, Default)]
pub struct Mean {
    sum: f64,
    count: u32,
}

impl Mean {
    pub fn see(&mut self, value: f64) {
        self.sum += value;
        self.count += 1;
    }

    pub fn value(&self) -> f64 {
        self.sum / f64::from(self.count)
    }

    fn rms_deg(&self) -> f64 {
        self.value().sqrt().to_degrees()
    }
}

/// What a run comes to.
#[derive(Debug, Clone, Copy, Default)]
pub struct Figures {
    sunlit: Mean,
    eclipse: Mean,
    whole: Mean,
    bias: Mean,
    pub largest_rad: f64,
    pub nis_field: Mean,
    pub nis_sun: Mean,
    pub nees_attitude: Mean,
    pub nees: Mean,
    /// Instants without an estimate.
    pub without: u32,
}

impl Figures {
    /// Of all instants from number `from` on.
    pub fn of<T: RealField + Copy>(moments: &[Moment], outputs: &[Output<T>], from: usize) -> Self {
        let mut figures = Self::default();
        for (moment, output) in moments.iter().zip(outputs).skip(from) {
            figures.see(moment, output);
        }
        figures
    }

    pub fn see<T: RealField + Copy>(&mut self, moment: &Moment, output: &Output<T>) {
        for (mean, innovation) in
            [(&mut self.nis_field, output.field), (&mut self.nis_sun, output.sun)]
        {
            if let Some(innovation) = innovation.filter(|it| it.accepted) {
                mean.see(f64_of(innovation.nis));
            }
        }
        let Some(estimate) = output.estimate else {
            self.without += 1;
            return;
        };
        let errors = Errors::of(moment, &estimate);
        let square = errors.theta.norm_squared();
        if moment.lit { &mut self.sunlit } else { &mut self.eclipse }.see(square);
        self.whole.see(square);
        self.largest_rad = self.largest_rad.max(square.sqrt());
        self.bias.see(errors.bias.norm_squared());
        self.nees_attitude.see(errors.nees_attitude);
        self.nees.see(errors.nees);
    }

    pub fn sunlit_deg(&self) -> f64 {
        self.sunlit.rms_deg()
    }

    pub fn eclipse_deg(&self) -> f64 {
        self.eclipse.rms_deg()
    }

    pub fn whole_deg(&self) -> f64 {
        self.whole.rms_deg()
    }

    pub fn bias_deg_s(&self) -> f64 {
        self.bias.rms_deg()
    }

    pub const HEADER: &'static str = "sunlit eclipse  whole largest  bias      NIS field   Sun  NEES(3)   (6)\n  deg    deg     deg    deg   deg/s";

    pub fn line(&self) -> String {
        format!(
            "{:6.4} {:6.3}  {:6.3} {:6.2}  {:7.5}   {:9.3} {:6.3}  {:6.3} {:6.3}",
            self.sunlit_deg(),
            self.eclipse_deg(),
            self.whole_deg(),
            self.largest_rad.to_degrees(),
            self.bias_deg_s(),
            self.nis_field.value(),
            self.nis_sun.value(),
            self.nees_attitude.value(),
            self.nees.value(),
        )
    }
}

/// Seeded standard normal deviates (Box-Muller over PCG).
pub struct Gaussian(Pcg32);

impl Gaussian {
    pub fn new(seed: u64) -> Self {
        Self(Pcg32::new(seed, 0))
    }

    /// Uniform, above 0 and up to 1.
    pub fn uniform(&mut self) -> f64 {
        (f64::from(self.0.next_u32()) + 1.0) / 4_294_967_296.0
    }

    pub fn sample(&mut self) -> f64 {
        let radius = libm::sqrt(-2.0 * libm::log(self.uniform()));
        radius * libm::cos(core::f64::consts::TAU * self.uniform())
    }

    pub fn vector(&mut self, sigma: f64) -> Vector3<f64> {
        Vector3::from_fn(|_, _| self.sample()) * sigma
    }

    /// `unit` turned by a small angle with σ about each axis across it.
    pub fn direction(&mut self, unit: Vector3<f64>, sigma_rad: f64) -> Vector3<f64> {
        let noise = self.vector(sigma_rad);
        let across = noise - unit * unit.dot(&noise);
        UnitQuaternion::from_scaled_axis(across) * unit
    }
}
