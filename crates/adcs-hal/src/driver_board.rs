//! The board made of drivers: MCP3208 behind the sensors, one DRV8838 a torquer, one clock.
//!
//! The one real implementation of [`Board`]. It is generic over the embedded-hal buses and pins
//! beneath, and these alone differ between the simulation, the emulated core and the satellite.
//!
//! | generic | what | on the satellite |
//! |---|---|---|
//! | `Spi` | the converter's bus with its chip select | SPI peripheral and a pin |
//! | `Pwm` | EN of each H-bridge | three channels of a timer |
//! | `Phase` | PH of each H-bridge | three pins |
//! | `Sleep` | nSLEEP, common to the three H-bridges | one pin |
//! | `C` | [`Clock`] | real-time clock or timer |
//!
//! The three PWM channels have one type, as have the three pins: where a HAL gives each its own,
//! its erased form is meant.
//!
//! Sensors are read in a fixed order, magnetometer x, y, z, then gyros x, y, z, each once.

use core::fmt;

use adcs_core::frames::{TorquerAxes, Vector};
use adcs_core::time::Utc;
use embedded_hal::digital::{OutputPin, PinState};
use embedded_hal::pwm::SetDutyCycle;
use embedded_hal::spi::SpiDevice;
use serde::{Deserialize, Serialize};

use crate::analog_triad::{self, AnalogTriad, AnalogTriadConfig, ConverterConfig};
use crate::board::{Board, Samples, TorquerFault};
use crate::drv8838::Drv8838;
use crate::mcp3208::Mcp3208;

/// Tells the time.
pub trait Clock {
    /// The instant of this call.
    fn now(&mut self) -> Utc;
}

/// Everything about the board that is a number.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct DriverBoardConfig {
    /// The converter and its surroundings.
    pub converter: ConverterConfig,
    /// The magnetometer, in T.
    pub magnetometer: AnalogTriadConfig,
    /// The gyros, in rad/s.
    pub gyro: AnalogTriadConfig,
    /// The dipole of each torquer at full duty, A·m².
    pub max_dipole_am2: [f32; 3],
}

impl DriverBoardConfig {
    /// SPROUT: torquers of ±0.6 A·m² as published; converter and sensors assumed (see their own
    /// constants).
    pub const SPROUT: Self = Self {
        converter: ConverterConfig::ASSUMED,
        magnetometer: AnalogTriadConfig::MAGNETOMETER,
        gyro: AnalogTriadConfig::GYRO,
        max_dipole_am2: [0.6; 3],
    };
}

/// Why a board cannot be built.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum ConfigError {
    /// The magnetometer's configuration.
    Magnetometer(analog_triad::ConfigError),
    /// The gyros' configuration.
    Gyro(analog_triad::ConfigError),
    /// Magnetometer and gyros share an input of the converter.
    ChannelShared {
        /// Which input.
        channel: u8,
    },
    /// A torquer's full dipole is not a positive, normal number.
    MaxDipole {
        /// Which torquer.
        axis: u8,
        /// What was asked for, A·m².
        max_dipole_am2: f32,
    },
    /// The timer behind a torquer has no steps: its maximal duty is 0.
    NoSteps {
        /// Which torquer.
        axis: u8,
    },
}

impl fmt::Display for ConfigError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Magnetometer(error) => write!(f, "magnetometer: {error}"),
            Self::Gyro(error) => write!(f, "gyro: {error}"),
            Self::ChannelShared { channel } => {
                write!(f, "magnetometer and gyro are both wired to channel {channel}")
            }
            Self::MaxDipole { axis, max_dipole_am2 } => {
                write!(f, "torquer {axis}: a full dipole of {max_dipole_am2} A m2 is not positive")
            }
            Self::NoSteps { axis } => {
                write!(f, "torquer {axis}: its timer has a maximal duty of 0")
            }
        }
    }
}

impl core::error::Error for ConfigError {}

/// The buses and pins of a board.
#[derive(Debug)]
pub struct Parts<Spi, Pwm, Phase, Sleep, C> {
    /// The converter's bus, in [`mcp3208::MODE`](crate::mcp3208::MODE).
    pub spi: Spi,
    /// EN of the torquers' bridges x, y, z.
    pub enable: [Pwm; 3],
    /// PH of the torquers' bridges x, y, z.
    pub phase: [Phase; 3],
    /// nSLEEP of all three bridges.
    pub sleep: Sleep,
    /// The satellite's clock.
    pub clock: C,
}

/// The board made of drivers.
#[derive(Debug)]
pub struct DriverBoard<Spi, Pwm, Phase, Sleep, C> {
    converter: Mcp3208<Spi>,
    magnetometer: AnalogTriad,
    gyro: AnalogTriad,
    torquers: [Torquer<Pwm, Phase>; 3],
    sleep: Sleep,
    clock: C,
}

/// A bridge and what its winding makes of full duty.
#[derive(Debug)]
struct Torquer<Pwm, Phase> {
    axis: u8,
    bridge: Drv8838<Pwm, Phase>,
    max_dipole_am2: f32,
}

impl<Pwm: SetDutyCycle, Phase: OutputPin> Torquer<Pwm, Phase> {
    fn new(axis: u8, enable: Pwm, phase: Phase, max_dipole_am2: f32) -> Result<Self, ConfigError> {
        // `is_normal` refuses NaN, infinity, zero and what would overflow a quotient.
        if !(max_dipole_am2 > 0.0 && max_dipole_am2.is_normal()) {
            return Err(ConfigError::MaxDipole { axis, max_dipole_am2 });
        }
        let bridge = Drv8838::new(enable, phase);
        if bridge.steps() == 0 {
            return Err(ConfigError::NoSteps { axis });
        }
        Ok(Self { axis, bridge, max_dipole_am2 })
    }

    /// Drives towards `dipole_am2` and returns what is made of it.
    fn set(&mut self, dipole_am2: f32) -> Result<f32, TorquerFault> {
        let limit = self.max_dipole_am2;
        // Clipped before it is divided: the quotient of a huge dipole would be infinite.
        let fraction = dipole_am2.min(limit).max(-limit) / limit;
        let made = self.bridge.set(fraction).map_err(|_| TorquerFault::Pin { axis: self.axis })?;
        Ok(made * limit)
    }

    fn off(&mut self) -> Result<(), TorquerFault> {
        self.bridge.off().map_err(|_| TorquerFault::Pin { axis: self.axis })
    }
}

impl<Spi, Pwm, Phase, Sleep, C> DriverBoard<Spi, Pwm, Phase, Sleep, C>
where
    Spi: SpiDevice,
    Pwm: SetDutyCycle,
    Phase: OutputPin,
    Sleep: OutputPin,
    C: Clock,
{
    /// Checks the configuration, takes the parts and switches the torquers off. A pin that refuses
    /// here does not keep the board from being built: a satellite with one dead pin still measures,
    /// and the first [`drive`](Board::drive) reports the pin.
    ///
    /// # Errors
    /// [`ConfigError`] with the value that cannot be.
    pub fn new(
        config: DriverBoardConfig,
        parts: Parts<Spi, Pwm, Phase, Sleep, C>,
    ) -> Result<Self, ConfigError> {
        let magnetometer = AnalogTriad::new(config.magnetometer, config.converter)
            .map_err(ConfigError::Magnetometer)?;
        let gyro = AnalogTriad::new(config.gyro, config.converter).map_err(ConfigError::Gyro)?;
        if let Some(shared) =
            magnetometer.channels().iter().find(|channel| gyro.channels().contains(channel))
        {
            return Err(ConfigError::ChannelShared { channel: shared.number() });
        }
        let [enable_x, enable_y, enable_z] = parts.enable;
        let [phase_x, phase_y, phase_z] = parts.phase;
        let [max_x, max_y, max_z] = config.max_dipole_am2;
        let mut board = Self {
            converter: Mcp3208::new(parts.spi),
            magnetometer,
            gyro,
            torquers: [
                Torquer::new(0, enable_x, phase_x, max_x)?,
                Torquer::new(1, enable_y, phase_y, max_y)?,
                Torquer::new(2, enable_z, phase_z, max_z)?,
            ],
            sleep: parts.sleep,
            clock: parts.clock,
        };
        let _ = board.switch_off();
        Ok(board)
    }

    /// Switches every torquer off and lets the bridges sleep; tries all pins whatever happens.
    ///
    /// # Errors
    /// The first pin that refused.
    pub fn switch_off(&mut self) -> Result<(), TorquerFault> {
        // nSLEEP first: it alone stops all three.
        let asleep = self.set_sleep(PinState::Low);
        self.torquers.iter_mut().map(Torquer::off).fold(asleep, Result::and)
    }

    fn set_sleep(&mut self, level: PinState) -> Result<(), TorquerFault> {
        self.sleep.set_state(level).map_err(|_| TorquerFault::Sleep)
    }

    fn try_drive(
        &mut self,
        dipole: Vector<TorquerAxes>,
    ) -> Result<Vector<TorquerAxes>, TorquerFault> {
        if !dipole.is_finite() {
            return Err(TorquerFault::NotFinite);
        }
        let [torquer_x, torquer_y, torquer_z] = &mut self.torquers;
        let [x, y, z] = dipole.to_array();
        let made = [torquer_x.set(x)?, torquer_y.set(y)?, torquer_z.set(z)?];
        // The bridges wake only after each has taken its command, so that a refused pin never
        // leaves the others pulling while they could still sleep.
        let any = made.iter().any(|&dipole_am2| dipole_am2 != 0.0);
        self.set_sleep(PinState::from(any))?;
        let [x, y, z] = made;
        Ok(Vector::new(x, y, z))
    }
}

impl<Spi, Pwm, Phase, Sleep, C> Board for DriverBoard<Spi, Pwm, Phase, Sleep, C>
where
    Spi: SpiDevice,
    Pwm: SetDutyCycle,
    Phase: OutputPin,
    Sleep: OutputPin,
    C: Clock,
{
    fn now(&mut self) -> Utc {
        self.clock.now()
    }

    fn sample(&mut self) -> Samples {
        let field_t = self.magnetometer.read(&mut self.converter);
        let rate_rad_s = self.gyro.read(&mut self.converter);
        Samples { rate_rad_s, field_t }
    }

    fn drive(&mut self, dipole: Vector<TorquerAxes>) -> Result<Vector<TorquerAxes>, TorquerFault> {
        let made = self.try_drive(dipole);
        if made.is_err() {
            // The first fault is the one to report.
            let _ = self.switch_off();
        }
        made
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use adcs_core::reading::{MissingReason, Reading};
    use core::cell::{Cell, RefCell};
    use embedded_hal::digital;
    use embedded_hal::pwm;
    use embedded_hal::spi;
    use std::string::ToString;
    use std::vec::Vec;

    /// One thing that a pin can be told.
    #[derive(Debug, Clone, Copy, PartialEq)]
    enum Event {
        Sleep(bool),
        Phase(usize, bool),
        Duty(usize, u16),
    }
    use Event::{Duty, Phase, Sleep};

    /// Which pin an event concerns, whatever it is told.
    fn pin_of(event: Event) -> (u8, usize) {
        match event {
            Sleep(_) => (0, 0),
            Phase(axis, _) => (1, axis),
            Duty(axis, _) => (2, axis),
        }
    }

    /// All pins of a board: a common log, and one pin that may be broken.
    #[derive(Default)]
    struct Wires {
        log: RefCell<Vec<Event>>,
        broken: Cell<Option<Event>>,
        steps: Cell<u16>,
        /// Every byte that the bus answers with; `None` is an error of the bus.
        answer: Cell<Option<u8>>,
    }

    impl Wires {
        fn new() -> Self {
            let wires = Self::default();
            wires.steps.set(100);
            wires
        }

        fn tell(&self, event: Event) -> Result<(), Refused> {
            if self.broken.get().is_some_and(|broken| pin_of(broken) == pin_of(event)) {
                return Err(Refused);
            }
            self.log.borrow_mut().push(event);
            Ok(())
        }

        fn parts(&self) -> Parts<Wire<'_>, Wire<'_>, Wire<'_>, Wire<'_>, Stopped> {
            let duty = |axis| Wire { wires: self, event: Duty(axis, 0) };
            let phase = |axis| Wire { wires: self, event: Phase(axis, false) };
            Parts {
                spi: Wire { wires: self, event: Sleep(false) },
                enable: [duty(0), duty(1), duty(2)],
                phase: [phase(0), phase(1), phase(2)],
                sleep: Wire { wires: self, event: Sleep(false) },
                clock: Stopped,
            }
        }

        fn board(&self) -> TestBoard<'_> {
            let board = DriverBoard::new(DriverBoardConfig::SPROUT, self.parts()).unwrap();
            self.log.borrow_mut().clear();
            board
        }
    }

    type TestBoard<'a> = DriverBoard<Wire<'a>, Wire<'a>, Wire<'a>, Wire<'a>, Stopped>;

    struct Wire<'a> {
        wires: &'a Wires,
        event: Event,
    }

    #[derive(Debug)]
    struct Refused;
    impl digital::Error for Refused {
        fn kind(&self) -> digital::ErrorKind {
            digital::ErrorKind::Other
        }
    }
    impl pwm::Error for Refused {
        fn kind(&self) -> pwm::ErrorKind {
            pwm::ErrorKind::Other
        }
    }
    impl spi::Error for Refused {
        fn kind(&self) -> spi::ErrorKind {
            spi::ErrorKind::Other
        }
    }
    impl digital::ErrorType for Wire<'_> {
        type Error = Refused;
    }
    impl pwm::ErrorType for Wire<'_> {
        type Error = Refused;
    }
    impl spi::ErrorType for Wire<'_> {
        type Error = Refused;
    }
    impl OutputPin for Wire<'_> {
        fn set_low(&mut self) -> Result<(), Refused> {
            self.set_state(PinState::Low)
        }
        fn set_high(&mut self) -> Result<(), Refused> {
            self.set_state(PinState::High)
        }
        fn set_state(&mut self, state: PinState) -> Result<(), Refused> {
            let level = state == PinState::High;
            self.wires.tell(match self.event {
                Phase(axis, _) => Phase(axis, level),
                _ => Sleep(level),
            })
        }
    }
    impl SetDutyCycle for Wire<'_> {
        fn max_duty_cycle(&self) -> u16 {
            self.wires.steps.get()
        }
        fn set_duty_cycle(&mut self, duty: u16) -> Result<(), Refused> {
            let (_, axis) = pin_of(self.event);
            self.wires.tell(Duty(axis, duty))
        }
    }
    impl SpiDevice for Wire<'_> {
        fn transaction(
            &mut self,
            operations: &mut [spi::Operation<'_, u8>],
        ) -> Result<(), Refused> {
            let answer = self.wires.answer.get().ok_or(Refused)?;
            for operation in operations {
                if let spi::Operation::Transfer(read, _) = operation {
                    read.fill(answer);
                }
            }
            Ok(())
        }
    }

    struct Stopped;
    impl Clock for Stopped {
        fn now(&mut self) -> Utc {
            Utc::from_micros_since_2000(7)
        }
    }

    const OFF: [Event; 4] = [Sleep(false), Duty(0, 0), Duty(1, 0), Duty(2, 0)];

    #[test]
    fn a_new_board_has_switched_everything_off() {
        let wires = Wires::new();
        let mut board = DriverBoard::new(DriverBoardConfig::SPROUT, wires.parts()).unwrap();
        assert_eq!(*wires.log.borrow(), OFF);
        assert_eq!(board.now(), Utc::from_micros_since_2000(7));
    }

    #[test]
    fn the_torquers_take_their_command_before_the_bridges_wake() {
        let wires = Wires::new();
        let made = wires.board().drive(Vector::new(0.3, -5.0, 0.001)).unwrap();
        // 0.001 A·m² is below half of the 0.006 A·m² step; −5 A·m² is clipped.
        assert_eq!(made, Vector::new(0.3, -0.6, 0.0));
        let expected = [
            Duty(0, 0),
            Phase(0, false),
            Duty(0, 50),
            Duty(1, 0),
            Phase(1, true),
            Duty(1, 100),
            Duty(2, 0),
            Sleep(true),
        ];
        assert_eq!(*wires.log.borrow(), expected);
    }

    #[test]
    fn with_all_torquers_off_the_bridges_sleep() {
        let wires = Wires::new();
        assert_eq!(wires.board().drive(Vector::zero()), Ok(Vector::zero()));
        assert_eq!(wires.log.borrow().last(), Some(&Sleep(false)));
    }

    #[test]
    fn a_dipole_that_is_not_a_number_switches_everything_off() {
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            let wires = Wires::new();
            let made = wires.board().drive(Vector::new(0.3, bad, 0.0));
            assert_eq!(made, Err(TorquerFault::NotFinite));
            assert_eq!(*wires.log.borrow(), OFF);
        }
    }

    #[test]
    fn whichever_pin_breaks_it_is_named_and_all_others_are_switched_off() {
        let pin = |axis| TorquerFault::Pin { axis };
        let cases = [
            (Duty(0, 0), pin(0)),
            (Duty(1, 0), pin(1)),
            (Duty(2, 0), pin(2)),
            (Phase(0, false), pin(0)),
            (Phase(1, false), pin(1)),
            (Phase(2, false), pin(2)),
            (Sleep(false), TorquerFault::Sleep),
        ];
        for (broken, fault) in cases {
            let wires = Wires::new();
            let mut board = wires.board();
            board.drive(Vector::new(0.1, 0.2, 0.3)).unwrap();
            wires.broken.set(Some(broken));
            wires.log.borrow_mut().clear();
            assert_eq!(board.drive(Vector::new(-0.3, -0.2, -0.1)), Err(fault));
            let log = wires.log.borrow();
            for off in OFF.into_iter().filter(|off| pin_of(*off) != pin_of(broken)) {
                let last = log.iter().rev().find(|event| pin_of(**event) == pin_of(off));
                assert_eq!(last, Some(&off), "{broken:?}");
            }
        }
    }

    #[test]
    fn the_fault_of_an_off_command_that_cannot_be_carried_out_is_reported() {
        let wires = Wires::new();
        let mut board = wires.board();
        wires.broken.set(Some(Duty(1, 0)));
        assert_eq!(board.switch_off(), Err(TorquerFault::Pin { axis: 1 }));
        assert_eq!(*wires.log.borrow(), [Sleep(false), Duty(0, 0), Duty(2, 0)]);
    }

    #[test]
    fn a_dead_bus_of_any_kind_is_missing_never_a_number() {
        let cases = [
            (Some(0xFF), MissingReason::Bus),
            (Some(0x00), MissingReason::OutOfRange),
            (None, MissingReason::Bus),
        ];
        for (answer, reason) in cases {
            let wires = Wires::new();
            wires.answer.set(answer);
            let missing = [Reading::Missing(reason); 3];
            let expected = Samples { rate_rad_s: missing, field_t: missing };
            assert_eq!(wires.board().sample(), expected);
        }
    }

    #[test]
    fn impossible_boards_are_refused_with_the_value() {
        let refused = |change: &dyn Fn(&mut DriverBoardConfig), steps| {
            let wires = Wires::new();
            wires.steps.set(steps);
            let mut config = DriverBoardConfig::SPROUT;
            change(&mut config);
            DriverBoard::new(config, wires.parts()).err().unwrap()
        };
        for found in [0.0, -0.6, f32::NAN, f32::INFINITY, 1e-40] {
            let error = refused(&|config| config.max_dipole_am2[2] = found, 100);
            assert!(matches!(error, ConfigError::MaxDipole { axis: 2, .. }), "{found}: {error}");
        }
        assert_eq!(
            refused(&|config| config.gyro.channels = [2, 4, 5], 100),
            ConfigError::ChannelShared { channel: 2 }
        );
        assert_eq!(refused(&|_| (), 0), ConfigError::NoSteps { axis: 0 });
        assert_eq!(
            refused(&|config| config.gyro.channels = [3, 4, 9], 100).to_string(),
            "gyro: the converter has no channel 9; it has 0 to 7"
        );
    }
}
