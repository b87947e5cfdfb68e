//! One number for a whole flight.

use core::fmt;

/// CRC-64/XZ over the postcard bytes of every cycle's record and, in simulation, of the true state,
/// in the order in which they were made.
///
/// Two flights with equal digests had the same bits in every reading, state and command of every
/// cycle: on the host and on the ARM core, before and after a change. It is a check against
/// accidents, not against an adversary.
#[derive(Clone)]
pub struct Digest {
    crc: crc::Digest<'static, u64, crc::Table<1>>,
}

static CRC: crc::Crc<u64, crc::Table<1>> = crc::Crc::<u64, crc::Table<1>>::new(&crc::CRC_64_XZ);

impl Default for Digest {
    fn default() -> Self {
        Self { crc: CRC.digest() }
    }
}

impl Digest {
    /// Takes in the bytes of one more message.
    pub fn update(&mut self, bytes: &[u8]) {
        self.crc.update(bytes);
    }

    /// The digest of everything taken in so far.
    pub fn value(&self) -> u64 {
        self.crc.clone().finalize()
    }
}

impl fmt::Debug for Digest {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Digest({:016x})", self.value())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_the_catalogued_crc_64_xz_and_does_not_depend_on_the_pieces() {
        // Check value of CRC-64/XZ in the CRC catalogue for "123456789".
        const CHECK: u64 = 0x995d_c9bb_df19_39fa;
        let mut whole = Digest::default();
        whole.update(b"123456789");
        let mut pieces = Digest::default();
        pieces.update(b"1234");
        pieces.update(b"56789");
        assert_eq!((whole.value(), pieces.value()), (CHECK, CHECK));
    }
}
