//! A board that fails by a script: wraps any other board and spoils what passes through it.
//!
//! For tests and campaigns: what the flight application does with a sensor that goes silent, gets
//! stuck or breaks the [`Board`] contract with a NaN, and with a torquer that refuses. Faults of the
//! wire (all ones, all zeros, slipped frames) belong one floor lower, to the simulated chips.

use adcs_core::frames::{TorquerAxes, Vector};
use adcs_core::reading::{MissingReason, Reading};
use adcs_core::time::Utc;

use crate::board::{Board, Samples, TorquerFault};

/// One axis of one sensor, or one Sun sensor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SensorAxis {
    /// Gyro 0, 1 or 2.
    Gyro(usize),
    /// Magnetometer axis 0, 1 or 2.
    Magnetometer(usize),
    /// All four currents of Sun sensor 0 to 5.
    SunFace(usize),
}

/// What goes wrong.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum FaultKind {
    /// The axis gives no value, for this reason.
    Missing(SensorAxis, MissingReason),
    /// The axis gives a fresh NaN, which no driver should.
    NotANumber(SensorAxis),
    /// The axis repeats what it said in the cycle before.
    Stuck(SensorAxis),
    /// This torquer (0, 1, 2) refuses its command; all torquers are then off, as the contract asks.
    TorquerRefuses {
        /// Which torquer.
        axis: u8,
    },
}

impl FaultKind {
    /// The sensor that it spoils.
    fn axis(self) -> Option<SensorAxis> {
        match self {
            Self::Missing(axis, _) | Self::NotANumber(axis) | Self::Stuck(axis) => Some(axis),
            Self::TorquerRefuses { .. } => None,
        }
    }
}

/// A fault and when it is there.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Fault {
    /// First cycle with the fault. A cycle begins with [`Board::sample`]; the first is 0.
    pub first_cycle: u32,
    /// Last cycle with the fault.
    pub last_cycle: u32,
    /// What goes wrong.
    pub kind: FaultKind,
}

/// Wraps a board and applies a script of faults, in the script's order.
#[derive(Debug)]
pub struct FaultInjector<'script, B> {
    board: B,
    script: &'script [Fault],
    /// How many times the board has been sampled: the cycle in progress, plus one.
    cycles_begun: u32,
    previous: Option<Samples>,
}

impl<'script, B: Board> FaultInjector<'script, B> {
    /// Wraps `board`.
    pub fn new(board: B, script: &'script [Fault]) -> Self {
        Self { board, script, cycles_begun: 0, previous: None }
    }

    /// Gives the board back.
    pub fn release(self) -> B {
        self.board
    }

    fn active(&self) -> impl Iterator<Item = FaultKind> + use<'script, B> {
        let cycle = self.cycles_begun.saturating_sub(1);
        self.script
            .iter()
            .filter(move |fault| (fault.first_cycle..=fault.last_cycle).contains(&cycle))
            .map(|fault| fault.kind)
    }
}

/// What is left of a reading; `None` when there is no such axis.
fn spoil<T: Copy>(
    kind: FaultKind,
    reading: Option<&mut Reading<T>>,
    previous: Option<&Reading<T>>,
    not_a_number: T,
) {
    let spoilt = match kind {
        FaultKind::Missing(_, reason) => Some(Reading::Missing(reason)),
        FaultKind::NotANumber(_) => Some(Reading::Fresh(not_a_number)),
        FaultKind::Stuck(_) => previous.copied(),
        FaultKind::TorquerRefuses { .. } => None,
    };
    if let (Some(reading), Some(spoilt)) = (reading, spoilt) {
        *reading = spoilt;
    }
}

impl<B: Board> Board for FaultInjector<'_, B> {
    fn now(&mut self) -> Utc {
        self.board.now()
    }

    fn sample(&mut self) -> Samples {
        let mut samples = self.board.sample();
        self.cycles_begun = self.cycles_begun.saturating_add(1);
        // Before the first cycle there is nothing to be stuck at but its own value.
        let previous = self.previous.unwrap_or(samples);
        for kind in self.active() {
            let (Samples { rate_rad_s, field_t, sun_a }, before) = (&mut samples, &previous);
            match kind.axis() {
                Some(SensorAxis::Gyro(axis)) => {
                    spoil(kind, rate_rad_s.get_mut(axis), before.rate_rad_s.get(axis), f32::NAN);
                }
                Some(SensorAxis::Magnetometer(axis)) => {
                    spoil(kind, field_t.get_mut(axis), before.field_t.get(axis), f32::NAN);
                }
                Some(SensorAxis::SunFace(face)) => {
                    spoil(kind, sun_a.get_mut(face), before.sun_a.get(face), [f32::NAN; 4]);
                }
                None => {}
            }
        }
        self.previous = Some(samples);
        samples
    }

    fn drive(&mut self, dipole: Vector<TorquerAxes>) -> Result<Vector<TorquerAxes>, TorquerFault> {
        let refusing = self.active().find_map(|kind| match kind {
            FaultKind::TorquerRefuses { axis } => Some(axis),
            _ => None,
        });
        match refusing {
            None => self.board.drive(dipole),
            Some(axis) => {
                self.board.drive(Vector::zero())?;
                Err(TorquerFault::Pin { axis })
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::psd_face::FACES;

    /// Counts its samples in all axes and remembers the last dipole.
    struct Counter {
        count: f32,
        driven: Vector<TorquerAxes>,
    }

    impl Board for Counter {
        fn now(&mut self) -> Utc {
            Utc::from_micros_since_2000(0)
        }
        fn sample(&mut self) -> Samples {
            self.count += 1.0;
            let readings = [Reading::Fresh(self.count); 3];
            Samples {
                rate_rad_s: readings,
                field_t: readings,
                sun_a: [Reading::Fresh([self.count; 4]); FACES],
            }
        }
        fn drive(
            &mut self,
            dipole: Vector<TorquerAxes>,
        ) -> Result<Vector<TorquerAxes>, TorquerFault> {
            self.driven = dipole;
            Ok(dipole)
        }
    }

    fn inject(script: &[Fault]) -> FaultInjector<'_, Counter> {
        FaultInjector::new(Counter { count: 0.0, driven: Vector::zero() }, script)
    }

    #[test]
    fn a_fault_spoils_its_axis_in_its_cycles_and_nothing_else() {
        let out = MissingReason::OutOfRange;
        let kind = FaultKind::Missing(SensorAxis::Magnetometer(1), out);
        let script = [Fault { first_cycle: 1, last_cycle: 2, kind }];
        let mut board = inject(&script);
        for cycle in 0..4_u8 {
            let count = f32::from(cycle) + 1.0;
            let samples = board.sample();
            assert_eq!(samples.rate_rad_s, [Reading::Fresh(count); 3]);
            assert_eq!(samples.field_t[0], Reading::Fresh(count));
            let spoilt = (1..=2).contains(&cycle);
            let expected = if spoilt { Reading::Missing(out) } else { Reading::Fresh(count) };
            assert_eq!(samples.field_t[1], expected);
        }
    }

    #[test]
    fn a_stuck_axis_repeats_the_last_good_value() {
        let kind = FaultKind::Stuck(SensorAxis::Gyro(2));
        let script = [Fault { first_cycle: 2, last_cycle: 3, kind }];
        let mut board = inject(&script);
        let seen: [_; 5] = core::array::from_fn(|_| board.sample().rate_rad_s[2].value().unwrap());
        assert_eq!(seen, [1.0, 2.0, 2.0, 2.0, 5.0]);
    }

    #[test]
    fn a_sun_sensor_is_stuck_and_silenced_as_a_whole() {
        let stuck = FaultKind::Stuck(SensorAxis::SunFace(5));
        let silent = FaultKind::Missing(SensorAxis::SunFace(0), MissingReason::Bus);
        let script = [stuck, silent].map(|kind| Fault { first_cycle: 1, last_cycle: 9, kind });
        let mut board = inject(&script);
        board.sample();
        let sun_a = board.sample().sun_a;
        assert_eq!(sun_a[5], Reading::Fresh([1.0; 4]));
        assert_eq!(sun_a[0], Reading::Missing(MissingReason::Bus));
        assert_eq!(sun_a[1..5], [Reading::Fresh([2.0; 4]); 4]);
    }

    #[test]
    fn a_nan_passes_as_fresh() {
        let kind = FaultKind::NotANumber(SensorAxis::Gyro(0));
        let script = [Fault { first_cycle: 0, last_cycle: u32::MAX, kind }];
        assert!(inject(&script).sample().rate_rad_s[0].value().unwrap().is_nan());
    }

    #[test]
    fn a_refusing_torquer_leaves_all_torquers_off() {
        let kind = FaultKind::TorquerRefuses { axis: 1 };
        let script = [Fault { first_cycle: 1, last_cycle: 1, kind }];
        let mut board = inject(&script);
        let dipole = Vector::new(0.1, 0.2, 0.3);
        board.sample();
        assert_eq!(board.drive(dipole), Ok(dipole));
        board.sample();
        assert_eq!(board.drive(dipole), Err(TorquerFault::Pin { axis: 1 }));
        assert_eq!(board.release().driven, Vector::zero());
    }

    #[test]
    fn an_axis_that_does_not_exist_is_no_fault_and_no_panic() {
        let kind = FaultKind::NotANumber(SensorAxis::Gyro(3));
        let script = [Fault { first_cycle: 0, last_cycle: 9, kind }];
        assert_eq!(inject(&script).sample().rate_rad_s, [Reading::Fresh(1.0); 3]);
    }
}
