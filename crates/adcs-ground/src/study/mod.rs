//! How well filters and laws do, over many simulated flights.
//!
//! | file | what |
//! |---|---|
//! | `sprout` | the satellite as it was published |
//! | `random`, `satellite` | what moves it |
//! | `campaign` | many flights, side by side on all cores |
//!
//! Both filters on the same measurements, beside the bounds that no filter can beat:
//!
//! | file | what |
//! |---|---|
//! | `scene` | what is flown, and what the filters are told wrongly |
//! | `truth` | the satellite as it is: rigid body, torques, sensors, closed loop |
//! | `run` | one flight through the filters and their bounds |
//! | `figures` | errors pooled over flights |
//!
//! The flight code in a closed loop with a satellite that is not quite what it was told: `closed_loop`.

pub mod campaign;
pub mod closed_loop;
pub mod commissioning;
pub mod despin;
pub mod figures;
pub mod pointing;
pub mod polarity;
pub mod random;
pub mod run;
pub mod satellite;
pub mod scene;
pub mod sprout;
pub mod truth;
