//! The emulated STM32F405: QEMU found or installed, and images run on it.

use std::{
    env,
    io::{BufRead as _, BufReader},
    path::{Path, PathBuf},
    process::{Command, Stdio},
    sync::mpsc,
    thread,
    time::{Duration, Instant},
};

use anyhow::{Context as _, Result, bail};

use crate::{packages, process::which};

const PROGRAM: &str = "qemu-system-arm";
/// The board whose STM32F405 has flash at 0x0800_0000 and RAM at 0x2000_0000.
const MACHINE: &str = "netduinoplus2";
/// Names an emulator that is not on the search path.
pub const VARIABLE: &str = "ADCS_QEMU";

/// The emulator that is there, or one just installed; else an error that says what to type.
pub fn find() -> Result<PathBuf> {
    if let Some(path) = present() {
        return Ok(path);
    }
    if packages::can_install() {
        packages::install(&[PROGRAM])?;
        return present().context("the package has no emulator");
    }
    bail!(
        "no {PROGRAM}. Install it with one of\n  {}\n  brew install qemu\n  \
         or name it in the environment variable {VARIABLE}",
        packages::command(&[PROGRAM])
    )
}

fn present() -> Option<PathBuf> {
    env::var_os(VARIABLE).map(PathBuf::from).or_else(|| which(PROGRAM))
}

/// Runs `image` with `words` as its command line, counting instructions: one takes 2⁷ ns of
/// emulated time, so that the emulated SysTick counts instructions, the same in every run.
/// Gives the lines the image printed.
pub fn run_counting(image: &Path, words: &[&str], limit: Duration) -> Result<Vec<String>> {
    let mut command = Command::new(find()?);
    command
        .args(["-machine", MACHINE, "-nographic", "-monitor", "none", "-serial", "none"])
        .args(["-icount", "shift=7", "-semihosting-config", &semihosting(words)])
        .arg("-kernel")
        .arg(image)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::piped());
    let mut child = command.spawn().context("cannot start the emulator")?;
    let text = child.stderr.take().context("the emulator has no standard error")?;

    let (sender, receiver) = mpsc::channel();
    let reader = thread::spawn(move || {
        for line in BufReader::new(text).lines().map_while(Result::ok) {
            if sender.send(line).is_err() {
                break;
            }
        }
    });
    let mut lines = Vec::new();
    let end = Instant::now() + limit;
    loop {
        match receiver.recv_timeout(end.saturating_duration_since(Instant::now())) {
            Ok(line) => lines.push(line),
            Err(mpsc::RecvTimeoutError::Disconnected) => break,
            Err(mpsc::RecvTimeoutError::Timeout) => {
                child.kill()?;
                child.wait()?;
                bail!("the emulated image did not end within {} s", limit.as_secs());
            }
        }
    }
    let status = child.wait()?;
    // The channel is closed, so the thread is at its end.
    let _ = reader.join();
    if !status.success() {
        bail!("the emulated image failed ({status}): {}", lines.join("\n"));
    }
    Ok(lines)
}

/// The emulator's option that hands `words` to the image. Commas separate options, so they are
/// doubled inside a word.
fn semihosting(words: &[&str]) -> String {
    let words = words.iter().map(|word| format!(",arg={}", word.replace(',', ",,")));
    format!("enable=on,target=native,arg=adcs{}", words.collect::<String>())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_comma_in_a_word_does_not_end_it() {
        assert_eq!(
            semihosting(&["fly", "a,b.bin"]),
            "enable=on,target=native,arg=adcs,arg=fly,arg=a,,b.bin"
        );
    }
}
