//! Records in RAM that outlives a reset: the value, then the CRC of it.
//!
//! The CRC is looked at when the value has been read: whatever bytes lie there, reading them does no harm, and a
//! value whose CRC is wrong is dropped. To sum byte by byte on the way, as postcard's own CRC does, takes 4 KB
//! more of flash.

use crc::{CRC_32_ISO_HDLC, Crc};
use serde::{Deserialize, Serialize};

/// The CRC of Ethernet and zip.
static CRC: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// Writes `value` and its CRC to the beginning of `region`, and says how many bytes that is; `None` if they do not
/// fit.
pub(crate) fn seal(value: &impl Serialize, region: &mut [u8]) -> Option<usize> {
    let used = postcard::to_slice(value, region).ok()?.len();
    let (data, rest) = region.split_at_mut_checked(used)?;
    let sum = CRC.checksum(data).to_le_bytes();
    rest.get_mut(..sum.len())?.copy_from_slice(&sum);
    Some(used + sum.len())
}

/// The value in `region`; `None` when there is none, or its CRC is wrong.
pub(crate) fn open<'a, T: Deserialize<'a>>(region: &'a [u8]) -> Option<T> {
    let (value, rest) = postcard::take_from_bytes(region).ok()?;
    let data = region.get(..region.len().checked_sub(rest.len())?)?;
    let sum = rest.first_chunk().copied().map(u32::from_le_bytes)?;
    (sum == CRC.checksum(data)).then_some(value)
}
