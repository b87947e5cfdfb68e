//! One file a command: its arguments, and what it does with the library.

pub mod mission;
