//! How well the satellite points with magnets alone: many flights of eight orbits in each world.
//!
//! | file | what |
//! |---|---|
//! | `case` | the worlds, and what the flight knows of them |
//! | `flight` | one flight |
//! | `knowing` | stages II and III with what a perfect stage II would say |
//! | `figures` | angles pooled over flights |

pub mod case;
pub mod figures;
pub mod flight;
mod knowing;
