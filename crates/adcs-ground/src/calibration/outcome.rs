//! What a calibration says, to programs and to people.

use std::fmt;

use adcs_core::calibration::{self, Evidence};
use adcs_core::frames::SignedPermutation;
use nalgebra::Vector3;
use serde::Serialize;

use super::{Fit, Measured, Naming, Request};

/// The result, as it is written to `OUT.json`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Outcome {
    /// Which errors were sought; with `auto`, which were found.
    pub model: &'static str,
    /// s of B = C (s ∘ V) + b + Σ k I.
    pub scale_nt_per_v: [f64; 3],
    /// b.
    pub bias_nt: [f64; 3],
    /// Standard deviation of s.
    pub scale_sigma_nt_per_v: [f64; 3],
    /// Standard deviation of b.
    pub bias_sigma_nt: [f64; 3],
    /// xy, xz, yz of C, which has ones on its diagonal.
    pub cross_axis: [f64; 3],
    /// Standard deviation of these.
    pub cross_axis_sigma: [f64; 3],
    /// k of each current.
    pub couplings: Vec<Coupling>,
    /// Whether the shift that noise makes was taken out.
    pub unbiased: bool,
    /// Σ (|B|² − |B_IGRF|²)².
    pub cost_nt4: f64,
    /// How many samples were used.
    pub samples: u32,
    /// Steps of the search; of TWOSTEP none.
    pub iterations: Option<u32>,
    /// Condition of the scaled normal matrix.
    pub condition: Option<f64>,
    /// |B| − |B_IGRF| by the data sheet.
    pub norm_error_before_nt: Range,
    /// The same calibrated.
    pub norm_error_after_nt: Range,
    /// By how much the calibration turns the field.
    pub turned_deg: Range,
    /// The models that were tried.
    pub evidence: Vec<Judged>,
    /// Which axis is which, where the table has gyros.
    pub axes: Option<Naming>,
    /// What the flight software takes.
    pub correction: Correction,
    #[serde(skip)]
    fit: Fit,
    /// Along which of Body's axes the sensor's are, where they are put right.
    #[serde(skip)]
    put_right: SignedPermutation,
}

/// Least, largest and root mean square.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Range {
    /// Least.
    pub min: f64,
    /// Largest.
    pub max: f64,
    /// Root mean square.
    pub rms: f64,
}

/// What one current does.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Coupling {
    /// The column that it stands in, with its unit.
    pub current: &'static str,
    /// Field for one unit of it, x y z.
    pub field_nt: [f64; 3],
    /// Standard deviation of that.
    pub field_sigma_nt: [f64; 3],
}

/// How a model did.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Judged {
    /// Its name.
    pub model: &'static str,
    /// How many unknowns it has.
    pub unknowns: u32,
    /// Root mean square of (|B|² − |B_IGRF|²) / 2 |B_IGRF|.
    pub rms_nt: f64,
    /// Schwarz' criterion: the lower, the better, and by 10 very clearly.
    pub bic: f64,
}

impl Judged {
    pub(super) fn of(model: &'static str, evidence: &Evidence) -> Self {
        let Evidence { unknowns, rms, .. } = *evidence;
        Self { model, unknowns, rms_nt: rms, bic: evidence.bic() }
    }
}

/// Section `[magnetometer.calibration]` of a mission: field = C (scale · reading) − bias.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Correction {
    /// Factor on what the driver gives.
    pub scale: [f64; 3],
    /// What an axis takes from another then: xy, xz, yz.
    pub cross_axis: [f64; 3],
    /// Subtracted after it.
    pub bias_nt: [f64; 3],
    /// Attitude quaternion from the sensor's axes to Body, where axes were found exchanged.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub alignment_xyzw: Option<[f64; 4]>,
}

impl Range {
    fn of(values: impl Iterator<Item = f64>) -> Self {
        let (mut min, mut max, mut sum, mut count) = (f64::INFINITY, f64::NEG_INFINITY, 0.0, 0.0);
        for value in values {
            (min, max) = (min.min(value), max.max(value));
            sum += value * value;
            count += 1.0;
        }
        Self { min, max, rms: (sum / count).sqrt() }
    }
}

impl Outcome {
    pub(super) fn new(
        model: &'static str,
        used: &[Measured],
        request: &Request<'_>,
        fit: Fit,
        evidence: Vec<Judged>,
        axes: Option<Naming>,
    ) -> Self {
        let wiring = axes.as_ref().and_then(|axes| axes.wiring).filter(|_| request.apply_signs);
        let put_right = wiring.unwrap_or(SignedPermutation::IDENTITY);
        let (found, sigma) = (fit.parameters(), fit.sigmas());
        let before = |one: &Measured| {
            let sheet = request.before;
            Vector3::from(one.sample.reading).map(|v| sheet.sensitivity * (v - sheet.zero))
        };
        let after = |one: &Measured| put_right.apply(Vector3::from(fit.field(one)));
        let of_norm = |field: &dyn Fn(&Measured) -> Vector3<f64>| {
            Range::of(used.iter().map(|one| field(one).norm() - one.sample.intensity))
        };
        let currents = match model {
            "coupled" => request.currents.names,
            _ => &[],
        };
        Self {
            model,
            scale_nt_per_v: found.scale(),
            bias_nt: found.bias(),
            scale_sigma_nt_per_v: sigma.scale(),
            bias_sigma_nt: sigma.bias(),
            cross_axis: found.cross_axis(),
            cross_axis_sigma: sigma.cross_axis(),
            couplings: currents
                .iter()
                .enumerate()
                .map(|(index, current)| Coupling {
                    current,
                    field_nt: found.coupling(index),
                    field_sigma_nt: sigma.coupling(index),
                })
                .collect(),
            // TWOSTEP never has the shift.
            unbiased: request.unbiased || model == "twostep",
            cost_nt4: fit.cost,
            samples: fit.samples,
            iterations: fit.iterations,
            condition: fit.condition,
            norm_error_before_nt: of_norm(&before),
            norm_error_after_nt: of_norm(&after),
            turned_deg: Range::of(
                used.iter().map(|one| before(one).angle(&after(one)).to_degrees()),
            ),
            evidence,
            axes,
            correction: Correction::new(found.correction(request.driver), put_right),
            fit,
            put_right,
        }
    }

    /// The calibrated field of a reading, nT; in Body, where axes were put right.
    pub fn field(&self, measured: &Measured) -> Vector3<f64> {
        self.put_right.apply(Vector3::from(self.fit.field(measured)))
    }
}

impl Correction {
    /// What the flight software takes, with the sensor's axes along these of Body.
    fn new(found: calibration::Correction<f64>, axes: SignedPermutation) -> Self {
        let (calibration::Correction { scale, cross_axis, bias }, rotation) = found.along(axes);
        let exchanged = rotation.angle_rad() > 0.0;
        let alignment_xyzw = exchanged.then(|| rotation.attitude_quaternion());
        Self { scale, cross_axis, bias_nt: bias, alignment_xyzw }
    }

    /// The section as a mission file has it, and as it is uplinked: in single precision.
    pub fn toml(&self) -> String {
        let list = |values: &[f64]| {
            format!("{:?}", values.iter().map(|&value| value as f32).collect::<Vec<_>>())
        };
        let alignment = self
            .alignment_xyzw
            .map_or(String::new(), |xyzw| format!("alignment_xyzw = {}\n", list(&xyzw)));
        let cross_axis = match self.cross_axis == [0.0; 3] {
            true => String::new(),
            false => format!("cross_axis = {}\n", list(&self.cross_axis)),
        };
        format!(
            "[magnetometer.calibration]\nscale = {}\n{cross_axis}bias_nt = {}\n{alignment}",
            list(&self.scale),
            list(&self.bias_nt)
        )
    }
}

/// For a person to read.
impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "model {}, {} samples", self.model, self.samples)?;
        if let (Some(iterations), Some(condition)) = (self.iterations, self.condition) {
            write!(f, ", {iterations} iterations, condition {condition:.1}")?;
        }
        writeln!(f, "\naxis      scale, nT/V                bias, nT")?;
        for (axis, name) in ["x", "y", "z"].iter().enumerate() {
            writeln!(
                f,
                "{name}    {:>10.1} ± {:<8.1}    {:>10.1} ± {:<8.1}",
                self.scale_nt_per_v[axis],
                self.scale_sigma_nt_per_v[axis],
                self.bias_nt[axis],
                self.bias_sigma_nt[axis]
            )?;
        }
        if self.cross_axis != [0.0; 3] {
            for (pair, name) in ["xy", "xz", "yz"].iter().enumerate() {
                let (value, sigma) = (self.cross_axis[pair], self.cross_axis_sigma[pair]);
                writeln!(f, "cross-axis {name}  {value:+.5} ± {sigma:.5}")?;
            }
        }
        for Coupling { current, field_nt: [x, y, z], field_sigma_nt } in &self.couplings {
            let sigma = field_sigma_nt.iter().fold(0.0_f64, |most, &sigma| most.max(sigma));
            writeln!(f, "{current}: {x:.0}, {y:.0}, {z:.0} nT for 1, ± {sigma:.0} at most")?;
        }
        if self.evidence.len() > 1 {
            writeln!(f, "model      unknowns    rms, nT        BIC")?;
            for Judged { model, unknowns, rms_nt, bic } in &self.evidence {
                writeln!(f, "{model:<10} {unknowns:>8} {rms_nt:>10.1} {bic:>10.1}")?;
            }
        }
        for (when, range) in
            [("before", self.norm_error_before_nt), ("after ", self.norm_error_after_nt)]
        {
            let Range { min, max, rms } = range;
            writeln!(f, "|B| - |IGRF| {when}  {min:+.0} to {max:+.0} nT, rms {rms:.0} nT")?;
        }
        let Range { min, max, .. } = self.turned_deg;
        writeln!(f, "the calibration turns the field by {min:.0} to {max:.0} deg")?;
        match &self.axes {
            Some(Naming { axes: Some(axes), as_wired: Some(true), .. }) => {
                writeln!(f, "axes {axes}: as they are wired")?;
            }
            Some(Naming { axes: Some(axes), .. }) => writeln!(
                f,
                "WARNING: Body's x, y, z are the sensor's {axes}, by gyros and torquers"
            )?,
            Some(Naming { open: Some(open), .. }) => writeln!(f, "axes not named: {open}")?,
            _ => {}
        }
        write!(f, "\nFor the mission file:\n\n{}", self.correction.toml())
    }
}
