//! What a filter may be handed by what is broken.
#![allow(dead_code)] // each test uses its part

use adcs_core::frames::Vector;
use proptest::prelude::*;

/// A number such as a broken driver, or a bent model, may hand over.
pub fn anything() -> impl Strategy<Value = f32> {
    prop_oneof![
        4 => -1e-4..1e-4_f32,
        4 => -6.0..6.0_f32,
        1 => any::<f32>(),
        1 => Just(f32::NAN),
        1 => Just(f32::INFINITY),
        1 => Just(0.0_f32),
    ]
}

/// Three of them.
pub fn any_vector<F>() -> impl Strategy<Value = Vector<F>> {
    [anything(), anything(), anything()].prop_map(|[x, y, z]| Vector::new(x, y, z))
}
