//! The commands of `adcs`, one a file.

mod console;
pub mod fly;
pub mod mission;
pub mod report;
