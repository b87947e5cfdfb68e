//! A sensor that repeats itself to the last bit has stopped measuring.
//!
//! A chip, a converter's input or a bus buffer that hangs gives one plausible number for ever. No filter
//! sees that while the satellite moves slowly: a gyro stuck near zero is a gyro at rest, and in eclipse it
//! leads the attitude astray for as long as it lasts. What gives it away is that the noise is gone: with a
//! noise of a few steps of the converter (SPROUT's gyro 4, magnetometer 15), an axis repeats its code once
//! in ten or more.
//!
//! Each axis is watched by itself, on what the driver gave: after calibration a frozen axis would hide among
//! the others.

use crate::reading::{MissingReason, Reading};

/// So many readings in a row that are the same to the last bit are no chance: 1e-40 for the gyro.
const REPEATS: u8 = 40;

/// The last reading of each of three axes and how often it has come back. `Default` is power-on.
#[derive(Debug, Clone, Copy, Default)]
pub struct Frozen {
    axes: [Option<Repeated>; 3],
}

#[derive(Debug, Clone, Copy)]
struct Repeated {
    value: f32,
    times: u8,
}

impl Frozen {
    /// The readings of one cycle, with those of a frozen axis [`Missing`](Reading::Missing) as
    /// [`MissingReason::Frozen`]. A reading that is missing already stays as it is, and does not count: a
    /// sensor that comes back with its old value has measured nothing in between.
    pub fn screen(&mut self, axes: [Reading<f32>; 3]) -> [Reading<f32>; 3] {
        let mut screened = axes;
        for (reading, last) in screened.iter_mut().zip(&mut self.axes) {
            let Reading::Fresh(value) = *reading else { continue };
            let times = match last {
                Some(last) if last.value == value => last.times.saturating_add(1),
                _ => 0,
            };
            *last = Some(Repeated { value, times });
            if times >= REPEATS {
                *reading = Reading::Missing(MissingReason::Frozen);
            }
        }
        screened
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BUS: Reading<f32> = Reading::Missing(MissingReason::Bus);
    const FROZEN: Reading<f32> = Reading::Missing(MissingReason::Frozen);

    fn cycle(frozen: &mut Frozen, y: Reading<f32>, cycle: u16) -> Reading<f32> {
        // The neighbours measure.
        let x = Reading::Fresh(f32::from(cycle) * 1e-3);
        let [x_screened, screened, z_screened] = frozen.screen([x, y, BUS]);
        assert_eq!((x_screened, z_screened), (x, BUS));
        screened
    }

    #[test]
    fn an_axis_that_repeats_itself_is_frozen_until_it_moves() {
        let (mut frozen, stuck) = (Frozen::default(), Reading::Fresh(0.02));
        for k in 0..u16::from(REPEATS) {
            assert_eq!(cycle(&mut frozen, stuck, k), stuck);
        }
        for k in 0..300 {
            assert_eq!(cycle(&mut frozen, stuck, k), FROZEN);
        }
        let moved = Reading::Fresh(0.020_1);
        assert_eq!(cycle(&mut frozen, moved, 0), moved);
        assert_eq!(cycle(&mut frozen, moved, 1), moved);
    }

    #[test]
    fn a_gap_does_not_thaw_it() {
        let (mut frozen, stuck) = (Frozen::default(), Reading::Fresh(-0.1));
        for k in 0..=u16::from(REPEATS) {
            cycle(&mut frozen, stuck, k);
        }
        assert_eq!(cycle(&mut frozen, BUS, 0), BUS);
        assert_eq!(cycle(&mut frozen, stuck, 1), FROZEN);
    }

    #[test]
    fn a_sensor_that_alternates_between_two_codes_is_not_frozen() {
        let mut frozen = Frozen::default();
        for k in 0..1000 {
            let reading = Reading::Fresh(if k % 7 == 0 { 0.1 } else { 0.2 });
            assert_eq!(cycle(&mut frozen, reading, k), reading);
        }
    }
}
