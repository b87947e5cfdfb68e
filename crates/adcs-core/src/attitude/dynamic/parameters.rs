//! What the dynamics-aided filter is told, beyond what the MEKF is told about the same sensors.

use core::fmt;

use nalgebra::{Matrix3, RealField, convert};
use serde::{Deserialize, Serialize};

use super::block::Blocks;
use crate::attitude::mekf::MekfParameters;

/// The filter's tuning as it is stored and uplinked. Sensors are described by [`MekfParameters`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct DynamicParameters<T> {
    /// Noise of the sensors, gates and limits, as the MEKF knows them.
    pub sensors: MekfParameters<T>,
    /// Which states fly.
    pub blocks: Blocks,
    /// The inertia tensor as well as it is known before flight, Body, kg·m²; entries of the tensor as
    /// they stand.
    pub inertia_kg_m2: [[T; 3]; 3],
    /// σ of each moment of inertia, in units of the mean moment.
    pub moment_prior: T,
    /// σ of each product of inertia, in units of the mean moment.
    pub product_prior: T,
    /// Residual dipole as well as it is known before flight, Body, A·m².
    pub dipole_am2: [T; 3],
    /// σ of the residual dipole before anything is known of it, each axis, A·m².
    pub dipole_prior_am2: T,
    /// How the residual dipole walks, each axis, A·m² per √s.
    pub dipole_walk_am2_per_sqrt_s: T,
    /// σ of what the residual dipole jumps by when the satellite enters or leaves the shadow, each
    /// axis, A·m²: panels switch their currents.
    pub dipole_step_am2: T,
    /// The torque of unknown cause.
    pub torque: TorqueNoise<T>,
}

/// Torque of unknown cause: a first-order Gauss–Markov process whose size the filter finds out.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct TorqueNoise<T> {
    /// Smallest σ of each axis that is ever believed, N·m.
    pub smallest_n_m: T,
    /// σ of each axis before anything is known, N·m.
    pub start_n_m: T,
    /// Largest σ of each axis, N·m.
    pub largest_n_m: T,
    /// Correlation time, s.
    pub correlation_s: T,
    /// Over how long σ is averaged, s.
    pub memory_s: T,
}

impl<T: RealField + Copy> Default for DynamicParameters<T> {
    /// SPROUT's assumed inertia, 8 % of the moments and 5 % in the products uncertain; a dipole of which
    /// nothing is known but that it is below 1 A·m².
    ///
    /// Torque: drag and solar pressure make 6e-9 to 2.5e-7 N·m of such a satellite (docs/paper), a field
    /// model that is 60 to 100 nT wrong 3e-8 to 9e-8 N·m with a dipole of 0.4 to 0.9 A·m², both within
    /// minutes.
    fn default() -> Self {
        let value = convert::<f64, T>;
        Self {
            sensors: MekfParameters::default(),
            blocks: Blocks { inertia: true, torque: true },
            inertia_kg_m2: [
                [value(0.05184), value(0.00058), value(-0.00077)],
                [value(0.00058), value(0.05416), value(0.00069)],
                [value(-0.00077), value(0.00069), value(0.05978)],
            ],
            moment_prior: value(0.08),
            product_prior: value(0.05),
            dipole_am2: [T::zero(); 3],
            dipole_prior_am2: value(0.5),
            dipole_walk_am2_per_sqrt_s: value(1e-5),
            dipole_step_am2: value(0.006),
            torque: TorqueNoise {
                smallest_n_m: value(2e-8),
                start_n_m: value(8e-8),
                largest_n_m: value(2e-6),
                correlation_s: value(300.0),
                memory_s: value(400.0),
            },
        }
    }
}

/// Why parameters are refused; what was in force stays.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum DynamicError {
    /// A parameter of the sensors.
    Sensors(crate::attitude::mekf::MekfError),
    /// The inertia tensor is not symmetric, not positive definite, or not finite.
    Inertia,
    /// A number outside its range.
    OutOfRange {
        /// Which.
        name: &'static str,
        /// What was given.
        found: f64,
        /// The smallest that is accepted.
        from: f64,
        /// The largest that is accepted.
        to: f64,
    },
}

impl fmt::Display for DynamicError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Sensors(error) => write!(f, "{error}"),
            Self::Inertia => write!(f, "the inertia tensor must be symmetric and positive definite"),
            Self::OutOfRange { name, found, from, to } => {
                write!(f, "{name} is {found:e}, it must be from {from:e} to {to:e}")
            }
        }
    }
}

impl core::error::Error for DynamicError {}

impl<T: RealField + Copy> DynamicParameters<T> {
    /// Whether the filter can work with this.
    pub(super) fn check(&self) -> Result<(), DynamicError> {
        self.sensors.check().map_err(DynamicError::Sensors)?;
        let tensor = self.inertia();
        let physical = tensor.iter().all(|entry| entry.is_finite())
            && tensor == tensor.transpose()
            && tensor.cholesky().is_some();
        if !physical {
            return Err(DynamicError::Inertia);
        }
        let TorqueNoise { smallest_n_m, start_n_m, largest_n_m, correlation_s, memory_s } = self.torque;
        let [m_x, m_y, m_z] = self.dipole_am2;
        for (name, found, from, to) in [
            ("the mean moment of inertia", self.mean_moment(), 1e-6, 1e4),
            ("the prior of the moments of inertia", self.moment_prior, 0.0, 0.3),
            ("the prior of the products of inertia", self.product_prior, 0.0, 0.3),
            ("the residual dipole along x", m_x, -100.0, 100.0),
            ("the residual dipole along y", m_y, -100.0, 100.0),
            ("the residual dipole along z", m_z, -100.0, 100.0),
            ("the prior of the residual dipole", self.dipole_prior_am2, 1e-4, 100.0),
            ("the walk of the residual dipole", self.dipole_walk_am2_per_sqrt_s, 0.0, 1.0),
            ("the step of the residual dipole", self.dipole_step_am2, 0.0, 10.0),
            ("the smallest unknown torque", smallest_n_m, 1e-10, 1e-3),
            ("the unknown torque at the start", start_n_m, 1e-10, 1e-3),
            ("the largest unknown torque", largest_n_m, 1e-10, 1e-3),
            ("the unknown torque's correlation time", correlation_s, 1.0, 1e6),
            ("the memory for the unknown torque", memory_s, 10.0, 1e6),
        ] {
            let found: f64 = nalgebra::try_convert(found).unwrap_or(f64::NAN);
            if !(from..=to).contains(&found) {
                return Err(DynamicError::OutOfRange { name, found, from, to });
            }
        }
        Ok(())
    }

    /// The given tensor.
    pub(super) fn inertia(&self) -> Matrix3<T> {
        let [[xx, xy, xz], [yx, yy, yz], [zx, zy, zz]] = self.inertia_kg_m2;
        Matrix3::new(xx, xy, xz, yx, yy, yz, zx, zy, zz)
    }

    /// A third of the trace: the unit of the parameters of inertia, kg·m².
    pub(super) fn mean_moment(&self) -> T {
        self.inertia().trace() / convert(3.0)
    }
}
