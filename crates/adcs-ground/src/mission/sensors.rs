//! Sections `converter`, `magnetometer` and `gyro`: how they are wired, what the flight software
//! takes them for, and what they really do.

use adcs_core::frames::{Body, GyroAxes, MagnetometerAxes, Rotation};
use adcs_core::sensing::{Triad, TriadError, TriadParameters};
use adcs_hal::analog_triad::{AnalogTriad, AnalogTriadConfig, ConfigError, ConverterConfig};
use adcs_sim::scenario::SensorTruth;

use super::misalignment;
use super::problem::Fault;
use super::section::Section;
use super::typed::{Check, NOT_ZERO, POSITIVE, TURN_DEG};

/// Nanotesla in a tesla.
const NT_PER_T: f64 = 1e9;
/// Millivolts in a volt.
const MV_PER_V: f64 = 1e3;

/// What the MCP3208 takes (DS21298E §1.0).
const REFERENCE: Check =
    Check::new(|x| (0.25..=5.5).contains(&x), "from 0.25 to 5.5, as the converter takes it");

/// A middle voltage; the converter's own reference limits it further.
const ZERO_V: Check = Check::new(|x| (0.0..=5.5).contains(&x), "from 0 to 5.5 V");
/// Above it two axes would be nearer to each other than to a right angle.
const CROSS_AXIS: Check = Check::new(|c| c.abs() <= 0.5, "between -0.5 and 0.5");
const OFFSET_M: Check = Check::new(|x| x.abs() <= 10.0, "within 10 m");

/// The names of a sensor's keys and how they become SI.
struct Kind {
    section: &'static str,
    sensitivity: &'static str,
    bias: &'static str,
    noise: &'static str,
    /// One person's unit (nT, deg/s) in SI.
    to_si: fn(f64) -> f64,
    /// The sensitivity as written, in volts per SI unit.
    volts_per_si: fn(f64) -> f64,
    /// Words for `switched_off`.
    errors: &'static [(&'static str, &'static str)],
    /// What noise and bias can be, in that unit.
    range: Check,
    noise_range: Check,
}

const MAGNETOMETER: Kind = Kind {
    section: "magnetometer",
    sensitivity: "sensitivity_nt_per_v",
    bias: "bias_nt",
    noise: "noise_nt",
    to_si: |nt| nt / NT_PER_T,
    volts_per_si: |nt_per_v| NT_PER_T / nt_per_v,
    errors: &[
        ("noise", "noise"),
        ("bias", "bias"),
        ("matrix", "matrix"),
        ("misalignment", "misalignment"),
        ("torquer_field", "torquer_field"),
    ],
    range: Check::new(|nt| nt.abs() <= 1e6, "within 1000000 nT, twenty times the Earth's field"),
    noise_range: Check::new(|nt| (0.0..=1e6).contains(&nt), "zero or positive, at most 1000000 nT"),
};

const GYRO: Kind = Kind {
    section: "gyro",
    sensitivity: "sensitivity_mv_per_deg_s",
    bias: "bias_deg_s",
    noise: "noise_deg_s",
    to_si: f64::to_radians,
    volts_per_si: |mv_per_deg_s| (mv_per_deg_s / MV_PER_V).to_degrees(),
    errors: &[
        ("noise", "noise"),
        ("bias", "bias"),
        ("matrix", "matrix"),
        ("misalignment", "misalignment"),
    ],
    range: Check::new(|deg_s| deg_s.abs() <= 1e4, "within 10000 deg/s"),
    noise_range: Check::new(|x| (0.0..=1e4).contains(&x), "zero or positive, at most 10000 deg/s"),
};

/// One sensor of three axes.
pub(super) struct Sensor {
    pub wiring: AnalogTriadConfig,
    pub calibration: TriadParameters,
    pub truth: SensorTruth,
    /// From the torquers to a magnetometer that feels them, Body, m.
    pub offset_from_torquers_m: Option<[f64; 3]>,
}

pub(super) fn converter(root: &Section) -> Option<ConverterConfig> {
    let section = root.section("converter")?;
    let reference_v = section.number("reference_v", REFERENCE);
    let rail_margin_codes = section.integer("rail_margin_codes", 0..=2047);
    section.finish();
    Some(ConverterConfig {
        reference_v: reference_v? as f32,
        rail_margin_codes: rail_margin_codes? as u16,
    })
}

pub(super) fn magnetometer(root: &Section, converter: Option<ConverterConfig>) -> Option<Sensor> {
    sensor::<MagnetometerAxes>(root, &MAGNETOMETER, converter)
}

pub(super) fn gyro(root: &Section, converter: Option<ConverterConfig>) -> Option<Sensor> {
    sensor::<GyroAxes>(root, &GYRO, converter)
}

/// Says that both sensors are wired to one input.
pub(super) fn refuse_shared_channels(root: &Section, magnetometer: &Sensor, gyro: &Sensor) {
    let Some(section) = root.section("gyro") else { return };
    for (axis, channel) in gyro.wiring.channels.iter().enumerate() {
        if magnetometer.wiring.channels.contains(channel) {
            let place = section.place_within("channels", &[axis]);
            let fault = Fault::new(format!("channel {channel} is the magnetometer's already"));
            section.refuse_at(place, "channels", fault);
        }
    }
}

fn sensor<S>(root: &Section, kind: &Kind, converter: Option<ConverterConfig>) -> Option<Sensor> {
    let section = root.section(kind.section)?;
    let channels = section.channels("channels");
    let zero_v = section.number("zero_v", ZERO_V);
    let sensitivity = section.number(kind.sensitivity, POSITIVE);
    let alignment = section.quaternion_or("alignment_xyzw", super::NO_ROTATION);
    let calibration = section.section_or_empty("calibration");
    let errors = section.section_or_empty("errors");
    section.finish();
    let calibration =
        calibration.and_then(|below| self::calibration::<S>(&below, kind, alignment?));
    let errors = errors.and_then(|below| self::errors::<S>(&below, kind, alignment?));

    let wiring = AnalogTriadConfig {
        channels: channels?,
        zero_v: zero_v? as f32,
        sensitivity_v_per_si: (kind.volts_per_si)(sensitivity?) as f32,
    };
    if let Err(error) = AnalogTriad::new(wiring, converter?) {
        let key = match error {
            ConfigError::Sensitivity { .. } => kind.sensitivity,
            ConfigError::Zero { .. } => "zero_v",
            _ => "channels",
        };
        section.refuse(key, Fault::new(error.to_string()));
    }
    let (truth, offset_from_torquers_m) = errors?;
    Some(Sensor { wiring, calibration: calibration?, truth, offset_from_torquers_m })
}

/// `drawn` is how the sensor should be mounted, and really is but for its errors.
fn calibration<S>(section: &Section, kind: &Kind, drawn: [f64; 4]) -> Option<TriadParameters> {
    let scale = section.vector_or("scale", NOT_ZERO, [1.0; 3]);
    let cross_axis = section.vector_or("cross_axis", CROSS_AXIS, [0.0; 3]);
    let bias = section.vector_or(kind.bias, kind.range, [0.0; 3]);
    let alignment = section.quaternion_or("alignment_xyzw", drawn);
    section.finish();
    let parameters = TriadParameters {
        scale: scale?.map(|x| x as f32),
        cross_axis: cross_axis?.map(|x| x as f32),
        bias: bias?.map(|x| (kind.to_si)(x) as f32),
        alignment_xyzw: alignment?.map(|x| x as f32),
    };
    if let Err(error) = Triad::<S>::new(&parameters) {
        let key = match error {
            TriadError::Bias { .. } => kind.bias,
            TriadError::CrossAxis { .. } => "cross_axis",
            _ => "scale",
        };
        section.refuse(key, Fault::new(error.to_string()));
    }
    Some(parameters)
}

fn errors<S>(
    section: &Section,
    kind: &Kind,
    alignment: [f64; 4],
) -> Option<(SensorTruth, Option<[f64; 3]>)> {
    let perfect = SensorTruth::PERFECT;
    let noise = section.number_or(kind.noise, kind.noise_range, 0.0);
    let bias = section.vector_or(kind.bias, kind.range, [0.0; 3]);
    let matrix = section.matrix_or("matrix", perfect.matrix);
    let turned = section.vector_or("misalignment_deg", TURN_DEG, [0.0; 3]);
    let feels_torquers = kind.errors.iter().any(|(word, _)| *word == "torquer_field");
    let offset_key = "offset_from_torquers_m";
    let offset = match feels_torquers && section.has(offset_key) {
        true => section.vector(offset_key, OFFSET_M).map(Some),
        false => Some(None),
    };
    let off = section.choices("switched_off", kind.errors);
    section.finish();

    let off = off?;
    let on = |word| !off.contains(&word);
    if offset? == Some([0.0; 3]) {
        let fault = Fault::new("impossible: the magnetometer is not inside the torquers");
        section.refuse(offset_key, fault);
    }
    let nominal: Rotation<Body, S, f64> = Rotation::from_attitude_quaternion(alignment)?;
    let truth = SensorTruth {
        alignment_xyzw: match misalignment::<S>(turned?, !on("misalignment")) {
            None => alignment,
            Some(turned) => (nominal * turned).attitude_quaternion(),
        },
        matrix: if on("matrix") { matrix? } else { perfect.matrix },
        bias: if on("bias") { bias?.map(kind.to_si) } else { perfect.bias },
        noise: if on("noise") { (kind.to_si)(noise?) } else { perfect.noise },
    };
    Some((truth, offset?.filter(|_| on("torquer_field"))))
}
