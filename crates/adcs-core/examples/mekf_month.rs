//! A month of SPROUT's orbit through the f32 MEKF: does its covariance stay one, do its errors stay what it
//! says?
//!
//! `cargo run --release -p adcs-core --example mekf_month [DAYS] [SEED]` (30 days, seed 1) prints a line
//! a day, then the whole, and fails when the filter lost its estimate once or its covariance was none.

#[path = "../tests/mekf_support/mod.rs"]
mod mekf_support;

use std::process::ExitCode;

use adcs_core::attitude::mekf::{Event, Mekf, MekfParameters, MekfState};
use mekf_support::Figures;
use mekf_support::orbit_world::OrbitWorld;

const DAY_S: u32 = 86_400;
/// After the start, which waits for the Sun.
const TRANSIENT_S: u32 = 600;

fn main() -> ExitCode {
    let mut arguments = std::env::args().skip(1).map(|argument| argument.parse::<u32>());
    let days = arguments.next().and_then(Result::ok).unwrap_or(30);
    let seed = arguments.next().and_then(Result::ok).unwrap_or(1);

    let mekf = Mekf::<f32>::new(&MekfParameters::default()).expect("the default is accepted");
    let mut state = MekfState::default();
    let mut world = OrbitWorld::new(u64::from(seed));
    let mut started = None;
    let (mut events, mut not_positive) = (0_u32, 0_u32);
    let mut month = Figures::default();
    println!("day {}", Figures::HEADER);
    for day in 1..=days {
        let mut figures = Figures::default();
        for second in (day - 1) * DAY_S..day * DAY_S {
            let moment = world.next();
            let output = mekf.cycle(&mut state, &moment.inputs(1.0));
            match output.event {
                Some(Event::Started) if started.is_none() => started = Some(second),
                Some(event) => {
                    events += 1;
                    println!("{second} s: {event:?}");
                }
                None => {}
            }
            if started.is_some_and(|started| second >= started + TRANSIENT_S) {
                figures.see(&moment, &output);
                month.see(&moment, &output);
                let is_positive =
                    output.estimate.is_none_or(|it| it.covariance.cholesky().is_some());
                not_positive += u32::from(!is_positive);
            }
        }
        println!("{day:3} {}", figures.line());
    }
    println!("all {}", month.line());
    println!("{not_positive} covariances not positive, {events} events after the start");
    if not_positive == 0 && events == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
