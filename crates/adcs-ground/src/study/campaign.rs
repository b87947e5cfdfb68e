//! All flights of a scene, side by side on all cores.

use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread;

use anyhow::Result;

use super::run::{self, Flight};
use super::scene::Scene;

/// Flies the seeds 1 to `flights`; `flown` hears of each as it ends. The order of the result is that of
/// the seeds, however many cores there are.
pub fn fly(scene: &Scene, flights: u64, flown: impl Fn() + Sync) -> Result<Vec<Flight>> {
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
                    let flight = run::fly(scene, seed);
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
