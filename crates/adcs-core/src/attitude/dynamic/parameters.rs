//! What the dynamics-aided filter is told, beyond what the MEKF is told about the same sensors.

use core::fmt;

use nalgebra::{Matrix3, RealField, convert, convert_unchecked};
use serde::{Deserialize, Serialize};

use super::block::Blocks;
use crate::attitude::mekf::MekfParameters;
use crate::parameter::{self, OutOfRange};

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
    /// axis, A·m²: panels switch their currents. With [`Blocks::shadow`] it is the prior of what is
    /// learned instead.
    pub dipole_step_am2: T,
    /// How slowly that jump comes and goes, s: the satellite cools and warms. Nobody knows this lag
    /// before flight, so the jump is learned in two parts, one with a short lag and one with a long one,
    /// which between them make any other. For [`Blocks::shadow`].
    pub shadow_lags_s: [T; 2],
    /// σ of the magnetometer's bias before anything is known of it, each axis, T. For
    /// [`Blocks::field_bias`].
    pub field_bias_prior_t: T,
    /// White torque noise, each axis, N·m √s: what no state of the filter follows.
    pub white_torque_n_m_sqrt_s: T,
    /// How wrong the inertia tensor is taken to be where its parameters do not fly, as a share of the
    /// mean moment: the white torque of a tumble grows by (ε J)² |ω|³.
    pub inertia_allowance: T,
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
            blocks: Blocks { inertia: true, torque: true, ..Blocks::NONE },
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
            shadow_lags_s: [value(60.0), value(500.0)],
            field_bias_prior_t: value(600e-9),
            white_torque_n_m_sqrt_s: value(0.0),
            inertia_allowance: value(0.0),
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
    /// The inertia tensor is not symmetric, not positive definite, or not finite.
    Inertia,
    /// A number outside its range.
    OutOfRange(OutOfRange),
}

impl fmt::Display for DynamicError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Inertia => {
                write!(f, "the inertia tensor must be symmetric and positive definite")
            }
            Self::OutOfRange(error) => error.fmt(f),
        }
    }
}

impl core::error::Error for DynamicError {}

impl From<OutOfRange> for DynamicError {
    fn from(error: OutOfRange) -> Self {
        Self::OutOfRange(error)
    }
}

impl<T: RealField + Copy> DynamicParameters<T> {
    /// Whether the filter can work with this.
    pub(super) fn check(&self) -> Result<(), DynamicError> {
        self.sensors.check()?;
        parameter::inertia(self.inertia_kg_m2).ok_or(DynamicError::Inertia)?;
        let TorqueNoise { smallest_n_m, start_n_m, largest_n_m, correlation_s, memory_s } =
            self.torque;
        let [m_x, m_y, m_z] = self.dipole_am2;
        let [soon, late] = self.shadow_lags_s;
        let [smallest, largest] = [smallest_n_m, largest_n_m].map(convert_unchecked::<T, f64>);
        parameter::check(&[
            ("inertia_kg_m2, its mean moment", self.mean_moment(), 1e-6, 1e4),
            ("moment_prior", self.moment_prior, 0.0, 0.3),
            ("product_prior", self.product_prior, 0.0, 0.3),
            ("dipole_am2[0]", m_x, -100.0, 100.0),
            ("dipole_am2[1]", m_y, -100.0, 100.0),
            ("dipole_am2[2]", m_z, -100.0, 100.0),
            ("dipole_prior_am2", self.dipole_prior_am2, 1e-4, 100.0),
            ("dipole_walk_am2_per_sqrt_s", self.dipole_walk_am2_per_sqrt_s, 0.0, 1.0),
            ("dipole_step_am2", self.dipole_step_am2, 0.0, 10.0),
            ("shadow_lags_s[0]", soon, 0.0, 1e4),
            ("shadow_lags_s[1]", late, 0.0, 1e4),
            ("field_bias_prior_t", self.field_bias_prior_t, 1e-12, 1e-4),
            ("white_torque_n_m_sqrt_s", self.white_torque_n_m_sqrt_s, 0.0, 1e-3),
            ("inertia_allowance", self.inertia_allowance, 0.0, 0.5),
            ("torque.smallest_n_m", smallest_n_m, 1e-10, 1e-3),
            ("torque.largest_n_m", largest_n_m, smallest, 1e-3),
            ("torque.start_n_m", start_n_m, smallest, largest),
            ("torque.correlation_s", correlation_s, 1.0, 1e6),
            ("torque.memory_s", memory_s, 10.0, 1e6),
        ])?;
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

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(change: impl FnOnce(&mut DynamicParameters<f32>)) -> Option<DynamicError> {
        let mut parameters = DynamicParameters::default();
        change(&mut parameters);
        parameters.check().err()
    }

    fn refused_name(change: impl FnOnce(&mut DynamicParameters<f32>)) -> Option<&'static str> {
        match refused(change)? {
            DynamicError::OutOfRange(error) => Some(error.name),
            DynamicError::Inertia => Some("inertia"),
        }
    }

    #[test]
    fn the_default_is_accepted_in_both_precisions() {
        assert_eq!(DynamicParameters::<f32>::default().check(), Ok(()));
        assert_eq!(DynamicParameters::<f64>::default().check(), Ok(()));
    }

    #[test]
    fn impossible_values_are_refused_by_name() {
        type Field = fn(&mut DynamicParameters<f32>) -> &mut f32;
        let fields: [(Field, &str); 18] = [
            (|p| &mut p.moment_prior, "moment_prior"),
            (|p| &mut p.product_prior, "product_prior"),
            (|p| &mut p.dipole_am2[0], "dipole_am2[0]"),
            (|p| &mut p.dipole_am2[1], "dipole_am2[1]"),
            (|p| &mut p.dipole_am2[2], "dipole_am2[2]"),
            (|p| &mut p.dipole_prior_am2, "dipole_prior_am2"),
            (|p| &mut p.dipole_walk_am2_per_sqrt_s, "dipole_walk_am2_per_sqrt_s"),
            (|p| &mut p.dipole_step_am2, "dipole_step_am2"),
            (|p| &mut p.shadow_lags_s[0], "shadow_lags_s[0]"),
            (|p| &mut p.shadow_lags_s[1], "shadow_lags_s[1]"),
            (|p| &mut p.field_bias_prior_t, "field_bias_prior_t"),
            (|p| &mut p.white_torque_n_m_sqrt_s, "white_torque_n_m_sqrt_s"),
            (|p| &mut p.inertia_allowance, "inertia_allowance"),
            (|p| &mut p.torque.smallest_n_m, "torque.smallest_n_m"),
            (|p| &mut p.torque.start_n_m, "torque.start_n_m"),
            (|p| &mut p.torque.largest_n_m, "torque.largest_n_m"),
            (|p| &mut p.torque.correlation_s, "torque.correlation_s"),
            (|p| &mut p.torque.memory_s, "torque.memory_s"),
        ];
        for (field, name) in fields {
            for bad in [f32::NAN, f32::INFINITY, -1e9] {
                assert_eq!(refused_name(|p| *field(p) = bad), Some(name), "{bad}");
            }
        }
        // A forgotten factor of 1e6: micronewton metres.
        let start = refused_name(|p| p.torque.start_n_m = 0.08);
        assert_eq!(start, Some("torque.start_n_m"));
        // No walk, no step and a tensor that is known are possible.
        assert_eq!(refused(|p| p.dipole_walk_am2_per_sqrt_s = 0.0), None);
        assert_eq!(refused(|p| p.dipole_step_am2 = 0.0), None);
        assert_eq!(refused(|p| (p.moment_prior, p.product_prior) = (0.0, 0.0)), None);
    }

    #[test]
    fn the_unknown_torque_is_between_its_limits_from_the_start() {
        let start = refused_name(|p| p.torque.start_n_m = 1e-8);
        assert_eq!(start, Some("torque.start_n_m"), "below the smallest");
        let start = refused_name(|p| p.torque.start_n_m = 3e-6);
        assert_eq!(start, Some("torque.start_n_m"), "above the largest");
        let largest = refused_name(|p| p.torque.largest_n_m = 1e-8);
        assert_eq!(largest, Some("torque.largest_n_m"), "below the smallest");
    }

    #[test]
    fn what_is_no_inertia_is_refused() {
        let inertia = Some(DynamicError::Inertia);
        assert_eq!(refused(|p| p.inertia_kg_m2[0][1] = 0.001), inertia, "not symmetric");
        assert_eq!(refused(|p| p.inertia_kg_m2[1][1] = -0.05), inertia);
        for bad in [f32::NAN, f32::INFINITY] {
            assert_eq!(refused(|p| p.inertia_kg_m2[2][2] = bad), inertia);
        }
        // Grams and square millimetres.
        let name = refused_name(|p| p.inertia_kg_m2.iter_mut().flatten().for_each(|j| *j *= 1e9));
        assert_eq!(name, Some("inertia_kg_m2, its mean moment"));
    }

    #[test]
    fn what_the_mekf_refuses_is_refused() {
        let name = refused_name(|p| p.sensors.gyro_noise_rad_s = f32::NAN);
        assert_eq!(name, Some("gyro_noise_rad_s"));
    }
}
