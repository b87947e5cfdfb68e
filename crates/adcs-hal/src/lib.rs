//! Drivers for a small satellite's ADCS on embedded-hal 1.0, and the Board trait.
#![no_std]
#![forbid(unsafe_code)]
