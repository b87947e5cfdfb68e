//! How well the filters do: many simulated flights, both filters on the same measurements, beside the
//! bounds that no filter can beat.
//!
//! | file | what |
//! |---|---|
//! | `scene` | what is flown, and what the filters are told wrongly |
//! | `truth` | the satellite as it is: rigid body, torques, sensors, closed loop |
//! | `run` | one flight through the filters and their bounds |
//! | `figures` | errors pooled over flights |
//! | `campaign` | all flights of a scene, side by side on all cores |

pub mod campaign;
pub mod figures;
pub mod run;
pub mod scene;
pub mod truth;
