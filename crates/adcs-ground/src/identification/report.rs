//! What was identified, to programs and to people.

use std::fmt;

use adcs_core::identification::momentum::{ALL_UNKNOWNS, MomentumFit, RATIO_UNKNOWNS};
use adcs_core::identification::{IdentificationError, Solution};
use nalgebra::{Matrix3, Vector3};
use serde::Serialize;

/// Something that was found, or the reason why not.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Finding<T> {
    /// What was found.
    Found(T),
    /// What the record does not support.
    Refused {
        /// Why.
        refused: String,
    },
}

impl<T> Finding<T> {
    pub(super) fn of(found: Result<T, IdentificationError>) -> Self {
        match found {
            Ok(found) => Self::Found(found),
            Err(error) => Self::Refused { refused: error.to_string() },
        }
    }

    pub(super) fn map<U>(self, make: impl FnOnce(T) -> U) -> Finding<U> {
        match self {
            Self::Found(found) => Finding::Found(make(found)),
            Self::Refused { refused } => Finding::Refused { refused },
        }
    }
}

/// All of it, as it is written to `OUT.json`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Identification {
    /// Rows that could be used.
    pub rows: usize,
    /// From the first to the last.
    pub duration_s: f64,
    /// The paper's eq. (2).
    pub torque_eq_2: Option<Torque>,
    /// Its eq. (3).
    pub residual_dipole_eq_3: Finding<Dipole>,
    /// The same from the balance of momentum.
    pub residual_dipole: Finding<Dipole>,
    /// What that becomes when something is told a little wrong.
    pub sensitivity: Vec<Sensitivity>,
    /// Tensor with the trace that was told.
    pub inertia: Finding<Tensors>,
    /// What the torquers make of a command.
    pub torquer_gains: Finding<Gains>,
    /// Of the gyros.
    pub gyro_bias: Finding<Bias>,
    /// Of the Sun sensors.
    pub sun_alignment: Finding<Alignment>,
    /// Rows of the paper's table 5.1.
    pub table_5_1: Table51,
}

/// By eq. (2).
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Torque {
    /// Step of the central differences.
    pub difference_s: f64,
    /// Root mean square of an axis.
    pub rms_n_m: f64,
    /// The longest vector.
    pub largest_n_m: f64,
    /// What the gyros' noise alone makes of each axis, 1 sigma.
    pub of_gyro_noise_n_m: [f64; 3],
}

/// A residual dipole, Body.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Dipole {
    /// M.
    pub am2: [f64; 3],
    /// By noise alone.
    pub sigma_am2: [f64; 3],
    /// Condition of its equations.
    pub condition: f64,
    /// What is left of an equation: by momentum the gyros' noise, when the model explains the record.
    pub residual_deg_s: f64,
}

/// What M changes by.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Sensitivity {
    /// What was told so.
    pub told: String,
    /// The change.
    pub change_am2: [f64; 3],
}

/// A tensor, Body.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Tensors {
    /// Row by row; its trace is as told.
    pub kg_m2: [[f64; 3]; 3],
    /// Of xx, yy, xy, xz, yz.
    pub sigma_kg_m2: [f64; 5],
    /// M with this tensor.
    pub residual_dipole_am2: [f64; 3],
    /// Condition of its equations.
    pub condition: f64,
    /// What is left of an equation.
    pub residual_deg_s: f64,
}

/// What the torquers do.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Gains {
    /// True over commanded dipole, row by row: one on the diagonal when they do as they are told.
    pub matrix: [[f64; 3]; 3],
    /// By noise alone.
    pub sigma: [[f64; 3]; 3],
    /// Condition of its equations.
    pub condition: f64,
}

/// Of the gyros.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Bias {
    /// Bias, at `at_c` where there are temperatures.
    pub deg_s: [f64; 3],
    /// By noise alone.
    pub sigma_deg_s: [f64; 3],
    /// Temperature of the bias.
    pub at_c: Option<f64>,
    /// Slope, where there are temperatures.
    pub slope_deg_s_per_c: Option<[f64; 3]>,
    /// By noise alone.
    pub slope_sigma_deg_s_per_c: Option<[f64; 3]>,
}

/// Of the Sun sensors against the magnetometer.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Alignment {
    /// Turn that brings a measured Sun to where it belongs, Body.
    pub turn_deg: [f64; 3],
    /// By noise alone.
    pub sigma_deg: [f64; 3],
}

/// What the paper's table says beside what follows from its own numbers.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Table51 {
    /// |M| in the strongest field of the record; the paper: 5.0e-5.
    pub residual_magnetic_n_m: Option<f64>,
    /// Root mean square by eq. (2).
    pub by_differences_n_m: Option<f64>,
    /// At most, of this tensor at 615 km; the paper: 8.0e-14.
    pub gravity_gradient_n_m: f64,
}

fn three<const N: usize>(values: &nalgebra::SVector<f64, N>, from: usize) -> [f64; 3] {
    [0, 1, 2].map(|axis| values[from + axis])
}

impl Dipole {
    pub(super) fn of(found: &Solution<f64, 3>) -> Self {
        Self {
            am2: found.x.into(),
            sigma_am2: found.sigma().into(),
            condition: found.condition,
            residual_deg_s: found.residual_rms.to_degrees(),
        }
    }
}

impl Tensors {
    pub(super) fn of(
        fit: &MomentumFit<f64, RATIO_UNKNOWNS>,
        found: &Solution<f64, RATIO_UNKNOWNS>,
    ) -> Self {
        let sigma = found.sigma();
        Self {
            kg_m2: fit.tensor(found),
            sigma_kg_m2: [3, 4, 5, 6, 7].map(|index| sigma[index]),
            residual_dipole_am2: three(&found.x, 0),
            condition: found.condition,
            residual_deg_s: found.residual_rms.to_degrees(),
        }
    }
}

impl Gains {
    pub(super) fn of(found: &Solution<f64, ALL_UNKNOWNS>) -> Self {
        // Columns of G; rows of its transpose.
        let matrix = |values: nalgebra::SVector<f64, ALL_UNKNOWNS>| {
            let columns = Matrix3::from_iterator(values.iter().skip(RATIO_UNKNOWNS).copied());
            columns.transpose().into()
        };
        Self { matrix: matrix(found.x), sigma: matrix(found.sigma()), condition: found.condition }
    }
}

impl Bias {
    pub(super) fn constant(found: &Solution<f64, 3>) -> Self {
        Self {
            deg_s: three(&found.x, 0).map(f64::to_degrees),
            sigma_deg_s: three(&found.sigma(), 0).map(f64::to_degrees),
            at_c: None,
            slope_deg_s_per_c: None,
            slope_sigma_deg_s_per_c: None,
        }
    }

    pub(super) fn warm(found: &Solution<f64, 6>, at_c: f64) -> Self {
        Self {
            deg_s: three(&found.x, 0).map(f64::to_degrees),
            sigma_deg_s: three(&found.sigma(), 0).map(f64::to_degrees),
            at_c: Some(at_c),
            slope_deg_s_per_c: Some(three(&found.x, 3).map(f64::to_degrees)),
            slope_sigma_deg_s_per_c: Some(three(&found.sigma(), 3).map(f64::to_degrees)),
        }
    }
}

impl Alignment {
    pub(super) fn of(found: &Solution<f64, 3>) -> Self {
        Self {
            turn_deg: found.x.map(f64::to_degrees).into(),
            sigma_deg: found.sigma().map(f64::to_degrees).into(),
        }
    }
}

/// `name  +0.1234 ± 0.0012  …`; of inertias two digits more.
fn line(
    f: &mut fmt::Formatter<'_>,
    name: &str,
    values: &[f64],
    sigma: &[f64],
    unit: &str,
) -> fmt::Result {
    write!(f, "{name:<26}")?;
    let digits = if unit == "kg m^2" { 6 } else { 4 };
    for (value, sigma) in values.iter().zip(sigma) {
        write!(f, " {value:>+9.digits$} ± {sigma:<8.digits$}")?;
    }
    writeln!(f, " {unit}")
}

fn of_finding<T>(
    f: &mut fmt::Formatter<'_>,
    name: &str,
    finding: &Finding<T>,
    show: impl FnOnce(&mut fmt::Formatter<'_>, &T) -> fmt::Result,
) -> fmt::Result {
    match finding {
        Finding::Found(found) => show(f, found),
        Finding::Refused { refused } => writeln!(f, "{name:<26} not found: {refused}"),
    }
}

/// For a person to read.
impl fmt::Display for Identification {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{} rows, {:.0} s", self.rows, self.duration_s)?;
        for (name, dipole) in [
            ("residual dipole, eq. (3)", &self.residual_dipole_eq_3),
            ("residual dipole, momentum", &self.residual_dipole),
        ] {
            of_finding(f, name, dipole, |f, it| line(f, name, &it.am2, &it.sigma_am2, "A m^2"))?;
        }
        for Sensitivity { told, change_am2: [x, y, z] } in &self.sensitivity {
            writeln!(f, "    {told:<22} {x:>+9.4} {y:>+20.4} {z:>+20.4}")?;
        }
        of_finding(f, "inertia", &self.inertia, |f, it| {
            let [[xx, xy, xz], [_, yy, yz], [_, _, zz]] = it.kg_m2;
            let [s_xx, s_yy, s_xy, s_xz, s_yz] = it.sigma_kg_m2;
            // zz is what xx and yy leave of the trace.
            let s_zz = s_xx.hypot(s_yy);
            line(f, "inertia xx yy zz", &[xx, yy, zz], &[s_xx, s_yy, s_zz], "kg m^2")?;
            line(f, "inertia xy xz yz", &[xy, xz, yz], &[s_xy, s_xz, s_yz], "kg m^2")?;
            let Dipole { sigma_am2, .. } = match &self.residual_dipole {
                Finding::Found(dipole) => *dipole,
                Finding::Refused { .. } => return Ok(()),
            };
            line(f, "  with it, dipole", &it.residual_dipole_am2, &sigma_am2, "A m^2")
        })?;
        of_finding(f, "torquer gains", &self.torquer_gains, |f, it| {
            let rows = it.matrix.iter().zip(&it.sigma).zip(["x", "y", "z"]);
            rows.into_iter().try_for_each(|((row, sigma), axis)| {
                line(f, &format!("torquer gains, row {axis}"), row, sigma, "")
            })
        })?;
        of_finding(f, "gyro bias", &self.gyro_bias, |f, it| {
            line(f, "gyro bias", &it.deg_s, &it.sigma_deg_s, "deg/s")?;
            match (&it.slope_deg_s_per_c, &it.slope_sigma_deg_s_per_c) {
                (Some(slope), Some(sigma)) => {
                    line(f, "gyro slope", slope, sigma, "deg/s per deg C")
                }
                _ => Ok(()),
            }
        })?;
        of_finding(f, "Sun sensors' turn", &self.sun_alignment, |f, it| {
            line(f, "Sun sensors' turn", &it.turn_deg, &it.sigma_deg, "deg")
        })?;
        writeln!(f, "\ntable 5.1, N m                the paper    here")?;
        if let Some(magnetic) = self.table_5_1.residual_magnetic_n_m {
            writeln!(f, "  residual magnetic, at most  5.0e-5       {magnetic:.1e}")?;
        }
        if let Some(Torque { difference_s, rms_n_m, of_gyro_noise_n_m, .. }) = &self.torque_eq_2 {
            let noise = Vector3::from(*of_gyro_noise_n_m).norm() / 3_f64.sqrt();
            writeln!(
                f,
                "  by eq. (2), {difference_s:.1} s, an axis               {rms_n_m:.1e}, gyro noise alone {noise:.1e}"
            )?;
        }
        let gradient = self.table_5_1.gravity_gradient_n_m;
        writeln!(f, "  gravity gradient, at most   8.0e-14      {gradient:.1e}")
    }
}
