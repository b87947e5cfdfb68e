//! The flight application: one object that flies on the host, on the emulated core and on the board.
#![no_std]
#![forbid(unsafe_code)]
