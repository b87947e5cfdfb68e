//! The run of an independent simulator (`tests/data/mekf/README.md`).

#[path = "../reference/table.rs"]
mod table;

use adcs_core::attitude::mekf::{
    FieldNoise, GivenStart, GyroSampling, Mekf, MekfParameters, MekfState,
};
use adcs_core::frames::{Body, Eci, Rotation, Vector};
use adcs_core::reading::Reading;
use nalgebra::{RealField, UnitQuaternion, Vector3, convert};

#[allow(unused_imports)] // each test uses its part
pub use self::table::{Row, Table, Worst};
use super::{Gaussian, Moment};

const MEASUREMENTS: &str = include_str!("../data/mekf/measurements.csv");
const REFERENCES: &str = include_str!("../data/mekf/reference_vectors.csv");
const TRUTH: &str = include_str!("../data/mekf/truth.csv");
const CONFIG: &str = include_str!("../data/mekf/config.json");
pub const REFERENCE_FILTER: &str = include_str!("../data/mekf/reference_filter.csv");

/// A number of `config.json`.
fn configured(key: &str) -> f64 {
    let config: serde_json::Value = serde_json::from_str(CONFIG).expect("JSON");
    config[key].as_f64().unwrap_or_else(|| panic!("no number {key}"))
}

pub fn attitude(row: &Row<'_>) -> Rotation<Body, Eci, f64> {
    let xyzw = ["q_x", "q_y", "q_z", "q_w"].map(|column| row.number(column));
    Rotation::from_attitude_quaternion(xyzw).expect("a unit quaternion")
}

/// The run, second by second.
pub fn moments() -> Vec<Moment> {
    let [measurements, references, truth] = [MEASUREMENTS, REFERENCES, TRUTH].map(Table::parse);
    let rows = measurements.rows().zip(references.rows()).zip(truth.rows());
    rows.map(|((measured, reference), truth)| {
        assert_eq!(measured.text("t_s"), reference.text("t_s"));
        assert_eq!(measured.text("t_s"), truth.text("t_s"));
        let gyro = measured.vector(["gyro_x_rad_s", "gyro_y_rad_s", "gyro_z_rad_s"]);
        let sun_b = measured.vector(["sun_x", "sun_y", "sun_z"]);
        Moment {
            attitude: attitude(&truth),
            omega_bi_b: truth.vector(["rate_x_rad_s", "rate_y_rad_s", "rate_z_rad_s"]),
            bias_b: truth.vector(["gyro_bias_x_rad_s", "gyro_bias_y_rad_s", "gyro_bias_z_rad_s"]),
            lit: reference.text("eclipse") == "0",
            field_i: reference.vector(["B_teme_x_nT", "B_teme_y_nT", "B_teme_z_nT"]) * 1e-9,
            sun_i: reference.vector(["sun_teme_x", "sun_teme_y", "sun_teme_z"]),
            gyro: Reading::Fresh(gyro),
            field_b: Some(measured.vector(["mag_x_nT", "mag_y_nT", "mag_z_nT"]) * 1e-9),
            sun_b: (measured.text("sun_valid") == "1").then_some(sun_b),
        }
    })
    .collect()
}

/// The same truth, measured again with other noise of the same size; the bias walks anew.
pub fn measured_again(run: &[Moment], seed: u64) -> Vec<Moment> {
    let mut noise = Gaussian::new(seed);
    let sigma = |key| configured(key);
    let (gyro, walk) = (sigma("gyro_sigma_rad_s"), sigma("gyro_bias_rw_rad_s_sqrt_s"));
    let (sun, field) =
        (sigma("sun_sigma_rad_per_transverse_axis"), sigma("mag_sigma_nT_per_axis") * 1e-9);
    let mut bias_b = run.first().map_or(Vector3::zeros(), |first| first.bias_b);
    run.iter()
        .map(|moment| {
            bias_b += noise.vector(walk);
            let r_bi = moment.attitude.hamilton();
            Moment {
                bias_b,
                gyro: Reading::Fresh(moment.omega_bi_b + bias_b + noise.vector(gyro)),
                field_b: Some(r_bi * moment.field_i + noise.vector(field)),
                sun_b: moment.lit.then(|| noise.direction(r_bi * moment.sun_i, sun)),
                ..*moment
            }
        })
        .collect()
}

/// What the run's sensors are; nothing stands between field model and truth.
pub fn parameters<T: RealField + Copy>() -> MekfParameters<T> {
    MekfParameters {
        gyro_noise_rad_s: convert(configured("gyro_sigma_rad_s")),
        gyro_sampling: GyroSampling::Instant,
        bias_walk_rad_s_per_sqrt_s: convert(configured("gyro_bias_rw_rad_s_sqrt_s")),
        bias_prior_rad_s: convert(configured("reference_filter_P0_bias_sigma_deg_s").to_radians()),
        sun_noise_rad: convert(configured("sun_sigma_rad_per_transverse_axis")),
        field_noise: FieldNoise {
            sensor_t: convert(configured("mag_sigma_nT_per_axis") * 1e-9),
            calibration_t: T::zero(),
            model_t: T::zero(),
        },
        ..Default::default()
    }
}

/// The state at the start that the run gives, turned by `wrong_by_deg` about no particular axis, and
/// believed to `sigma_deg`.
pub fn given_start<T: RealField + Copy>(wrong_by_deg: f64, sigma_deg: f64) -> MekfState<T> {
    let config: serde_json::Value = serde_json::from_str(CONFIG).expect("JSON");
    let xyzw: [f64; 4] =
        serde_json::from_value(config["reference_filter_initial_q_xyzw"].clone()).expect("four");
    let turn = Vector3::new(1.0, -2.0, 0.5).normalize() * wrong_by_deg.to_radians();
    let turn: Rotation<Body, Body, f64> =
        Rotation::from_hamilton(UnitQuaternion::from_scaled_axis(turn));
    let r_bi = turn * Rotation::<Body, Eci, f64>::from_attitude_quaternion(xyzw).expect("unit");
    let start = GivenStart {
        r_bi: Rotation::from_attitude_quaternion(r_bi.attitude_quaternion().map(convert))
            .expect("unit"),
        attitude_sigma_rad: convert(sigma_deg.to_radians()),
        gyro_bias: Vector::zero(),
        gyro_bias_sigma_rad_s: parameters::<T>().bias_prior_rad_s,
    };
    let mut state = MekfState::default();
    let mekf = Mekf::new(&parameters::<T>()).expect("accepted");
    mekf.begin(&mut state, &start).expect("accepted");
    state
}

/// σ with which the reference filter believes its start, deg.
pub fn given_sigma_deg() -> f64 {
    configured("reference_filter_P0_attitude_sigma_deg")
}
