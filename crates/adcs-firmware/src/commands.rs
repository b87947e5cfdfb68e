//! What the emulated image can be asked to do.
//!
//! | command line | what happens |
//! |---|---|
//! | `version` | says what it is |
//! | `panic`, `fault`, `overflow` | switches the torquers on, then dies that way |
//!
//! Exit codes: 0 done; 2 wrong command line; 101 the image died and this is its next boot.

use adcs_firmware::{boot::Boot, rehearsal};
use semihosting::{eprintln, process::exit};

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
        Some("version") => {
            eprintln!("adcs-firmware {}", env!("CARGO_PKG_VERSION"));
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
