//! What commissioning found, kept where a reset does not reach it.
//!
//! Every rung of the ladder takes up to hours; a watchdog's bite must not cost them. As with the epitaph
//! the record lies in a part of RAM that start-up leaves alone (`memory.x`), with a magic number and a CRC,
//! because RAM holds noise after power-on. Power that fails takes it: then the ladder begins anew.

use adcs_core::commissioning::Findings;
use serde::{Deserialize, Serialize};

use crate::sealed;

/// Bytes of the region in RAM.
pub const REGION_BYTES: usize = 384;

/// Says "findings in this layout". Change the last digit when the layout changes.
const MAGIC: [u8; 4] = *b"FND1";

#[derive(Serialize, Deserialize)]
struct Page {
    magic: [u8; 4],
    findings: Findings,
}

/// The region with these findings in it; `None` if they do not fit, which a test excludes.
#[must_use]
pub fn encode(findings: &Findings) -> Option<[u8; REGION_BYTES]> {
    let mut region = [0; REGION_BYTES];
    let page = Page { magic: MAGIC, findings: *findings };
    sealed::seal(&page, &mut region)?;
    Some(region)
}

/// The findings in a region; `None` when there are none, as after power-on.
#[must_use]
pub fn decode(region: &[u8; REGION_BYTES]) -> Option<Findings> {
    let page: Page = sealed::open(region)?;
    (page.magic == MAGIC).then_some(page.findings)
}

#[cfg(test)]
mod tests {
    use super::*;
    use adcs_core::commissioning::{
        CouplingFound, InertiaFound, MagnetometerFound, Outcome, RUNGS, Shortfall, Three,
    };
    use adcs_core::polarity::Suspect;
    use proptest::prelude::*;

    /// Everything present, and as long as it gets.
    fn longest() -> Findings {
        let three = Three { value: [f32::MAX; 3], sigma: [f32::MIN_POSITIVE; 3] };
        let nine = [[f32::MAX; 3]; 3];
        let suspect = Suspect::DeadTorquers([true; 3]);
        Findings {
            outcomes: [Some(Outcome::Failed(Shortfall::Miswired(suspect))); RUNGS],
            magnetometer: Some(MagnetometerFound {
                scale: three,
                cross_axis: three,
                bias_t: three,
                norm_error_t: 1.0,
            }),
            coupling: Some(CouplingFound { t_per_am2: nine, sigma_t_per_am2: nine }),
            gyro: Some(three),
            sun: Some(three),
            dipole: Some(three),
            inertia: Some(InertiaFound { tensor_kg_m2: nine, sigma_kg_m2: nine }),
            committed: true,
        }
    }

    #[test]
    fn the_longest_findings_fit_and_come_back() {
        assert_eq!(decode(&encode(&longest()).unwrap()), Some(longest()));
    }

    #[test]
    fn what_is_in_ram_after_power_on_is_no_findings() {
        assert_eq!(decode(&[0; REGION_BYTES]), None);
        assert_eq!(decode(&[0xff; REGION_BYTES]), None);
    }

    proptest! {
        #[test]
        fn a_flipped_bit_is_found(at in 0..REGION_BYTES, bit in 0..8_u8) {
            let mut region = encode(&longest()).unwrap();
            region[at] ^= 1 << bit;
            // Behind the CRC nothing counts.
            let found = decode(&region);
            prop_assert!(found.is_none() || found == Some(longest()));
        }

        #[test]
        fn whatever_bytes_lie_there_nothing_panics(
            bytes in prop::collection::vec(any::<u8>(), REGION_BYTES),
        ) {
            let mut region = [0; REGION_BYTES];
            region.copy_from_slice(&bytes);
            let _ = decode(&region);
        }
    }
}
