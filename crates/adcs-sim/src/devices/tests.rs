//! The real drivers against the simulated chips.

extern crate std;

use core::cell::RefCell;
use std::string::ToString;
use std::vec;
use std::vec::Vec;

use adcs_core::frames::{TorquerAxes, Vector};
use adcs_core::reading::{MissingReason, Reading};
use adcs_core::time::Utc;
use adcs_hal::board::{Board, TorquerFault};
use adcs_hal::driver_board::{Clock, DriverBoardConfig};
use adcs_hal::mcp3208::registers::CommandError;
use adcs_hal::mcp3208::{Channel, Code, Error, Mcp3208, registers};
use embedded_hal::digital::OutputPin;
use embedded_hal::pwm::SetDutyCycle;
use embedded_hal::spi::{Operation, SpiDevice};
use proptest::prelude::*;

use super::*;

/// A world of constant voltages that remembers its windings.
struct Table {
    volts: [f64; 8],
    /// At every input of the Sun sensors' converters.
    sun_volts: f64,
    /// The inputs converted so far, in order.
    conversions: Vec<(Converter, u8)>,
    windings: [f64; 3],
    powered: bool,
}

impl Table {
    fn new() -> RefCell<Self> {
        let (volts, sun_volts) = ([1.65; 8], 1.3);
        let (conversions, windings) = (Vec::new(), [0.0; 3]);
        RefCell::new(Self { volts, sun_volts, conversions, windings, powered: true })
    }
}

impl Plant for Table {
    fn pin_volts(&mut self, converter: Converter, channel: u8) -> f64 {
        self.conversions.push((converter, channel));
        match converter {
            Converter::Main => self.volts[usize::from(channel)],
            Converter::Sun(_) => self.sun_volts,
        }
    }
    fn set_winding(&mut self, axis: usize, drive: f64) {
        self.windings[axis] = drive;
    }
    fn powered(&self) -> bool {
        self.powered
    }
}

struct Stopped;
impl Clock for Stopped {
    fn now(&mut self) -> Utc {
        Utc::from_micros_since_2000(0)
    }
}

fn bench(table: &RefCell<Table>) -> Bench<'_, Table> {
    Bench::new(table, BenchConfig::default())
}

fn board<'b>(bench: &'b Bench<'_, Table>) -> SimBoard<'b, Table, Stopped> {
    bench.board(DriverBoardConfig::SPROUT, Stopped).unwrap()
}

/// One step of the default timer, and the f32 rounding of a dipole, both of 0.6 A·m².
const STEP_AM2: f32 = 0.6 / 4200.0;
const ROUNDING_AM2: f32 = 2e-7;

#[test]
fn every_code_of_every_channel_reaches_the_driver() {
    let table = Table::new();
    let bench = bench(&table);
    let mut converter = Mcp3208::new(bench.converter(Converter::Main));
    for number in 0..Channel::COUNT {
        for raw in 0..registers::LEVELS {
            let code = Code::new(raw).unwrap();
            table.borrow_mut().volts = [f64::NAN; 8];
            table.borrow_mut().volts[usize::from(number)] = f64::from(raw) * 3.3 / 4096.0;
            assert_eq!(converter.convert(Channel::new(number).unwrap()), Ok(code));
        }
    }
    assert_eq!(table.borrow().conversions.len(), 8 * usize::from(registers::LEVELS));
    assert_eq!(bench.violations(), Violations::default());
}

#[test]
fn a_cycle_reads_magnetometer_then_gyros_each_axis_once_and_right() {
    let table = Table::new();
    table.borrow_mut().volts = [0.65, 1.25, 2.65, 1.63, 1.67, 1.75, f64::NAN, f64::NAN];
    let bench = bench(&table);
    let samples = board(&bench).sample();
    let triads = (0..6).map(|channel| (Converter::Main, channel));
    let suns = (0..3).flat_map(|n| (0..8).map(move |channel| (Converter::Sun(n), channel)));
    assert_eq!(table.borrow().conversions, triads.chain(suns).collect::<Vec<_>>());
    // (1.3 − 0.1) V over 30 kΩ, to half a step of 27 nA.
    for face in samples.sun_a {
        assert!(face.value().unwrap().iter().all(|current| (current - 40e-6).abs() < 14e-9));
    }
    // Half a step of the converter: 20.1 nT and 0.0201 deg/s, and a little rounding.
    const HALF_STEP_T: f32 = 20.2e-9;
    const HALF_STEP_DEG_S: f32 = 0.0202;
    for (field, expected_t) in samples.field_t.into_iter().zip([-50e-6, -20e-6, 50e-6]) {
        assert!((field.value().unwrap() - expected_t).abs() < HALF_STEP_T);
    }
    for (rate, expected_deg_s) in samples.rate_rad_s.into_iter().zip([-1.0, 1.0, 5.0]) {
        assert!((rate.value().unwrap().to_degrees() - expected_deg_s).abs() < HALF_STEP_DEG_S);
    }
}

#[test]
fn a_sensor_at_a_rail_is_missing_and_leaves_the_others_alone() {
    let table = Table::new();
    let bench = bench(&table);
    for (rail_v, channel) in [(0.0, 1), (3.3, 4), (-5.0, 1), (17.0, 4), (f64::NAN, 1)] {
        table.borrow_mut().volts = [1.65; 8];
        table.borrow_mut().volts[channel] = rail_v;
        let samples = board(&bench).sample();
        let all = [samples.field_t, samples.rate_rad_s].concat();
        for (axis, reading) in all.into_iter().enumerate() {
            let out = Reading::Missing(MissingReason::OutOfRange);
            assert_eq!(reading, if axis == channel { out } else { Reading::Fresh(0.0) });
        }
    }
}

#[test]
fn a_dead_bus_is_missing_and_comes_back() {
    let table = Table::new();
    let bench = bench(&table);
    let mut board = board(&bench);
    let cases = [
        (Some(SpiFault::Ones), Reading::Missing(MissingReason::Bus)),
        (Some(SpiFault::Zeros), Reading::Missing(MissingReason::OutOfRange)),
        (Some(SpiFault::Error), Reading::Missing(MissingReason::Bus)),
        (None, Reading::Fresh(0.0)),
    ];
    for (spi, expected) in cases {
        bench.set_faults(Faults { spi, ..Faults::default() });
        let samples = board.sample();
        assert_eq!(samples.field_t, [expected; 3], "{spi:?}");
        assert_eq!(samples.rate_rad_s, [expected; 3], "{spi:?}");
    }
}

#[test]
fn the_converter_without_supply_is_an_error_and_counted() {
    let table = Table::new();
    let bench = bench(&table);
    table.borrow_mut().powered = false;
    let error = Mcp3208::new(bench.converter(Converter::Main)).convert(Channel::new(0).unwrap());
    assert_eq!(error, Err(Error::Bus(DeviceError::Violation(Violation::Unpowered))));
    assert_eq!(bench.violations(), Violations { count: 1, last: Some(Violation::Unpowered) });
    assert!(table.borrow().conversions.is_empty());
}

#[test]
fn a_borrowed_world_is_an_error_not_a_panic() {
    let table = Table::new();
    let bench = bench(&table);
    let _held = table.borrow();
    let error = Mcp3208::new(bench.converter(Converter::Main)).convert(Channel::new(0).unwrap());
    assert_eq!(error, Err(Error::Bus(DeviceError::PlantBusy)));
    assert_eq!(bench.sleep().set_high(), Err(DeviceError::PlantBusy));
}

#[test]
fn frames_that_the_data_sheet_does_not_have_are_refused_and_counted() {
    let table = Table::new();
    let bench = bench(&table);
    let mut spi = bench.converter(Converter::Main);
    let refused = |found: Violation, result: Result<(), DeviceError>| {
        assert_eq!(result, Err(DeviceError::Violation(found)));
        assert_eq!(bench.violations().last, Some(found));
    };
    let mut reply = [0; 3];
    refused(
        Violation::FrameLength { written: 2, read: 3 },
        spi.transfer(&mut reply, &[0x06, 0x00]),
    );
    refused(
        Violation::FrameLength { written: 4, read: 4 },
        spi.transfer_in_place(&mut [0x06, 0, 0, 0]),
    );
    refused(
        Violation::Command(CommandError::Start { found: 0x18 }),
        spi.transfer(&mut reply, &[0x18, 0x00, 0x00]),
    );
    refused(
        Violation::Command(CommandError::Differential { found: 0x04 }),
        spi.transfer(&mut reply, &[0x04, 0x00, 0x00]),
    );
    refused(
        Violation::Command(CommandError::DontCare { found: [0x3F, 0x00] }),
        spi.transfer(&mut reply, &[0x06, 0x3F, 0x00]),
    );
    refused(Violation::OneWay, spi.write(&[0x06, 0x00, 0x00]));
    refused(
        Violation::Pieces { found: 2 },
        spi.transaction(&mut [Operation::Write(&[0x06]), Operation::Read(&mut [0; 2])]),
    );
    refused(Violation::Pieces { found: 0 }, spi.transaction(&mut []));
    assert_eq!(bench.violations().count, 8);
    assert!(table.borrow().conversions.is_empty());
}

#[test]
fn a_transfer_in_place_answers_like_any_other() {
    let table = Table::new();
    let bench = bench(&table);
    let mut bytes = registers::encode_command(Channel::new(6).unwrap());
    bench.converter(Converter::Main).transfer_in_place(&mut bytes).unwrap();
    assert_eq!(bytes, [0xFF, 0b1110_1000, 0x00]);
}

#[test]
fn the_windings_get_what_the_driver_says_it_made() {
    let table = Table::new();
    let bench = bench(&table);
    let mut board = board(&bench);
    for asked in [[0.6, -0.6, 0.1], [-0.3, 0.2, -0.6], [0.0, 0.0, 1e-5], [9.0, -9.0, 0.0]] {
        let made = board.drive(Vector::new(asked[0], asked[1], asked[2])).unwrap().to_array();
        for axis in 0..3 {
            let clipped = asked[axis].clamp(-0.6, 0.6);
            assert!((made[axis] - clipped).abs() <= 0.5 * STEP_AM2 + ROUNDING_AM2);
            let winding_am2 = table.borrow().windings[axis] as f32 * 0.6;
            assert!((winding_am2 - made[axis]).abs() <= ROUNDING_AM2);
        }
    }
    assert_eq!(bench.violations(), Violations::default());
}

#[test]
fn whatever_pin_breaks_no_reachable_winding_keeps_its_drive() {
    let flag = |axis: usize| core::array::from_fn(|other| other == axis);
    let pin = |axis: usize| TorquerFault::Pin { axis: axis as u8 };
    let mut cases = vec![(Faults { sleep: true, ..Faults::default() }, TorquerFault::Sleep)];
    for axis in 0..3 {
        cases.push((Faults { enable: flag(axis), ..Faults::default() }, pin(axis)));
        cases.push((Faults { phase: flag(axis), ..Faults::default() }, pin(axis)));
    }
    for (faults, fault) in cases {
        let table = Table::new();
        let bench = bench(&table);
        let mut board = board(&bench);
        board.drive(Vector::new(0.3, 0.3, 0.3)).unwrap();
        assert_eq!(table.borrow().windings, [0.5; 3]);
        bench.set_faults(faults);
        assert_eq!(board.drive(Vector::new(-0.3, -0.3, -0.3)), Err(fault));
        assert_eq!(table.borrow().windings, [0.0; 3], "{faults:?}");
        bench.set_faults(Faults::default());
        assert!(board.drive(Vector::new(-0.3, -0.3, -0.3)).is_ok());
        assert_eq!(table.borrow().windings, [-0.5; 3]);
        assert_eq!(bench.violations(), Violations::default());
    }
}

#[test]
fn only_a_dead_enable_together_with_a_dead_sleep_line_leaves_its_own_winding_on() {
    let table = Table::new();
    let bench = bench(&table);
    let mut board = board(&bench);
    board.drive(Vector::new(0.3, 0.3, 0.3)).unwrap();
    bench.set_faults(Faults { enable: [false, true, false], sleep: true, ..Faults::default() });
    assert_eq!(board.drive(Vector::zero()), Err(TorquerFault::Pin { axis: 1 }));
    assert_eq!(table.borrow().windings, [0.0, 0.5, 0.0]);
}

#[test]
fn turning_a_driven_bridge_round_is_refused_and_counted() {
    let table = Table::new();
    let bench = bench(&table);
    let [mut enable, ..] = bench.enable();
    let [mut phase, ..] = bench.phase();
    bench.sleep().set_high().unwrap();
    enable.set_duty_cycle(1).unwrap();
    phase.set_low().unwrap();
    let violation = Violation::PhaseUnderDrive { axis: 0 };
    assert_eq!(phase.set_high(), Err(DeviceError::Violation(violation)));
    assert_eq!(bench.violations(), Violations { count: 1, last: Some(violation) });
    assert!(table.borrow().windings[0] > 0.0);
    enable.set_duty_cycle(0).unwrap();
    assert_eq!(phase.set_high(), Ok(()));
}

#[test]
fn a_duty_above_the_maximum_is_refused_and_counted() {
    let table = Table::new();
    let bench = bench(&table);
    let [.., mut enable] = bench.enable();
    let violation = Violation::Duty { axis: 2, found: 4201 };
    assert_eq!(enable.set_duty_cycle(4201), Err(DeviceError::Violation(violation)));
    assert_eq!(
        DeviceError::Violation(violation).to_string(),
        "misused device: torquer 2: duty 4201 is above the timer's maximum"
    );
}

#[test]
fn a_sleeping_or_unpowered_bridge_drives_nothing() {
    let table = Table::new();
    let bench = bench(&table);
    let [mut enable, ..] = bench.enable();
    enable.set_duty_cycle(4200).unwrap();
    assert_eq!(table.borrow().windings[0], 0.0);
    bench.sleep().set_high().unwrap();
    assert_eq!(table.borrow().windings[0], 1.0);
    table.borrow_mut().powered = false;
    enable.set_duty_cycle(4200).unwrap();
    assert_eq!(table.borrow().windings[0], 0.0);
}

proptest! {
    #[test]
    fn no_voltage_makes_a_reading_that_is_not_finite(volts in prop::array::uniform8(any::<f64>())) {
        let table = Table::new();
        table.borrow_mut().volts = volts;
        let bench = bench(&table);
        let samples = board(&bench).sample();
        for reading in samples.field_t.into_iter().chain(samples.rate_rad_s) {
            prop_assert!(reading.value().is_none_or(f32::is_finite));
        }
    }

    #[test]
    fn no_dipole_drives_a_winding_beyond_its_limit(
        dipoles in prop::collection::vec(prop::array::uniform3(any::<f32>()), 1..8),
        max_duty in 1..=u16::MAX,
    ) {
        let table = Table::new();
        let bench = Bench::new(&table, BenchConfig { max_duty, ..BenchConfig::default() });
        let mut board = board(&bench);
        for [x, y, z] in dipoles {
            let dipole: Vector<TorquerAxes> = Vector::new(x, y, z);
            let made = board.drive(dipole);
            prop_assert!(table.borrow().windings.iter().all(|drive| drive.abs() <= 1.0));
            match made {
                Ok(made) => {
                    prop_assert!(made.to_array().iter().all(|made_am2| made_am2.abs() <= 0.6));
                }
                Err(fault) => {
                    prop_assert_eq!(fault, TorquerFault::NotFinite);
                    prop_assert!(!dipole.is_finite());
                    prop_assert_eq!(table.borrow().windings, [0.0; 3]);
                }
            }
        }
        prop_assert_eq!(bench.violations(), Violations::default());
    }

    #[test]
    fn no_bytes_on_the_bus_make_the_chip_or_the_driver_panic(
        command in prop::collection::vec(any::<u8>(), 0..6),
    ) {
        let table = Table::new();
        let bench = bench(&table);
        let mut reply = vec![0; command.len()];
        let answered = bench.converter(Converter::Main).transfer(&mut reply, &command).is_ok();
        prop_assert_eq!(bench.violations().count, u32::from(!answered));
        if let Ok(reply) = <[u8; 3]>::try_from(reply.as_slice()) {
            let _ = registers::decode_reply(reply);
        }
    }
}
