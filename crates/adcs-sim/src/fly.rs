//! A whole flight: the application over a simulated board, cycle by cycle, on the host and in the
//! image alike.

use core::cell::RefCell;
use core::fmt;

use adcs_app::{FlightApp, Health, ParameterError};
use adcs_core::pipeline::State;
use adcs_core::time::{TimeScaleError, Utc};
use adcs_hal::board::Board;
use adcs_hal::driver_board::{self, Clock};
use adcs_hal::fault::{Fault, FaultInjector};
use adcs_link::message::{self, End, Hello, Message};

use crate::devices::{Bench, BenchConfig, Faults};
use crate::exact_board::ExactBoard;
use crate::rigid_body::InertiaError;
use crate::scenario::{self, Order, Readings, Scenario};
use crate::world::World;

/// Why a scenario cannot be flown, or not to its end.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum FlightError {
    /// The scenario was written by another version.
    Version {
        /// The version it was written by.
        found: u16,
    },
    /// The flight software refuses its parameters.
    Parameters(ParameterError),
    /// The drivers refuse their configuration.
    Board(driver_board::ConfigError),
    /// The inertia is that of no body.
    Inertia(InertiaError),
    /// An attitude or alignment quaternion is zero.
    Attitude,
    /// The step of the integration is zero.
    Step,
    /// SGP4 refuses the elements, or the orbit decayed on the way.
    Orbit(sgp4_lite::Error),
    /// The field model ends.
    Field(igrf::Error),
    /// The date has no place in the time scales.
    Time(TimeScaleError),
}

impl fmt::Display for FlightError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Version { found } => {
                write!(f, "the scenario has version {found}, this is version {}", scenario::VERSION)
            }
            Self::Parameters(error) => write!(f, "flight parameters: {error}"),
            Self::Board(error) => write!(f, "board: {error}"),
            Self::Inertia(error) => write!(f, "inertia: {error}"),
            Self::Attitude => write!(f, "an attitude or alignment quaternion is zero"),
            Self::Step => write!(f, "the step of the integration is zero"),
            Self::Orbit(error) => write!(f, "orbit: {error}"),
            Self::Field(error) => write!(f, "field model: {error}"),
            Self::Time(error) => write!(f, "time: {error}"),
        }
    }
}

impl core::error::Error for FlightError {}

/// Why a flight ended early: it could not go on, or nobody could take its messages any more.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Stopped<E> {
    /// The flight.
    Flight(FlightError),
    /// Whoever takes the messages.
    Sink(E),
}

impl<E> From<FlightError> for Stopped<E> {
    fn from(error: FlightError) -> Self {
        Self::Flight(error)
    }
}

/// How a flight ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Outcome {
    /// The message that closed the stream: cycles, digest, violations.
    pub end: End,
    /// What the application counted.
    pub health: Health,
}

/// Flies `scenario` from start to end and hands every message to `sink`: a hello, then for each
/// cycle the truth and what the satellite made of it, then the end. An error of the sink stops the
/// flight.
///
/// # Errors
/// [`Stopped`] says who stopped it and why.
pub fn fly<E>(
    scenario: &Scenario,
    sink: impl FnMut(&Message) -> Result<(), E>,
) -> Result<Outcome, Stopped<E>> {
    fly_with_faults(scenario, &[], sink)
}

/// As [`fly`], with sensors and torquers that fail by a script between the drivers and the application.
///
/// # Errors
/// As [`fly`].
pub fn fly_with_faults<E>(
    scenario: &Scenario,
    faults: &[Fault],
    sink: impl FnMut(&Message) -> Result<(), E>,
) -> Result<Outcome, Stopped<E>> {
    fly_in(&mut State::default(), scenario, faults, sink)
}

/// As [`fly_with_faults`], with the flight's memory where the caller has room for it: it is a third of
/// the ADC MPU's. `state` must be that of power-on.
///
/// # Errors
/// As [`fly`].
pub fn fly_in<E>(
    state: &mut State,
    scenario: &Scenario,
    faults: &[Fault],
    sink: impl FnMut(&Message) -> Result<(), E>,
) -> Result<Outcome, Stopped<E>> {
    if scenario.version != scenario::VERSION {
        return Err(FlightError::Version { found: scenario.version }.into());
    }
    let world = RefCell::new(World::new(&scenario.world, &scenario.board)?);
    match scenario.readings {
        Readings::Exact => {
            let board = FaultInjector::new(ExactBoard::new(&world), faults);
            fly_board(state, scenario, &world, board, || 0, sink)
        }
        Readings::Drivers => {
            let bench = Bench::new(&world, bench_config(scenario));
            bench.set_faults(Faults { spi: scenario.converter_fault, ..Faults::default() });
            let board =
                bench.board(scenario.board, WorldClock(&world)).map_err(FlightError::Board)?;
            let board = FaultInjector::new(board, faults);
            fly_board(state, scenario, &world, board, || bench.violations().count, sink)
        }
    }
}

/// Flies `scenario` over any board that lives in `world`.
///
/// # Errors
/// As [`fly`].
// In a frame of its own: in the image the flight over the one board does not lie beside that over the other.
#[inline(never)]
pub fn fly_board<B: Board, E>(
    state: &mut State,
    scenario: &Scenario,
    world: &RefCell<World>,
    board: B,
    violations: impl Fn() -> u32,
    mut sink: impl FnMut(&Message) -> Result<(), E>,
) -> Result<Outcome, Stopped<E>> {
    let app = FlightApp::new(board, &scenario.flight, state);
    let mut app = app.map_err(FlightError::Parameters)?;
    let cycle_us = scenario.flight.cycle_us;
    let hello = Hello { version: message::VERSION, cycles: scenario.cycles, cycle_us };
    sink(&Message::Hello(hello)).map_err(Stopped::Sink)?;
    for cycle in 0..=scenario.cycles {
        if cycle > 0 {
            world.borrow_mut().advance(cycle_us)?;
        }
        let truth = world.borrow().truth(cycle);
        app.witness(&truth);
        sink(&Message::Truth(truth)).map_err(Stopped::Sink)?;
        for command in scenario.commands.iter().flatten().filter(|it| it.cycle == cycle) {
            match command.order {
                Order::Enter(mode) => app.command(mode),
                // A refusal is counted in the health.
                Order::Commit => drop(app.commit()),
            }
        }
        let record = app.cycle();
        sink(&Message::Cycle(record)).map_err(Stopped::Sink)?;
    }
    let end = End { cycles: scenario.cycles, digest: app.digest(), violations: violations() };
    sink(&Message::End(end)).map_err(Stopped::Sink)?;
    Ok(Outcome { end, health: app.health() })
}

fn bench_config(scenario: &Scenario) -> BenchConfig {
    BenchConfig {
        reference_v: f64::from(scenario.board.converter.reference_v),
        max_duty: scenario.world.torquer_steps,
    }
}

/// The satellite's clock, which in simulation is never wrong.
struct WorldClock<'w>(&'w RefCell<World>);

impl Clock for WorldClock<'_> {
    fn now(&mut self) -> Utc {
        self.0.borrow().now()
    }
}
