//! The board over pins that write down what they are told.

extern crate std;
use super::*;
use crate::psd_face;
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

    fn bus(&self) -> Wire<'_> {
        Wire { wires: self, event: Sleep(false) }
    }

    fn parts(&self) -> Parts<Wire<'_>, Wire<'_>, Wire<'_>, Wire<'_>, Stopped> {
        let duty = |axis| Wire { wires: self, event: Duty(axis, 0) };
        let phase = |axis| Wire { wires: self, event: Phase(axis, false) };
        Parts {
            spi: self.bus(),
            sun_spi: Some([self.bus(), self.bus(), self.bus()]),
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
    fn transaction(&mut self, operations: &mut [spi::Operation<'_, u8>]) -> Result<(), Refused> {
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
        let sun_a = [Reading::Missing(reason); FACES];
        let expected = Samples { rate_rad_s: missing, field_t: missing, sun_a };
        assert_eq!(wires.board().sample(), expected);
    }
}

#[test]
fn a_board_without_sun_sensors_says_so() {
    let wires = Wires::new();
    wires.answer.set(Some(0x08));
    let config = DriverBoardConfig { sun: None, ..DriverBoardConfig::SPROUT };
    let parts = Parts { sun_spi: None, ..wires.parts() };
    let samples = DriverBoard::new(config, parts).unwrap().sample();
    assert_eq!(samples.sun_a, Samples::NO_SUN_SENSORS);
    assert!(samples.field_t.iter().all(|axis| axis.value().is_some()));
    let parts = Parts { sun_spi: None, ..wires.parts() };
    let error = DriverBoard::new(DriverBoardConfig::SPROUT, parts).err();
    assert_eq!(error, Some(ConfigError::NoSunConverters));
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
    let sun = |change: &dyn Fn(&mut [PsdFaceConfig; FACES])| {
        let change = |config: &mut DriverBoardConfig| config.sun.iter_mut().for_each(change);
        refused(&change, 100)
    };
    let error = psd_face::ConfigError::Channel { channel: 8 };
    assert_eq!(sun(&|f| f[4].channels[3] = 8), ConfigError::SunFace { face: 4, error });
    assert_eq!(
        sun(&|faces| faces[1].channels[0] = 2),
        ConfigError::SunChannelShared { face: 1, channel: 2 }
    );
    assert_eq!(
        refused(&|config| config.gyro.channels = [3, 4, 9], 100).to_string(),
        "gyro: the converter has no channel 9; it has 0 to 7"
    );
}
