//! A three-axis sensor, from its own axes to Body: scale, bias, alignment.
//!
//! A driver speaks SI along the axes in which its chip was soldered in, by the formula of the data
//! sheet. Here, and only here, that becomes a Body vector:
//!
//! v_body = R (C (s ∘ v_sensor) − b)
//!
//! | symbol | code | meaning |
//! |---|---|---|
//! | s | `scale` | correction of each axis' sensitivity, 1 when the data sheet is right |
//! | C | `cross_axis` | symmetric, ones on its diagonal: what one axis takes from another |
//! | b | `bias` | what the scaled axis shows when the true value is zero, in the sensor's SI unit |
//! | R | `alignment` | rotation from the sensor's axes to Body |
//!
//! The paper's eq. (5), B = s V + b, is the same with its s divided by the data sheet's volts-to-field
//! factor and its b of opposite sign.

use core::fmt;

use serde::{Deserialize, Serialize};

use crate::frames::{Body, Rotation, Vector};
use crate::reading::{MissingReason, Reading};

/// The correction of one three-axis sensor as it is stored, uplinked and written in mission files.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct TriadParameters {
    /// Factor on each axis, no unit.
    pub scale: [f32; 3],
    /// c_xy, c_xz, c_yz: what a scaled axis takes from another, no unit.
    pub cross_axis: [f32; 3],
    /// Subtracted after scaling, in the sensor's SI unit (T, rad/s).
    pub bias: [f32; 3],
    /// Attitude quaternion `[q_x, q_y, q_z, q_w]` from the sensor's axes to Body.
    pub alignment_xyzw: [f32; 4],
}

impl Default for TriadParameters {
    /// The data sheet is right and the axes are Body's.
    fn default() -> Self {
        Self {
            scale: [1.0; 3],
            cross_axis: [0.0; 3],
            bias: [0.0; 3],
            alignment_xyzw: [0.0, 0.0, 0.0, 1.0],
        }
    }
}

/// Why parameters of a sensor are refused.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum TriadError {
    /// A scale is zero or not finite.
    Scale {
        /// Axis 0, 1 or 2.
        axis: u8,
        /// What was given.
        found: f32,
    },
    /// A cross-axis term is not below one, where two axes would be the same.
    CrossAxis {
        /// The pair: 0 for xy, 1 for xz, 2 for yz.
        pair: u8,
        /// What was given.
        found: f32,
    },
    /// A bias is not finite.
    Bias {
        /// Axis 0, 1 or 2.
        axis: u8,
        /// What was given.
        found: f32,
    },
    /// The alignment quaternion has no direction.
    Alignment,
}

impl fmt::Display for TriadError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Scale { axis, found } => {
                write!(f, "scale {found} of axis {axis} must be finite and not zero")
            }
            Self::CrossAxis { pair, found } => {
                write!(f, "cross-axis term {found} of pair {pair} must be between -1 and 1")
            }
            Self::Bias { axis, found } => write!(f, "bias {found} of axis {axis} must be finite"),
            Self::Alignment => write!(f, "the alignment quaternion must not be zero"),
        }
    }
}

impl core::error::Error for TriadError {}

/// The accepted correction of one three-axis sensor whose axes are `S`.
#[derive(Debug, Clone, Copy)]
pub struct Triad<S> {
    scale: [f32; 3],
    cross_axis: [f32; 3],
    bias: [f32; 3],
    alignment: Rotation<Body, S>,
}

impl<S> Triad<S> {
    /// Accepts parameters.
    ///
    /// # Errors
    /// [`TriadError`] with the axis and the value; the previous parameters should stay in force.
    pub fn new(parameters: &TriadParameters) -> Result<Self, TriadError> {
        for (axis, (&scale, &bias)) in (0_u8..).zip(parameters.scale.iter().zip(&parameters.bias)) {
            if !scale.is_finite() || scale == 0.0 {
                return Err(TriadError::Scale { axis, found: scale });
            }
            if !bias.is_finite() {
                return Err(TriadError::Bias { axis, found: bias });
            }
        }
        for (pair, &found) in (0_u8..).zip(&parameters.cross_axis) {
            // A NaN fails the comparison.
            let usable = found.abs() < 1.0;
            if !usable {
                return Err(TriadError::CrossAxis { pair, found });
            }
        }
        let alignment = Rotation::from_attitude_quaternion(parameters.alignment_xyzw)
            .ok_or(TriadError::Alignment)?;
        let TriadParameters { scale, cross_axis, bias, .. } = *parameters;
        Ok(Self { scale, cross_axis, bias, alignment })
    }

    /// The measured vector in Body, in the sensor's SI unit; missing when an axis is, or when a
    /// value is not finite.
    pub fn to_body(&self, axes: [Reading<f32>; 3]) -> Reading<Vector<Body>> {
        let raw = match Reading::from_axes(axes) {
            Reading::Fresh([x, y, z]) => Vector::<S>::new(x, y, z),
            Reading::Missing(reason) => return Reading::Missing(reason),
        };
        let [s_x, s_y, s_z] = self.scale;
        let [b_x, b_y, b_z] = self.bias;
        let [xy, xz, yz] = self.cross_axis;
        let (x, y, z) = (s_x * raw.xyz.x, s_y * raw.xyz.y, s_z * raw.xyz.z);
        let corrected: Vector<S> = Vector::new(
            x - b_x + (xy * y + xz * z),
            y - b_y + (xy * x + yz * z),
            z - b_z + (xz * x + yz * y),
        );
        let body = self.alignment * corrected;
        if body.is_finite() {
            Reading::Fresh(body)
        } else {
            Reading::Missing(MissingReason::NotFinite)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frames::MagnetometerAxes;

    fn fresh(values: [f32; 3]) -> [Reading<f32>; 3] {
        values.map(Reading::Fresh)
    }

    #[test]
    fn scale_then_bias_then_alignment() {
        let half = core::f32::consts::FRAC_1_SQRT_2;
        let triad: Triad<MagnetometerAxes> = Triad::new(&TriadParameters {
            scale: [2.0, 1.0, 1.0],
            bias: [0.0, 5.0, 0.0],
            cross_axis: [0.0; 3],
            // Body is yawed by +90 deg from the sensor: sensor y is Body x.
            alignment_xyzw: [0.0, 0.0, half, half],
        })
        .unwrap();
        let body = triad.to_body(fresh([1.0, 15.0, 3.0])).value().unwrap();
        let expected: Vector<Body> = Vector::new(10.0, -2.0, 3.0);
        assert!((body - expected).norm() < 1e-5, "{body:?}");
    }

    #[test]
    fn an_axis_takes_from_the_others_before_the_bias() {
        let triad: Triad<MagnetometerAxes> = Triad::new(&TriadParameters {
            scale: [2.0, 1.0, 1.0],
            cross_axis: [0.5, 0.25, -0.5],
            bias: [1.0, 2.0, 3.0],
            ..Default::default()
        })
        .unwrap();
        let body = triad.to_body(fresh([1.0, 4.0, 8.0])).value().unwrap();
        // C (2, 4, 8) = (2 + 2 + 2, 4 + 1 − 4, 8 + 0.5 − 2)
        let expected: Vector<Body> = Vector::new(5.0, -1.0, 3.5);
        assert!((body - expected).norm() < 1e-5, "{body:?}");
    }

    #[test]
    fn nothing_that_is_not_a_number_passes() {
        let triad: Triad<MagnetometerAxes> = Triad::new(&TriadParameters::default()).unwrap();
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            let reading = triad.to_body(fresh([0.0, bad, 0.0]));
            assert_eq!(reading.missing(), Some(MissingReason::NotFinite));
        }
        // Finite on input, infinite after scaling.
        let steep: Triad<MagnetometerAxes> =
            Triad::new(&TriadParameters { scale: [1e30; 3], ..Default::default() }).unwrap();
        let reading = steep.to_body(fresh([1e30, 0.0, 0.0]));
        assert_eq!(reading.missing(), Some(MissingReason::NotFinite));
    }

    #[test]
    fn impossible_parameters_are_refused_with_their_axis() {
        let scale = TriadParameters { scale: [1.0, 0.0, 1.0], ..Default::default() };
        assert_eq!(
            Triad::<MagnetometerAxes>::new(&scale).unwrap_err(),
            TriadError::Scale { axis: 1, found: 0.0 }
        );
        let skew = TriadParameters { cross_axis: [0.0, 0.0, -1.0], ..Default::default() };
        assert_eq!(
            Triad::<MagnetometerAxes>::new(&skew).unwrap_err(),
            TriadError::CrossAxis { pair: 2, found: -1.0 }
        );
        let none = TriadParameters { alignment_xyzw: [0.0; 4], ..Default::default() };
        assert_eq!(Triad::<MagnetometerAxes>::new(&none).unwrap_err(), TriadError::Alignment);
    }
}
