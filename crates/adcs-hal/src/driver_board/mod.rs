//! The board made of drivers: MCP3208 behind the sensors, one DRV8838 a torquer, one clock.
//!
//! The one real implementation of [`Board`]. It is generic over the embedded-hal buses and pins
//! beneath, and these alone differ between the simulation, the emulated core and the satellite.
//!
//! | generic | what | on the satellite |
//! |---|---|---|
//! | `Spi` | a converter's bus with its chip select | SPI peripheral and a pin |
//! | `Pwm` | EN of each H-bridge | three channels of a timer |
//! | `Phase` | PH of each H-bridge | three pins |
//! | `Sleep` | nSLEEP, common to the three H-bridges | one pin |
//! | `C` | [`Clock`] | real-time clock or timer |
//!
//! The three PWM channels have one type, as have the three pins and the buses of the converters:
//! where a HAL gives each its own, its erased form is meant.
//!
//! Sensors are read in a fixed order, magnetometer x, y, z, gyros x, y, z, then the Sun sensors from
//! 0 to 5 with X1, X2, Y1, Y2 of each, all once. A board may have no Sun sensors.

mod config;
#[cfg(test)]
mod tests;

use adcs_core::frames::{TorquerAxes, Vector};
use adcs_core::reading::{MissingReason, Reading};
use adcs_core::time::Utc;
use embedded_hal::digital::{OutputPin, PinState};
use embedded_hal::pwm::SetDutyCycle;
use embedded_hal::spi::SpiDevice;

use crate::analog_triad::{AnalogTriad, ConverterConfig};
use crate::board::{Board, Samples, TorquerFault};
use crate::drv8838::Drv8838;
use crate::mcp3208::Mcp3208;
use crate::psd_face::{CONVERTERS, FACES, PsdFace, PsdFaceConfig};

pub use config::{ConfigError, DriverBoardConfig};

/// Tells the time.
pub trait Clock {
    /// The instant of this call.
    fn now(&mut self) -> Utc;
}

/// The buses and pins of a board.
#[derive(Debug)]
pub struct Parts<Spi, Pwm, Phase, Sleep, C> {
    /// The bus of the converter behind magnetometer and gyros, in
    /// [`mcp3208::MODE`](crate::mcp3208::MODE).
    pub spi: Spi,
    /// Those of the converters behind the Sun sensors, where there are any.
    pub sun_spi: Option<[Spi; CONVERTERS]>,
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
    sun: Option<SunSensors<Spi>>,
    torquers: [Torquer<Pwm, Phase>; 3],
    sleep: Sleep,
    clock: C,
}

/// The Sun sensors and their converters.
#[derive(Debug)]
struct SunSensors<Spi> {
    converters: [Mcp3208<Spi>; CONVERTERS],
    faces: [PsdFace; FACES],
}

impl<Spi: SpiDevice> SunSensors<Spi> {
    fn new(
        faces: [PsdFaceConfig; FACES],
        converter: ConverterConfig,
        buses: [Spi; CONVERTERS],
    ) -> Result<Self, ConfigError> {
        let face = |face, config| {
            PsdFace::new(config, converter).map_err(|error| ConfigError::SunFace { face, error })
        };
        let [a, b, c, d, e, f] = faces;
        let faces = [face(0, a)?, face(1, b)?, face(2, c)?, face(3, d)?, face(4, e)?, face(5, f)?];
        refuse_shared(&faces)?;
        Ok(Self { converters: buses.map(Mcp3208::new), faces })
    }

    fn read(&mut self) -> [Reading<[f32; 4]>; FACES] {
        let Self { converters, faces } = self;
        faces.map(|face| match converters.get_mut(usize::from(face.converter())) {
            Some(converter) => face.read(converter),
            // Excluded when the face was accepted.
            None => Reading::Missing(MissingReason::NotFitted),
        })
    }
}

/// Each input of each converter belongs to one face.
fn refuse_shared(faces: &[PsdFace; FACES]) -> Result<(), ConfigError> {
    for (number, face) in (0_u8..).zip(faces) {
        let earlier = faces.iter().take(usize::from(number));
        for other in earlier.filter(|other| other.converter() == face.converter()) {
            let shared = face.channels().into_iter().find(|c| other.channels().contains(c));
            if let Some(channel) = shared {
                let channel = channel.number();
                return Err(ConfigError::SunChannelShared { face: number, channel });
            }
        }
    }
    Ok(())
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
        let sun = match (config.sun, parts.sun_spi) {
            (Some(faces), Some(buses)) => Some(SunSensors::new(faces, config.converter, buses)?),
            (Some(_), None) => return Err(ConfigError::NoSunConverters),
            (None, _) => None,
        };
        let [enable_x, enable_y, enable_z] = parts.enable;
        let [phase_x, phase_y, phase_z] = parts.phase;
        let [max_x, max_y, max_z] = config.max_dipole_am2;
        let mut board = Self {
            converter: Mcp3208::new(parts.spi),
            magnetometer,
            gyro,
            sun,
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
        let sun_a = self.sun.as_mut().map_or(Samples::NO_SUN_SENSORS, SunSensors::read);
        Samples { rate_rad_s, field_t, sun_a }
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
