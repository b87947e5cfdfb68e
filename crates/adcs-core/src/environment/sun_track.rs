//! The Sun in every cycle for the price of the formula once an hour.

use core::num::NonZeroU16;

use super::sun::ApparentSun;
use crate::frames::{Eci, Vector};
use crate::nodes::{Grid, NodePair};
use crate::time::{LeapSeconds, TimeScaleError, Utc};

/// The spacing of the nodes, s.
pub const SPACING_S: NonZeroU16 = NonZeroU16::new(3_600).unwrap();

/// The Sun's position by the formula of [`ApparentSun`] at every full hour UTC, on a straight line
/// between.
///
/// A straight line departs from an arc by at most h²/8 of the acceleration: with h = 3600 s and the
/// Sun's fastest motion of 2.06e-7 rad/s that is 6.9e-8 rad or 4e-6 deg, a thousandth of the
/// formula's own error. A call evaluates the formula twice after a jump in time, once in a new
/// hour, and otherwise not at all; the result does not depend on what was asked for before.
#[derive(Debug, Clone, Copy)]
pub struct SunTrack {
    leap_seconds: LeapSeconds,
    grid: Grid,
}

/// The hours in use: what a [`SunTrack`] carries from one call to the next. `Default` has none. To
/// be set back to that when the table of leap seconds is exchanged (kept, it would be 1e-5 deg old
/// for an hour).
#[derive(Debug, Clone, Copy, Default)]
pub struct SunNodes {
    held: Option<NodePair<Vector<Eci, f64>>>,
}

impl SunTrack {
    /// The Sun, with Terrestrial Time by this table.
    pub fn new(leap_seconds: LeapSeconds) -> Self {
        Self { leap_seconds, grid: Grid::new(Utc::from_micros_since_2000(0), SPACING_S) }
    }

    /// The Sun's centre from the Earth's at `now`, m.
    ///
    /// # Errors
    /// [`TimeScaleError::UtcBefore1972`].
    pub fn position_m(
        &self,
        nodes: &mut SunNodes,
        now: Utc,
    ) -> Result<Vector<Eci, f64>, TimeScaleError> {
        let (index, u) = self.grid.place(now);
        let pair = NodePair::at(index, nodes.held, |node| {
            let tt = self.grid.instant(node).to_tt(&self.leap_seconds)?;
            Ok(ApparentSun::at(tt).position_eci_m())
        })?;
        nodes.held = Some(pair);
        Ok(pair.left + (pair.right - pair.left) * u)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::time::{MICROS_PER_DAY, MICROS_PER_SECOND};
    use proptest::prelude::*;

    /// The bound of the doc comment, with a tenth for the changing speed.
    const CHORD_BOUND_RAD: f64 = 7.6e-8;

    #[test]
    fn the_sun_between_full_hours_is_where_the_formula_has_it() {
        let (track, mut nodes) = (SunTrack::new(LeapSeconds::BUILT_IN), SunNodes::default());
        let mut worst_rad = 0.0_f64;
        for step in 0..20_000_i64 {
            let now = Utc::from_micros_since_2000(
                9_000 * MICROS_PER_DAY + step * 1_777 * MICROS_PER_SECOND,
            );
            let found = track.position_m(&mut nodes, now).unwrap();
            let sun = ApparentSun::at(now.to_tt(&LeapSeconds::BUILT_IN).unwrap());
            let truth = sun.position_eci_m();
            worst_rad = worst_rad.max((found - truth).norm() / truth.norm());
        }
        assert!(
            worst_rad < CHORD_BOUND_RAD && worst_rad > 0.5 * CHORD_BOUND_RAD,
            "{worst_rad} rad"
        );
    }

    #[test]
    fn before_1972_there_is_no_sun_and_later_there_is_again() {
        let (track, mut nodes) = (SunTrack::new(LeapSeconds::BUILT_IN), SunNodes::default());
        let early = Utc::parse("1971-06-01T00:00:00Z").unwrap();
        let refused = track.position_m(&mut nodes, early);
        assert_eq!(refused, Err(TimeScaleError::UtcBefore1972 { utc: early }));
        assert!(track.position_m(&mut nodes, Utc::from_micros_since_2000(0)).is_ok());
    }

    proptest! {
        #[test]
        fn the_sun_does_not_depend_on_what_was_asked_before(
            hours in prop::collection::vec(0_i64..200_000, 1..20), micros in 0_i64..3_600_000_000,
        ) {
            let (track, mut nodes) = (SunTrack::new(LeapSeconds::BUILT_IN), SunNodes::default());
            for hour in hours {
                let now = Utc::from_micros_since_2000(hour * 3_600_000_000 + micros);
                let fresh = track.position_m(&mut SunNodes::default(), now);
                prop_assert_eq!(track.position_m(&mut nodes, now), fresh);
            }
        }
    }
}
