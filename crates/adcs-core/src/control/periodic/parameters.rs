//! What the law is told: its weights, its horizon and the satellite's inertia.

use core::fmt;

use nalgebra::{Matrix3, RealField, convert, convert_unchecked};
use serde::{Deserialize, Serialize};

use super::plan::NODES;
use crate::parameter::{self, OutOfRange};

/// The law as stored and uplinked.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PeriodicParameters<T = f32> {
    /// e₀: the error of attitude that weighs as much as ω₀ and m₀, rad.
    pub attitude_weight_rad: T,
    /// ω₀, rad/s.
    pub rate_weight_rad_s: T,
    /// m₀, A·m².
    pub dipole_weight_am2: T,
    /// Step of the sweep, s.
    pub step_s: T,
    /// How far the sweep looks ahead, s.
    pub horizon_s: T,
    /// J, Body, kg·m².
    pub inertia_kg_m2: [[T; 3]; 3],
}

impl<T: RealField + Copy> Default for PeriodicParameters<T> {
    /// The weights and the horizon of an independent study of SPROUT (docs/pointing): 5 deg, 0.05 deg/s,
    /// 0.01 A·m² (0.003 to 0.03 makes no difference), a little less than two orbits; SPROUT's assumed
    /// inertia.
    fn default() -> Self {
        let value = convert::<f64, T>;
        let deg = core::f64::consts::PI / 180.0;
        Self {
            attitude_weight_rad: value(5.0 * deg),
            rate_weight_rad_s: value(0.05 * deg),
            dipole_weight_am2: value(0.01),
            step_s: value(120.0),
            horizon_s: value(10_800.0),
            inertia_kg_m2: [
                [value(0.05184), value(0.00058), value(-0.00077)],
                [value(0.00058), value(0.05416), value(0.00069)],
                [value(-0.00077), value(0.00069), value(0.05978)],
            ],
        }
    }
}

/// Why parameters are refused; what was in force stays.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum PeriodicError {
    /// The inertia tensor is not symmetric, not positive definite, or not finite.
    Inertia,
    /// A number outside its range.
    OutOfRange(OutOfRange),
}

impl fmt::Display for PeriodicError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Inertia => {
                write!(f, "the inertia tensor must be symmetric and positive definite")
            }
            Self::OutOfRange(error) => error.fmt(f),
        }
    }
}

impl core::error::Error for PeriodicError {}

impl From<OutOfRange> for PeriodicError {
    fn from(error: OutOfRange) -> Self {
        Self::OutOfRange(error)
    }
}

impl<T: RealField + Copy> PeriodicParameters<T> {
    /// Whether the law can work with this; its inertia tensor, and the inverse.
    pub(super) fn check(&self) -> Result<[Matrix3<T>; 2], PeriodicError> {
        // The sweep keeps NODES of them, and looks further than it keeps.
        let kept = convert_unchecked::<T, f64>(self.step_s) * (NODES - 1) as f64;
        parameter::check(&[
            ("attitude_weight_rad", self.attitude_weight_rad, 1e-3, 1.0),
            ("rate_weight_rad_s", self.rate_weight_rad_s, 1e-6, 1.0),
            ("dipole_weight_am2", self.dipole_weight_am2, 1e-6, 1e3),
            ("step_s", self.step_s, 10.0, 240.0),
            ("horizon_s", self.horizon_s, kept, 16.0 * kept),
        ])?;
        parameter::inertia(self.inertia_kg_m2).ok_or(PeriodicError::Inertia)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    type Change = fn(&mut PeriodicParameters<f32>);

    fn refused(change: Change) -> Option<PeriodicError> {
        let mut parameters = PeriodicParameters::default();
        change(&mut parameters);
        parameters.check().err()
    }

    #[test]
    fn the_default_is_accepted() {
        assert_eq!(refused(|_| ()), None);
    }

    #[test]
    fn what_no_satellite_flies_is_refused_by_name() {
        let changes: [(Change, &str); 7] = [
            (|p| p.attitude_weight_rad = f32::NAN, "attitude_weight_rad"),
            // Degrees.
            (|p| p.attitude_weight_rad = 5.0, "attitude_weight_rad"),
            (|p| p.rate_weight_rad_s = -1.0, "rate_weight_rad_s"),
            (|p| p.dipole_weight_am2 = 0.0, "dipole_weight_am2"),
            (|p| p.step_s = 600.0, "step_s"),
            (|p| p.horizon_s = 600.0, "horizon_s"),
            (|p| p.horizon_s = f32::INFINITY, "horizon_s"),
        ];
        for (change, expected) in changes {
            match refused(change) {
                Some(PeriodicError::OutOfRange(error)) => assert_eq!(error.name, expected),
                other => panic!("{expected}: {other:?}"),
            }
        }
        for change in [
            (|p| p.inertia_kg_m2[0][1] = 0.01) as Change,
            |p| p.inertia_kg_m2[0][0] = -0.05,
            |p| p.inertia_kg_m2[2][2] = f32::NAN,
        ] {
            assert_eq!(refused(change), Some(PeriodicError::Inertia));
        }
    }
}
