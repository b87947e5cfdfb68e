//! Any bytes are refused as an OMM, or read as elements that can be propagated or refused.
#![no_main]

use libfuzzer_sys::fuzz_target;
use sgp4_lite::Elements;

#[path = "propagate.rs"]
mod propagate;

fuzz_target!(|text: &[u8]| {
    if let Ok(elements) = Elements::from_omm(text) {
        propagate::at_any_time(&elements);
    }
});
