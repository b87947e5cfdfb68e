//! What the ADCS, the C&DH computer and the ground say to each other.
#![no_std]
#![forbid(unsafe_code)]
