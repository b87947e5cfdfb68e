//! What a satellite on the commissioning ladder found out about itself.

use std::fmt;

use adcs_app::LawParameters;
use adcs_core::commissioning::{Ended, Finding, Findings, Three};
use adcs_core::control::cross_product::CrossProductParameters;
use adcs_core::modes::{Cause, Mode};
use serde::Serialize;

use super::rows::Row;
use crate::mission::Mission;

const DEG: f64 = core::f64::consts::PI / 180.0;

/// The climb.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Climb {
    /// Rung by rung, as they ended.
    pub rungs: Vec<RungAt>,
    /// When the results were put in force, ms since the start.
    pub committed_ms: Vec<u64>,
    /// All that was found, as the satellite keeps it.
    #[serde(skip)]
    pub findings: Findings,
}

/// A rung that ended.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RungAt {
    /// When, ms since the start.
    pub time_ms: u64,
    /// Which.
    pub rung: String,
    /// Whether it passed its gate, and if not, why.
    pub outcome: String,
    /// What was found.
    pub found: Vec<Number>,
}

/// A number, how well it is known, and its unit.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Number {
    /// What it is.
    pub name: String,
    /// Its value.
    pub value: f64,
    /// Its σ.
    pub sigma: f64,
    /// Of both.
    pub unit: &'static str,
}

/// The climb of a flight; `None` when there was none.
pub fn climb(rows: &[Row]) -> Option<Climb> {
    let mut climb =
        Climb { rungs: Vec::new(), committed_ms: Vec::new(), findings: Findings::default() };
    for row in rows {
        let time_ms = (row.time_s * 1e3).round() as u64;
        let transition = row.mode.and_then(|report| report.transition);
        if transition.is_some_and(|it| it.to == Mode::Commissioning && it.cause != Cause::Resumed) {
            climb.findings.retry();
        }
        if let Some(ended) = row.commissioning.and_then(|report| report.ended) {
            climb.findings.take(&ended);
            climb.rungs.push(rung_at(time_ms, &ended));
        }
        if row.committed {
            climb.committed_ms.push(time_ms);
        }
    }
    (!climb.rungs.is_empty()).then_some(climb)
}

fn rung_at(time_ms: u64, ended: &Ended) -> RungAt {
    RungAt {
        time_ms,
        rung: ended.rung.to_string(),
        outcome: ended.outcome.to_string(),
        found: ended.finding.as_ref().map(numbers).unwrap_or_default(),
    }
}

fn numbers(finding: &Finding) -> Vec<Number> {
    let number = |name: String, (value, sigma): (f32, f32), (unit, si): (&'static str, f64)| {
        Number { name, value: f64::from(value) / si, sigma: f64::from(sigma) / si, unit }
    };
    let three = |what: &str, axes: [&str; 3], it: &Three, unit| {
        let pairs = it.value.into_iter().zip(it.sigma);
        let named = axes.into_iter().zip(pairs);
        named.map(|(axis, pair)| number(format!("{what} {axis}"), pair, unit)).collect::<Vec<_>>()
    };
    let (xyz, pairs) = (["x", "y", "z"], ["xy", "xz", "yz"]);
    let nine = |what: &str, value: &[[f32; 3]; 3], sigma: &[[f32; 3]; 3], unit| {
        let at = |r: usize, c: usize| {
            let name = format!("{what} {}{}", xyz[r], xyz[c]);
            number(name, (value[r][c], sigma[r][c]), unit)
        };
        (0..9).map(|k| at(k / 3, k % 3)).collect::<Vec<_>>()
    };
    match finding {
        Finding::Magnetometer(it) => [
            three("scale", xyz, &it.scale, ("", 1.0)),
            three("cross-axis", pairs, &it.cross_axis, ("", 1.0)),
            three("bias", xyz, &it.bias_t, ("nT", 1e-9)),
        ]
        .concat(),
        Finding::Coupling(it) => {
            nine("coupling", &it.t_per_am2, &it.sigma_t_per_am2, ("nT/(A·m²)", 1e-9))
        }
        Finding::Gyro(it) => three("bias", xyz, it, ("deg/s", DEG)),
        Finding::Sun(it) => three("turn about", xyz, it, ("deg", DEG)),
        Finding::Dipole(it) => three("dipole", xyz, it, ("A·m²", 1.0)),
        Finding::Inertia(it) => {
            let all = nine("inertia", &it.tensor_kg_m2, &it.sigma_kg_m2, ("kg·m²", 1.0));
            // Each product once.
            [0, 4, 8, 1, 2, 5].into_iter().filter_map(|k| all.get(k).cloned()).collect()
        }
    }
}

impl Climb {
    /// What passed its gates, as a mission that builds on the one that was flown: the same satellite, which knows
    /// this of itself from the start.
    pub fn toml(&self, flown: &Mission) -> String {
        let flight = &flown.scenario.flight;
        let next = flight.committed(&self.findings);
        let scaled = |values: [f32; 3], unit: f64| values.map(|v| f64::from(v) / unit);
        let mut text = String::from(
            "# What the satellite found out about itself, put in force: a mission that `adcs fly` takes. For a mission\n\
             # of your own, take over the sections from [magnetometer.calibration] on.\n",
        );
        if let Some(file) = flown.files.first() {
            let file = file.canonicalize().unwrap_or_else(|_| file.clone());
            text += &format!("base = {}\n", quoted(&file.display().to_string()));
        }
        let about = "The satellite knows from the start what it found out about itself on the way.";
        text += &format!(
            "\n[mission]\ntitle = {}\ndescription = {}\n",
            quoted(&format!("Commissioned: {}", flown.title)),
            quoted(about),
        );
        if flight.modes.is_some_and(|modes| modes.table.start == Mode::Commissioning) {
            text += "\n[modes]\nstart = \"detumble\"\n";
        }
        text += &format!(
            "\n[magnetometer.calibration]\nscale = {:?}\ncross_axis = {:?}\nbias_nt = {:?}\n\n\
             [gyro.calibration]\nscale = {:?}\nbias_deg_s = {:?}\n",
            next.magnetometer.scale,
            next.magnetometer.cross_axis,
            scaled(next.magnetometer.bias, 1e-9),
            next.gyro.scale,
            scaled(next.gyro.bias, DEG),
        );
        if let Some(faces) = &next.sun_sensors {
            let faces = faces.faces.each_ref().map(|face| face.alignment_xyzw);
            text += &format!("\n[sun_sensors.calibration]\nalignment_xyzw = {faces:?}\n");
        }
        if let Some(attitude) = &next.attitude {
            let told = &attitude.dynamics;
            text += &format!(
                "\n[attitude]\nfield_calibration_nt = {:?}\ngyro_bias_prior_deg_s = {:?}\n\
                 residual_dipole_am2 = {:?}\nresidual_dipole_prior_am2 = {:?}\ninertia_kg_m2 = {:?}\n\
                 inertia_product_prior = {:?}\n",
                f64::from(told.sensors.field_noise.calibration_t) / 1e-9,
                f64::from(told.sensors.bias_prior_rad_s) / DEG,
                told.dipole_am2,
                told.dipole_prior_am2,
                told.inertia_kg_m2,
                told.product_prior,
            );
        }
        if let LawParameters::CrossProduct {
            law: CrossProductParameters { inertia_kg_m2, .. },
            ..
        }
        | LawParameters::Periodic {
            unplanned: CrossProductParameters { inertia_kg_m2, .. },
            ..
        } = next.law
        {
            text += &format!("\n[law]\ninertia_kg_m2 = {inertia_kg_m2:?}\n");
        }
        text
    }
}

/// A string as TOML has it.
fn quoted(text: &str) -> String {
    toml::Value::from(text).to_string()
}

impl fmt::Display for Number {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { name, value, sigma, unit } = self;
        // Two digits of σ.
        let decimals =
            if *sigma > 0.0 { (1.0 - sigma.log10().floor()).clamp(0.0, 9.0) } else { 6.0 };
        let decimals = decimals as usize;
        write!(f, "{name} {value:.decimals$} ± {sigma:.decimals$} {unit}")
    }
}
