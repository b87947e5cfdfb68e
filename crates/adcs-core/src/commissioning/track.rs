//! From cycle to cycle: when the gyro spoke last, what the torquers did meanwhile, and since when they
//! rest.

use nalgebra::Vector3;

use super::Witnessed;
use crate::attitude::{Method, Observation};
use crate::frames::{Body, Direction, Eci, Rotation, Vector};
use crate::identification::Recorded;
use crate::reading::Reading;
use crate::time::Utc;

/// A gap that is longer breaks a record, s.
const LONGEST_GAP_S: f32 = 20.0;
/// σ of a direction in the attitude that is made of field and Sun, rad: both count alike.
const DIRECTION_SIGMA_RAD: f32 = 0.02;

/// What one cycle leaves for the next. `Default` has seen none.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Track {
    last: Option<Utc>,
    since_gyro_s: f32,
    /// ∫ m dt since the gyro spoke, A·m²·s.
    carried: Vector3<f32>,
    rest_s: f32,
}

/// An instant at which the gyro spoke.
#[derive(Debug, Clone, Copy)]
pub(super) struct Instant {
    /// Since the last one, s; zero after a gap.
    pub dt_s: f32,
    /// Rate, Body, rad/s.
    pub rate: Vector3<f32>,
    /// Mean dipole of the torquers since the last one, Body, A·m².
    pub dipole: Vector3<f32>,
    /// What they carry now, Body, A·m².
    pub carried: Vector3<f32>,
}

/// What one cycle adds.
#[derive(Debug, Clone, Copy)]
pub(super) struct Passed {
    /// Since the last cycle, s.
    pub dt_s: f32,
    /// Whether the torquers' field has died away.
    pub rests: bool,
    /// When the gyro spoke.
    pub instant: Option<Instant>,
}

impl Track {
    /// Takes a cycle in; the torquers' field dies away in `settle_s`.
    pub fn pass(&mut self, seen: &Witnessed, settle_s: f32) -> Passed {
        let now = seen.devices.now;
        let dt_s = self.last.map_or(0.0, |last| now.seconds_since(last) as f32);
        // A clock that was set back breaks the record too.
        let broken = self.last.is_some() && !(0.0..=LONGEST_GAP_S).contains(&dt_s);
        if broken {
            *self = Self::default();
        }
        let dt_s = if broken { 0.0 } else { dt_s };
        self.last = Some(now);
        let carried = seen.devices.carried.xyz;
        self.rest_s = if carried == Vector3::zeros() { self.rest_s + dt_s } else { 0.0 };
        self.since_gyro_s += dt_s;
        self.carried += carried * dt_s;
        let instant = possible(seen.devices.omega_bi, FASTEST_RAD_S).map(|rate| {
            let dt_s = if self.since_gyro_s <= LONGEST_GAP_S { self.since_gyro_s } else { 0.0 };
            let dipole = if dt_s > 0.0 { self.carried / dt_s } else { carried };
            (self.since_gyro_s, self.carried) = (0.0, Vector3::zeros());
            Instant { dt_s, rate: rate.xyz, dipole, carried }
        });
        Passed { dt_s, rests: self.rest_s >= settle_s, instant }
    }
}

impl Instant {
    /// As the identification takes it.
    pub fn recorded(&self, field: Option<Vector<Body>>) -> Recorded<f32> {
        Recorded {
            dt_s: self.dt_s,
            rate_rad_s: self.rate.into(),
            field_t: field.map(|field| field.to_array()),
            dipole_am2: self.dipole.into(),
        }
    }
}

/// Fastest rate that a gyro reports, each axis, rad/s (as the MEKF's limit).
const FASTEST_RAD_S: f32 = 5.2;
/// Largest field that a magnetometer shows, each axis, T: that of the Earth, of a torquer beside it, and its own bias.
pub(super) const STRONGEST_T: f32 = 1e-3;

/// Sine of the angle between Sun and field below which an attitude is not coarse, but none: errors about
/// the two are divided by it.
const LEAST_SINE: f32 = 0.3;

/// Attitude from field and Sun of this instant; `None` in the dark, or where the two are nearly parallel.
pub(super) fn attitude(
    (field, reference_field): (Vector<Body>, Vector<Eci>),
    (sun, reference_sun): (Direction<Body>, Direction<Eci>),
) -> Option<Rotation<Body, Eci>> {
    let (b, s) = (reference_field.direction()?.vector(), reference_sun.vector());
    if b.cross(&s).norm() < LEAST_SINE {
        return None;
    }
    let field = Observation::new(field, reference_field, DIRECTION_SIGMA_RAD).ok()?;
    let sun = Observation::new(sun.vector(), reference_sun.vector(), DIRECTION_SIGMA_RAD).ok()?;
    let found = Method::QMethod.solve(&[field, sun]).ok()?;
    Some(found.attitude)
}

/// A reading that is there, and no larger on any axis than such a sensor can show.
pub(super) fn possible<F>(reading: Reading<Vector<F>>, largest: f32) -> Option<Vector<F>> {
    // A NaN fails the comparison.
    reading.value().filter(|it| it.xyz.iter().all(|axis| axis.abs() <= largest))
}
