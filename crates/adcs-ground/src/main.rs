//! The command `adcs`.
fn main() {}
