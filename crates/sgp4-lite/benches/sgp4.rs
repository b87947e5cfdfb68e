//! This crate beside crate `sgp4` 2.4, over the whole verification set, in one run.
//!
//! Every satellite of the set is propagated to the same times by both, in the opsmode "improved".
//! `cargo bench -p sgp4-lite --features deep-space`

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use sgp4_lite::{Elements, MinutesSinceEpoch, Propagator};
use std::hint::black_box;
use std::time::Instant;

const TLES: &str = include_str!("../tests/data/vallado_tle.csv");

/// Times from the epoch at which every satellite is evaluated, minutes.
const TIMES_MIN: [f64; 8] = [0.0, 1.0, 17.0, 60.0, 101.0, 360.0, 721.0, 1440.0];

/// Both libraries' propagators of one satellite.
struct Pair {
    ours: Propagator,
    theirs: sgp4::Constants,
}

/// The satellites of the verification set whose checksums are right and which `sgp4` takes too;
/// near-Earth (`n`) or deep-space (`d`) ones.
fn pairs(method: &str) -> Vec<Pair> {
    TLES.lines()
        .skip(1)
        .map(|line| line.split(',').collect::<Vec<_>>())
        .filter(|cells| cells[2] == method && cells[8] == "1" && cells[9] == "1")
        .filter_map(|cells| {
            let (line1, line2) = (cells[3], cells[4]);
            let elements = Elements::from_tle(line1, line2).ok()?;
            let theirs = sgp4::Elements::from_tle(None, line1.as_bytes(), line2.as_bytes()).ok()?;
            Some(Pair {
                ours: Propagator::new(&elements).ok()?,
                theirs: sgp4::Constants::from_elements(&theirs).ok()?,
            })
        })
        .collect()
}

fn compare(criterion: &mut Criterion, name: &str, pairs: &[Pair]) {
    if pairs.is_empty() {
        return;
    }
    let mut group = criterion.benchmark_group(name);
    group.throughput(Throughput::Elements((pairs.len() * TIMES_MIN.len()) as u64));
    group.bench_function("sgp4-lite", |bencher| bencher.iter(|| propagate_ours(pairs)));
    group.bench_function("sgp4 2.4", |bencher| bencher.iter(|| propagate_theirs(pairs)));
    group.finish();
    println!(
        "{name}: sgp4-lite is {:.2} times as fast as sgp4 2.4 (median of {ROUNDS} rounds in turn)\n",
        median_ratio(pairs)
    );
}

fn propagate_ours(pairs: &[Pair]) {
    for pair in pairs {
        for minutes in TIMES_MIN {
            let _ = black_box(pair.ours.propagate(MinutesSinceEpoch(black_box(minutes))));
        }
    }
}

fn propagate_theirs(pairs: &[Pair]) {
    for pair in pairs {
        for minutes in TIMES_MIN {
            let _ = black_box(pair.theirs.propagate(sgp4::MinutesSinceEpoch(black_box(minutes))));
        }
    }
}

/// Rounds of the direct comparison.
const ROUNDS: usize = 1001;

/// Their time over ours. They take turns within microseconds, so that other load on the machine
/// meets both alike.
fn median_ratio(pairs: &[Pair]) -> f64 {
    let seconds = |propagate: fn(&[Pair])| {
        let start = Instant::now();
        propagate(pairs);
        start.elapsed().as_secs_f64()
    };
    let mut ratios: Vec<_> = (0..ROUNDS)
        .map(|_| {
            let ours = seconds(propagate_ours);
            seconds(propagate_theirs) / ours
        })
        .collect();
    ratios.sort_by(f64::total_cmp);
    ratios[ROUNDS / 2]
}

fn propagation(criterion: &mut Criterion) {
    compare(criterion, "near Earth", &pairs("n"));
    compare(criterion, "deep space", &pairs("d"));
}

fn set_up(criterion: &mut Criterion) {
    let (line1, line2) = (
        "1 00005U 58002B   00179.78495062  .00000023  00000-0  28098-4 0  4753",
        "2 00005  34.2682 348.7242 1859667 331.7664  19.3264 10.82419157413667",
    );
    let mut group = criterion.benchmark_group("TLE to propagator");
    group.bench_function("sgp4-lite", |bencher| {
        bencher.iter(|| {
            let elements = Elements::from_tle(black_box(line1), black_box(line2)).ok()?;
            Propagator::new(&elements).ok()
        });
    });
    group.bench_function("sgp4 2.4", |bencher| {
        bencher.iter(|| {
            let (line1, line2) = (black_box(line1), black_box(line2));
            let elements =
                sgp4::Elements::from_tle(None, line1.as_bytes(), line2.as_bytes()).ok()?;
            sgp4::Constants::from_elements(&elements).ok()
        });
    });
    group.finish();
}

criterion_group!(benches, propagation, set_up);
criterion_main!(benches);
