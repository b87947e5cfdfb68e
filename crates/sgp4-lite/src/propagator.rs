//! The propagator: everything precomputed, then a state for any time.

#[cfg(feature = "deep-space")]
use crate::deep_space::{DeepSpace, ResonanceState};
use crate::mean_orbit::MeanOrbit;
use crate::near_earth::NearEarth;
use crate::{Elements, Error};
use core::f64::consts::TAU;

/// From this period on an orbit is propagated with SDP4.
const DEEP_SPACE_PERIOD_MIN: f64 = 225.0;

/// Minutes from the epoch of the elements; negative before it.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct MinutesSinceEpoch(pub f64);

/// Position and velocity in TEME of date (true equator, mean equinox).
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct State {
    /// Position, km.
    pub position_km: [f64; 3],
    /// Velocity, km/s.
    pub velocity_km_s: [f64; 3],
}

/// The orbit of one satellite, ready to be evaluated.
///
/// Building it does all that can be done once; [`propagate`](Self::propagate) is a pure function of
/// time. It holds no reference and no hidden state.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Propagator {
    theory: Theory,
}

/// The constants of one theory or the other. There is no heap to put the larger one on.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "deep-space", expect(clippy::large_enum_variant))]
enum Theory {
    NearEarth(NearEarth),
    #[cfg(feature = "deep-space")]
    DeepSpace(DeepSpace),
}

impl Theory {
    #[cfg(feature = "deep-space")]
    fn deep_space(orbit: MeanOrbit, elements: &Elements) -> Result<Self, Error> {
        let bstar = elements.bstar_per_earth_radius;
        DeepSpace::new(orbit, bstar, elements.epoch).map(Self::DeepSpace)
    }

    #[cfg(not(feature = "deep-space"))]
    fn deep_space(orbit: MeanOrbit, _: &Elements) -> Result<Self, Error> {
        Err(Error::DeepSpace { period_min: TAU / orbit.mean_motion })
    }
}

impl Propagator {
    /// A propagator for these elements.
    ///
    /// # Errors
    /// [`Error::Element`] when an element is not finite or out of range, [`Error::DeepSpace`] when
    /// the period is 225 minutes or more and the feature `deep-space` is off, and
    /// [`Error::DragModel`] when the orbit makes the drag model divide by zero.
    pub fn new(elements: &Elements) -> Result<Self, Error> {
        if let Some((element, value)) = elements.out_of_range() {
            return Err(Error::Element { element, value });
        }
        let orbit = MeanOrbit::new(elements);
        let period_min = TAU / orbit.mean_motion;
        let theory = if period_min < DEEP_SPACE_PERIOD_MIN {
            Theory::NearEarth(NearEarth::new(orbit, elements.bstar_per_earth_radius)?)
        } else {
            Theory::deep_space(orbit, elements)?
        };
        Ok(Self { theory })
    }

    /// Position and velocity (TEME) at a time.
    ///
    /// # Errors
    /// [`Error::Time`] when the time is not finite; otherwise when the theory has no state at this
    /// time, see [`Error`].
    pub fn propagate(&self, time: MinutesSinceEpoch) -> Result<State, Error> {
        let t = finite(time)?;
        match &self.theory {
            Theory::NearEarth(near_earth) => near_earth.propagate(t),
            #[cfg(feature = "deep-space")]
            Theory::DeepSpace(deep_space) => {
                deep_space.propagate(t, &mut ResonanceState::default())
            }
        }
    }

    /// [`propagate`](Self::propagate), faster for resonant deep-space orbits when times follow each
    /// other.
    ///
    /// `resume` holds where the integration stands, from one call to the next; the result does not
    /// depend on it. Give each propagator its own.
    ///
    /// # Errors
    /// Those of [`propagate`](Self::propagate).
    #[cfg(feature = "deep-space")]
    pub fn propagate_resumed(
        &self,
        time: MinutesSinceEpoch,
        resume: &mut ResonanceState,
    ) -> Result<State, Error> {
        let t = finite(time)?;
        match &self.theory {
            Theory::NearEarth(near_earth) => near_earth.propagate(t),
            Theory::DeepSpace(deep_space) => deep_space.propagate(t, resume),
        }
    }
}

fn finite(time: MinutesSinceEpoch) -> Result<f64, Error> {
    let MinutesSinceEpoch(minutes_since_epoch) = time;
    if minutes_since_epoch.is_finite() {
        Ok(minutes_since_epoch)
    } else {
        Err(Error::Time { minutes_since_epoch })
    }
}
