//! Mission files: what they become, and what is refused in them.

mod commissioned;
mod guidance;
mod loads;
mod modes;
mod refused;
mod workshop;
