//! Any bytes are refused as a TLE, or read as elements that can be propagated or refused.
#![no_main]

use libfuzzer_sys::fuzz_target;
use sgp4_lite::{Elements, TleText};

#[path = "propagate.rs"]
mod propagate;

fuzz_target!(|text: &[u8]| {
    let strict = Elements::from_tle_text(text);
    if let Ok(TleText { line1, line2, .. }) = TleText::split(text) {
        assert_eq!(Elements::from_tle(line1, line2), strict);
        // The lenient entry finds elements where a random checksum hides them.
        if let Ok(elements) = Elements::from_tle_lenient(line1, line2) {
            propagate::at_any_time(&elements);
            assert!(strict.is_err() || strict == Ok(elements));
        } else {
            assert!(strict.is_err());
        }
    }
});
