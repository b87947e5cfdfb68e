//! Frames: postcard, CRC-32, COBS.
//!
//! ```text
//! COBS( postcard(message) | CRC-32/ISO-HDLC, little-endian ) 0x00
//! ```

use core::fmt;

use postcard::ser_flavors::crc::CrcModifier;
use postcard::ser_flavors::{Cobs, Slice};

use crate::digest::Digest;
use crate::message::Message;

/// No frame is longer than this, bytes. That of the longest message, a cycle with every field
/// present and a rung of the commissioning ladder that ended, has 495 with its CRC, what COBS adds, and the zero.
pub const MAX_FRAME: usize = 512;

/// CRC-32 of the frames, as in Ethernet.
static CRC32: crc::Crc<u32> = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC);

/// Why bytes are not a frame, or a message no frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum FrameError {
    /// The frame is longer than [`MAX_FRAME`]: its end was lost, or it is none of ours.
    TooLong,
    /// The COBS code is broken.
    Cobs,
    /// The bytes are no message, or their CRC is wrong.
    Corrupt,
}

impl fmt::Display for FrameError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let text = match self {
            Self::TooLong => "longer than any frame",
            Self::Cobs => "broken COBS code",
            Self::Corrupt => "wrong CRC, or no message",
        };
        f.write_str(text)
    }
}

impl core::error::Error for FrameError {}

/// Encodes `message` into `buffer` and returns the frame, its closing zero included.
///
/// # Errors
/// [`FrameError::TooLong`] when `buffer` cannot hold it; [`MAX_FRAME`] bytes always do.
pub fn encode<'a>(message: &Message, buffer: &'a mut [u8]) -> Result<&'a mut [u8], FrameError> {
    let cobs = Cobs::try_new(Slice::new(buffer)).map_err(|_| FrameError::TooLong)?;
    postcard::serialize_with_flavor(message, CrcModifier::new(cobs, CRC32.digest()))
        .map_err(|_| FrameError::TooLong)
}

/// Decodes one frame (with or without its closing zero). The bytes are overwritten on the way.
///
/// # Errors
/// [`FrameError`]; the reader goes on after the next zero byte.
pub fn decode(frame: &mut [u8]) -> Result<Message, FrameError> {
    let length = cobs_decode(frame)?;
    let bytes = frame.get(..length).ok_or(FrameError::Cobs)?;
    postcard::from_bytes_crc32(bytes, CRC32.digest()).map_err(|_| FrameError::Corrupt)
}

fn cobs_decode(frame: &mut [u8]) -> Result<usize, FrameError> {
    cobs::decode_in_place(frame).map_err(|_| FrameError::Cobs)
}

/// Adds the postcard bytes of a cycle or truth message to a flight's digest; other messages do not
/// count.
///
/// # Errors
/// [`FrameError::TooLong`], which no message of this version can cause.
pub fn digest(message: &Message, digest: &mut Digest) -> Result<(), FrameError> {
    if matches!(message, Message::Cycle(_) | Message::Truth(_)) {
        let mut buffer = [0; MAX_FRAME];
        let bytes = postcard::to_slice(message, &mut buffer).map_err(|_| FrameError::TooLong)?;
        digest.update(bytes);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::message::{
        AttitudeRecord, CycleRecord, DeterminationRecord, End, Hello, RateRecord, SunRecord,
        VERSION,
    };
    use adcs_core::attitude::mekf::Lost;
    use adcs_core::attitude::selection::{AttitudeSource, RateSource, Reason};
    use adcs_core::commissioning::{
        Ended, Finding, LadderReport, MagnetometerFound, Outcome, Rung, Shortfall, Three,
    };
    use adcs_core::modes::{Cause, Mode, ModeReport, Transition};
    use adcs_core::pipeline::ControlStatus;
    use adcs_core::polarity::Suspect;
    use adcs_core::reading::{MissingReason, Reading};
    use adcs_core::schedule::Phase;
    use adcs_core::sensing::FaceVerdict;
    use adcs_core::sensing::sun_faces::FACES;
    use adcs_core::time::Utc;
    use proptest::prelude::*;

    const THREE: Three = Three { value: [f32::MAX; 3], sigma: [f32::MAX; 3] };

    /// That of the doc comment of [`MAX_FRAME`].
    const LONGEST_FRAME: usize = 495;

    fn longest() -> Message {
        Message::Cycle(CycleRecord {
            cycle: u32::MAX,
            utc: Utc::from_micros_since_2000(i64::MIN),
            phase: Phase::Acting,
            gyro_rad_s: [Reading::Fresh(f32::MAX); 3],
            magnetometer_t: [Reading::Fresh(f32::MIN); 3],
            sun_a: [Reading::Fresh([f32::MAX; 4]); FACES],
            omega_bi_rad_s: Reading::Fresh([f32::MAX; 3]),
            field_body_t: Reading::Fresh([f32::MAX; 3]),
            sun: Reading::Fresh(SunRecord {
                body: [1.0; 3],
                sigma_rad: f32::MAX,
                worst_residual_rad: f32::MAX,
            }),
            sun_faces: [FaceVerdict::Missing(MissingReason::NotFitted); FACES],
            position_eci_m: Some([f64::MAX; 3]),
            reference_field_eci_t: Some([f32::MAX; 3]),
            reference_sun_eci: Some([f32::MAX; 3]),
            sunlit: Some(f32::MAX),
            determination: Some(DeterminationRecord {
                attitude: Some(AttitudeRecord {
                    xyzw: [f32::MAX; 4],
                    sigma_rad: [f32::MAX; 3],
                    source: AttitudeSource::TwoVectors,
                }),
                rate: Some(RateRecord {
                    omega_bi_rad_s: [f32::MAX; 3],
                    sigma_rad_s: f32::MAX,
                    source: RateSource::AcrossField,
                }),
                reason: Reason::MekfLost(Lost::Uncertain),
                gyro_bias_rad_s: Some([f32::MAX; 3]),
                residual_dipole_am2: Some([f32::MAX; 3]),
                nis_field: Some(f32::MAX),
                nis_sun: Some(f32::MAX),
            }),
            mode: Some(ModeReport {
                mode: Mode::Experiment,
                transition: Some(Transition {
                    from: Mode::Experiment,
                    to: Mode::Experiment,
                    cause: Cause::Miswired(Suspect::DeadTorquers([true; 3])),
                }),
                refused: Some(Mode::Experiment),
                retries: u8::MAX,
            }),
            commissioning: Some(LadderReport {
                rung: Some(Rung::Inertia),
                ended: Some(Ended {
                    rung: Rung::Magnetometer,
                    outcome: Outcome::Failed(Shortfall::Miswired(Suspect::DeadTorquers([true; 3]))),
                    finding: Some(Finding::Magnetometer(MagnetometerFound {
                        scale: THREE,
                        cross_axis: THREE,
                        bias_t: THREE,
                        norm_error_t: f32::MAX,
                    })),
                }),
            }),
            committed: true,
            pointing_error_rad: Some(f32::MAX),
            control: ControlStatus::NoField(MissingReason::TorquersOn),
            commanded_am2: [f32::MAX; 3],
            driven_am2: Some([f32::MAX; 3]),
            saturated: [true; 3],
        })
    }

    #[test]
    fn the_longest_message_fits_and_comes_back() {
        let mut buffer = [0; MAX_FRAME];
        let frame = encode(&longest(), &mut buffer).unwrap();
        assert_eq!(frame.len(), LONGEST_FRAME);
        assert_eq!(frame.iter().filter(|&&byte| byte == 0).count(), 1);
        assert_eq!(frame.last(), Some(&0));
        assert_eq!(decode(frame), Ok(longest()));
    }

    #[test]
    fn a_buffer_that_is_too_small_is_an_error() {
        assert_eq!(encode(&longest(), &mut [0; 40]).unwrap_err(), FrameError::TooLong);
    }

    #[test]
    fn only_cycles_and_truths_count_into_the_digest() {
        let mut digest_value = Digest::default();
        let nothing = digest_value.value();
        let hello = Hello { version: VERSION, cycles: 3, cycle_us: 500_000 };
        digest(&Message::Hello(hello), &mut digest_value).unwrap();
        let end = End { cycles: 3, digest: 7, violations: 0 };
        digest(&Message::End(end), &mut digest_value).unwrap();
        assert_eq!(digest_value.value(), nothing);
        digest(&longest(), &mut digest_value).unwrap();
        assert_ne!(digest_value.value(), nothing);
    }

    proptest! {
        #[test]
        fn whatever_bytes_come_nothing_panics(mut bytes in prop::collection::vec(any::<u8>(), 0..400)) {
            let _ = decode(&mut bytes);
        }

        #[test]
        fn a_flipped_bit_is_found(at in 0_usize..1600, bit in 0_u8..8) {
            let mut buffer = [0; MAX_FRAME];
            let frame = encode(&longest(), &mut buffer).unwrap();
            let at = at % (frame.len() - 1);
            frame[at] ^= 1 << bit;
            prop_assert_ne!(decode(frame), Ok(longest()));
        }
    }
}
