//! What is measured: the field at 256 positions of a low orbit, all at one date.

use criterion::{BenchmarkGroup, Criterion, Throughput, measurement::WallTime};
use igrf::{Coefficients, DecimalYear, GeodeticPosition, Real};
use std::hint::black_box;
use world_magnetic_model::GeomagneticField;
use world_magnetic_model::time::Date;
use world_magnetic_model::uom::si::angle::radian;
use world_magnetic_model::uom::si::f32::{Angle, Length};
use world_magnetic_model::uom::si::length::kilometer;
use world_magnetic_model::uom::si::magnetic_flux_density::nanotesla;

const POSITIONS: usize = 256;
/// 1 July 2026, within all models.
pub const YEAR: DecimalYear = DecimalYear(2026.0 + 181.0 / 365.0);

/// Two revolutions at 630 km and 98° inclination, over the ellipsoid.
pub fn geodetic() -> Vec<GeodeticPosition<f64>> {
    (0..POSITIONS)
        .map(|step| {
            let along = step as f64 / POSITIONS as f64 * 4.0 * std::f64::consts::PI;
            GeodeticPosition {
                latitude_rad: (along.sin() * 98_f64.to_radians().sin()).asin(),
                longitude_rad: (3.0 + step as f64 * 0.7) % (2.0 * std::f64::consts::PI)
                    - std::f64::consts::PI,
                height_km: 630.0 + 10.0 * along.cos(),
            }
        })
        .collect()
}

/// The same positions in the precision `T`.
fn geodetic_of<T: Real>() -> Vec<GeodeticPosition<T>> {
    geodetic()
        .into_iter()
        .map(|position| GeodeticPosition {
            latitude_rad: T::from_f64(position.latitude_rad),
            longitude_rad: T::from_f64(position.longitude_rad),
            height_km: T::from_f64(position.height_km),
        })
        .collect()
}

/// The same orbit, roughly, as Earth-fixed positions in km.
pub fn earth_fixed<T: Real>() -> Vec<[T; 3]> {
    let cartesian = |position: GeodeticPosition<f64>| {
        let r_km = 6_371.2 + position.height_km;
        let (sin_lat, cos_lat) = position.latitude_rad.sin_cos();
        let (sin_lon, cos_lon) = position.longitude_rad.sin_cos();
        [r_km * cos_lat * cos_lon, r_km * cos_lat * sin_lon, r_km * sin_lat].map(T::from_f64)
    };
    geodetic().into_iter().map(cartesian).collect()
}

pub fn group(criterion: &mut Criterion) -> BenchmarkGroup<'_, WallTime> {
    let mut group = criterion.benchmark_group("field at 256 positions");
    group.throughput(Throughput::Elements(POSITIONS as u64));
    group
}

/// This crate, from Earth-fixed positions.
pub fn ours<T: Real>(group: &mut BenchmarkGroup<'_, WallTime>, name: &str, degree: u8) {
    let coefficients =
        Coefficients::<T>::at(YEAR).and_then(|full| full.with_degree(degree)).expect("valid");
    let positions = earth_fixed::<T>();
    group.bench_function(format!("igrf (this crate), {name}, degree {degree}"), |bencher| {
        bencher.iter(|| {
            for &position in &positions {
                let _ = black_box(coefficients.field_ecef_nt(black_box(position)));
            }
        });
    });
}

/// The same, many positions at a time.
pub fn ours_many<T: Real>(group: &mut BenchmarkGroup<'_, WallTime>, name: &str) {
    let coefficients = Coefficients::<T>::at(YEAR).expect("valid");
    let positions = earth_fixed::<T>();
    group.bench_function(format!("igrf (this crate), {name}, degree 13, many"), |bencher| {
        bencher.iter(|| {
            for field in coefficients.fields_ecef_nt(black_box(&positions).iter().copied()) {
                let _ = black_box(field);
            }
        });
    });
}

/// This crate, from geodetic positions to north, east, down: what the others compute.
pub fn ours_geodetic<T: Real>(group: &mut BenchmarkGroup<'_, WallTime>, name: &str) {
    let coefficients = Coefficients::<T>::at(YEAR).expect("valid");
    let positions = geodetic_of::<T>();
    group.bench_function(format!("igrf (this crate), {name}, degree 13, geodetic"), |bencher| {
        bencher.iter(|| {
            for &position in &positions {
                let _ = black_box(coefficients.field_geodetic_nt(black_box(position)));
            }
        });
    });
    group.bench_function(
        format!("igrf (this crate), {name}, degree 13, geodetic, many"),
        |bencher| {
            bencher.iter(|| {
                let positions = black_box(&positions).iter().copied();
                for field in coefficients.fields_geodetic_nt(positions) {
                    let _ = black_box(field);
                }
            });
        },
    );
}

/// Crate `world_magnetic_model`, f32, degree 12, geodetic; dates its coefficients in each call.
pub fn world_magnetic_model(group: &mut BenchmarkGroup<'_, WallTime>) {
    let date = Date::from_ordinal_date(2026, 182).expect("valid");
    let positions: Vec<_> = geodetic()
        .into_iter()
        .map(|position| {
            (
                Length::new::<kilometer>(position.height_km as f32),
                Angle::new::<radian>(position.latitude_rad as f32),
                Angle::new::<radian>(position.longitude_rad as f32),
            )
        })
        .collect();
    group.bench_function("world_magnetic_model 1.2025, f32, degree 12, geodetic", |bencher| {
        bencher.iter(|| {
            for &(height, latitude, longitude) in &positions {
                let field = GeomagneticField::new(
                    black_box(height),
                    black_box(latitude),
                    black_box(longitude),
                    black_box(date),
                )
                .expect("valid");
                let components = [field.x(), field.y(), field.z()];
                black_box(components.map(|component| component.get::<nanotesla>()));
            }
        });
    });
}

/// The same from Earth-fixed positions and into Earth-fixed axes: the job of a satellite, with
/// the geodetic coordinates (Bowring 1976) and the rotation that it then needs.
pub fn world_magnetic_model_earth_fixed(group: &mut BenchmarkGroup<'_, WallTime>) {
    let date = Date::from_ordinal_date(2026, 182).expect("valid");
    let positions = earth_fixed::<f32>();
    group.bench_function("world_magnetic_model 1.2025, f32, degree 12, Earth fixed", |bencher| {
        bencher.iter(|| {
            for &position in &positions {
                let (latitude, longitude, height_km) = bowring(black_box(position));
                let field = GeomagneticField::new(
                    Length::new::<kilometer>(height_km),
                    Angle::new::<radian>(latitude),
                    Angle::new::<radian>(longitude),
                    black_box(date),
                )
                .expect("valid");
                let [north, east, down] =
                    [field.x(), field.y(), field.z()].map(|component| component.get::<nanotesla>());
                let (sin_lat, cos_lat) = latitude.sin_cos();
                let (sin_lon, cos_lon) = longitude.sin_cos();
                let outward = -sin_lat * north - cos_lat * down;
                black_box([
                    cos_lon * outward - sin_lon * east,
                    sin_lon * outward + cos_lon * east,
                    cos_lat * north - sin_lat * down,
                ]);
            }
        });
    });
}

/// Latitude and longitude in rad, and height in km, over the WGS84 ellipsoid.
fn bowring([x, y, z]: [f32; 3]) -> (f32, f32, f32) {
    const A: f32 = 6378.137;
    const B: f32 = 6_356.752_3;
    const E2: f32 = 1.0 - B * B / (A * A);
    const E2_PRIME: f32 = A * A / (B * B) - 1.0;

    let from_axis = x.hypot(y);
    let (sin, cos) = (z * A).atan2(from_axis * B).sin_cos();
    let latitude = (z + E2_PRIME * B * sin.powi(3)).atan2(from_axis - E2 * A * cos.powi(3));
    let (sin, cos) = latitude.sin_cos();
    let height = from_axis * cos + z * sin - A * (1.0 - E2 * sin * sin).sqrt();
    (latitude, y.atan2(x), height)
}
