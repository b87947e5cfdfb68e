//! The table of leap seconds: built in, and replaceable by uplink.

use core::fmt;

use super::Utc;

/// Days from 1972-01-01, where the whole leap seconds begin, to 2000-01-01.
const DAYS_FROM_1972_TO_2000: i32 = 10_227;

/// From the midnight that begins a day on, TAI − UTC has this value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct LeapSecond {
    /// The day, counted from 1972-01-01 = 0 (reaches to the year 2151).
    pub days_since_1972: u16,
    /// TAI − UTC from that midnight on, s.
    pub tai_minus_utc_s: i16,
}

impl LeapSecond {
    /// The midnight from which the value holds.
    pub const fn begins(&self) -> Utc {
        midnight(self.days_since_1972)
    }
}

const fn midnight(days_since_1972: u16) -> Utc {
    Utc::from_day(days_since_1972 as i32 - DAYS_FROM_1972_TO_2000, 0)
}

/// TAI − UTC since 1972, and until when it is known.
///
/// Past leap seconds are facts: a table that contradicts the built-in one is refused, so an uplink
/// can only add what has been announced since the image was built. A table that has expired is
/// still used, since after its last entry no better value is known;
/// [`is_current`](Self::is_current) says so to whoever watches over the satellite's data. A missed
/// leap second moves the Sun by 1.1e-5 deg, and moves nothing else on board.
///
/// As sent by uplink ([`encode`](Self::encode), [`decode`](Self::decode)), in little-endian 16-bit
/// words: format (1), number of entries, expiry (days since 1972-01-01),
/// [`CAPACITY`](Self::CAPACITY) × (days since 1972-01-01, TAI − UTC in s), unused entries zero;
/// then the CRC-32 (ISO-HDLC, as of zip and Ethernet) of these bytes, 32 bits.
///
/// Source: IERS Bulletin C and the file `leap-seconds.list`, as distributed with the tz database.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct LeapSeconds {
    /// The first `count` are the table, the others are zero.
    entries: [LeapSecond; Self::CAPACITY],
    count: usize,
    expires_days_since_1972: u16,
}

/// Why a table of leap seconds is refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum LeapSecondsError {
    /// Not [`LeapSeconds::ENCODED_LEN`] bytes.
    Length {
        /// The number of bytes found.
        found: usize,
    },
    /// The bytes are not those that were sent.
    Crc {
        /// The CRC-32 of the bytes.
        expected: u32,
        /// The CRC-32 that came with them.
        found: u32,
    },
    /// A format this image does not know.
    Format {
        /// The format word found.
        found: u16,
    },
    /// More entries than fit.
    Count {
        /// The number of entries found.
        found: usize,
    },
    /// An entry that differs from a leap second of the past, or misses it.
    History {
        /// The entry, counted from 0.
        index: usize,
    },
    /// An entry that is not later than the one before it.
    Order {
        /// The entry, counted from 0.
        index: usize,
    },
    /// An entry that does not differ by one second from the one before it.
    Step {
        /// The entry, counted from 0.
        index: usize,
        /// By how much it differs, s.
        step_s: i32,
    },
    /// The expiry is not later than the last entry.
    Expiry {
        /// The expiry found, days since 1972-01-01.
        days_since_1972: u16,
    },
}

impl fmt::Display for LeapSecondsError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Length { found } => {
                write!(f, "{found} bytes, a table has {}", LeapSeconds::ENCODED_LEN)
            }
            Self::Crc { expected, found } => {
                write!(f, "CRC-32 is {found:08x}, of these bytes it is {expected:08x}")
            }
            Self::Format { found } => write!(f, "unknown format {found}"),
            Self::Count { found } => {
                write!(f, "{found} entries, at most {} fit", LeapSeconds::CAPACITY)
            }
            Self::History { index } => {
                write!(f, "entry {index} contradicts a leap second of the past")
            }
            Self::Order { index } => write!(f, "entry {index} is not later than the one before"),
            Self::Step { index, step_s } => {
                write!(f, "entry {index} steps by {step_s} s instead of one")
            }
            Self::Expiry { days_since_1972 } => {
                write!(f, "expires on day {days_since_1972} since 1972, not after its last entry")
            }
        }
    }
}

impl core::error::Error for LeapSecondsError {}

const CRC: crc::Crc<u32, crc::NoTable> = crc::Crc::<u32, crc::NoTable>::new(&crc::CRC_32_ISO_HDLC);

impl LeapSeconds {
    /// The most entries a table can have; 28 are in use.
    pub const CAPACITY: usize = 40;
    /// Bytes of a table as sent by uplink.
    pub const ENCODED_LEN: usize = 2 * (3 + 2 * Self::CAPACITY) + 4;
    const FORMAT: u16 = 1;
    const UNUSED: LeapSecond = LeapSecond { days_since_1972: 0, tai_minus_utc_s: 0 };

    /// All leap seconds to 2017-01-01 (37 s). No other is to come before 2027-06-28, where the
    /// `leap-seconds.list` of tz database 2026e expires.
    #[expect(clippy::indexing_slicing, reason = "evaluated when compiled")]
    pub const BUILT_IN: Self = {
        let mut entries = [Self::UNUSED; Self::CAPACITY];
        let mut index = 0;
        while index < HISTORY.len() {
            let (days_since_1972, tai_minus_utc_s) = HISTORY[index];
            entries[index] = LeapSecond { days_since_1972, tai_minus_utc_s };
            index += 1;
        }
        Self { entries, count: HISTORY.len(), expires_days_since_1972: BUILT_IN_EXPIRES }
    };

    /// The table with these entries, in order of time, valid until the midnight that begins the
    /// day of expiry.
    ///
    /// # Errors
    /// Anything but [`Length`](LeapSecondsError::Length), [`Crc`](LeapSecondsError::Crc) and
    /// [`Format`](LeapSecondsError::Format).
    pub fn new(
        table: &[LeapSecond],
        expires_days_since_1972: u16,
    ) -> Result<Self, LeapSecondsError> {
        if table.len() > Self::CAPACITY {
            return Err(LeapSecondsError::Count { found: table.len() });
        }
        check_history(table)?;
        check_steps(table)?;
        if table.last().is_none_or(|last| last.days_since_1972 >= expires_days_since_1972) {
            return Err(LeapSecondsError::Expiry { days_since_1972: expires_days_since_1972 });
        }
        let mut entries = [Self::UNUSED; Self::CAPACITY];
        for (slot, entry) in entries.iter_mut().zip(table) {
            *slot = *entry;
        }
        Ok(Self { entries, count: table.len(), expires_days_since_1972 })
    }

    /// The entries, in order of time.
    pub fn entries(&self) -> &[LeapSecond] {
        self.entries.get(..self.count).unwrap_or(&self.entries)
    }

    /// The instant until which the table is known to be complete.
    pub fn expires(&self) -> Utc {
        midnight(self.expires_days_since_1972)
    }

    /// True while the table is known to be complete: a newer one should be sent up before that
    /// ends.
    pub fn is_current(&self, utc: Utc) -> bool {
        utc < self.expires()
    }

    /// TAI − UTC at an instant, s; `None` before 1972, when UTC ran at another rate than TAI.
    pub fn tai_minus_utc_s(&self, utc: Utc) -> Option<i16> {
        let entry = self.entries().iter().rev().find(|entry| entry.begins() <= utc)?;
        Some(entry.tai_minus_utc_s)
    }

    /// The bytes to send.
    pub fn encode(&self) -> [u8; Self::ENCODED_LEN] {
        let header = [Self::FORMAT, self.count as u16, self.expires_days_since_1972];
        let table = self.entries.iter();
        let table = table.flat_map(|e| [e.days_since_1972, e.tai_minus_utc_s.cast_unsigned()]);
        let mut block = [0; Self::ENCODED_LEN];
        if let Some((body, check)) = block.split_last_chunk_mut::<4>() {
            for (bytes, word) in body.chunks_exact_mut(2).zip(header.into_iter().chain(table)) {
                bytes.copy_from_slice(&word.to_le_bytes());
            }
            *check = CRC.checksum(body).to_le_bytes();
        }
        block
    }

    /// The table of these bytes.
    ///
    /// # Errors
    /// What is wrong with them; the table in use then stays.
    pub fn decode(block: &[u8]) -> Result<Self, LeapSecondsError> {
        let wrong_length = LeapSecondsError::Length { found: block.len() };
        let (body, check) = block.split_last_chunk::<4>().ok_or(wrong_length)?;
        if block.len() != Self::ENCODED_LEN {
            return Err(wrong_length);
        }
        let (expected, found) = (CRC.checksum(body), u32::from_le_bytes(*check));
        if expected != found {
            return Err(LeapSecondsError::Crc { expected, found });
        }
        let (words, _) = body.as_chunks::<2>();
        let mut words = words.iter().map(|word| u16::from_le_bytes(*word));
        let mut next = || words.next().ok_or(wrong_length);
        let format = next()?;
        if format != Self::FORMAT {
            return Err(LeapSecondsError::Format { found: format });
        }
        let (count, expires) = (usize::from(next()?), next()?);
        let mut entries = [Self::UNUSED; Self::CAPACITY];
        for entry in &mut entries {
            *entry =
                LeapSecond { days_since_1972: next()?, tai_minus_utc_s: next()?.cast_signed() };
        }
        let table = entries.get(..count).ok_or(LeapSecondsError::Count { found: count })?;
        Self::new(table, expires)
    }
}

impl Default for LeapSeconds {
    fn default() -> Self {
        Self::BUILT_IN
    }
}

fn check_history(table: &[LeapSecond]) -> Result<(), LeapSecondsError> {
    for (index, (days_since_1972, tai_minus_utc_s)) in HISTORY.into_iter().enumerate() {
        if table.get(index) != Some(&LeapSecond { days_since_1972, tai_minus_utc_s }) {
            return Err(LeapSecondsError::History { index });
        }
    }
    Ok(())
}

fn check_steps(table: &[LeapSecond]) -> Result<(), LeapSecondsError> {
    for (index, (earlier, later)) in table.iter().zip(table.iter().skip(1)).enumerate() {
        let index = index + 1;
        if later.days_since_1972 <= earlier.days_since_1972 {
            return Err(LeapSecondsError::Order { index });
        }
        let step_s = i32::from(later.tai_minus_utc_s) - i32::from(earlier.tai_minus_utc_s);
        if step_s.abs() != 1 {
            return Err(LeapSecondsError::Step { index, step_s });
        }
    }
    Ok(())
}

/// (days since 1972-01-01, TAI − UTC in s). The days are those of `HISTORY_DATES` in the tests.
const HISTORY: [(u16, i16); 28] = [
    (0, 10),
    (182, 11),
    (366, 12),
    (731, 13),
    (1096, 14),
    (1461, 15),
    (1827, 16),
    (2192, 17),
    (2557, 18),
    (2922, 19),
    (3469, 20),
    (3834, 21),
    (4199, 22),
    (4930, 23),
    (5844, 24),
    (6575, 25),
    (6940, 26),
    (7487, 27),
    (7852, 28),
    (8217, 29),
    (8766, 30),
    (9313, 31),
    (9862, 32),
    (12419, 33),
    (13515, 34),
    (14792, 35),
    (15887, 36),
    (16437, 37),
];

/// 2027-06-28.
const BUILT_IN_EXPIRES: u16 = 20_267;

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use crate::time::MICROS_PER_DAY;
    use std::format;
    use std::vec::Vec;

    /// The dates of `leap-seconds.list`; the first is 10 s, each next one second more.
    const HISTORY_DATES: [&str; 28] = [
        "1972-01-01",
        "1972-07-01",
        "1973-01-01",
        "1974-01-01",
        "1975-01-01",
        "1976-01-01",
        "1977-01-01",
        "1978-01-01",
        "1979-01-01",
        "1980-01-01",
        "1981-07-01",
        "1982-07-01",
        "1983-07-01",
        "1985-07-01",
        "1988-01-01",
        "1990-01-01",
        "1991-01-01",
        "1992-07-01",
        "1993-07-01",
        "1994-07-01",
        "1996-01-01",
        "1997-07-01",
        "1999-01-01",
        "2006-01-01",
        "2009-01-01",
        "2012-07-01",
        "2015-07-01",
        "2017-01-01",
    ];

    fn day(date: &str) -> Utc {
        Utc::parse(&format!("{date}T00:00:00Z")).unwrap()
    }

    fn table_with(added: &[LeapSecond]) -> Vec<LeapSecond> {
        LeapSeconds::BUILT_IN.entries().iter().chain(added).copied().collect()
    }

    #[test]
    fn the_built_in_table_is_the_published_one() {
        let entries = LeapSeconds::BUILT_IN.entries();
        assert_eq!(entries.len(), HISTORY_DATES.len());
        for (index, (entry, date)) in entries.iter().zip(HISTORY_DATES).enumerate() {
            assert_eq!(entry.begins(), day(date), "{date}");
            assert_eq!(usize::from(entry.tai_minus_utc_s.unsigned_abs()), 10 + index);
        }
        assert_eq!(LeapSeconds::BUILT_IN.expires(), day("2027-06-28"));
        let rebuilt = LeapSeconds::new(entries, BUILT_IN_EXPIRES);
        assert_eq!(rebuilt, Ok(LeapSeconds::BUILT_IN));
    }

    #[test]
    fn the_value_changes_at_midnight_and_is_absent_before_1972() {
        let table = LeapSeconds::BUILT_IN;
        let midnight = day("2017-01-01");
        assert_eq!(table.tai_minus_utc_s(midnight), Some(37));
        assert_eq!(table.tai_minus_utc_s(midnight.plus_micros(-1)), Some(36));
        assert_eq!(table.tai_minus_utc_s(day("1972-01-01")), Some(10));
        assert_eq!(table.tai_minus_utc_s(day("1972-01-01").plus_micros(-1)), None);
        assert_eq!(table.tai_minus_utc_s(day("2100-01-01")), Some(37));
        assert!(table.is_current(day("2026-12-31")) && !table.is_current(day("2027-06-28")));
    }

    #[test]
    fn a_table_survives_the_uplink_and_a_single_wrong_bit_is_noticed() {
        let added = LeapSecond { days_since_1972: 21_000, tai_minus_utc_s: 36 };
        let table = LeapSeconds::new(&table_with(&[added]), 21_200).unwrap();
        let block = table.encode();
        assert_eq!(LeapSeconds::decode(&block), Ok(table));
        assert_eq!(table.tai_minus_utc_s(added.begins()), Some(36));
        for bit in 0..8 * block.len() {
            let mut spoilt = block;
            spoilt[bit / 8] ^= 1 << (bit % 8);
            let refused = LeapSeconds::decode(&spoilt);
            assert!(matches!(refused, Err(LeapSecondsError::Crc { .. })), "bit {bit}");
        }
    }

    #[test]
    fn a_block_of_wrong_length_format_or_count_is_refused() {
        let block = LeapSeconds::BUILT_IN.encode();
        for length in 0..block.len() {
            let refused = LeapSeconds::decode(&block[..length]);
            assert_eq!(refused, Err(LeapSecondsError::Length { found: length }));
        }
        let sealed = |at: usize, value: u8| {
            let mut block = block;
            block[at] = value;
            let (body, check) = block.split_last_chunk_mut::<4>().unwrap();
            *check = CRC.checksum(body).to_le_bytes();
            LeapSeconds::decode(&block)
        };
        assert_eq!(sealed(0, 2), Err(LeapSecondsError::Format { found: 2 }));
        assert_eq!(sealed(2, 41), Err(LeapSecondsError::Count { found: 41 }));
        assert_eq!(sealed(2, 27), Err(LeapSecondsError::History { index: 27 }));
        assert_eq!(sealed(2, 29), Err(LeapSecondsError::Order { index: 28 }));
    }

    #[test]
    fn a_table_out_of_order_or_against_the_past_is_refused() {
        let entry =
            |days_since_1972, tai_minus_utc_s| LeapSecond { days_since_1972, tai_minus_utc_s };
        let new = |added: &[LeapSecond]| LeapSeconds::new(&table_with(added), 30_000);
        let order = [entry(21_000, 38), entry(21_000, 39)];
        assert_eq!(new(&order), Err(LeapSecondsError::Order { index: 29 }));
        let step = [entry(21_000, 39)];
        assert_eq!(new(&step), Err(LeapSecondsError::Step { index: 28, step_s: 2 }));
        let late = [entry(30_000, 38)];
        assert_eq!(new(&late), Err(LeapSecondsError::Expiry { days_since_1972: 30_000 }));
        let mut past = table_with(&[]);
        past[5].days_since_1972 += 1;
        assert_eq!(LeapSeconds::new(&past, 30_000), Err(LeapSecondsError::History { index: 5 }));
        assert_eq!(LeapSeconds::new(&[], 30_000), Err(LeapSecondsError::History { index: 0 }));
        let many = [entry(0, 0); LeapSeconds::CAPACITY + 1];
        assert_eq!(LeapSeconds::new(&many, 30_000), Err(LeapSecondsError::Count { found: 41 }));
    }

    #[test]
    fn the_days_of_the_table_reach_beyond_any_flight() {
        let last = LeapSecond { days_since_1972: u16::MAX, tai_minus_utc_s: 0 }.begins();
        assert_eq!(last.micros_of_day() % MICROS_PER_DAY, 0);
        assert_eq!(last.civil().year, 2151);
    }
}
