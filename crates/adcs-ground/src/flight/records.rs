//! `records.bin`: the framed messages of a flight, one behind the other.

use std::fs::{self, File};
use std::io::{self, BufWriter, Write as _};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use adcs_link::frame::{self, MAX_FRAME};
use adcs_link::message::{self, End, Hello, Message};
use adcs_link::{CycleRecord, Digest, TruthRecord};
use anyhow::{Context as _, Result, bail};

/// What a flight that is killed may lose at most.
const FLUSH_EVERY: Duration = Duration::from_millis(100);

/// Writes records as they come.
#[derive(Debug)]
pub struct Writer {
    path: PathBuf,
    file: BufWriter<File>,
    flushed: Instant,
}

impl Writer {
    /// Creates the file, or empties it.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn create(path: &Path) -> Result<Self> {
        let file =
            File::create(path).with_context(|| format!("{} cannot be written", path.display()))?;
        Ok(Self { path: path.to_owned(), file: BufWriter::new(file), flushed: Instant::now() })
    }

    /// Appends a message.
    ///
    /// # Errors
    /// When the file cannot be written, for example because the disk is full.
    pub fn write(&mut self, message: &Message) -> Result<()> {
        let mut buffer = [0; MAX_FRAME];
        let bytes = frame::encode(message, &mut buffer)?;
        let mut append = || -> io::Result<()> {
            self.file.write_all(bytes)?;
            if self.flushed.elapsed() > FLUSH_EVERY {
                self.file.flush()?;
                self.flushed = Instant::now();
            }
            Ok(())
        };
        append().with_context(|| format!("{} cannot be written", self.path.display()))
    }

    /// Hands everything to the file.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn finish(mut self) -> Result<()> {
        self.file.flush().with_context(|| format!("{} cannot be written", self.path.display()))
    }
}

/// One cycle: what was so, and what the satellite made of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Step {
    /// The true state at its start.
    pub truth: TruthRecord,
    /// What it measured, thought and did.
    pub record: CycleRecord,
}

/// What was flown, as far as it was recorded.
#[derive(Debug, Clone, PartialEq)]
pub struct Flown {
    /// How it was announced.
    pub hello: Hello,
    /// Cycle by cycle.
    pub steps: Vec<Step>,
    /// How it was closed; `None` when it was cut off.
    pub end: Option<End>,
    /// Digest over the steps that are here.
    pub digest: u64,
    /// Frames that could not be read. The last one of a flight that was cut off is often among them.
    pub lost_frames: usize,
}

impl Flown {
    /// Reads the records of a flight, also of one that was cut off.
    ///
    /// # Errors
    /// When the file cannot be read, or holds no records of this version.
    pub fn read(path: &Path) -> Result<Self> {
        let bytes = fs::read(path).with_context(|| format!("{} cannot be read", path.display()))?;
        Self::decode(bytes).with_context(|| format!("{}", path.display()))
    }

    fn decode(mut bytes: Vec<u8>) -> Result<Self> {
        let mut frames = bytes.split_mut(|&byte| byte == 0);
        let first = frames.next().and_then(|first| frame::decode(first).ok());
        let Some(Message::Hello(hello)) = first else {
            bail!("no records of a flight (they begin with a hello, and this does not)");
        };
        if hello.version != message::VERSION {
            bail!(
                "records of version {}; this program reads version {}",
                hello.version,
                message::VERSION
            );
        }
        let mut flown = Self { hello, steps: Vec::new(), end: None, digest: 0, lost_frames: 0 };
        let mut digest = Digest::default();
        let mut last_truth = None;
        for frame in frames.filter(|frame| !frame.is_empty()) {
            let Ok(message) = frame::decode(frame) else {
                flown.lost_frames += 1;
                continue;
            };
            frame::digest(&message, &mut digest)?;
            match message {
                Message::Truth(truth) => last_truth = Some(truth),
                Message::Cycle(record) => {
                    // A cycle whose truth was lost is left out.
                    let truth = last_truth.take().filter(|truth| truth.cycle == record.cycle);
                    flown.steps.extend(truth.map(|truth| Step { truth, record }));
                }
                Message::End(end) => flown.end = Some(end),
                Message::Hello(_) => bail!("the records of two flights, one behind the other"),
            }
        }
        flown.digest = digest.value();
        Ok(flown)
    }

    /// Seconds from the start to the start of a cycle.
    pub fn time_s(&self, cycle: u32) -> f64 {
        f64::from(cycle) * self.cycle_s()
    }

    /// The cycle period, s.
    pub fn cycle_s(&self) -> f64 {
        f64::from(self.hello.cycle_us) / 1e6
    }

    /// How far the records go, s.
    pub fn flown_s(&self) -> f64 {
        self.steps.last().map_or(0.0, |step| self.time_s(step.record.cycle))
    }

    /// How far they were meant to go, s.
    pub fn planned_s(&self) -> f64 {
        self.time_s(self.hello.cycles)
    }

    /// Whether nothing is missing: closed, no frame lost, and the digest is that of the flight.
    pub fn is_whole(&self) -> bool {
        self.lost_frames == 0 && self.end.is_some_and(|end| end.digest == self.digest)
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use adcs_core::pipeline::ControlStatus;
    use adcs_core::reading::{MissingReason, Reading};
    use adcs_core::schedule::Phase;
    use adcs_core::sensing::SunSighting;
    use adcs_core::sensing::sun_faces::FACES;
    use adcs_core::time::Utc;

    const CYCLE_US: u32 = 500_000;

    fn step(cycle: u32) -> Step {
        let truth = TruthRecord {
            cycle,
            attitude_xyzw: [0.0, 0.0, 0.0, 1.0],
            omega_bi_rad_s: [0.1, 0.2, 0.0],
            position_eci_m: [7e6, 0.0, 0.0],
            field_eci_t: [0.0, 0.0, 3e-5],
            kinetic_energy_j: 1e-3,
            torquer_dipole_body_am2: [0.0; 3],
            sun_eci: [1.0, 0.0, 0.0],
            sunlit: true,
        };
        let record = CycleRecord {
            cycle,
            utc: Utc::from_micros_since_2000(i64::from(cycle) * i64::from(CYCLE_US)),
            phase: Phase::Settling,
            gyro_rad_s: [0.1, 0.2, 0.0].map(Reading::Fresh),
            magnetometer_t: [0.0, 0.0, 3e-5].map(Reading::Fresh),
            sun_a: [Reading::Missing(MissingReason::NotFitted); FACES],
            omega_bi_rad_s: Reading::Fresh([0.1, 0.2, 0.0]),
            field_body_t: Reading::Fresh([0.0, 0.0, 3e-5]),
            sun: Reading::Missing(MissingReason::NotFitted),
            sun_faces: SunSighting::NOT_FITTED.faces,
            position_eci_m: Some([7e6, 0.0, 0.0]),
            reference_field_eci_t: Some([0.0, 0.0, 3e-5]),
            reference_sun_eci: Some([1.0, 0.0, 0.0]),
            sunlit: Some(1.0),
            determination: None,
            mode: None,
            commissioning: None,
            committed: false,
            control: ControlStatus::Resting,
            pointing_error_rad: None,
            commanded_am2: [0.0; 3],
            driven_am2: Some([0.0; 3]),
            saturated: [false; 3],
        };
        Step { truth, record }
    }

    /// The records of a flight of `steps` cycles that does nothing.
    pub(crate) fn flown(steps: u32) -> Flown {
        let hello = Hello { version: message::VERSION, cycles: steps, cycle_us: CYCLE_US };
        let steps = (0..steps).map(step).collect();
        Flown { hello, steps, end: None, digest: 0, lost_frames: 0 }
    }

    /// The bytes of a flight of `steps` cycles, closed.
    fn bytes(steps: u32) -> Vec<u8> {
        let flown = flown(steps);
        let mut digest = Digest::default();
        let mut all = vec![Message::Hello(flown.hello)];
        for step in flown.steps {
            all.extend([Message::Truth(step.truth), Message::Cycle(step.record)]);
        }
        for message in &all {
            frame::digest(message, &mut digest).unwrap();
        }
        all.push(Message::End(End { cycles: steps, digest: digest.value(), violations: 0 }));
        let mut buffer = [0; MAX_FRAME];
        all.iter()
            .flat_map(|message| frame::encode(message, &mut buffer).unwrap().to_vec())
            .collect()
    }

    #[test]
    fn a_whole_flight_comes_back_and_says_so() {
        let flown = Flown::decode(bytes(5)).unwrap();
        assert!(flown.is_whole());
        assert_eq!(flown.steps, self::flown(5).steps);
        assert_eq!((flown.flown_s(), flown.planned_s()), (2.0, 2.5));
    }

    #[test]
    fn wherever_it_is_cut_off_all_cycles_before_the_cut_are_read() {
        let whole = bytes(5);
        let hello_end = whole.iter().position(|&byte| byte == 0).unwrap() + 1;
        let mut steps = 0;
        for cut in hello_end..whole.len() - 1 {
            let flown = Flown::decode(whole[..cut].to_vec()).unwrap();
            assert!(!flown.is_whole() && flown.end.is_none());
            assert!(flown.steps.len() >= steps && flown.lost_frames <= 1);
            steps = flown.steps.len();
        }
        assert_eq!(steps, 5);
    }

    #[test]
    fn a_damaged_frame_costs_its_cycle_and_no_other() {
        let mut damaged = bytes(5);
        let middle = damaged.len() / 2;
        damaged[middle] ^= 0x10;
        let flown = Flown::decode(damaged).unwrap();
        assert!(!flown.is_whole());
        assert!(flown.lost_frames >= 1 && flown.steps.len() >= 3, "{flown:?}");
    }

    #[test]
    fn something_else_than_records_is_refused() {
        for other in [&b""[..], b"\0", b"time,rate\n1,2\n", &[7; 400]] {
            let error = Flown::decode(other.to_vec()).unwrap_err().to_string();
            assert!(error.contains("no records of a flight"), "{error}");
        }
    }

    #[test]
    fn records_of_another_version_are_refused_with_the_version() {
        let hello = Hello { version: message::VERSION + 1, cycles: 1, cycle_us: 1 };
        let mut buffer = [0; MAX_FRAME];
        let bytes = frame::encode(&Message::Hello(hello), &mut buffer).unwrap().to_vec();
        let error = Flown::decode(bytes).unwrap_err().to_string();
        assert!(error.contains(&format!("version {}", message::VERSION + 1)), "{error}");
    }

    #[test]
    fn a_folder_that_is_not_there_is_named() {
        let error = Writer::create(Path::new("no/such/folder/records.bin")).unwrap_err();
        assert!(format!("{error:#}").starts_with("no/such/folder/records.bin cannot be written"));
    }
}
