//! The image on the emulated STM32F405: started, listened to, waited for.
//!
//! ```text
//! scenario file ─► QEMU, adcs-firmware ─► record file
//!                   │ standard output: defmt frames, decoded with the image ─► log lines
//!                   └ standard error: progress, digest, errors
//! ```

use std::{
    env, fs,
    io::{BufRead as _, BufReader, Read},
    path::{Path, PathBuf},
    process::{Child, Command, Stdio},
    sync::mpsc::{self, RecvTimeoutError, Sender},
    thread,
    time::{Duration, Instant},
};

use anyhow::{Context as _, Result, bail};
use defmt_decoder::{DecodeError, Table};

use crate::flight::Watcher;

/// The emulator, when [`VARIABLE`] does not name another.
const PROGRAM: &str = "qemu-system-arm";
/// Names an emulator that is not on the search path.
const VARIABLE: &str = "ADCS_QEMU";
/// The board whose STM32F405 has flash at 0x0800_0000 and RAM at 0x2000_0000.
const MACHINE: &str = "netduinoplus2";
/// The image speaks at least once a hundredth of the flight. One that is silent for so long hangs.
const LONGEST_SILENCE: Duration = Duration::from_secs(120);
/// Names of the files in the output folder. The emulator runs there, so that no path with blanks
/// or commas goes through its command line.
const SCENARIO_FILE: &str = "scenario.bin";
const RECORDS_FILE: &str = "records.bin";
/// How long the wish to stop may go unheard.
const ATTENTION: Duration = Duration::from_millis(100);

/// An emulator and the image it runs.
#[derive(Debug, Clone)]
pub struct Emulator {
    program: PathBuf,
    image: PathBuf,
}

/// How an emulated flight ended.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Landing {
    /// The image's own digest.
    pub digest: u64,
    /// The most stack it used, bytes.
    pub stack_bytes: u32,
    /// What it recorded.
    pub records: PathBuf,
}

/// A line of the image's standard error.
#[derive(Debug, Clone, PartialEq, Eq)]
enum Line {
    Progress { cycle: u32, cycles: u32 },
    Digest(u64),
    Stack(u32),
    Failure(String),
    Other,
}

enum Heard {
    Log(String),
    Line(Line),
}

impl Emulator {
    /// `image` on the emulator that `ADCS_QEMU` names, else on the usual one.
    ///
    /// # Errors
    /// When the image is not there.
    pub fn new(image: &Path) -> Result<Self> {
        // The emulator runs in another folder.
        let image = image.canonicalize().with_context(|| {
            format!("no image at {}: build it with `cargo xtask image`", image.display())
        })?;
        let program = env::var_os(VARIABLE).unwrap_or_else(|| PROGRAM.into()).into();
        Ok(Self { program, image })
    }

    /// Flies the scenario (postcard bytes) and leaves the records in `folder`, those of an
    /// interrupted flight too. `watcher` is told how it goes; `None` when it wants to stop.
    ///
    /// # Errors
    /// When the emulator is missing, or the image refuses the scenario, dies, or hangs.
    pub fn fly(
        &self,
        scenario: &[u8],
        folder: &Path,
        watcher: &mut impl Watcher,
    ) -> Result<Option<Landing>> {
        let file = folder.join(SCENARIO_FILE);
        fs::write(&file, scenario).with_context(|| format!("writing {}", file.display()))?;
        let mut child = Running(self.start(folder)?);
        let heard = listen(&mut child.0, &self.image)?;

        let (mut digest, mut stack_bytes, mut failure) = (None, 0, None);
        let mut last_heard = Instant::now();
        loop {
            if watcher.wants_to_stop() {
                return Ok(None);
            }
            match heard.recv_timeout(ATTENTION) {
                Err(RecvTimeoutError::Disconnected) => break,
                Err(RecvTimeoutError::Timeout) => {
                    if last_heard.elapsed() > LONGEST_SILENCE {
                        let silence_s = LONGEST_SILENCE.as_secs();
                        bail!("the emulated image has been silent for {silence_s} s");
                    }
                    continue;
                }
                Ok(Heard::Log(text)) => watcher.log(&text),
                Ok(Heard::Line(Line::Progress { cycle, .. })) => watcher.cycle(cycle),
                Ok(Heard::Line(Line::Digest(value))) => digest = Some(value),
                Ok(Heard::Line(Line::Stack(bytes))) => stack_bytes = bytes,
                Ok(Heard::Line(Line::Failure(text))) => failure = Some(text),
                Ok(Heard::Line(Line::Other)) => {}
            }
            last_heard = Instant::now();
        }
        let status = child.0.wait()?;
        if let Some(text) = failure {
            bail!("the emulated image: {text}");
        }
        if !status.success() {
            bail!("the emulator failed: {status}");
        }
        let digest = digest.context("the emulated flight ended without a digest")?;
        Ok(Some(Landing { digest, stack_bytes, records: folder.join(RECORDS_FILE) }))
    }

    fn start(&self, folder: &Path) -> Result<Child> {
        let words = format!("arg=adcs,arg=fly,arg={SCENARIO_FILE},arg={RECORDS_FILE}");
        Command::new(&self.program)
            .args(["-machine", MACHINE, "-nographic", "-monitor", "none", "-serial", "none"])
            .args(["-semihosting-config", &format!("enable=on,target=native,{words}")])
            .arg("-kernel")
            .arg(&self.image)
            .current_dir(folder)
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .with_context(|| {
                format!(
                    "cannot start {}: install QEMU with `cargo xtask setup`, or name it in {VARIABLE}",
                    self.program.display()
                )
            })
    }
}

/// An emulator that does not outlive the flight, however that ends.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        // Both fail when it has ended already, as it should have.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Hears both outputs of the image until both end.
fn listen(child: &mut Child, image: &Path) -> Result<mpsc::Receiver<Heard>> {
    let logs = child.stdout.take().context("the emulator has no standard output")?;
    let lines = child.stderr.take().context("the emulator has no standard error")?;
    let elf = fs::read(image).with_context(|| format!("reading {}", image.display()))?;
    let table = Table::parse(&elf)
        .with_context(|| image.display().to_string())?
        .with_context(|| format!("{} has no table of log texts", image.display()))?;

    let (sender, receiver) = mpsc::channel();
    let log_sender = sender.clone();
    thread::spawn(move || decode(logs, &table, &log_sender));
    thread::spawn(move || {
        for text in BufReader::new(lines).lines().map_while(Result::ok) {
            if sender.send(Heard::Line(line(&text))).is_err() {
                break;
            }
        }
    });
    Ok(receiver)
}

/// Decodes log frames until the stream ends, or nobody listens any more.
fn decode(mut stream: impl Read, table: &Table, sender: &Sender<Heard>) {
    let mut decoder = table.new_stream_decoder();
    let mut buffer = [0; 1024];
    while let Ok(length @ 1..) = stream.read(&mut buffer) {
        decoder.received(&buffer[..length]);
        loop {
            let text = match decoder.decode() {
                Ok(frame) => {
                    let level = frame.level().map_or("", |level| level.as_str());
                    format!("{level:<5} {}", frame.display_message())
                }
                Err(DecodeError::UnexpectedEof) => break,
                Err(DecodeError::Malformed) => "a log line was lost".to_owned(),
            };
            if sender.send(Heard::Log(text)).is_err() {
                return;
            }
        }
    }
}

fn line(text: &str) -> Line {
    let mut words = text.split_whitespace();
    let mut word = || words.next().unwrap_or_default();
    match (word(), word(), word()) {
        ("progress", cycle, cycles) => match (cycle.parse(), cycles.parse()) {
            (Ok(cycle), Ok(cycles)) => Line::Progress { cycle, cycles },
            _ => Line::Other,
        },
        ("digest", hex, "") => u64::from_str_radix(hex, 16).map_or(Line::Other, Line::Digest),
        ("stack", peak, _) => peak.parse().map_or(Line::Other, Line::Stack),
        ("error:" | "epitaph:", ..) => Line::Failure(text.to_owned()),
        _ => Line::Other,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flight::Patient;

    #[test]
    fn lines_of_the_image_are_understood() {
        assert_eq!(line("progress 24 2400"), Line::Progress { cycle: 24, cycles: 2400 });
        assert_eq!(line("digest 00000000deadbeef"), Line::Digest(0xdead_beef));
        assert_eq!(line("stack 20308 65536"), Line::Stack(20_308));
        assert_eq!(line("error: no such file"), Line::Failure("error: no such file".into()));
        assert!(matches!(line("epitaph: panic at x"), Line::Failure(_)));
    }

    #[test]
    fn lines_of_the_emulator_and_broken_ones_are_passed_over() {
        for text in ["", "qemu-system-arm: warning: x", "progress x 1", "digest xyz", "stack -1"] {
            assert_eq!(line(text), Line::Other, "{text}");
        }
    }

    #[test]
    fn an_image_that_is_not_there_is_named_with_what_to_do() {
        let error = Emulator::new(Path::new("no/such/image.elf")).unwrap_err();
        let text = format!("{error:#}");
        assert!(text.contains("no/such/image.elf") && text.contains("xtask image"), "{text}");
    }

    #[test]
    fn an_emulator_that_is_not_there_is_an_error_that_says_how_to_get_it() {
        let emulator =
            Emulator { program: "no-such-emulator".into(), image: env::current_exe().unwrap() };
        let error = emulator.fly(&[], &env::temp_dir(), &mut Patient).unwrap_err();
        assert!(format!("{error:#}").contains("cargo xtask setup"), "{error:#}");
    }
}
