//! SGP4 orbit propagation for microcontrollers: TLE in, TEME position and velocity out.
#![no_std]
#![forbid(unsafe_code)]
