//! The mathematics of a small satellite's attitude determination and control: no bus, no pin, no clock.
#![no_std]
#![forbid(unsafe_code)]
