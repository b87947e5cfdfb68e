//! The messages and their fields. Components are plain arrays in SI units; the frame stands in the
//! name or in the field's doc line.

use adcs_core::attitude::selection::{AttitudeSource, RateSource, Reason};
use adcs_core::commissioning::LadderReport;
use adcs_core::modes::ModeReport;
use adcs_core::pipeline::ControlStatus;
use adcs_core::reading::Reading;
use adcs_core::schedule::Phase;
use adcs_core::sensing::FaceVerdict;
use adcs_core::sensing::sun_faces::FACES;
use adcs_core::time::Utc;
use serde::{Deserialize, Serialize};

/// Version of the messages below. A reader refuses any other: postcard carries no field names, so
/// bytes of another version would decode into nonsense.
pub const VERSION: u16 = 6;

/// One message.
// The large variant is the one that is sent, every cycle; nothing ever holds many.
#[allow(clippy::large_enum_variant)]
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Message {
    /// First of a stream: who speaks and in which version.
    Hello(Hello),
    /// What one cycle measured, thought and did.
    Cycle(CycleRecord),
    /// In simulation: what was really so at that instant.
    Truth(TruthRecord),
    /// Last of a stream that was not cut off.
    End(End),
}

/// Opens a stream.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Hello {
    /// [`VERSION`] of the writer.
    pub version: u16,
    /// How many cycles will follow, when that is known.
    pub cycles: u32,
    /// The cycle period, µs.
    pub cycle_us: u32,
}

/// What one cycle measured, thought and did: telemetry, history and golden trace in one.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct CycleRecord {
    /// Cycles since the application started.
    pub cycle: u32,
    /// The satellite's clock at the start of the cycle.
    pub utc: Utc,
    /// What the cycle was for.
    pub phase: Phase,
    /// Rate along each gyro's axis as the driver gave it, rad/s.
    pub gyro_rad_s: [Reading<f32>; 3],
    /// Field along each magnetometer axis as the driver gave it, T, torquers' field included.
    pub magnetometer_t: [Reading<f32>; 3],
    /// Photocurrents X1, X2, Y1, Y2 of each Sun sensor as the driver gave them, A.
    pub sun_a: [Reading<[f32; 4]>; FACES],
    /// Rate of Body relative to Eci after calibration, Body, rad/s.
    pub omega_bi_rad_s: Reading<[f32; 3]>,
    /// Field after calibration, Body, T; missing unless it was measured with the torquers at rest.
    pub field_body_t: Reading<[f32; 3]>,
    /// The Sun as the Sun sensors together see it, or why they do not.
    pub sun: Reading<SunRecord>,
    /// What became of each Sun sensor.
    pub sun_faces: [FaceVerdict; FACES],
    /// Where the satellite takes itself to be, Eci, m; `None` when the orbit model fails.
    pub position_eci_m: Option<[f64; 3]>,
    /// The model's field there, Eci, T.
    pub reference_field_eci_t: Option<[f32; 3]>,
    /// Where the Sun should be, Eci, unit vector.
    pub reference_sun_eci: Option<[f32; 3]>,
    /// Fraction of the Sun's disc that should be free, 0 in eclipse to 1.
    pub sunlit: Option<f32>,
    /// What stage II believes; `None` when it does not fly.
    pub determination: Option<DeterminationRecord>,
    /// The mode, and how it was entered; `None` when one law flies from start to end.
    pub mode: Option<ModeReport>,
    /// The rung of the commissioning ladder, and what one that ended has found; `None` when it is not
    /// being climbed.
    pub commissioning: Option<LadderReport>,
    /// Since the last cycle, what commissioning found has been put in force.
    pub committed: bool,
    /// What stage III made of it.
    pub control: ControlStatus,
    /// Angle from Body to the target, rad, as believed when the round was decided; `None` in a rest, and
    /// when no attitude is aimed at.
    pub pointing_error_rad: Option<f32>,
    /// Dipole commanded, along the torquers' axes, A·m².
    pub commanded_am2: [f32; 3],
    /// Dipole that the hardware made of the command, A·m²; `None` when it refused and is off.
    pub driven_am2: Option<[f32; 3]>,
    /// Which torquers stood at their limit.
    pub saturated: [bool; 3],
}

/// What stage II believes, where it comes from, and why not from somewhere better.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct DeterminationRecord {
    /// The attitude.
    pub attitude: Option<AttitudeRecord>,
    /// The rate.
    pub rate: Option<RateRecord>,
    /// Why a better source was not used.
    pub reason: Reason,
    /// Gyro bias as the filter that is believed knows it, Body, rad/s.
    pub gyro_bias_rad_s: Option<[f32; 3]>,
    /// Residual dipole, Body, A·m², while the dynamics-aided filter has an estimate.
    pub residual_dipole_am2: Option<[f32; 3]>,
    /// NIS of the field in the filter that is believed, 3 degrees of freedom.
    pub nis_field: Option<f32>,
    /// NIS of the Sun, 2 degrees of freedom.
    pub nis_sun: Option<f32>,
}

/// An attitude that is believed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct AttitudeRecord {
    /// Attitude quaternion `[q_x, q_y, q_z, q_w]`, Eci to Body.
    pub xyzw: [f32; 4],
    /// σ about each Body axis, rad.
    pub sigma_rad: [f32; 3],
    /// Where it comes from.
    pub source: AttitudeSource,
}

/// A rate that is believed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct RateRecord {
    /// Rate of Body relative to Eci, Body, rad/s.
    pub omega_bi_rad_s: [f32; 3],
    /// σ of its least known axis, rad/s.
    pub sigma_rad_s: f32,
    /// Where it comes from.
    pub source: RateSource,
}

/// The Sun, measured.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SunRecord {
    /// Its direction, Body, unit vector.
    pub body: [f32; 3],
    /// σ about each axis across it, rad.
    pub sigma_rad: f32,
    /// By how much the face furthest from it differs, rad.
    pub worst_residual_rad: f32,
}

/// The true state at the start of a cycle, before the cycle's command.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct TruthRecord {
    /// The cycle it belongs to.
    pub cycle: u32,
    /// Attitude quaternion `[q_x, q_y, q_z, q_w]`, Eci to Body.
    pub attitude_xyzw: [f64; 4],
    /// Rate of Body relative to Eci, Body, rad/s.
    pub omega_bi_rad_s: [f64; 3],
    /// Position, Eci, m.
    pub position_eci_m: [f64; 3],
    /// Geomagnetic field, Eci, T.
    pub field_eci_t: [f64; 3],
    /// Kinetic energy of turning, J.
    pub kinetic_energy_j: f64,
    /// Dipole that the torquers carried up to this instant, Body, A·m².
    pub torquer_dipole_body_am2: [f64; 3],
    /// Where the Sun is, from the satellite, Eci, unit vector.
    pub sun_eci: [f64; 3],
    /// Whether the Sun was in sight.
    pub sunlit: bool,
}

/// Closes a stream.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct End {
    /// Cycles flown.
    pub cycles: u32,
    /// [`Digest`](crate::Digest) over every cycle and truth message of the stream.
    pub digest: u64,
    /// Violations of a chip's protocol that the simulated devices counted (0 on hardware).
    pub violations: u32,
}
