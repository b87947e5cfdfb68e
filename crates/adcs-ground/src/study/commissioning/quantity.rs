//! What was found, beside what is true.

use adcs_core::commissioning::{Finding, Three};
use nalgebra::{Matrix3, Vector3};

use super::super::closed_loop::{ClosedLoop, Truth};
use super::super::sprout::INERTIA_KG_M2;

/// What is found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// Scales of the magnetometer.
    Scale,
    /// Its cross-axis terms.
    CrossAxis,
    /// Its biases, T.
    FieldBias,
    /// What torquers add to it, T per A·m².
    Coupling,
    /// Gyro bias, rad/s.
    GyroBias,
    /// Turn of the Sun sensors, rad.
    SunTurn,
    /// Residual dipole, A·m².
    Dipole,
    /// Inertia ratios, kg·m².
    Inertia,
}

impl Quantity {
    /// All of them.
    pub const ALL: [Self; 8] = [
        Self::Scale,
        Self::CrossAxis,
        Self::FieldBias,
        Self::Coupling,
        Self::GyroBias,
        Self::SunTurn,
        Self::Dipole,
        Self::Inertia,
    ];

    /// What it is called in tables, its unit there, and that unit in SI.
    pub fn shown(self) -> (&'static str, &'static str, f64) {
        const DEG: f64 = core::f64::consts::PI / 180.0;
        match self {
            Self::Scale => ("magnetometer scale", "%", 1e-2),
            Self::CrossAxis => ("magnetometer cross-axis", "%", 1e-2),
            Self::FieldBias => ("magnetometer bias", "nT", 1e-9),
            Self::Coupling => ("torquer coupling", "µT/(A·m²)", 1e-6),
            Self::GyroBias => ("gyro bias", "deg/s", DEG),
            Self::SunTurn => ("Sun sensor turn", "deg", DEG),
            Self::Dipole => ("residual dipole", "A·m²", 1.0),
            Self::Inertia => ("inertia ratios", "1e-3 kg·m²", 1e-3),
        }
    }
}

/// One number that was found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Found {
    /// Of what.
    pub quantity: Quantity,
    /// Found less true.
    pub error: f64,
    /// As reported.
    pub sigma: f64,
}

impl Found {
    /// Whether the truth is inside the reported 2 σ.
    pub fn is_inside(&self) -> bool {
        self.error.abs() <= 2.0 * self.sigma
    }
}

/// Every number of a finding.
pub(super) fn found(finding: &Finding, satellite: &ClosedLoop, truth: &Truth) -> Vec<Found> {
    let flaws = satellite.flaws();
    let three = |quantity, found: &Three, truth: Vector3<f64>| {
        let of = |axis: usize| Found {
            quantity,
            error: f64::from(found.value[axis]) - truth[axis],
            sigma: f64::from(found.sigma[axis]),
        };
        [of(0), of(1), of(2)]
    };
    let nine = |quantity, value: &[[f32; 3]; 3], sigma: &[[f32; 3]; 3], truth: Matrix3<f64>| {
        let at = |(r, c): (usize, usize)| Found {
            quantity,
            error: f64::from(value[r][c]) - truth[(r, c)],
            sigma: f64::from(sigma[r][c]),
        };
        (0..9).map(|k| (k / 3, k % 3)).map(at).collect::<Vec<_>>()
    };
    // What turns the satellite shows M and J in proportion to each other: the trace is as told.
    let inertia = satellite.inertia();
    let told = [0, 1, 2].map(|i| INERTIA_KG_M2[i][i]).iter().sum::<f64>();
    let share = told / inertia.trace();
    match finding {
        Finding::Magnetometer(it) => {
            let mut all = three(Quantity::Scale, &it.scale, flaws.scale).to_vec();
            // Zero σ: not asked for by the readings.
            if it.cross_axis.sigma != [0.0; 3] {
                all.extend(three(Quantity::CrossAxis, &it.cross_axis, flaws.cross_axis));
            }
            all.extend(three(Quantity::FieldBias, &it.bias_t, flaws.bias_t));
            all
        }
        Finding::Coupling(it) => {
            let truth = flaws.coupling * satellite.torquers();
            nine(Quantity::Coupling, &it.t_per_am2, &it.sigma_t_per_am2, truth)
        }
        Finding::Gyro(it) => three(Quantity::GyroBias, it, truth.gyro_bias).to_vec(),
        Finding::Sun(it) => three(Quantity::SunTurn, it, flaws.sun_turn).to_vec(),
        Finding::Dipole(it) => three(Quantity::Dipole, it, truth.dipole * share).to_vec(),
        Finding::Inertia(it) => {
            let all = nine(Quantity::Inertia, &it.tensor_kg_m2, &it.sigma_kg_m2, inertia * share);
            // The tensor is symmetric: each product once.
            [0, 1, 2, 4, 5, 8].into_iter().filter_map(|k| all.get(k).copied()).collect()
        }
    }
}
