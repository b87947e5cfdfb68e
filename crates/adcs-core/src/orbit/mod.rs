//! Where the satellite is: SGP4 in this crate's units and time.

pub mod frame;
pub mod interpolated;

use sgp4_lite::{Elements, MinutesSinceEpoch, Propagator};

use crate::frames::{Eci, Vector};
use crate::time::Utc;

/// Metres in a kilometre: SGP4 speaks km, everything above it m.
const M_PER_KM: f64 = 1e3;
/// Microseconds in a minute: SGP4 speaks minutes.
const MICROS_PER_MINUTE: f64 = 60e6;

/// Position and velocity of the satellite.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OrbitState {
    /// Position from the Earth's centre, Eci (TEME), m.
    pub position: Vector<Eci, f64>,
    /// Velocity, Eci (TEME), m/s.
    pub velocity: Vector<Eci, f64>,
}

/// An accepted set of mean elements, ready to be propagated.
#[derive(Debug, Clone)]
pub struct OrbitModel {
    propagator: Propagator,
    epoch: Utc,
    identity: u32,
}

impl OrbitModel {
    /// Accepts mean elements.
    ///
    /// # Errors
    /// Those of [`Propagator::new`]: elements that SGP4 cannot start from.
    pub fn new(elements: &Elements) -> Result<Self, sgp4_lite::Error> {
        let epoch = elements.epoch;
        Ok(Self {
            propagator: Propagator::new(elements)?,
            epoch: Utc::from_day(epoch.days_since_j2000_midnight(), epoch.micros_of_day()),
            identity: identity(elements),
        })
    }

    /// The instant at which the elements hold.
    pub fn epoch(&self) -> Utc {
        self.epoch
    }

    /// A number that tells these elements from others: the CRC-32 of everything that moves the
    /// satellite.
    pub fn identity(&self) -> u32 {
        self.identity
    }

    /// Position and velocity at `now`.
    ///
    /// # Errors
    /// Those of [`Propagator::propagate`]: elements that have drifted out of the theory's range.
    pub fn state(&self, now: Utc) -> Result<OrbitState, sgp4_lite::Error> {
        let minutes = now.micros_since(self.epoch) as f64 / MICROS_PER_MINUTE;
        let state = self.propagator.propagate(MinutesSinceEpoch(minutes))?;
        let [x, y, z] = state.position_km;
        let [vx, vy, vz] = state.velocity_km_s;
        Ok(OrbitState {
            position: Vector::new(x, y, z) * M_PER_KM,
            velocity: Vector::new(vx, vy, vz) * M_PER_KM,
        })
    }
}

fn identity(elements: &Elements) -> u32 {
    const CRC: crc::Crc<u32, crc::NoTable> = crc::Crc::<u32, _>::new(&crc::CRC_32_ISO_HDLC);
    let mut digest = CRC.digest();
    digest.update(&elements.epoch.days_since_j2000_midnight().to_le_bytes());
    digest.update(&elements.epoch.micros_of_day().to_le_bytes());
    let numbers = [
        elements.mean_motion_rev_per_day,
        elements.eccentricity,
        elements.inclination_deg,
        elements.raan_deg,
        elements.argument_of_perigee_deg,
        elements.mean_anomaly_deg,
        elements.bstar_per_earth_radius,
    ];
    for number in numbers {
        digest.update(&number.to_bits().to_le_bytes());
    }
    digest.finalize()
}
