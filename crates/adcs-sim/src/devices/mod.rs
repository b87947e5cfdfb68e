//! The satellite's chips as the drivers meet them: bytes on a bus and levels on pins, with the
//! simulated world behind.
//!
//! ```text
//! adcs_hal::DriverBoard ── embedded-hal traits ── SimMcp3208, SimEnable, SimPhase, SimSleep
//!                                                      └──────────┬───────────┘
//!                                                               Bench ── RefCell<Plant> (the world)
//! ```
//!
//! A model reads the same bits as its driver ([`adcs_hal::mcp3208::registers`],
//! [`adcs_hal::drv8838::logic`]), from the other side, and is stricter than the chip: what a chip
//! forgives, and a driver ought not to do, is refused and counted as a [`Violation`]. Faults are
//! switched on at the [`Bench`]: a bus that answers nothing, pins that refuse.
//!
//! One chip a file; all handles of a bench share its state, as chips share wires.

mod drv8838;
mod mcp3208;
mod plant;
#[cfg(test)]
mod tests;

use core::cell::{Cell, RefCell, RefMut};
use core::fmt;

use adcs_hal::driver_board::{Clock, ConfigError, DriverBoard, DriverBoardConfig, Parts};
use adcs_hal::drv8838::logic;
use adcs_hal::mcp3208::registers::CommandError;
use embedded_hal::{digital, pwm, spi};
use serde::{Deserialize, Serialize};

pub use drv8838::{SimEnable, SimPhase, SimSleep};
pub use mcp3208::SimMcp3208;
pub use plant::{Converter, Plant};

/// Something that a driver must not do, although the chip might forgive it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Violation {
    /// A transaction of the converter is not one single transfer.
    Pieces {
        /// How many operations it had.
        found: usize,
    },
    /// The one operation of a transaction does not write as many bytes as it reads.
    OneWay,
    /// A frame of the converter is not three bytes long.
    FrameLength {
        /// Bytes written.
        written: usize,
        /// Bytes read.
        read: usize,
    },
    /// A frame of the converter is not the command of the data sheet.
    Command(CommandError),
    /// The converter was talked to without its supply.
    Unpowered,
    /// A duty above the timer's maximum.
    Duty {
        /// Which torquer.
        axis: usize,
        /// What was asked for.
        found: u16,
    },
    /// The direction of a bridge was changed while its EN was not at duty 0.
    PhaseUnderDrive {
        /// Which torquer.
        axis: usize,
    },
}

/// Why a simulated bus or pin failed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum DeviceError {
    /// The driver did what it must not.
    Violation(Violation),
    /// A fault that was switched on at the bench.
    Injected,
    /// The world was borrowed elsewhere: a mistake in the simulation.
    PlantBusy,
}

impl fmt::Display for Violation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Pieces { found } => write!(f, "a conversion in {found} operations, not one"),
            Self::OneWay => write!(f, "a conversion that only reads or only writes"),
            Self::FrameLength { written, read } => {
                write!(f, "a conversion of {written} bytes out and {read} in, not three")
            }
            Self::Command(error) => write!(f, "{error}"),
            Self::Unpowered => write!(f, "the converter has no supply"),
            Self::Duty { axis, found } => {
                write!(f, "torquer {axis}: duty {found} is above the timer's maximum")
            }
            Self::PhaseUnderDrive { axis } => {
                write!(f, "torquer {axis}: its direction was changed while it was driven")
            }
        }
    }
}

impl fmt::Display for DeviceError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Violation(violation) => write!(f, "misused device: {violation}"),
            Self::Injected => write!(f, "injected fault"),
            Self::PlantBusy => write!(f, "the simulated world is borrowed elsewhere"),
        }
    }
}

impl core::error::Error for Violation {}
impl core::error::Error for DeviceError {}

impl spi::Error for DeviceError {
    fn kind(&self) -> spi::ErrorKind {
        spi::ErrorKind::Other
    }
}
impl pwm::Error for DeviceError {
    fn kind(&self) -> pwm::ErrorKind {
        pwm::ErrorKind::Other
    }
}
impl digital::Error for DeviceError {
    fn kind(&self) -> digital::ErrorKind {
        digital::ErrorKind::Other
    }
}

/// How the converters' common bus fails.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum SpiFault {
    /// The data line is stuck low: the bus answers nothing.
    Zeros,
    /// The data line floats high, or the chip is gone.
    Ones,
    /// The bus itself reports an error.
    Error,
}

/// What is broken on the bench; [`Default`] is nothing. A refusing pin keeps its old level.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Faults {
    /// The bus of all converters.
    pub spi: Option<SpiFault>,
    /// The PWM of each torquer refuses.
    pub enable: [bool; 3],
    /// The direction pin of each torquer refuses.
    pub phase: [bool; 3],
    /// The common sleep line refuses.
    pub sleep: bool,
}

/// How the bench is built.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BenchConfig {
    /// The converter's true reference voltage, V.
    pub reference_v: f64,
    /// Steps of the PWM timer. 4200 gives 20 kHz from the STM32F405's 84 MHz timer clock.
    pub max_duty: u16,
}

impl Default for BenchConfig {
    fn default() -> Self {
        Self { reference_v: 3.3, max_duty: 4200 }
    }
}

/// One H-bridge: the levels at its own two inputs, low after power-on, and what is broken.
#[derive(Debug)]
struct Bridge {
    axis: usize,
    phase: Cell<bool>,
    duty: Cell<u16>,
    phase_refuses: Cell<bool>,
    enable_refuses: Cell<bool>,
}

impl Bridge {
    fn new(axis: usize) -> Self {
        Self {
            axis,
            phase: Cell::default(),
            duty: Cell::default(),
            phase_refuses: Cell::default(),
            enable_refuses: Cell::default(),
        }
    }
}

/// What has been done wrong so far.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Violations {
    /// How many times.
    pub count: u32,
    /// The last one.
    pub last: Option<Violation>,
}

/// All simulated chips of one satellite, wired to one world.
#[derive(Debug)]
pub struct Bench<'w, P> {
    plant: &'w RefCell<P>,
    config: BenchConfig,
    bridges: [Bridge; 3],
    /// The level of nSLEEP.
    awake: Cell<bool>,
    sleep_refuses: Cell<bool>,
    spi_fault: Cell<Option<SpiFault>>,
    violations: Cell<Violations>,
}

/// The board that flies in simulations: real drivers over the bench's handles.
pub type SimBoard<'b, P, C> =
    DriverBoard<SimMcp3208<'b, P>, SimEnable<'b, P>, SimPhase<'b, P>, SimSleep<'b, P>, C>;

impl<'w, P: Plant> Bench<'w, P> {
    /// Chips in the state of power-on, connected to `plant`.
    pub fn new(plant: &'w RefCell<P>, config: BenchConfig) -> Self {
        Self {
            plant,
            config,
            bridges: [0, 1, 2].map(Bridge::new),
            awake: Cell::default(),
            sleep_refuses: Cell::default(),
            spi_fault: Cell::default(),
            violations: Cell::default(),
        }
    }

    /// The real drivers on these chips. More than one board on a bench would be two masters on one
    /// bus: nothing forbids it, nothing good comes of it.
    ///
    /// # Errors
    /// As [`DriverBoard::new`].
    pub fn board<C: Clock>(
        &self,
        config: DriverBoardConfig,
        clock: C,
    ) -> Result<SimBoard<'_, P, C>, ConfigError> {
        DriverBoard::new(
            config,
            Parts {
                spi: self.converter(Converter::Main),
                sun_spi: Some([0, 1, 2].map(|number| self.converter(Converter::Sun(number)))),
                enable: self.enable(),
                phase: self.phase(),
                sleep: self.sleep(),
                clock,
            },
        )
    }

    /// The bus of one of the converters.
    pub fn converter(&self, converter: Converter) -> SimMcp3208<'_, P> {
        SimMcp3208::new(self, converter)
    }

    /// The PWM channels on EN of the three torquers.
    pub fn enable(&self) -> [SimEnable<'_, P>; 3] {
        self.bridges.each_ref().map(|bridge| SimEnable::new(self, bridge))
    }

    /// The pins at PH of the three torquers.
    pub fn phase(&self) -> [SimPhase<'_, P>; 3] {
        self.bridges.each_ref().map(|bridge| SimPhase::new(self, bridge))
    }

    /// The pin at nSLEEP of all torquers.
    pub fn sleep(&self) -> SimSleep<'_, P> {
        SimSleep::new(self)
    }

    /// Breaks and repairs things from now on.
    pub fn set_faults(&self, faults: Faults) {
        self.spi_fault.set(faults.spi);
        self.sleep_refuses.set(faults.sleep);
        for (bridge, (enable, phase)) in
            self.bridges.iter().zip(faults.enable.into_iter().zip(faults.phase))
        {
            bridge.enable_refuses.set(enable);
            bridge.phase_refuses.set(phase);
        }
    }

    /// What the drivers have done wrong so far.
    pub fn violations(&self) -> Violations {
        self.violations.get()
    }

    fn plant(&self) -> Result<RefMut<'_, P>, DeviceError> {
        self.plant.try_borrow_mut().map_err(|_| DeviceError::PlantBusy)
    }

    /// Counts a violation and makes an error of it.
    fn violated(&self, violation: Violation) -> DeviceError {
        let count = self.violations.get().count.saturating_add(1);
        self.violations.set(Violations { count, last: Some(violation) });
        DeviceError::Violation(violation)
    }

    /// Hands to the world what `bridge` makes of the levels at its inputs.
    fn drive_winding(&self, plant: &mut P, bridge: &Bridge) {
        let awake = self.awake.get() && plant.powered();
        // A timer without steps never raises EN.
        let steps = self.config.max_duty.max(1);
        let duty = f64::from(bridge.duty.get()) / f64::from(steps);
        plant.set_winding(bridge.axis, logic::mean_drive(awake, bridge.phase.get(), duty));
    }
}
