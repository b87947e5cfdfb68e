//! This crate, `world_magnetic_model` and crate `igrf` 0.2 in one run.

#[path = "../benches/cases/mod.rs"]
mod cases;

use criterion::{
    BenchmarkGroup, Criterion, criterion_group, criterion_main, measurement::WallTime,
};
use std::hint::black_box;
use world_magnetic_model::time::Date;

fn field(criterion: &mut Criterion) {
    let mut group = cases::group(criterion);
    cases::ours::<f64>(&mut group, "f64", 13);
    cases::ours::<f32>(&mut group, "f32", 13);
    cases::ours_many::<f64>(&mut group, "f64");
    cases::ours_many::<f32>(&mut group, "f32");
    cases::world_magnetic_model_earth_fixed(&mut group);
    cases::ours_geodetic::<f64>(&mut group, "f64");
    cases::ours_geodetic::<f32>(&mut group, "f32");
    cases::world_magnetic_model(&mut group);
    igrf_02(&mut group);
}

/// Crate `igrf` 0.2 (IGRF-13), f64, degree 13, geodetic; dates its coefficients in each call, and
/// computes the rates as well.
fn igrf_02(group: &mut BenchmarkGroup<'_, WallTime>) {
    // It extrapolates no further than 2025.
    let date = Date::from_ordinal_date(2024, 183).expect("valid");
    let positions: Vec<_> = cases::geodetic()
        .into_iter()
        .map(|position| {
            let (latitude, longitude) = (position.latitude_rad, position.longitude_rad);
            (latitude.to_degrees(), longitude.to_degrees(), (1000.0 * position.height_km) as u32)
        })
        .collect();
    group.bench_function("igrf 0.2, f64, degree 13, geodetic", |bencher| {
        bencher.iter(|| {
            for &(latitude, longitude, height_m) in &positions {
                let field = igrf02::declination(
                    black_box(latitude),
                    black_box(longitude),
                    black_box(height_m),
                    black_box(date),
                );
                let _ = black_box(field);
            }
        });
    });
}

criterion_group!(benches, field);
criterion_main!(benches);
