//! The stages: one line each.

use core::hint::black_box;

use adcs_core::{
    control::b_dot::{BDot, BDotGain},
    frames::Vector,
    time::{Utc, gmst82_rad},
};
use igrf::{Coefficients, DecimalYear};
use semihosting::eprintln;
use sgp4_lite::{Elements, MinutesSinceEpoch, Propagator};

use crate::counter::Counter;

/// SPROUT on 2015-11-19 (CelesTrak).
const LINE_1: &str = "1 39770U 14029E   15323.12177538  .00004189  00000-0  50368-3 0  9997";
const LINE_2: &str = "2 39770  97.8736  57.8959 0010514  58.6984 301.5230 14.84437654 80617";
/// Where SPROUT then is, Earth fixed, km, rounded: the field's cost does not depend on it.
const POSITION_KM: [f64; 3] = [-3_470.0, 3_430.0, 4_990.0];

/// Counts every stage and prints the results.
pub fn run(counter: &Counter) {
    let elements = Elements::from_tle(LINE_1, LINE_2).expect("the lines above are a TLE");
    let propagator = Propagator::new(&elements).expect("SPROUT is near the Earth");
    let minutes = MinutesSinceEpoch(36.0);
    let now = Utc::parse("2015-11-19T03:31:21Z").expect("a date");
    let year = DecimalYear(2015.881);
    let field_f64 = Coefficients::<f64>::at(year).expect("within the table");
    let field_f32 = Coefficients::<f32>::at(year).expect("within the table");
    let law = BDot::new(BDotGain::Plain { gain_am2_s_per_t: 1e5 }).expect("a gain");
    let omega = Vector::new(0.06_f32, 0.03, 0.14);
    let field = Vector::new(2e-5_f32, -1e-5, 3e-5);

    let stage = Stage { counter };
    stage.count("sgp4_init", || Propagator::new(black_box(&elements)));
    stage.count("sgp4_propagate", || propagator.propagate(black_box(minutes)));
    stage.count("igrf_prepare_f32", || Coefficients::<f32>::at(black_box(year)));
    stage.count("igrf_field_f64", || field_f64.field_ecef_nt(black_box(POSITION_KM)));
    stage.count("igrf_field_f32", || {
        field_f32.field_ecef_nt(black_box(POSITION_KM).map(|x| x as f32))
    });
    stage.count("gmst82", || gmst82_rad(black_box(now).julian_date()));
    stage.count("b_dot", || black_box(law).dipole(black_box(omega), black_box(field)));
}

struct Stage<'a> {
    counter: &'a Counter,
}

impl Stage<'_> {
    /// Counts `work` once; every run takes the same.
    fn count<T>(&self, name: &str, work: impl FnOnce() -> T) {
        let instructions = self.counter.count(|| {
            black_box(work());
        });
        eprintln!("instructions {name} {instructions}");
    }
}
