//! What stage III works with.

use crate::attitude::selection::Determination;
use crate::control::periodic::Gains;
use crate::frames::{Body, Direction, Eci, Vector};
use crate::orbit::OrbitState;
use crate::reading::Reading;

/// What stages I and II and the sensors say.
#[derive(Debug, Clone, Copy)]
pub struct Known<'a> {
    /// Where the satellite is.
    pub orbit: Option<&'a OrbitState>,
    /// Where the Sun is from there.
    pub sun: Option<Direction<Eci>>,
    /// Rate as the gyros show it, rad/s.
    pub omega_bi: Reading<Vector<Body>>,
    /// Field as the magnetometer shows it, T.
    pub field_b: Reading<Vector<Body>>,
    /// What stage II believes.
    pub determination: Option<&'a Determination>,
    /// The model's field, T.
    pub reference_field: Option<Vector<Eci>>,
    /// Of the law that plans, for now.
    pub gains: Option<Gains>,
}
