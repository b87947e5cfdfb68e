//! The DRV8838s from the chips' side of their pins, and the timer that drives EN.
//!
//! What the three inputs do to the winding is [`logic`](adcs_hal::drv8838::logic), as in the driver;
//! the world gets the mean over a PWM period. Stricter than the chip and than most timers: a change
//! of direction while EN has a duty, and a duty above the timer's maximum, are refused and counted.

use embedded_hal::digital::{self, OutputPin, PinState};
use embedded_hal::pwm::{self, SetDutyCycle};

use super::{Bench, Bridge, DeviceError, Plant, Violation};

/// The PWM channel on EN of one bridge.
#[derive(Debug)]
pub struct SimEnable<'b, P> {
    bench: &'b Bench<'b, P>,
    bridge: &'b Bridge,
}

/// The pin at PH of one bridge.
#[derive(Debug)]
pub struct SimPhase<'b, P> {
    bench: &'b Bench<'b, P>,
    bridge: &'b Bridge,
}

/// The pin at nSLEEP of all bridges.
#[derive(Debug)]
pub struct SimSleep<'b, P> {
    bench: &'b Bench<'b, P>,
}

impl<'b, P: Plant> SimEnable<'b, P> {
    pub(super) fn new(bench: &'b Bench<'b, P>, bridge: &'b Bridge) -> Self {
        Self { bench, bridge }
    }
}

impl<'b, P: Plant> SimPhase<'b, P> {
    pub(super) fn new(bench: &'b Bench<'b, P>, bridge: &'b Bridge) -> Self {
        Self { bench, bridge }
    }
}

impl<'b, P: Plant> SimSleep<'b, P> {
    pub(super) fn new(bench: &'b Bench<'b, P>) -> Self {
        Self { bench }
    }
}

impl<P> pwm::ErrorType for SimEnable<'_, P> {
    type Error = DeviceError;
}
impl<P> digital::ErrorType for SimPhase<'_, P> {
    type Error = DeviceError;
}
impl<P> digital::ErrorType for SimSleep<'_, P> {
    type Error = DeviceError;
}

impl<P: Plant> SetDutyCycle for SimEnable<'_, P> {
    fn max_duty_cycle(&self) -> u16 {
        self.bench.config.max_duty
    }

    fn set_duty_cycle(&mut self, duty: u16) -> Result<(), DeviceError> {
        let Self { bench, bridge } = *self;
        if bridge.enable_refuses.get() {
            return Err(DeviceError::Injected);
        }
        if duty > bench.config.max_duty {
            return Err(bench.violated(Violation::Duty { axis: bridge.axis, found: duty }));
        }
        let mut plant = bench.plant()?;
        bridge.duty.set(duty);
        bench.drive_winding(&mut plant, bridge);
        Ok(())
    }
}

impl<P: Plant> OutputPin for SimPhase<'_, P> {
    fn set_low(&mut self) -> Result<(), DeviceError> {
        self.set_state(PinState::Low)
    }

    fn set_high(&mut self) -> Result<(), DeviceError> {
        self.set_state(PinState::High)
    }

    fn set_state(&mut self, state: PinState) -> Result<(), DeviceError> {
        let Self { bench, bridge } = *self;
        if bridge.phase_refuses.get() {
            return Err(DeviceError::Injected);
        }
        let phase = state == PinState::High;
        if bridge.phase.get() != phase && bridge.duty.get() != 0 {
            return Err(bench.violated(Violation::PhaseUnderDrive { axis: bridge.axis }));
        }
        let mut plant = bench.plant()?;
        bridge.phase.set(phase);
        bench.drive_winding(&mut plant, bridge);
        Ok(())
    }
}

impl<P: Plant> OutputPin for SimSleep<'_, P> {
    fn set_low(&mut self) -> Result<(), DeviceError> {
        self.set_state(PinState::Low)
    }

    fn set_high(&mut self) -> Result<(), DeviceError> {
        self.set_state(PinState::High)
    }

    fn set_state(&mut self, state: PinState) -> Result<(), DeviceError> {
        let bench = self.bench;
        if bench.sleep_refuses.get() {
            return Err(DeviceError::Injected);
        }
        let mut plant = bench.plant()?;
        bench.awake.set(state == PinState::High);
        for bridge in &bench.bridges {
            bench.drive_winding(&mut plant, bridge);
        }
        Ok(())
    }
}
