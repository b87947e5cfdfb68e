//! What the DRV8838 does with its winding for each state of its three inputs.
//!
//! | nSLEEP | PH | EN | OUT1 | OUT2 | [`Winding`] |
//! |---|---|---|---|---|---|
//! | 0 | x | x | Z | Z | `Coast` |
//! | 1 | x | 0 | L | L | `Brake` |
//! | 1 | 0 | 1 | H | L | `Forward` |
//! | 1 | 1 | 1 | L | H | `Reverse` |
//!
//! Source: Texas Instruments, DRV8837/DRV8838 data sheet, SLVSBA4, "Bridge Control" (§7.3.1,
//! table 2 in revision C).

/// What the bridge does with its winding.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Winding {
    /// Both ends float (through the body diodes the current falls fast).
    Coast,
    /// Both ends at ground: the current falls slowly, no voltage drives it.
    Brake,
    /// Current is driven from OUT1 to OUT2.
    Forward,
    /// Current is driven from OUT2 to OUT1.
    Reverse,
}

impl Winding {
    /// The table above.
    pub const fn of(n_sleep: bool, phase: bool, enable: bool) -> Self {
        match (n_sleep, enable, phase) {
            (false, _, _) => Self::Coast,
            (true, false, _) => Self::Brake,
            (true, true, false) => Self::Forward,
            (true, true, true) => Self::Reverse,
        }
    }

    /// The voltage across the winding as a fraction of the supply: +1 forward, −1 reverse, 0 else.
    pub const fn drive(self) -> f64 {
        match self {
            Self::Coast | Self::Brake => 0.0,
            Self::Forward => 1.0,
            Self::Reverse => -1.0,
        }
    }
}

/// The way in which current is to flow.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Direction {
    /// OUT1 to OUT2; positive fractions.
    Forward,
    /// OUT2 to OUT1; negative fractions.
    Reverse,
}

impl Direction {
    /// The level of PH that gives this direction.
    pub const fn phase(self) -> bool {
        matches!(self, Self::Reverse)
    }
}

/// The mean voltage across the winding, as a fraction of the supply, when EN is high for the part
/// `duty` (0 to 1) of each period: drive and slow decay in turn.
pub fn mean_drive(n_sleep: bool, phase: bool, duty: f64) -> f64 {
    duty * Winding::of(n_sleep, phase, true).drive()
        + (1.0 - duty) * Winding::of(n_sleep, phase, false).drive()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_truth_table_is_that_of_the_data_sheet() {
        for phase in [false, true] {
            for enable in [false, true] {
                assert_eq!(Winding::of(false, phase, enable), Winding::Coast);
            }
            assert_eq!(Winding::of(true, phase, false), Winding::Brake);
        }
        assert_eq!(Winding::of(true, false, true), Winding::Forward);
        assert_eq!(Winding::of(true, true, true), Winding::Reverse);
    }

    #[test]
    fn a_direction_sets_the_phase_that_the_table_turns_into_it() {
        let forward = Winding::of(true, Direction::Forward.phase(), true);
        let reverse = Winding::of(true, Direction::Reverse.phase(), true);
        assert_eq!((forward, reverse), (Winding::Forward, Winding::Reverse));
    }

    #[test]
    fn the_mean_drive_follows_the_duty_and_sleep_ends_it() {
        assert_eq!(mean_drive(true, false, 0.25), 0.25);
        assert_eq!(mean_drive(true, true, 0.25), -0.25);
        assert_eq!(mean_drive(false, true, 1.0), 0.0);
    }
}
