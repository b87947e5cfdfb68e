//! The command `adcs` as a library, so that tests can call what the command calls.
