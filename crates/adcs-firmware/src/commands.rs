//! What the emulated image can be asked to do.
//!
//! | command line | what happens |
//! |---|---|
//! | `fly SCENARIO RECORDS` | flies the scenario in the first file, writes the records to the second |
//! | `version` | says what it is |
//! | `panic`, `fault`, `overflow` | switches the torquers on, then dies that way |
//!
//! While it flies it prints `progress CYCLE CYCLES`, at the end `digest HEX`, `violations COUNT`
//! and `stack PEAK SIZE` (bytes). Errors are lines that begin with `error:`.
//!
//! Exit codes: 0 done; 1 the flight failed; 2 wrong command line; 101 the image died, and this is
//! its next boot.

use adcs_firmware::{boot::Boot, memory, rehearsal};
use adcs_link::message;
use adcs_sim::scenario;
use semihosting::{eprintln, process::exit};

use crate::flight;

/// Exit code of a flight that could not begin or not end.
const FAILED: i32 = 1;
/// Exit code of a wrong command line.
const USAGE: i32 = 2;
/// Exit code after a death, as of a Rust program that panicked.
const DIED: i32 = 101;
/// Longest command line, bytes.
const COMMAND_LINE_BYTES: usize = 1024;

/// Does what the command line says and ends the emulation. After a death the command line is the
/// same as before, so the epitaph is reported and nothing is repeated.
pub fn run(boot: &Boot) -> ! {
    if let Some(epitaph) = &boot.epitaph {
        eprintln!("epitaph: {epitaph}");
        exit(DIED);
    }
    let Ok(words) = semihosting::experimental::env::args::<COMMAND_LINE_BYTES>() else {
        eprintln!("error: no command line, or one longer than {COMMAND_LINE_BYTES} bytes");
        exit(USAGE);
    };
    // The first word is the program's name.
    let mut words = words.skip(1).map(|word| word.unwrap_or(""));
    match words.next() {
        Some("fly") => match (words.next(), words.next(), words.next()) {
            (Some(scenario), Some(records), None) => fly(scenario, records),
            _ => {
                eprintln!("error: usage: fly SCENARIO RECORDS");
                exit(USAGE);
            }
        },
        Some("version") => {
            let (scenario, messages) = (scenario::VERSION, message::VERSION);
            eprintln!(
                "adcs-firmware {} scenario {scenario} messages {messages}",
                env!("CARGO_PKG_VERSION")
            );
            exit(0);
        }
        Some("panic") => rehearsal::panic(),
        Some("fault") => rehearsal::fault(),
        Some("overflow") => rehearsal::overflow(),
        other => {
            eprintln!("error: unknown command {:?}", other.unwrap_or(""));
            exit(USAGE);
        }
    }
}

fn fly(scenario: &str, records: &str) -> ! {
    match flight::fly(scenario, records) {
        Ok(end) => {
            let stack = memory::stack_use();
            eprintln!("digest {:016x}", end.digest);
            eprintln!("violations {}", end.violations);
            eprintln!("stack {} {}", stack.peak_bytes, stack.size_bytes);
            exit(0);
        }
        Err(error) => {
            eprintln!("error: {error}");
            exit(FAILED);
        }
    }
}
