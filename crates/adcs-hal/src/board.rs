//! The world as the flight application sees it: one trait, small enough to hold in the head.
//!
//! Everything above this line (sensing, laws, modes, telemetry) is the same on the host, on the
//! emulated core and on the satellite; everything below it is drivers and buses. The trait is
//! admitted by embedded-hal's rule for its own traits: more than one implementation
//! ([`DriverBoard`](crate::driver_board::DriverBoard) over any embedded-hal buses, and the boards of
//! tests and simulations that hand exact readings over) and one generic user, the flight
//! application.

use core::fmt;

use adcs_core::frames::{TorquerAxes, Vector};
use adcs_core::reading::{MissingReason, Reading};
use adcs_core::time::Utc;

use crate::psd_face::FACES;

/// What the sensors said in one cycle, in SI units along each sensor's own axes, by the formula of
/// the data sheet. Alignment, bias and scale are applied later, by `adcs_core::sensing`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Samples {
    /// Angular rate relative to inertial space along the three gyro axes, rad/s.
    pub rate_rad_s: [Reading<f32>; 3],
    /// Magnetic flux density along the three magnetometer axes, T.
    pub field_t: [Reading<f32>; 3],
    /// Photocurrents X1, X2, Y1, Y2 of each Sun sensor, A; `Missing(NotFitted)` on a board without.
    pub sun_a: [Reading<[f32; 4]>; FACES],
}

impl Samples {
    /// What a board without Sun sensors says of them.
    pub const NO_SUN_SENSORS: [Reading<[f32; 4]>; FACES] =
        [Reading::Missing(MissingReason::NotFitted); FACES];
}

/// Why the torquers could not be brought to the state that was asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum TorquerFault {
    /// A dipole was NaN or infinite; all torquers were switched off instead.
    NotFinite,
    /// A pin or timer of this torquer (0, 1, 2) refused; all that could be reached are off.
    Pin {
        /// Which torquer.
        axis: u8,
    },
    /// The line that lets all H-bridges sleep refused; all that could be reached are off.
    Sleep,
}

impl fmt::Display for TorquerFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotFinite => write!(f, "a torquer was commanded a dipole that is not a number"),
            Self::Pin { axis } => write!(f, "a pin of torquer {axis} refused"),
            Self::Sleep => write!(f, "the torquers' common sleep line refused"),
        }
    }
}

impl core::error::Error for TorquerFault {}

/// Sensors, torquers and clock of one satellite.
///
/// # Contract
/// - No method blocks longer than its transfers on the bus take, none panics.
/// - A reading that cannot be trusted is [`Reading::Missing`] with its reason, never a number.
/// - After [`drive`](Board::drive) returns an error no torquer carries current, as far as the pins
///   can be reached.
pub trait Board {
    /// The satellite's clock.
    fn now(&mut self) -> Utc;

    /// Reads every sensor once.
    fn sample(&mut self) -> Samples;

    /// Brings the torquers to `dipole` (A·m², along the torquers' axes) and keeps them there until
    /// the next call. Returns the dipole that the hardware can really make of it: clipped to its
    /// limit and rounded to its steps.
    ///
    /// # Errors
    /// [`TorquerFault`]; the torquers are then off.
    fn drive(&mut self, dipole: Vector<TorquerAxes>) -> Result<Vector<TorquerAxes>, TorquerFault>;
}
