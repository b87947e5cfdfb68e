//! Many flights, side by side on all cores.

use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread;

use adcs_sim::noise::Gaussian;
use anyhow::Result;

use super::run::{self, Flight};
use super::scene::Scene;

/// Stream of the bootstrap's choices.
const BOOTSTRAP: u64 = 104;

/// Pooled over flights.
pub fn pooled(flights: &[Flight]) -> Flight {
    let mut all = Flight::default();
    flights.iter().for_each(|flight| all.join(flight));
    all
}

/// Eclipse rms of the dynamics-aided filter over the MEKF's, pooled, and between which values it lies
/// with 90 % when other flights are drawn from these (bootstrap).
pub fn eclipse_ratio(flights: &[Flight]) -> (f64, [f64; 2]) {
    const DRAWS: usize = 2000;
    let ratio = |flights: &[Flight]| {
        let all = pooled(flights);
        all.dynamic.eclipse.rms() / all.mekf.eclipse.rms()
    };
    let mut generator = Gaussian::new(flights.len() as u64, BOOTSTRAP);
    let mut draw = || {
        let at = 0.5 * (1.0 + generator.symmetric()) * flights.len() as f64;
        flights.get(at as usize).copied().unwrap_or_default()
    };
    let mut drawn: Vec<f64> = (0..DRAWS)
        .map(|_| ratio(&(0..flights.len()).map(|_| draw()).collect::<Vec<_>>()))
        .collect();
    drawn.sort_by(f64::total_cmp);
    let quantile = |share: f64| drawn.get((share * DRAWS as f64) as usize).copied();
    let [low, high] = [0.05, 0.95].map(|share| quantile(share).unwrap_or(f64::NAN));
    (ratio(flights), [low, high])
}

/// Flies the seeds 1 to `flights` of a scene; `flown` hears of each as it ends.
///
/// # Errors
/// That of the first flight that could not be flown to its end.
pub fn fly(scene: &Scene, flights: u64, flown: impl Fn() + Sync) -> Result<Vec<Flight>> {
    fly_all(flights, |seed| run::fly(scene, seed), flown)
}

/// Flies the seeds 1 to `flights` with `fly`; `flown` hears of each as it ends. The order of the result is
/// that of the seeds, however many cores there are.
///
/// # Errors
/// That of the first flight that could not be flown to its end.
pub fn fly_all<T: Send>(
    flights: u64,
    fly: impl Fn(u64) -> Result<T> + Sync,
    flown: impl Fn() + Sync,
) -> Result<Vec<T>> {
    let next = AtomicU64::new(1);
    let results = Mutex::new(Vec::new());
    let cores = thread::available_parallelism().map_or(1, usize::from);
    thread::scope(|scope| {
        for _ in 0..cores {
            scope.spawn(|| {
                loop {
                    let seed = next.fetch_add(1, Ordering::Relaxed);
                    if seed > flights {
                        break;
                    }
                    let flight = fly(seed);
                    if let Ok(mut results) = results.lock() {
                        results.push((seed, flight));
                    }
                    flown();
                }
            });
        }
    });
    let mut results = results.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner);
    results.sort_by_key(|(seed, _)| *seed);
    results.into_iter().map(|(_, flight)| flight).collect()
}
