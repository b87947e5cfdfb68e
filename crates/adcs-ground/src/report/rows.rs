//! A flight in a person's units, row by row: what history, plots and summary are made of.

use adcs_core::attitude::selection::{AttitudeSource, RateSource, Reason};
use adcs_core::commissioning::LadderReport;
use adcs_core::frames::{Body, Eci, Rotation, Vector};
use adcs_core::modes::ModeReport;
use adcs_core::pipeline::ControlStatus;
use adcs_core::reading::{MissingReason, Reading};
use adcs_core::schedule::Phase;
use adcs_core::sensing::FaceVerdict;
use adcs_core::sensing::sun_faces::FACES;
use adcs_core::time::Utc;
use adcs_link::TruthRecord;
use adcs_link::message::DeterminationRecord;

use super::pointing::Targets;
use crate::flight::Flown;
use crate::flight::records::Step;

/// Nanotesla in a tesla.
const NT_PER_T: f64 = 1e9;

/// One cycle. Vectors are along Body's axes unless said otherwise.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// The cycle.
    pub cycle: u32,
    /// Time since the start, s.
    pub time_s: f64,
    /// The satellite's clock.
    pub utc: Utc,
    /// What the cycle was for.
    pub phase: Phase,
    /// True rate, deg/s.
    pub rate_deg_s: [f64; 3],
    /// Its length, deg/s.
    pub rate_norm_deg_s: f64,
    /// True attitude, scalar last.
    pub attitude_xyzw: [f64; 4],
    /// True position, Eci, km.
    pub position_km: [f64; 3],
    /// True field, nT.
    pub field_nt: [f64; 3],
    /// Its length, nT.
    pub field_norm_nt: f64,
    /// Readings of the gyros along their axes, deg/s.
    pub gyro_deg_s: [Reading<f64>; 3],
    /// Readings of the magnetometer along its axes, nT.
    pub magnetometer_nt: [Reading<f64>; 3],
    /// Rate after calibration, deg/s.
    pub measured_rate_deg_s: Option<[f64; 3]>,
    /// Field after calibration, nT; only from the cycles that measure.
    pub measured_field_nt: Option<[f64; 3]>,
    /// Length of the flight software's model field, nT.
    pub model_field_norm_nt: Option<f64>,
    /// Commanded dipole along the torquers' axes, A·m².
    pub commanded_am2: [f64; 3],
    /// Dipole that the hardware made of it, A·m²; `None` when it refused.
    pub driven_am2: Option<[f64; 3]>,
    /// Dipole that truly acts from this instant on, A·m²; that of the last row is not known.
    pub dipole_am2: Option<[f64; 3]>,
    /// What the mode machine said; `None` without modes.
    pub mode: Option<ModeReport>,
    /// What the commissioning ladder said; `None` when it was not being climbed.
    pub commissioning: Option<LadderReport>,
    /// Whether its results had just been put in force.
    pub committed: bool,
    /// What stage III did.
    pub control: ControlStatus,
    /// True angle from Body to the target, deg; `None` while nothing is pointed at.
    pub pointing_error_deg: Option<f64>,
    /// The same as the satellite believed it, deg; only while the torquers act.
    pub believed_pointing_deg: Option<f64>,
    /// Which torquers stood at their limit.
    pub saturated: [bool; 3],
    /// Kinetic energy of turning, J.
    pub energy_j: f64,
    /// Power of the control torque, ω · (m × B), over this cycle: the mean of its two ends, W.
    pub control_power_w: Option<f64>,
    /// Whether the Sun was in sight.
    pub sunlit: bool,
    /// Fraction of the Sun's disc that the flight software takes to be free.
    pub model_sunlit: Option<f64>,
    /// True direction of the Sun.
    pub sun: [f64; 3],
    /// As the Sun sensors see it, or why they do not.
    pub measured_sun: Reading<MeasuredSun>,
    /// What became of each Sun sensor.
    pub sun_faces: [FaceVerdict; FACES],
    /// What stage II believed; `None` when it did not fly.
    pub believed: Option<Believed>,
}

/// What stage II believed, beside the truth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Believed {
    /// As it is in the record.
    pub record: DeterminationRecord,
    /// Angle between the believed and the true attitude, deg.
    pub attitude_error_deg: Option<f64>,
    /// σ of that angle: root of the sum over the three axes, deg.
    pub attitude_sigma_deg: Option<f64>,
    /// Length of the believed minus the true rate, deg/s.
    pub rate_error_deg_s: Option<f64>,
}

/// The Sun as the Sun sensors see it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeasuredSun {
    /// Its direction.
    pub direction: [f64; 3],
    /// σ that the flight software gives it, about each axis, deg.
    pub sigma_deg: f64,
    /// Angle to the true direction, deg.
    pub error_deg: f64,
}

/// All rows of a flight; `targets` is what it should have pointed at.
pub fn rows(flown: &Flown, targets: Option<&Targets>) -> Vec<Row> {
    let following = flown.steps.iter().skip(1).map(Some).chain([None]);
    flown
        .steps
        .iter()
        .zip(following)
        .map(|(step, next)| Row {
            pointing_error_deg: targets.and_then(|it| it.error_deg(&step.truth, &step.record)),
            ..row(flown, step, next)
        })
        .collect()
}

fn row(flown: &Flown, Step { truth, record }: &Step, next: Option<&Step>) -> Row {
    let field = field_in_body(truth);
    // The next truth tells what the torquers carried up to it, that is, through this cycle.
    let next = next.map(|next| next.truth).filter(|next| next.cycle == truth.cycle + 1);
    let power = |at: &TruthRecord, dipole: [f64; 3]| {
        let omega: Vector<Body, f64> = vector(at.omega_bi_rad_s);
        omega.dot(&vector::<Body>(dipole).cross(&field_in_body(at)))
    };
    let mean_power = |next: TruthRecord| {
        let dipole = next.torquer_dipole_body_am2;
        (power(truth, dipole) + power(&next, dipole)) / 2.0
    };
    Row {
        cycle: record.cycle,
        time_s: flown.time_s(record.cycle),
        utc: record.utc,
        phase: record.phase,
        rate_deg_s: truth.omega_bi_rad_s.map(f64::to_degrees),
        rate_norm_deg_s: norm(truth.omega_bi_rad_s).to_degrees(),
        attitude_xyzw: truth.attitude_xyzw,
        position_km: truth.position_eci_m.map(|m| m / 1e3),
        field_nt: field.to_array().map(|t| t * NT_PER_T),
        field_norm_nt: field.norm() * NT_PER_T,
        gyro_deg_s: record.gyro_rad_s.map(|axis| axis.map(|x| f64::from(x).to_degrees())),
        magnetometer_nt: record.magnetometer_t.map(|axis| axis.map(|x| f64::from(x) * NT_PER_T)),
        measured_rate_deg_s: record
            .omega_bi_rad_s
            .value()
            .map(|rate| rate.map(|x| f64::from(x).to_degrees())),
        measured_field_nt: record
            .field_body_t
            .value()
            .map(|field| field.map(|x| f64::from(x) * NT_PER_T)),
        model_field_norm_nt: record
            .reference_field_eci_t
            .map(|field| norm(field.map(f64::from)) * NT_PER_T),
        commanded_am2: record.commanded_am2.map(f64::from),
        driven_am2: record.driven_am2.map(|dipole| dipole.map(f64::from)),
        dipole_am2: next.map(|next| next.torquer_dipole_body_am2),
        mode: record.mode,
        commissioning: record.commissioning,
        committed: record.committed,
        control: record.control,
        pointing_error_deg: None,
        believed_pointing_deg: record.pointing_error_rad.map(|it| f64::from(it).to_degrees()),
        saturated: record.saturated,
        energy_j: truth.kinetic_energy_j,
        control_power_w: next.map(mean_power),
        sunlit: truth.sunlit,
        model_sunlit: record.sunlit.map(f64::from),
        sun: sun_in_body(truth).to_array(),
        measured_sun: record.sun.map(|measured| {
            let direction: Vector<Body, f64> = vector(measured.body.map(f64::from));
            let sun = sun_in_body(truth);
            let error_rad = direction.cross(&sun).norm().atan2(direction.dot(&sun));
            MeasuredSun {
                direction: direction.to_array(),
                sigma_deg: f64::from(measured.sigma_rad).to_degrees(),
                error_deg: error_rad.to_degrees(),
            }
        }),
        sun_faces: record.sun_faces,
        believed: record.determination.map(|record| believed(truth, record)),
    }
}

fn believed(truth: &TruthRecord, record: DeterminationRecord) -> Believed {
    let error = record.attitude.and_then(|it| {
        let believed: Rotation<Body, Eci, f64> =
            Rotation::from_attitude_quaternion(it.xyzw.map(f64::from))?;
        Some((attitude(truth) * believed.inverse()).angle_rad().to_degrees())
    });
    let sigma = record.attitude.map(|it| norm(it.sigma_rad.map(f64::from)).to_degrees());
    let rate_error = record.rate.map(|it| {
        let off: [f64; 3] =
            core::array::from_fn(|i| f64::from(it.omega_bi_rad_s[i]) - truth.omega_bi_rad_s[i]);
        norm(off).to_degrees()
    });
    Believed {
        record,
        attitude_error_deg: error,
        attitude_sigma_deg: sigma,
        rate_error_deg_s: rate_error,
    }
}

/// The true attitude.
fn attitude(truth: &TruthRecord) -> Rotation<Body, Eci, f64> {
    // The truth's quaternion has length one.
    Rotation::from_attitude_quaternion(truth.attitude_xyzw).unwrap_or_else(Rotation::identity)
}

/// The true field, T.
fn field_in_body(truth: &TruthRecord) -> Vector<Body, f64> {
    attitude(truth) * vector(truth.field_eci_t)
}

/// The true direction of the Sun.
fn sun_in_body(truth: &TruthRecord) -> Vector<Body, f64> {
    attitude(truth) * vector(truth.sun_eci)
}

fn vector<F>([x, y, z]: [f64; 3]) -> Vector<F, f64> {
    Vector::new(x, y, z)
}

/// The length of a vector.
pub(super) fn norm(v: [f64; 3]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// Why a reading is missing, in a word.
pub(super) fn missing_word(reason: MissingReason) -> &'static str {
    match reason {
        MissingReason::Bus => "bus",
        MissingReason::OutOfRange => "out_of_range",
        MissingReason::NotFinite => "not_finite",
        MissingReason::TorquersOn => "torquers_on",
        MissingReason::NotFitted => "not_fitted",
        MissingReason::Dark => "dark",
        MissingReason::NotTheSun => "not_the_sun",
        MissingReason::Unpredicted => "unpredicted",
        MissingReason::Disagree => "disagree",
        MissingReason::Frozen => "frozen",
        _ => "missing",
    }
}

/// What became of a Sun sensor, in a word.
pub(super) fn face_word(verdict: FaceVerdict) -> &'static str {
    match verdict {
        FaceVerdict::Used => "used",
        FaceVerdict::Missing(reason) => missing_word(reason),
        FaceVerdict::Dark => "dark",
        FaceVerdict::Broken => "broken",
        FaceVerdict::OutsideCone => "outside_cone",
        FaceVerdict::Earth => "earth",
        FaceVerdict::Faint => "faint",
        FaceVerdict::Bright => "bright",
        FaceVerdict::Unpredicted => "unpredicted",
        FaceVerdict::Disagrees => "disagrees",
        _ => "unknown",
    }
}

/// What a cycle was for, in a word.
pub(super) fn phase_word(phase: Phase) -> &'static str {
    match phase {
        Phase::Settling => "settling",
        Phase::Measuring => "measuring",
        Phase::Acting => "acting",
        Phase::Settled => "settled",
    }
}

/// Where an attitude comes from, in a word.
pub(super) fn attitude_word(source: AttitudeSource) -> &'static str {
    match source {
        AttitudeSource::Dynamic => "dynamic",
        AttitudeSource::Mekf => "mekf",
        AttitudeSource::TwoVectors => "two_vectors",
    }
}

/// Where a rate comes from, in a word.
pub(super) fn rate_word(source: RateSource) -> &'static str {
    match source {
        RateSource::Dynamic => "dynamic",
        RateSource::GyroLessBias => "gyro_less_bias",
        RateSource::Gyro => "gyro",
        RateSource::AcrossField => "across_field",
    }
}

/// Why a better source was not used, in a word.
pub(super) fn reason_word(reason: Reason) -> &'static str {
    match reason {
        Reason::Best => "best",
        Reason::DynamicNotFlown => "dynamic_not_flown",
        Reason::DynamicNotStarted => "dynamic_not_started",
        Reason::DynamicNotTrusted => "dynamic_not_trusted",
        Reason::MekfStarts => "mekf_starts",
        Reason::MekfWithheld => "mekf_withheld",
        Reason::MekfLost(_) => "mekf_lost",
        Reason::MekfNotStarted => "mekf_not_started",
    }
}

/// What stage III did, in words.
pub(super) fn control_words(control: ControlStatus) -> String {
    match control {
        ControlStatus::Off => "off".to_owned(),
        ControlStatus::Resting => "resting".to_owned(),
        ControlStatus::Acting => "acting".to_owned(),
        ControlStatus::Unplanned => "unplanned".to_owned(),
        ControlStatus::NoRate(reason) => format!("no_rate:{}", missing_word(reason)),
        ControlStatus::NoField(reason) => format!("no_field:{}", missing_word(reason)),
        ControlStatus::NoDipole => "no_dipole".to_owned(),
        ControlStatus::NoAttitude => "no_attitude".to_owned(),
        ControlStatus::NoTarget => "no_target".to_owned(),
        ControlStatus::Spent => "spent".to_owned(),
    }
}
