//! What the mode machine looks at.

use crate::attitude::selection::{AttitudeSource, Determination};
use crate::commissioning::Witnessed;
use crate::frames::{Body, Direction, Eci, MagnetometerAxes, Vector};
use crate::reading::{MissingReason, Reading};
use crate::schedule::Phase;
use crate::sensing::{FaceVerdict, SunSighting};
use crate::time::Utc;

use super::Mode;
use crate::polarity::CheckInputs;

/// The Sun counts as shining from this fraction of its disc on, as in stage II.
const LIT: f32 = 0.5;

/// One cycle as the mode machine sees it.
#[derive(Debug, Clone, Copy)]
pub struct Sight {
    /// The satellite's clock.
    pub now: Utc,
    /// What the cycle is for.
    pub phase: Phase,
    /// A mode that the ground asks for.
    pub commanded: Option<Mode>,
    /// Rate of Body relative to Eci, rad/s: that of stage II, else the gyros'.
    pub rate: Option<Vector<Body>>,
    /// Whether the gyros speak.
    pub gyro_speaks: bool,
    /// Whether the magnetometer speaks; `None` while the torquers spoil it.
    pub magnetometer_speaks: Option<bool>,
    /// Whether the Sun sensors speak: by day, whether they see the Sun.
    pub sun_speaks: bool,
    /// Whether the torquers took what they were told since the last cycle.
    pub torquers_obey: bool,
    /// σ of the attitude's least known axis, rad; `None` without an attitude.
    pub attitude_sigma_rad: Option<f32>,
    /// Whether the attitude has been filtered, and is more than field and Sun of this instant.
    pub filtered: bool,
    /// σ of the residual dipole's least known axis, A·m²; `None` unless it is trusted.
    pub dipole_sigma_am2: Option<f32>,
    /// Angle to the target, rad, where it was last known in this mode.
    pub pointing_error_rad: Option<f32>,
    /// What the devices say and did, for what looks after them.
    pub witnessed: Witnessed,
}

/// The sensors of one cycle.
pub(crate) struct Heard<'a> {
    pub(crate) omega_bi: Reading<Vector<Body>>,
    pub(crate) field_b: Reading<Vector<Body>>,
    pub(crate) sun_b: &'a SunSighting,
    pub(crate) lit: Option<f32>,
    /// Field along the magnetometer's axes, with whatever the torquers add.
    pub(crate) reading: Reading<Vector<MagnetometerAxes>>,
    pub(crate) reference_field: Option<Vector<Eci>>,
    pub(crate) reference_sun: Option<Direction<Eci>>,
    /// What the torquers carried since the last cycle.
    pub(crate) carried: Vector<Body>,
    /// Whether they took what they were told.
    pub(crate) obey: bool,
}

impl Sight {
    /// What the sensors and stage II say.
    pub(crate) fn of(
        (now, phase): (Utc, Phase),
        commanded: Option<Mode>,
        heard: &Heard<'_>,
        determination: Option<&Determination>,
        pointing_error_rad: Option<f32>,
    ) -> Self {
        let believed = determination.and_then(|it| it.rate).map(|rate| rate.omega_bi);
        let attitude = determination.and_then(|it| it.attitude);
        let dynamic = determination.and_then(|it| it.dynamic.estimate.as_ref());
        let dynamic = dynamic.filter(|estimate| estimate.trusted);
        let rests = matches!(phase, Phase::Settled | Phase::Measuring);
        Self {
            now,
            phase,
            commanded,
            rate: believed.or(heard.omega_bi.value()).filter(Vector::is_finite),
            gyro_speaks: heard.omega_bi.value().is_some(),
            magnetometer_speaks: rests.then(|| heard.field_b.value().is_some()),
            sun_speaks: sun_speaks(heard),
            torquers_obey: heard.obey,
            attitude_sigma_rad: attitude.map(|it| it.sigma_rad().xyz.max()),
            filtered: attitude.is_some_and(|it| it.source != AttitudeSource::TwoVectors),
            dipole_sigma_am2: dynamic.map(|it| it.residual_dipole_sigma_am2.xyz.max()),
            pointing_error_rad,
            witnessed: Witnessed {
                devices: CheckInputs {
                    now,
                    phase,
                    omega_bi: heard.omega_bi,
                    field_b: heard.field_b,
                    carried: heard.carried,
                },
                reading: heard.reading,
                reference_field: heard.reference_field,
                reference_sun: heard
                    .reference_sun
                    .filter(|_| heard.lit.is_some_and(|lit| lit >= LIT)),
                sun: heard.sun_b.sun.value().map(|sun| sun.direction),
            },
        }
    }
}

/// By day the Sun sensors speak when they see the Sun; at night, or when nobody knows, when there is a
/// face that is neither silent nor broken.
fn sun_speaks(heard: &Heard<'_>) -> bool {
    match (heard.lit, heard.sun_b.sun) {
        // Nothing that is not there can fail.
        (_, Reading::Missing(MissingReason::NotFitted)) => true,
        (Some(lit), sun) if lit >= LIT => sun.value().is_some(),
        _ => heard
            .sun_b
            .faces
            .iter()
            .any(|face| !matches!(face, FaceVerdict::Missing(_) | FaceVerdict::Broken)),
    }
}
