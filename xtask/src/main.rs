//! Set-up, tests, emulation, budgets.
mod igrf_table;

fn main() {}
