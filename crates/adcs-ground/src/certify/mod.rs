//! Whether a pointing loop is stable: Floquet multipliers of the linearised loop, over a grid of orbits
//! and bodies.
//!
//! On target the loop of a magnetic satellite is linear with coefficients that change with the field:
//! x⁺ = A(t) x from round to round, x = (e, ω_e) in the target's axes. Over a day it comes to a matrix
//! Ψ, and the largest modulus of Ψ's eigenvalues, to the power of one over the orbits of the day, is
//! what an error is multiplied by each orbit: below one it dies out. Were the field periodic with the
//! orbit, these were the Floquet multipliers; as the Earth turns under the orbit, it is nearly periodic
//! with the day.
//!
//! | file | what |
//! |---|---|
//! | `plant` | the linear equations of the body on target |
//! | `closed_loop` | a day of rounds with the flight's own law |
//! | `grid` | orbits, seasons and bodies |
//! | `certificate` | the result as a file, and whether a mission is within it |
//! | `chart` | the result as a picture |
//!
//! Source: Wisniewski (1999), "Fully magnetic attitude control for spacecraft subject to gravity
//! gradient", Automatica 35, 1201–1214 (Floquet's theory for the magnetic loop).

mod certificate;
mod chart;
mod closed_loop;
mod grid;
mod plant;

pub use certificate::{Certificate, Entry};
pub use chart::svg;
pub use closed_loop::{Loop, multiplier};
pub use grid::{Body, Grid, Place};
