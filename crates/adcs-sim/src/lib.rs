//! Truth for the flight application: rigid body, torques, orbit, sensors, and register-level device
//! models.
//!
//! ```text
//!   scenario ─► World (rigid body, torques, orbit, field, sensors)
//!                 ▲ pins, volts            │
//!               devices (MCP3208, DRV8838) │ exact readings
//!                 ▲ embedded-hal           ▼
//!               DriverBoard            ExactBoard
//!                 └──────► FlightApp ◄─────┘
//! ```
//!
//! All of it is `no_std` and free of the platform's mathematics, so that the same flight runs on the
//! host and inside the image on the emulated core, with the same bits ([`fly`]).
#![no_std]
#![forbid(unsafe_code)]

pub mod devices;
pub mod earth_light;
pub mod exact_board;
pub mod fly;
pub mod noise;
pub mod rigid_body;
pub mod scenario;
pub mod sensor;
pub mod sun_sensors;
pub mod surroundings;
pub mod torques;
pub mod world;
