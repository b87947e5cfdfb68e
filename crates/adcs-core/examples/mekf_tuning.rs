//! What the MEKF makes of the reference run when it is told the truth about its sensors, and when not.
//!
//! `cargo run --release -p adcs-core --example mekf_tuning [DRAWS]` flies the truth of the reference run
//! with 20 other draws of the noise, starting by itself, in f32, and prints figures from 600 s on.

#[path = "../tests/mekf_support/mod.rs"]
mod mekf_support;

use adcs_core::attitude::mekf::{GyroSampling, MekfParameters, MekfState};
use mekf_support::reference_run::{measured_again, moments, parameters};
use mekf_support::{Figures, outputs};

const FROM_S: usize = 600;

/// What is told wrongly, by which change.
type Variant = (&'static str, fn(&mut MekfParameters<f32>));

const VARIANTS: [Variant; 13] = [
    ("as the sensors are", |_| ()),
    ("gyro sampling Interval", |p| p.gyro_sampling = GyroSampling::Interval),
    ("gyro noise halved", |p| p.gyro_noise_rad_s *= 0.5),
    ("gyro noise doubled", |p| p.gyro_noise_rad_s *= 2.0),
    ("bias walk / 3", |p| p.bias_walk_rad_s_per_sqrt_s /= 3.0),
    ("bias walk x 3", |p| p.bias_walk_rad_s_per_sqrt_s *= 3.0),
    ("bias walk x 10", |p| p.bias_walk_rad_s_per_sqrt_s *= 10.0),
    ("field noise halved", |p| p.field_noise.sensor_t *= 0.5),
    ("field noise x 1.5", |p| p.field_noise.sensor_t *= 1.5),
    ("field noise x 2", |p| p.field_noise.sensor_t *= 2.0),
    ("Sun noise halved", |p| p.sun_noise_rad *= 0.5),
    ("Sun noise x 1.5", |p| p.sun_noise_rad *= 1.5),
    ("Sun noise x 2", |p| p.sun_noise_rad *= 2.0),
];

fn main() {
    let draws = std::env::args().nth(1).and_then(|text| text.parse().ok()).unwrap_or(20);
    let run = moments();
    let measured: Vec<_> = (1..=draws).map(|seed| measured_again(&run, seed)).collect();
    println!("{:24} {}", "", Figures::HEADER.replace('\n', &format!("\n{:25}", "")));
    for (name, change) in VARIANTS {
        let mut told = parameters::<f32>();
        change(&mut told);
        let mut all = Figures::default();
        for moments in &measured {
            let outputs = outputs(&told, MekfState::default(), moments);
            for (moment, output) in moments.iter().zip(&outputs).skip(FROM_S) {
                all.see(moment, output);
            }
        }
        println!("{name:24} {}", all.line());
    }
}
