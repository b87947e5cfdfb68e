//! DRV8838: drives one torquer's winding with a chosen part of the supply, either way.
//!
//! Texas Instruments' H-bridge with PHASE/ENABLE inputs: PH chooses the direction, PWM on EN the
//! strength. While EN is low the winding is shorted (slow decay), so the mean voltage, and with a
//! period far below the winding's L/R the mean current, is proportional to the duty. nSLEEP is
//! commonly one line for several bridges and therefore belongs to the board, not to this driver.
//! What the inputs do is in [`logic`].
//!
//! | requirement | value |
//! |---|---|
//! | PWM frequency | at most 250 kHz (SLVSBA4, recommended operating conditions) |
//! | after nSLEEP rises | the bridge needs up to 30 µs before it drives (timing requirements) |
//! | inputs without drive | pulled low inside: no current before the MCU has set its pins (§7.3.3) |
//!
//! Source: Texas Instruments, DRV8837/DRV8838 data sheet, SLVSBA4 (section numbers of revision C).

pub mod logic;

use core::fmt;

use embedded_hal::digital::{self, OutputPin, PinState};
use embedded_hal::pwm::{self, SetDutyCycle};

use logic::Direction;

/// Why the bridge is not in the state that was asked for. It is then off, unless EN itself is what
/// refuses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Error<Enable, Phase> {
    /// The PWM on EN failed.
    Enable(Enable),
    /// The pin at PH failed.
    Phase(Phase),
    /// The timer behind EN has no steps: its maximal duty is 0.
    NoSteps,
    /// The fraction was NaN or infinite.
    NotFinite,
}

/// What sort of error it is, for code that knows nothing of the pins.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum ErrorKind {
    /// See [`Error::Enable`].
    Enable(pwm::ErrorKind),
    /// See [`Error::Phase`].
    Phase(digital::ErrorKind),
    /// See [`Error::NoSteps`].
    NoSteps,
    /// See [`Error::NotFinite`].
    NotFinite,
}

impl<E: pwm::Error, P: digital::Error> Error<E, P> {
    /// The sort of this error.
    pub fn kind(&self) -> ErrorKind {
        match self {
            Self::Enable(error) => ErrorKind::Enable(error.kind()),
            Self::Phase(error) => ErrorKind::Phase(error.kind()),
            Self::NoSteps => ErrorKind::NoSteps,
            Self::NotFinite => ErrorKind::NotFinite,
        }
    }
}

impl<E: pwm::Error, P: digital::Error> fmt::Display for Error<E, P> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Enable(error) => write!(f, "DRV8838, PWM on EN: {}", error.kind()),
            Self::Phase(error) => write!(f, "DRV8838, pin PH: {}", error.kind()),
            Self::NoSteps => write!(f, "DRV8838: the timer on EN has a maximal duty of 0"),
            Self::NotFinite => write!(f, "DRV8838: asked for a drive that is not a number"),
        }
    }
}

impl<E: pwm::Error, P: digital::Error> core::error::Error for Error<E, P> {}

/// The driver: owns the PWM channel on EN and the pin at PH.
#[derive(Debug)]
pub struct Drv8838<Pwm, Phase> {
    enable: Pwm,
    phase: Phase,
}

/// The error type of a bridge made of these pins.
type BridgeError<Pwm, Phase> =
    Error<<Pwm as pwm::ErrorType>::Error, <Phase as digital::ErrorType>::Error>;

impl<Pwm: SetDutyCycle, Phase: OutputPin> Drv8838<Pwm, Phase> {
    /// Takes the pins; nothing is switched.
    pub fn new(enable: Pwm, phase: Phase) -> Self {
        Self { enable, phase }
    }

    /// The PWM's number of steps; 0 means that the bridge can never be driven.
    pub fn steps(&self) -> u16 {
        self.enable.max_duty_cycle()
    }

    /// Drives the winding with `fraction` of the supply (−1 to 1; clipped beyond), positive from
    /// OUT1 to OUT2, and returns the fraction really made of it: the nearest whole step of the PWM.
    ///
    /// EN goes to duty 0 before PH changes, each time, so that no state remembered here can be
    /// wrong. The gap is a few instructions long. Where a timer takes a new duty only at the end of
    /// its period, the winding may see the new direction with the old duty for that one period.
    ///
    /// # Errors
    /// [`Error`]; the bridge is then off, or was at least told to be.
    pub fn set(&mut self, fraction: f32) -> Result<f32, BridgeError<Pwm, Phase>> {
        let made = self.try_set(fraction);
        if made.is_err() {
            // The first error is the one to report.
            let _ = self.off();
        }
        made
    }

    /// Stops driving the winding (EN low: slow decay).
    ///
    /// # Errors
    /// [`Error::Enable`] when the PWM refuses; the state of the winding is then unknown.
    pub fn off(&mut self) -> Result<(), BridgeError<Pwm, Phase>> {
        self.enable.set_duty_cycle(0).map_err(Error::Enable)
    }

    fn try_set(&mut self, fraction: f32) -> Result<f32, BridgeError<Pwm, Phase>> {
        let steps = self.steps();
        if steps == 0 {
            return Err(Error::NoSteps);
        }
        if !fraction.is_finite() {
            return Err(Error::NotFinite);
        }
        // At most 65,535, exact in f32.
        let all = f32::from(steps);
        let duty = libm::roundf(fraction.abs().min(1.0) * all);
        let direction = if fraction < 0.0 { Direction::Reverse } else { Direction::Forward };

        self.off()?;
        if duty == 0.0 {
            return Ok(0.0);
        }
        self.phase.set_state(PinState::from(direction.phase())).map_err(Error::Phase)?;
        self.enable.set_duty_cycle(duty as u16).map_err(Error::Enable)?;
        let made = duty / all;
        Ok(if direction == Direction::Reverse { -made } else { made })
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use embedded_hal_mock::eh1::MockError;
    use embedded_hal_mock::eh1::digital::{Mock as Pin, State, Transaction as Level};
    use embedded_hal_mock::eh1::pwm::{Mock as Pwm, Transaction as Duty};
    use std::io;
    use std::string::ToString;

    const REFUSED: MockError = MockError::Io(io::ErrorKind::NotConnected);

    /// Runs `set(fraction)` over pins that expect exactly these calls.
    fn set(
        fraction: f32,
        duties: &[Duty],
        levels: &[Level],
    ) -> Result<f32, Error<MockError, MockError>> {
        let mut bridge = Drv8838::new(Pwm::new(duties), Pin::new(levels));
        let made = bridge.set(fraction);
        bridge.enable.done();
        bridge.phase.done();
        made
    }

    #[test]
    fn half_reverse_stops_turns_the_phase_then_drives() {
        let duties =
            [Duty::max_duty_cycle(4200), Duty::set_duty_cycle(0), Duty::set_duty_cycle(2100)];
        assert_eq!(set(-0.5, &duties, &[Level::set(State::High)]), Ok(-0.5));
    }

    #[test]
    fn full_forward_and_everything_beyond_is_the_maximal_duty() {
        for fraction in [1.0, 1.5, f32::MAX] {
            let duties =
                [Duty::max_duty_cycle(4200), Duty::set_duty_cycle(0), Duty::set_duty_cycle(4200)];
            assert_eq!(set(fraction, &duties, &[Level::set(State::Low)]), Ok(1.0));
        }
    }

    #[test]
    fn the_fraction_really_made_is_a_whole_step() {
        let duties = [Duty::max_duty_cycle(10), Duty::set_duty_cycle(0), Duty::set_duty_cycle(3)];
        assert_eq!(set(0.333, &duties, &[Level::set(State::Low)]), Ok(0.3));
        // Below half a step nothing is driven and the phase is left alone.
        let duties = [Duty::max_duty_cycle(10), Duty::set_duty_cycle(0)];
        assert_eq!(set(-0.049, &duties, &[]), Ok(0.0));
    }

    #[test]
    fn a_fraction_that_is_not_a_number_switches_off() {
        for fraction in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            let duties = [Duty::max_duty_cycle(10), Duty::set_duty_cycle(0)];
            assert_eq!(set(fraction, &duties, &[]), Err(Error::NotFinite));
        }
    }

    #[test]
    fn a_timer_without_steps_is_an_error_not_a_division_by_zero() {
        let duties = [Duty::max_duty_cycle(0), Duty::set_duty_cycle(0)];
        assert_eq!(set(0.5, &duties, &[]), Err(Error::NoSteps));
    }

    #[test]
    fn a_phase_that_refuses_leaves_the_bridge_off() {
        let duties = [Duty::max_duty_cycle(10), Duty::set_duty_cycle(0), Duty::set_duty_cycle(0)];
        let levels = [Level::set(State::High).with_error(REFUSED)];
        let error = set(-1.0, &duties, &levels).unwrap_err();
        assert_eq!(error, Error::Phase(REFUSED));
        assert_eq!(error.kind(), ErrorKind::Phase(digital::ErrorKind::Other));
        assert!(error.to_string().starts_with("DRV8838, pin PH: "));
    }

    #[test]
    fn an_enable_that_refuses_is_told_once_more_to_be_off() {
        let duties = [
            Duty::max_duty_cycle(10),
            Duty::set_duty_cycle(0),
            Duty::set_duty_cycle(10).with_error(REFUSED),
            Duty::set_duty_cycle(0),
        ];
        let result = set(1.0, &duties, &[Level::set(State::Low)]);
        assert_eq!(result, Err(Error::Enable(REFUSED)));
    }
}
