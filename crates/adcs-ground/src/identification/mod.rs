//! What a record says of the satellite itself.

mod input;
mod report;
mod tensor;

use adcs_core::identification::gyro::GyroBias;
use adcs_core::identification::momentum::MomentumFit;
use adcs_core::identification::sun::SunAlignment;
use adcs_core::identification::torque::{DipoleByDifferences, central_torque, torque_noise};
use adcs_core::identification::{IdentificationError, Noise, Recorded};
use nalgebra::{Matrix3, Vector3};

pub use input::{Columns, Line};
pub use report::{
    Alignment, Bias, Dipole, Finding, Gains, Identification, Sensitivity, Table51, Tensors, Torque,
};
pub use tensor::Tensor;

/// Orbital rate at 615 km, rad/s: for the gravity gradient of table 5.1.
const ORBIT_RATE_RAD_S: f64 = 1.08e-3;
/// Of the sensitivity table: a moment is told so much wrong, and a field.
const OF_A_MOMENT: f64 = 0.01;
const FIELD_BIAS_T: f64 = 1e-6;

/// What is told.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Tensor, Body, kg·m².
    pub inertia_kg_m2: [[f64; 3]; 3],
    /// Between rates whose differences are taken, s.
    pub difference_s: f64,
    /// Of the sensors' readings.
    pub noise: Noise<f64>,
}

/// Identifies whatever the record supports.
///
/// # Errors
/// A tensor or an interval that is none.
pub fn identify(
    lines: &[Line],
    settings: &Settings,
) -> Result<Identification, IdentificationError> {
    let Settings { inertia_kg_m2: inertia, noise, .. } = *settings;
    let records = || lines.iter().map(|line| &line.recorded);

    let mut differences = DipoleByDifferences::new(inertia)?;
    records().for_each(|recorded| differences.add(recorded));
    let mut ratios = MomentumFit::ratios(inertia, noise)?;
    records().for_each(|recorded| ratios.add(recorded));
    let mut gains = MomentumFit::ratios_and_gains(inertia, noise)?;
    records().for_each(|recorded| gains.add(recorded));

    let residual_dipole = Finding::of(dipole(lines, inertia, noise, Vector3::zeros())?)
        .map(|found| Dipole::of(&found));
    let torque_eq_2 = torque(lines, settings);
    let table_5_1 = table_5_1(lines, settings, &residual_dipole, &torque_eq_2);
    Ok(Identification {
        rows: lines.len(),
        duration_s: lines.iter().map(|line| line.recorded.dt_s).sum(),
        sensitivity: sensitivity(lines, settings)?,
        torque_eq_2,
        residual_dipole_eq_3: Finding::of(differences.solve()).map(|found| Dipole::of(&found)),
        inertia: Finding::of(ratios.solve()).map(|found| Tensors::of(&ratios, &found)),
        torquer_gains: Finding::of(gains.solve()).map(|found| Gains::of(&found)),
        gyro_bias: gyro_bias(lines, settings),
        sun_alignment: sun_alignment(lines),
        residual_dipole,
        table_5_1,
    })
}

type Solved<const N: usize> =
    Result<adcs_core::identification::Solution<f64, N>, IdentificationError>;

/// By momentum, with this added to every field.
fn dipole(
    lines: &[Line],
    inertia: [[f64; 3]; 3],
    noise: Noise<f64>,
    bias: Vector3<f64>,
) -> Result<Solved<3>, IdentificationError> {
    let mut fit = MomentumFit::dipole(inertia, noise)?;
    for line in lines {
        let field_t = line.recorded.field_t.map(|field| (Vector3::from(field) + bias).into());
        fit.add(&Recorded { field_t, ..line.recorded });
    }
    Ok(fit.solve())
}

/// What the dipole becomes when something is told a little wrong.
fn sensitivity(
    lines: &[Line],
    settings: &Settings,
) -> Result<Vec<Sensitivity>, IdentificationError> {
    let Settings { inertia_kg_m2: inertia, noise, .. } = *settings;
    let Ok(found) = dipole(lines, inertia, noise, Vector3::zeros())? else {
        return Ok(Vec::new());
    };
    let mut table = Vec::new();
    let mut add = |told: String, moved: Solved<3>| {
        if let Ok(moved) = moved {
            table.push(Sensitivity { told, change_am2: (moved.x - found.x).into() });
        }
    };
    for (axis, name) in ["xx", "yy", "zz"].iter().enumerate() {
        let mut told = inertia;
        told[axis][axis] *= 1.0 + OF_A_MOMENT;
        let moved = dipole(lines, told, noise, Vector3::zeros())?;
        add(format!("inertia {name} {:+.0} %", 100.0 * OF_A_MOMENT), moved);
    }
    for (axis, name) in ["x", "y", "z"].iter().enumerate() {
        let mut bias = Vector3::zeros();
        bias[axis] = FIELD_BIAS_T;
        let moved = dipole(lines, inertia, noise, bias)?;
        add(format!("field bias {name} {:+.0} nT", FIELD_BIAS_T * 1e9), moved);
    }
    Ok(table)
}

/// Torque by eq. (2), from rates so far apart.
fn torque(lines: &[Line], settings: &Settings) -> Option<Torque> {
    let mut rates: Vec<(f64, [f64; 3])> = Vec::new();
    for line in lines {
        // Decimal fractions of a second are not exact.
        let due = rates.last().is_none_or(|(t, _)| line.t_s - t >= 0.999 * settings.difference_s);
        if due {
            rates.push((line.t_s, line.recorded.rate_rad_s));
        }
    }
    let (mut squares, mut largest, mut count, mut span) = (0.0, 0.0_f64, 0.0, 0.0);
    for at in rates.windows(3) {
        let dt = (at[2].0 - at[0].0) / 2.0;
        let rates = [at[0].1, at[1].1, at[2].1];
        let Some(torque) = central_torque(settings.inertia_kg_m2, rates, dt) else { continue };
        let norm = Vector3::from(torque).norm();
        squares += norm * norm;
        largest = largest.max(norm);
        count += 1.0;
        span += dt;
    }
    (count > 0.0).then(|| Torque {
        difference_s: span / count,
        rms_n_m: (squares / (3.0 * count)).sqrt(),
        largest_n_m: largest,
        of_gyro_noise_n_m: torque_noise(
            settings.inertia_kg_m2,
            settings.noise.rate_rad_s,
            span / count,
        ),
    })
}

/// The rows of the paper's table 5.1 that this record can say something of.
fn table_5_1(
    lines: &[Line],
    settings: &Settings,
    dipole: &Finding<Dipole>,
    torque: &Option<Torque>,
) -> Table51 {
    let fields = lines.iter().filter_map(|line| line.recorded.field_t);
    let strongest_t = fields.fold(0.0_f64, |most, field| most.max(Vector3::from(field).norm()));
    let moments = Matrix3::from(settings.inertia_kg_m2).symmetric_eigenvalues();
    Table51 {
        residual_magnetic_n_m: match dipole {
            Finding::Found(dipole) => Some(Vector3::from(dipole.am2).norm() * strongest_t),
            Finding::Refused { .. } => None,
        },
        by_differences_n_m: torque.map(|torque| torque.rms_n_m),
        gravity_gradient_n_m: 1.5
            * ORBIT_RATE_RAD_S.powi(2)
            * (moments.max() - moments.min()).max(0.0),
    }
}

fn gyro_bias(lines: &[Line], settings: &Settings) -> Finding<Bias> {
    let temperatures: Vec<f64> = lines.iter().filter_map(|line| line.temperature_c).collect();
    let coldest = temperatures.iter().copied().fold(f64::INFINITY, f64::min);
    let warmest = temperatures.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if temperatures.len() == lines.len() && warmest > coldest {
        let reference_c = (coldest + warmest) / 2.0;
        let mut fit = GyroBias::with_temperature(settings.noise, reference_c);
        for line in lines {
            fit.add(&line.recorded, line.temperature_c.unwrap_or(reference_c), None);
        }
        return Finding::of(fit.solve()).map(|found| Bias::warm(&found, reference_c));
    }
    let mut fit = GyroBias::constant(settings.noise);
    lines.iter().for_each(|line| fit.add(&line.recorded, 0.0, None));
    Finding::of(fit.solve()).map(|found| Bias::constant(&found))
}

fn sun_alignment(lines: &[Line]) -> Finding<Alignment> {
    let mut fit = SunAlignment::default();
    for line in lines {
        if let (Some((sun, cosine)), Some(field)) = (line.sun, line.recorded.field_t) {
            fit.add(sun, field, cosine);
        }
    }
    Finding::of(fit.solve()).map(|found| Alignment::of(&found))
}
