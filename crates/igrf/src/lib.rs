//! IGRF-14 geomagnetic field for microcontrollers.
#![no_std]
#![forbid(unsafe_code)]
