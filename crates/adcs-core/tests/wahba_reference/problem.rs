//! Problems as the reference tables and the tests write them.

use adcs_core::attitude::{Estimate, Method, NoAttitude, Observation};
use adcs_core::frames::{Body, Eci, Rotation, Vector};
use nalgebra::Vector3;

use crate::table::Row;

/// One pair in f64, before any method has seen it.
#[derive(Debug, Clone, Copy)]
pub struct Pair {
    pub body: Vector3<f64>,
    pub reference: Vector3<f64>,
    pub sigma_rad: f64,
}

impl Pair {
    pub fn f64(&self) -> Observation<f64> {
        Observation::new(
            Vector::from_xyz(self.body),
            Vector::from_xyz(self.reference),
            self.sigma_rad,
        )
        .expect("a valid pair")
    }

    pub fn f32(&self) -> Observation<f32> {
        let [body, reference] = [self.body, self.reference].map(|v| v.map(|x| x as f32));
        let sigma_rad = self.sigma_rad as f32;
        Observation::new(Vector::from_xyz(body), Vector::from_xyz(reference), sigma_rad)
            .expect("a valid pair")
    }
}

/// The pairs of a row of `wahba_random.csv`.
pub fn pairs(row: &Row<'_>) -> Vec<Pair> {
    let vector = |name: &str, i: u32| {
        let columns = ["x", "y", "z"].map(|axis| format!("{name}{i}_{axis}"));
        row.vector(columns.each_ref().map(String::as_str))
    };
    let n = row.number("n_vectors") as u32;
    (1..=n)
        .map(|i| Pair {
            body: vector("b", i),
            reference: vector("r", i),
            sigma_rad: row.number(&format!("sigma{i}_rad")),
        })
        .collect()
}

/// The attitude of four columns `{prefix}_x` … `{prefix}_w`.
pub fn attitude(row: &Row<'_>, prefix: &str) -> Rotation<Body, Eci, f64> {
    let xyzw = ["x", "y", "z", "w"].map(|part| row.number(&format!("{prefix}_{part}")));
    Rotation::from_attitude_quaternion(xyzw).expect("a unit quaternion")
}

/// Solves in f64.
pub fn solve(method: Method, pairs: &[Pair]) -> Result<Estimate<f64>, NoAttitude> {
    method.solve(&pairs.iter().map(Pair::f64).collect::<Vec<_>>())
}

/// Solves in f32.
pub fn solve_f32(method: Method, pairs: &[Pair]) -> Result<Estimate<f32>, NoAttitude> {
    method.solve(&pairs.iter().map(Pair::f32).collect::<Vec<_>>())
}

/// The attitude that was estimated in f32, exactly.
pub fn widened(r: Rotation<Body, Eci, f32>) -> Rotation<Body, Eci, f64> {
    Rotation::from_attitude_quaternion(r.attitude_quaternion().map(f64::from))
        .expect("a unit quaternion")
}

/// The angle between two attitudes, rad.
pub fn angle_rad(a: Rotation<Body, Eci, f64>, b: Rotation<Body, Eci, f64>) -> f64 {
    (a * b.inverse()).angle_rad()
}
