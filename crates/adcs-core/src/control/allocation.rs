//! From the dipole that a law wants to what three torquers can make.

use core::fmt;

use serde::{Deserialize, Serialize};

use crate::frames::{Body, Rotation, TorquerAxes, Vector};

/// Limit and mounting of the three torquers as stored and uplinked.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct TorquerParameters {
    /// Largest dipole of each torquer, A·m² (SPROUT: 0.6 at 210 mA).
    pub max_dipole_am2: f32,
    /// Attitude quaternion `[q_x, q_y, q_z, q_w]` from Body to the torquers' axes.
    pub alignment_xyzw: [f32; 4],
}

/// Why torquer parameters are refused.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum AllocationError {
    /// The limit must be positive and finite.
    MaxDipole {
        /// What was given, A·m².
        found: f32,
    },
    /// The alignment quaternion has no direction.
    Alignment,
}

impl fmt::Display for AllocationError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::MaxDipole { found } => {
                write!(f, "the largest dipole, {found} A·m², must be positive and finite")
            }
            Self::Alignment => write!(f, "the alignment quaternion must not be zero"),
        }
    }
}

impl core::error::Error for AllocationError {}

/// What the torquers are asked for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Command {
    /// Dipole along the torquers' axes, A·m², within the limit on each of them.
    pub dipole: Vector<TorquerAxes>,
    /// Which axes stood at the limit.
    pub saturated: [bool; 3],
}

impl Command {
    /// All torquers off.
    pub fn off() -> Self {
        Self { dipole: Vector::zero(), saturated: [false; 3] }
    }
}

/// Three torquers along the axes of `TorquerAxes`, each clipped on its own.
///
/// Clipping an axis keeps the sign of every component, and with it the sign of what each torquer
/// adds to B-dot's damping: for m = clip(k ω × B), each term mᵢ (ω × B)ᵢ of the power −m · (ω × B)
/// keeps its sign, so the power stays negative however much is clipped. Scaling the whole vector
/// would keep its direction but waste the axes that have room left.
#[derive(Debug, Clone, Copy)]
pub struct Allocation {
    max_dipole_am2: f32,
    alignment: Rotation<TorquerAxes, Body>,
}

impl Allocation {
    /// Accepts limit and mounting.
    ///
    /// # Errors
    /// [`AllocationError`] with the value.
    pub fn new(parameters: &TorquerParameters) -> Result<Self, AllocationError> {
        let TorquerParameters { max_dipole_am2, alignment_xyzw } = *parameters;
        if !(max_dipole_am2.is_finite() && max_dipole_am2 > 0.0) {
            return Err(AllocationError::MaxDipole { found: max_dipole_am2 });
        }
        let alignment =
            Rotation::from_attitude_quaternion(alignment_xyzw).ok_or(AllocationError::Alignment)?;
        Ok(Self { max_dipole_am2, alignment })
    }

    /// What a dipole along the torquers' axes is in Body, A·m².
    pub fn to_body(&self, dipole: Vector<TorquerAxes>) -> Vector<Body> {
        self.alignment.inverse() * dipole
    }

    /// The command that comes closest, axis by axis, to the wanted dipole (Body, A·m²). A wanted
    /// dipole that is not finite switches the torquers off.
    pub fn command(&self, wanted: Vector<Body>) -> Command {
        let along = self.alignment * wanted;
        if !along.is_finite() {
            return Command::off();
        }
        let limit = self.max_dipole_am2;
        Command {
            dipole: Vector::from_xyz(along.xyz.map(|m| m.clamp(-limit, limit))),
            saturated: along.to_array().map(|m| m.abs() >= limit),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const LIMIT_AM2: f32 = 0.6;

    fn sprout() -> Allocation {
        let alignment_xyzw = [0.0, 0.0, 0.0, 1.0];
        Allocation::new(&TorquerParameters { max_dipole_am2: LIMIT_AM2, alignment_xyzw }).unwrap()
    }

    proptest! {
        #[test]
        fn no_axis_ever_passes_the_limit(wanted in [any::<f32>(), any::<f32>(), any::<f32>()]) {
            let [x, y, z] = wanted;
            let command = sprout().command(Vector::new(x, y, z));
            prop_assert!(command.dipole.xyz.iter().all(|m| m.abs() <= LIMIT_AM2));
        }

        #[test]
        fn clipping_keeps_the_sign_of_each_axis(wanted in [-3.0_f32..3.0, -3.0_f32..3.0, -3.0_f32..3.0]) {
            let [x, y, z] = wanted;
            let command = sprout().command(Vector::new(x, y, z));
            for (got, want) in command.dipole.to_array().into_iter().zip(wanted) {
                prop_assert!(got * want >= 0.0);
            }
        }
    }

    #[test]
    fn what_is_clipped_is_said() {
        let command = sprout().command(Vector::new(0.7, -0.2, -9.0));
        assert_eq!(command.dipole.to_array(), [0.6, -0.2, -0.6]);
        assert_eq!(command.saturated, [true, false, true]);
    }

    #[test]
    fn a_wish_that_is_not_a_number_is_off() {
        for bad in [f32::NAN, f32::INFINITY] {
            assert_eq!(sprout().command(Vector::new(0.1, bad, 0.1)), Command::off());
        }
    }
}
