//! Truth for the flight application: rigid body, torques, orbit, sensors, and register-level device models.
#![no_std]
#![forbid(unsafe_code)]
