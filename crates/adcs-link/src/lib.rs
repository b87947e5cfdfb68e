//! What the ADCS, the C&DH computer and the ground say to each other: messages, and the frames that
//! carry them.
//!
//! A [`Message`] is encoded by postcard, closed by a CRC-32 and wrapped in COBS, so that a zero byte
//! stands at the end of every frame and nowhere else: a reader that joins late, or reads a file that
//! was cut off in mid-write, loses one frame and finds the next ([`frame`]). The [`digest`] over a
//! whole flight is what two flights are compared by.
#![no_std]
#![forbid(unsafe_code)]
#![cfg_attr(
    not(test),
    deny(
        clippy::unwrap_used,
        clippy::expect_used,
        clippy::panic,
        clippy::indexing_slicing,
        clippy::unreachable
    )
)]

pub mod digest;
pub mod frame;
pub mod message;

pub use digest::Digest;
pub use message::{CycleRecord, Message, SunRecord, TruthRecord};
