//! Section `attitude`: which filters fly, and what they are told. A mission without the section flies
//! without attitude, which despin does not need.

use adcs_core::attitude::dynamic::{Blocks, DynamicError, DynamicParameters, TorqueNoise};
use adcs_core::attitude::mekf::{FieldNoise, MekfParameters};
use adcs_core::attitude::selection::{Estimator, EstimatorParameters, Flies};

use super::problem::Fault;
use super::section::Section;
use super::typed::{Check, FINITE, POSITIVE};

const T_PER_NT: f64 = 1e-9;

const NOT_NEGATIVE: Check = Check::new(|x| x >= 0.0 && x.is_finite(), "zero or positive");

/// The keys of the numbers, by their fields.
const KEYS: [(&str, &str); 22] = [
    ("gyro_noise_rad_s", "gyro_noise_deg_s"),
    ("bias_walk_rad_s_per_sqrt_s", "gyro_bias_walk_deg_s_per_sqrt_s"),
    ("bias_prior_rad_s", "gyro_bias_prior_deg_s"),
    ("field_noise.sensor_t", "field_noise_nt"),
    ("field_noise.calibration_t", "field_calibration_nt"),
    ("field_noise.model_t", "field_model_nt"),
    ("sun_noise_rad", "sun_noise_deg"),
    ("inertia_kg_m2, its mean moment", "inertia_kg_m2"),
    ("moment_prior", "inertia_moment_prior"),
    ("product_prior", "inertia_product_prior"),
    ("dipole_am2[0]", "residual_dipole_am2"),
    ("dipole_am2[1]", "residual_dipole_am2"),
    ("dipole_am2[2]", "residual_dipole_am2"),
    ("dipole_prior_am2", "residual_dipole_prior_am2"),
    ("dipole_walk_am2_per_sqrt_s", "residual_dipole_walk_am2_per_sqrt_s"),
    ("dipole_step_am2", "shadow_dipole_prior_am2"),
    ("field_bias_prior_t", "magnetometer_bias_prior_nt"),
    ("white_torque_n_m_sqrt_s", "white_torque_n_m_sqrt_s"),
    ("inertia_allowance", "inertia_allowance"),
    ("torque.smallest_n_m", "unknown_torque_least_n_m"),
    ("torque.start_n_m", "unknown_torque_n_m"),
    ("torque.correlation_s", "unknown_torque_time_s"),
];

/// The key of a field of the filters' parameters.
fn key_of(field: &str) -> &'static str {
    KEYS.iter().find(|(known, _)| *known == field).map_or("filter", |(_, key)| key)
}

/// `Some(None)` for a flight without; `None` when something is wrong.
///
/// `inertia_kg_m2` is the true tensor: what the filters are told when the section says nothing else.
pub(super) fn attitude(
    root: &Section,
    inertia_kg_m2: Option<[[f64; 3]; 3]>,
) -> Option<Option<EstimatorParameters>> {
    let Some(section) = root.section_if_any("attitude")? else { return Some(None) };
    let usual = DynamicParameters::<f64>::default();
    let MekfParameters { field_noise, .. } = usual.sensors;
    let deg = f64::to_degrees;

    let flies = section.choice("filter", &[("mekf", Flies::Mekf), ("dynamic", Flies::Both)]);
    let gyro_noise =
        section.number_or("gyro_noise_deg_s", POSITIVE, deg(usual.sensors.gyro_noise_rad_s));
    let bias_walk = section.number_or(
        "gyro_bias_walk_deg_s_per_sqrt_s",
        NOT_NEGATIVE,
        deg(usual.sensors.bias_walk_rad_s_per_sqrt_s),
    );
    let bias_prior =
        section.number_or("gyro_bias_prior_deg_s", POSITIVE, deg(usual.sensors.bias_prior_rad_s));
    let field_nt = |tesla: f64| tesla / T_PER_NT;
    let field = section.number_or("field_noise_nt", POSITIVE, field_nt(field_noise.sensor_t));
    let calibration = section.number_or("field_calibration_nt", NOT_NEGATIVE, 0.0);
    let model = section.number_or("field_model_nt", NOT_NEGATIVE, field_nt(field_noise.model_t));
    let sun = section.number_or("sun_noise_deg", POSITIVE, deg(usual.sensors.sun_noise_rad));
    let inertia = match inertia_kg_m2 {
        Some(truth) => section.matrix_or("inertia_kg_m2", truth),
        None => section.matrix_or("inertia_kg_m2", usual.inertia_kg_m2),
    };
    let dipole = section.vector_or("residual_dipole_am2", FINITE, usual.dipole_am2);
    let dipole_prior =
        section.number_or("residual_dipole_prior_am2", POSITIVE, usual.dipole_prior_am2);
    let torque = section.number_or("unknown_torque_n_m", POSITIVE, usual.torque.start_n_m);
    let torque_least = section.number_or(
        "unknown_torque_least_n_m",
        POSITIVE,
        usual.torque.smallest_n_m.min(torque.unwrap_or(usual.torque.smallest_n_m)),
    );
    let torque_time =
        section.number_or("unknown_torque_time_s", POSITIVE, usual.torque.correlation_s);
    let white = section.number_or("white_torque_n_m_sqrt_s", NOT_NEGATIVE, 0.0);
    let inertia_flies = if section.has("learn_inertia") {
        section.flag("learn_inertia")
    } else {
        Some(usual.blocks.inertia)
    };
    let allowance = section.number_or("inertia_allowance", NOT_NEGATIVE, 0.0);
    let moments = section.number_or("inertia_moment_prior", NOT_NEGATIVE, usual.moment_prior);
    let products = section.number_or("inertia_product_prior", NOT_NEGATIVE, usual.product_prior);
    let walk = section.number_or(
        "residual_dipole_walk_am2_per_sqrt_s",
        NOT_NEGATIVE,
        usual.dipole_walk_am2_per_sqrt_s,
    );
    // The states that fly only when they are asked for.
    let optional = |key: &'static str| match section.has(key) {
        true => section.number(key, POSITIVE).map(Some),
        false => Some(None),
    };
    let shadow = optional("shadow_dipole_prior_am2");
    let field_bias = optional("magnetometer_bias_prior_nt");
    section.finish();

    let single = |x: f64| x as f32;
    let (shadow, field_bias) = (shadow?, field_bias?);
    let usual_bias_nt = field_nt(usual.field_bias_prior_t);
    let field_noise = FieldNoise {
        sensor_t: single(field? * T_PER_NT),
        calibration_t: single(calibration? * T_PER_NT),
        model_t: single(model? * T_PER_NT),
    };
    let parameters = EstimatorParameters {
        flies: flies?,
        dynamics: DynamicParameters {
            sensors: MekfParameters {
                gyro_noise_rad_s: single(gyro_noise?.to_radians()),
                bias_walk_rad_s_per_sqrt_s: single(bias_walk?.to_radians()),
                bias_prior_rad_s: single(bias_prior?.to_radians()),
                field_noise,
                sun_noise_rad: single(sun?.to_radians()),
                ..MekfParameters::default()
            },
            inertia_kg_m2: inertia?.map(|row| row.map(single)),
            dipole_am2: dipole?.map(single),
            dipole_prior_am2: single(dipole_prior?),
            blocks: Blocks {
                inertia: inertia_flies?,
                torque: true,
                shadow: shadow.is_some(),
                field_bias: field_bias.is_some(),
            },
            moment_prior: single(moments?),
            product_prior: single(products?),
            dipole_walk_am2_per_sqrt_s: single(walk?),
            dipole_step_am2: single(shadow.unwrap_or(usual.dipole_step_am2)),
            field_bias_prior_t: single(field_bias.unwrap_or(usual_bias_nt) * T_PER_NT),
            white_torque_n_m_sqrt_s: single(white?),
            inertia_allowance: single(allowance?),
            torque: TorqueNoise {
                smallest_n_m: single(torque_least?),
                start_n_m: single(torque?),
                correlation_s: single(torque_time?),
                ..DynamicParameters::<f32>::default().torque
            },
            ..DynamicParameters::default()
        },
    };
    if let Err(error) = Estimator::<f32>::new(&parameters) {
        let key = match error {
            DynamicError::Inertia => "inertia_kg_m2",
            DynamicError::OutOfRange(error) => key_of(error.name),
            _ => "filter",
        };
        section.refuse(key, Fault::new(format!("impossible: {error}")));
        return None;
    }
    Some(Some(parameters))
}
