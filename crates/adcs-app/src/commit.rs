//! What commissioning found, put into the parameters that fly.

use adcs_core::attitude::dynamic::DynamicParameters;
use adcs_core::commissioning::{Findings, InertiaFound, MagnetometerFound, Rung, Three, worst};
use adcs_core::frames::{Body, GyroAxes, Rotation, Vector};
use adcs_core::sensing::{SunFaceParameters, SunFacesParameters, TriadParameters};
use nalgebra::{UnitQuaternion, Vector3};

use crate::parameters::{FlightParameters, LawParameters};

/// Between which strengths a scale that is wrong counts, T: that of low orbits.
const STRENGTH_T: f32 = 4e-5;
/// No filter is told more than this of the residual dipole, each axis, A·m²: panels' currents move it
/// by as much (docs/filters).
const LEAST_DIPOLE_SIGMA_AM2: f32 = 0.01;
/// And of products of inertia, in units of the mean moment: a panel that is deployed later.
const LEAST_INERTIA_SIGMA: f32 = 0.005;
/// And of the gyro bias, each axis, rad/s: 0.03 deg/s, what a few degrees of temperature make of it.
const LEAST_BIAS_RAD_S: f32 = 5e-4;
/// And of what calibration leaves of the field, each axis, T: σ knows of noise alone, and not of what the
/// model of the field has wrong, or of what a warmer sensor shows.
const LEAST_FIELD_T: f32 = 300e-9;
/// A filter that starts is told a σ so many times that of the finding.
const CAUTION: f32 = 2.0;

impl FlightParameters {
    /// The same with every result that passed its gate put to use: corrections of magnetometer, gyros and Sun
    /// sensors; residual dipole and inertia wherever filters, laws and guard are told them; and how
    /// well all this is known. What the torquers do to the magnetometer is for the ground: in the rests, in
    /// which it is read, they do nothing.
    pub fn committed(&self, findings: &Findings) -> Self {
        let passed = |rung, it: Option<Three>| it.filter(|_| findings.passed(rung));
        let mut next = *self;
        if let Some(found) = findings.magnetometer.filter(|_| findings.passed(Rung::Magnetometer)) {
            next.set_magnetometer(&found);
        }
        if let Some(found) = passed(Rung::Gyro, findings.gyro) {
            next.set_gyro(&found);
        }
        if let Some(found) = passed(Rung::Sun, findings.sun) {
            next.sun_sensors = next.sun_sensors.map(|faces| turned(&faces, found.value));
        }
        if let Some(found) = passed(Rung::Dipole, findings.dipole) {
            next.set_dipole(&found);
        }
        if let Some(found) = findings.inertia.filter(|_| findings.passed(Rung::Inertia)) {
            next.set_inertia(&found);
        }
        next
    }

    fn dynamics(&mut self) -> Option<&mut DynamicParameters<f32>> {
        self.attitude.as_mut().map(|attitude| &mut attitude.dynamics)
    }

    fn set_magnetometer(&mut self, found: &MagnetometerFound) {
        self.magnetometer = found.correction(&self.magnetometer);
        let left = found.scale.worst_sigma().max(found.cross_axis.worst_sigma()) * STRENGTH_T;
        let bias = found.bias_t.worst_sigma();
        if let Some(dynamics) = self.dynamics() {
            let known = libm::sqrtf(left * left + bias * bias);
            dynamics.sensors.field_noise.calibration_t = known.max(LEAST_FIELD_T);
        }
    }

    fn set_gyro(&mut self, found: &Three) {
        let TriadParameters { bias, alignment_xyzw, .. } = &mut self.gyro;
        let Some(alignment) = Rotation::<Body, GyroAxes>::from_attitude_quaternion(*alignment_xyzw)
        else {
            return;
        };
        let [x, y, z] = found.value;
        let more = alignment.inverse() * Vector::new(x, y, z);
        *bias = (Vector3::from(*bias) + more.xyz).into();
        let known = (CAUTION * found.worst_sigma()).max(LEAST_BIAS_RAD_S);
        if let Some(dynamics) = self.dynamics() {
            let prior = &mut dynamics.sensors.bias_prior_rad_s;
            *prior = prior.min(known);
        }
    }

    fn set_dipole(&mut self, found: &Three) {
        let known = (CAUTION * found.worst_sigma()).max(LEAST_DIPOLE_SIGMA_AM2);
        if let Some(dynamics) = self.dynamics() {
            // Found in proportion to the trace of the tensor, which is as uncertain as its moments.
            let by_trace = dynamics.moment_prior * worst(&found.value.map(f32::abs));
            let known = libm::sqrtf(known * known + by_trace * by_trace);
            dynamics.dipole_am2 = found.value;
            dynamics.dipole_prior_am2 = dynamics.dipole_prior_am2.min(known);
        }
    }

    /// The moments keep their prior: their sum is not found.
    fn set_inertia(&mut self, found: &InertiaFound) {
        let tensor = found.tensor_kg_m2;
        let [[xx, ..], [_, yy, _], [.., zz]] = tensor;
        let [[_, xy, xz], [_, _, yz], _] = found.sigma_kg_m2;
        let share = CAUTION * worst(&[xy, xz, yz]) * 3.0 / (xx + yy + zz);
        if let Some(dynamics) = self.dynamics() {
            dynamics.inertia_kg_m2 = tensor;
            dynamics.product_prior = dynamics.product_prior.min(share.max(LEAST_INERTIA_SIGMA));
        }
        set_inertia(&mut self.law, tensor);
        if let Some(modes) = &mut self.modes {
            if let Some(experiment) = &mut modes.experiment {
                set_inertia(&mut experiment.law, tensor);
            }
            if let Some(polarity) = &mut modes.polarity {
                polarity.inertia_kg_m2 = tensor;
            }
        }
    }
}

fn set_inertia(law: &mut LawParameters, tensor: [[f32; 3]; 3]) {
    match law {
        LawParameters::Off | LawParameters::BDot(_) | LawParameters::BangBang(_) => {}
        LawParameters::CrossProduct { law, .. } => law.inertia_kg_m2 = tensor,
        LawParameters::Periodic { law, unplanned, .. } => {
            law.inertia_kg_m2 = tensor;
            unplanned.inertia_kg_m2 = tensor;
        }
    }
}

/// Every face turned by δ, Body, rad.
fn turned(faces: &SunFacesParameters, by: [f32; 3]) -> SunFacesParameters {
    // v + δ × v: the vector is turned by δ.
    let turn: Rotation<Body, Body> =
        Rotation::from_hamilton(UnitQuaternion::from_scaled_axis(Vector3::from(by)));
    let face = |face: &SunFaceParameters| {
        let alignment = Rotation::<Body, Body>::from_attitude_quaternion(face.alignment_xyzw);
        let alignment_xyzw = alignment
            .map_or(face.alignment_xyzw, |alignment| (turn * alignment).attitude_quaternion());
        SunFaceParameters { alignment_xyzw, ..*face }
    };
    SunFacesParameters { faces: faces.faces.each_ref().map(face), ..*faces }
}
