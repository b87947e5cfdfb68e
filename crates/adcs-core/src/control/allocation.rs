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

/// What gives way when a torquer cannot make what is wanted of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Saturation {
    /// Each axis is clipped on its own: signs are kept, the direction is not.
    ClipAxes,
    /// The whole vector is scaled down: its direction is kept.
    ScaleAll,
}

/// Three torquers along the axes of `TorquerAxes`, and what gives way at their limits.
///
/// **Despin clips.** Clipping an axis keeps the sign of every component, and with it the sign of what
/// each torquer adds to B-dot's damping: for m = clip(k ω × B), each term mᵢ (ω × B)ᵢ of the power
/// −m · (ω × B) keeps its sign, so the power stays negative however much is clipped. Scaling the whole
/// vector would keep its direction but waste the axes that have room left.
///
/// **Pointing scales.** There the torque that is wanted is not opposed to the rate, so a sign that is
/// kept promises nothing: clipping bends m and adds a torque across the wanted one. Scaled by λ the
/// law is for a moment the same law with gains λ K_p, λ K_d, and a magnetic loop with lower gains is
/// stable where the one with higher gains is.
///
/// **A feed-forward comes first.** It cancels a torque that is there; the law has what room is left.
/// So the law's share keeps its signs, or its direction, whatever is fed forward.
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

    /// What a dipole or field in Body is along the torquers' axes.
    pub fn to_torquers(&self, in_body: Vector<Body>) -> Vector<TorquerAxes> {
        self.alignment * in_body
    }

    /// The command that feeds forward as much of `fed` as the torquers can make and gives the rest of
    /// their room to what the law wants (both Body, A·m²). One that is not finite switches the torquers
    /// off.
    pub fn command_beside(
        &self,
        fed: Vector<Body>,
        wanted: Vector<Body>,
        saturation: Saturation,
    ) -> Command {
        let (fed, along) = (self.alignment * fed, self.alignment * wanted);
        if !(fed.is_finite() && along.is_finite()) {
            return Command::off();
        }
        let limit = self.max_dipole_am2;
        let fed = fed.xyz.map(|m| self.clipped(m));
        let share = match saturation {
            Saturation::ClipAxes => 1.0,
            // The largest part λ ≤ 1 with |fed + λ wanted| within the limit on each axis.
            Saturation::ScaleAll => {
                along.xyz.iter().zip(fed.iter()).fold(1.0, |least: f32, (m, fed)| {
                    let room = if *m < 0.0 { limit + fed } else { limit - fed };
                    if m.abs() > room { least.min(room / m.abs()) } else { least }
                })
            }
        };
        let within = fed + along.xyz * share;
        Command {
            dipole: Vector::from_xyz(within.map(|m| self.clipped(m))),
            saturated: (fed + along.xyz).map(|m| m.abs() >= limit).into(),
        }
    }

    /// Not `clamp`, which panics, and prints, should the limit ever be NaN.
    fn clipped(&self, dipole_am2: f32) -> f32 {
        dipole_am2.max(-self.max_dipole_am2).min(self.max_dipole_am2)
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
            dipole: Vector::from_xyz(along.xyz.map(|m| self.clipped(m))),
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

    fn component() -> impl Strategy<Value = f32> {
        -3.0_f32..3.0
    }

    proptest! {
        #[test]
        fn beside_a_feed_forward_clipping_keeps_the_signs_of_the_laws_share(
            wanted in [component(), component(), component()],
            fed in [component(), component(), component()],
        ) {
            let [w, f] = [wanted, fed].map(|[x, y, z]| Vector::new(x, y, z));
            let command = sprout().command_beside(f, w, Saturation::ClipAxes);
            for ((got, want), fed) in command.dipole.to_array().into_iter().zip(wanted).zip(fed) {
                prop_assert!(got.abs() <= LIMIT_AM2);
                prop_assert!((got - fed.clamp(-LIMIT_AM2, LIMIT_AM2)) * want >= 0.0);
            }
        }

        #[test]
        fn beside_a_feed_forward_scaling_keeps_the_direction_of_the_laws_share(
            wanted in [component(), component(), component()],
            fed in [component(), component(), component()],
        ) {
            let [w, f] = [wanted, fed].map(|[x, y, z]| Vector::<Body>::new(x, y, z));
            let command = sprout().command_beside(f, w, Saturation::ScaleAll);
            prop_assert!(command.dipole.xyz.iter().all(|m| m.abs() <= LIMIT_AM2));
            let share = command.dipole.xyz - f.xyz.map(|m| m.clamp(-LIMIT_AM2, LIMIT_AM2));
            // Rounding of differences of 0.6.
            prop_assert!(share.cross(&w.xyz).norm() < 1e-6 * w.norm());
            prop_assert!(share.dot(&w.xyz) >= -1e-6);
        }
    }

    #[test]
    fn scaling_fills_the_torquer_that_has_least_room() {
        let (fed, wanted) = (Vector::new(0.5, 0.0, 0.0), Vector::new(0.2, 0.4, 0.0));
        let command = sprout().command_beside(fed, wanted, Saturation::ScaleAll);
        assert!((command.dipole.xyz - nalgebra::Vector3::new(0.6, 0.2, 0.0)).norm() < 1e-6);
        assert_eq!(command.saturated, [true, false, false]);
        let clipped = sprout().command_beside(fed, wanted, Saturation::ClipAxes);
        assert_eq!(clipped.dipole.to_array(), [0.6, 0.4, 0.0]);
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
            let (bad, zero) = (Vector::new(0.1, bad, 0.1), Vector::zero());
            assert_eq!(sprout().command(bad), Command::off());
            for saturation in [Saturation::ClipAxes, Saturation::ScaleAll] {
                assert_eq!(sprout().command_beside(bad, zero, saturation), Command::off());
                assert_eq!(sprout().command_beside(zero, bad, saturation), Command::off());
            }
        }
    }
}
