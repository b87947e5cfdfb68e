//! This crate beside `world_magnetic_model`, in one run: `cargo bench -p igrf`.
//!
//! With crate `igrf` 0.2 as well, which shares our name: see `peers/Cargo.toml`.

mod cases;

use criterion::{Criterion, criterion_group, criterion_main};
use igrf::Coefficients;
use std::hint::black_box;

fn field(criterion: &mut Criterion) {
    let mut group = cases::group(criterion);
    for degree in [4, 8, 13] {
        cases::ours::<f64>(&mut group, "f64", degree);
        cases::ours::<f32>(&mut group, "f32", degree);
    }
    cases::ours_many::<f64>(&mut group, "f64");
    cases::ours_many::<f32>(&mut group, "f32");
    cases::world_magnetic_model_earth_fixed(&mut group);
    cases::ours_geodetic::<f64>(&mut group, "f64");
    cases::ours_geodetic::<f32>(&mut group, "f32");
    cases::world_magnetic_model(&mut group);
}

fn prepare(criterion: &mut Criterion) {
    criterion.bench_function("coefficients for one date, f64", |bencher| {
        bencher.iter(|| Coefficients::<f64>::at(black_box(cases::YEAR)));
    });
}

criterion_group!(benches, field, prepare);
criterion_main!(benches);
