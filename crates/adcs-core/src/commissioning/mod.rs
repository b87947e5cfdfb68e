//! The commissioning ladder: the satellite finds out what is wrong with itself.
//!
//! | rung | finds | while | rests upon | code |
//! |---|---|---|---|---|
//! | [`Rung::Magnetometer`] | scale, bias, cross-axis terms | the torquers rest | orbit, field model | `magnetometer` |
//! | [`Rung::Polarity`] | wrong signs, exchanged axes, dead torquers | one torquer pulses after the other | magnetometer | [`crate::polarity::ActiveCheck`] |
//! | [`Rung::Coupling`] | the torquers' field at the magnetometer | the same | magnetometer, polarity | `coupling` |
//! | [`Rung::Sun`] | turn between Sun sensors and magnetometer | the torquers rest | magnetometer | `sun` |
//! | [`Rung::Gyro`] | gyro bias | the same | magnetometer | `gyro` |
//! | [`Rung::Dipole`] | residual dipole | the same | magnetometer, gyro | `momentum` |
//! | [`Rung::Inertia`] | inertia ratios | the same | magnetometer, gyro | `momentum` |
//!
//! No loop is closed meanwhile. A rung ends when its σ passes its gate, or when its time is over; what rests upon a
//! rung that failed is not tried. Results stay in [`Findings`], which is what has to be kept over a reset:
//! the ladder goes on with the first rung that has not ended.
//!
//! The magnetometer comes first because all others compare directions of its field. Its own
//! calibration compares strengths, and is blind to signs and axes; so it needs nobody's help. The Sun sensors
//! come before the gyros because Sun and field together tell how the field itself changes along the orbit.
//!
//! Gates and what they are worth: docs/commissioning.

mod coupling;
mod findings;
mod gyro;
mod ladder;
mod magnetometer;
mod momentum;
mod parameters;
mod sun;
mod track;

use crate::frames::{Body, Direction, Eci, MagnetometerAxes, Vector};
use crate::polarity::CheckInputs;
use crate::reading::Reading;

pub use findings::{
    CouplingFound, Ended, Finding, Findings, InertiaFound, MagnetometerFound, Outcome, RUNGS, Rung,
    Shortfall, Three, worst,
};
pub use ladder::{Ladder, LadderReport, LadderState, LadderStep, Told};
pub use parameters::{CommissioningError, CommissioningParameters, Commit, StepTime};

/// What one cycle shows to the ladder.
#[derive(Debug, Clone, Copy)]
pub struct Witnessed {
    /// Clock, phase, rate, and what the torquers carried; the field as it is calibrated now.
    pub devices: CheckInputs,
    /// Field along the magnetometer's axes as its data sheet has it, T, the torquers' field included.
    pub reading: Reading<Vector<MagnetometerAxes>>,
    /// The model's field, T.
    pub reference_field: Option<Vector<Eci>>,
    /// Where the Sun should be, while it shines.
    pub reference_sun: Option<Direction<Eci>>,
    /// Where the Sun sensors see it.
    pub sun: Option<Direction<Body>>,
}
