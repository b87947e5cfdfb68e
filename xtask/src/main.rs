//! Set-up, tests, emulation, budgets.
fn main() {}
