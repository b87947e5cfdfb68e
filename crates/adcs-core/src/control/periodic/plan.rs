//! The sweep in slices, and the gains of the last good one.
//!
//! A sweep is some ninety steps. It is done one step a call, so that no cycle waits for it, and while it
//! runs the gains of the one before are in use:
//!
//! ```text
//! time      |---- kept, NODES steps ----|
//! table     o   o   o   o   o   o   o   o            looked up, linear between nodes
//! horizon   o---o---o---o---o---o---o---o---o---o---o   swept from its end
//!                             ^ from here the next sweep runs
//! ```
//!
//! A sweep that fails (no orbit, no field, a number that is none) is thrown away and tried again later;
//! the table stays until its time is over. Then there is no plan, and the law that needs none takes over.

use nalgebra::{ComplexField, RealField, convert, try_convert};

use super::law::PeriodicLaw;
use super::model::Ahead;
use super::sweep::{Cost, Gains};
use crate::time::Utc;

/// Instants of which the gains are kept.
pub const NODES: usize = 64;

/// Share of the kept time after which the next sweep begins. In what is left there are minutes even for
/// a cycle of ten seconds.
const REFRESH: f64 = 0.6;

/// How long to wait after a sweep that failed, s.
const RETRY_S: f64 = 60.0;

const MICROS: f64 = 1e6;

/// What a plan is worth.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum PlanStatus {
    /// No sweep has been completed, or the last one is too old.
    None,
    /// There are gains for now.
    Good,
}

/// Gains along the time that is ahead.
#[derive(Debug, Clone)]
struct Table<T: RealField + Copy> {
    origin: Utc,
    step_s: f64,
    nodes: [Gains<T>; NODES],
}

/// A sweep that is going on.
#[derive(Debug, Clone, Copy)]
struct Running<T: RealField + Copy> {
    cost: Cost<T>,
    /// What is at the node that was reached last.
    ahead: Ahead<T>,
    /// Its number.
    node: u16,
}

/// The plan from cycle to cycle. `Default` has none.
#[derive(Debug, Clone)]
pub struct Plan<T: RealField + Copy = f32> {
    good: bool,
    table: Table<T>,
    next: Table<T>,
    running: Option<Running<T>>,
    failed: Option<Utc>,
}

impl<T: RealField + Copy> Default for Plan<T> {
    fn default() -> Self {
        let (table, next) = (Table::empty(), Table::empty());
        Self { good: false, table, next, running: None, failed: None }
    }
}

impl<T: RealField + Copy> Table<T> {
    fn empty() -> Self {
        let origin = Utc::from_micros_since_2000(0);
        Self { origin, step_s: 1.0, nodes: [Gains::zero(); NODES] }
    }

    /// How many nodes into the table an instant lies.
    fn place(&self, now: Utc) -> f64 {
        now.seconds_since(self.origin) / self.step_s
    }

    fn instant(&self, node: u16) -> Utc {
        self.origin.plus_micros((f64::from(node) * self.step_s * MICROS) as i64)
    }

    fn gains(&self, now: Utc) -> Option<Gains<T>> {
        let place = self.place(now);
        if place.is_nan() || place < 0.0 {
            return None;
        }
        let node = place as usize;
        let (left, right) = (self.nodes.get(node)?, self.nodes.get(node + 1)?);
        Some(left.towards(right, convert(place - node as f64)))
    }
}

impl<T: RealField + Copy> Plan<T> {
    /// One slice of work at most: a step of the sweep when one is due. `ahead` predicts what is at an
    /// instant; it is asked once, or twice as a sweep begins.
    pub fn work(
        &mut self,
        law: &PeriodicLaw<T>,
        now: Utc,
        mut ahead: impl FnMut(Utc) -> Option<Ahead<T>>,
    ) {
        if self.good && !(0.0..(NODES - 1) as f64).contains(&self.table.place(now)) {
            self.good = false;
        }
        let done = match self.running {
            Some(running) => self.step(law, &running, &mut ahead),
            None if self.is_due(now) => self.begin(law, now, &mut ahead),
            None => return,
        };
        if done.is_none() {
            self.running = None;
            self.failed = Some(now);
        }
    }

    /// The gains for now; `None` when there is no plan.
    pub fn gains(&self, now: Utc) -> Option<Gains<T>> {
        self.table.gains(now).filter(|_| self.good)
    }

    /// Whether there are gains for now.
    pub fn status(&self, now: Utc) -> PlanStatus {
        match self.gains(now) {
            Some(_) => PlanStatus::Good,
            None => PlanStatus::None,
        }
    }

    /// Forgets everything: the target is another one.
    pub fn forget(&mut self) {
        (self.good, self.running, self.failed) = (false, None, None);
    }

    fn is_due(&self, now: Utc) -> bool {
        let waits =
            self.failed.is_some_and(|failed| (0.0..RETRY_S).contains(&now.seconds_since(failed)));
        let old = self.table.place(now) > REFRESH * (NODES - 1) as f64;
        !waits && (old || !self.good)
    }

    fn begin(
        &mut self,
        law: &PeriodicLaw<T>,
        now: Utc,
        ahead: &mut impl FnMut(Utc) -> Option<Ahead<T>>,
    ) -> Option<()> {
        let step_s: f64 = try_convert(law.step_s)?;
        let horizon_s: f64 = try_convert(law.horizon_s)?;
        // The parameters bound it by 16 × NODES.
        let node = (horizon_s / step_s) as u16;
        self.next = Table { origin: now, step_s, nodes: [Gains::zero(); NODES] };
        let end = seen(ahead(self.next.instant(node))?)?;
        self.running = Some(Running { cost: Cost::terminal(), ahead: end, node });
        Some(())
    }

    fn step(
        &mut self,
        law: &PeriodicLaw<T>,
        running: &Running<T>,
        ahead: &mut impl FnMut(Utc) -> Option<Ahead<T>>,
    ) -> Option<()> {
        let node = running.node.checked_sub(1)?;
        let before = seen(ahead(self.next.instant(node))?)?;
        let step = law.model.step(&before, &running.ahead, law.step_s);
        let cost = running.cost.before(&step, law.step_s)?;
        if let Some(kept) = self.next.nodes.get_mut(usize::from(node)) {
            *kept = cost.gains();
        }
        self.running = Some(Running { cost, ahead: before, node });
        if node == 0 {
            core::mem::swap(&mut self.table, &mut self.next);
            (self.good, self.running, self.failed) = (true, None, None);
        }
        Some(())
    }
}

/// What can be reckoned with.
fn seen<T: RealField + Copy>(ahead: Ahead<T>) -> Option<Ahead<T>> {
    let Ahead { field, omega_t } = ahead;
    let finite = |v: &nalgebra::Vector3<T>| v.iter().all(ComplexField::is_finite);
    (finite(&field.xyz) && finite(&omega_t.xyz)).then_some(ahead)
}

#[cfg(test)]
mod tests {
    use super::super::PeriodicParameters;
    use super::super::model::tests::polar;
    use super::*;
    use crate::frames::Vector;

    fn law() -> PeriodicLaw<f64> {
        PeriodicLaw::new(&PeriodicParameters::default()).unwrap()
    }

    fn at(t_s: f64) -> Utc {
        Utc::from_micros_since_2000((t_s * MICROS) as i64)
    }

    fn world(utc: Utc) -> Option<Ahead<f64>> {
        Some(polar(utc.seconds_since(at(0.0))))
    }

    /// One slice a second from `from` for `seconds`.
    fn worked(
        plan: &mut Plan<f64>,
        from: u32,
        seconds: u32,
        world: impl Fn(Utc) -> Option<Ahead<f64>>,
    ) {
        for t in from..from + seconds {
            plan.work(&law(), at(f64::from(t)), &world);
        }
    }

    #[test]
    fn a_sweep_takes_one_slice_for_each_step_and_then_there_are_gains() {
        let mut plan = Plan::default();
        worked(&mut plan, 0, 90, world);
        assert_eq!(plan.status(at(90.0)), PlanStatus::None);
        worked(&mut plan, 90, 1, world);
        assert_eq!(plan.status(at(91.0)), PlanStatus::Good);
        // For the kept time from where it began.
        assert_eq!(plan.status(at(120.0 * 63.0 - 1.0)), PlanStatus::Good);
        assert_eq!(plan.status(at(120.0 * 63.0 + 1.0)), PlanStatus::None);
        assert_eq!(plan.status(at(-1.0)), PlanStatus::None, "a clock that was set back");
    }

    #[test]
    fn each_slice_asks_the_world_once() {
        let asked = core::cell::Cell::new(0);
        let counting = |utc| {
            asked.set(asked.get() + 1);
            world(utc)
        };
        let mut plan = Plan::default();
        for t in 0..91 {
            let before = asked.get();
            plan.work(&law(), at(f64::from(t)), counting);
            assert_eq!(asked.get() - before, 1);
        }
        worked(&mut plan, 91, 1000, |_| panic!("nothing is due"));
    }

    #[test]
    fn the_next_sweep_takes_over_without_a_gap_and_continues_the_last() {
        let mut plan = Plan::default();
        worked(&mut plan, 0, 91, world);
        let mut largest: f64 = 0.0;
        let mut last = plan.gains(at(91.0)).unwrap();
        for t in 91..20_000 {
            plan.work(&law(), at(f64::from(t)), world);
            let gains = plan.gains(at(f64::from(t))).expect("always a plan");
            largest = largest.max((gains.rate - last.rate).norm() / gains.rate.norm());
            last = gains;
        }
        // In a second the gains move by a part in a hundred; what one horizon saw less of than the next
        // adds as much.
        assert!(largest < 0.03, "{largest}");
    }

    #[test]
    fn a_sweep_that_fails_leaves_the_last_one_and_is_tried_again() {
        let mut plan = Plan::default();
        worked(&mut plan, 0, 91, world);
        let nowhere = |_: Utc| None;
        let bad = |_: Utc| {
            Some(Ahead { field: Vector::new(f64::NAN, 0.0, 0.0), omega_t: Vector::zero() })
        };
        worked(&mut plan, 4600, 500, nowhere);
        worked(&mut plan, 5100, 500, bad);
        assert_eq!(plan.status(at(5600.0)), PlanStatus::Good, "the last good sweep");
        assert_eq!(plan.status(at(7600.0)), PlanStatus::None, "has come to its end");
        worked(&mut plan, 7600, 160, world);
        assert_eq!(plan.status(at(7760.0)), PlanStatus::Good, "and the next one began");
    }

    #[test]
    fn another_target_is_another_plan() {
        let mut plan = Plan::default();
        worked(&mut plan, 0, 91, world);
        plan.forget();
        assert_eq!(plan.status(at(100.0)), PlanStatus::None);
        worked(&mut plan, 100, 91, world);
        assert_eq!(plan.status(at(200.0)), PlanStatus::Good);
    }

    #[test]
    fn in_f32_the_gains_are_those_of_f64() {
        // Of the gains' own size, over the whole of the table.
        const TOLERANCE: f64 = 2e-3;
        let mut exact = Plan::default();
        worked(&mut exact, 0, 91, world);
        let single = PeriodicLaw::<f32>::new(&PeriodicParameters::default()).unwrap();
        let mut plan = Plan::<f32>::default();
        for t in 0..91 {
            plan.work(&single, at(f64::from(t)), |utc| {
                world(utc).map(|ahead| Ahead {
                    field: ahead.field.to_f32(),
                    omega_t: ahead.omega_t.to_f32(),
                })
            });
        }
        for t in (91..7500).step_by(100) {
            let (a, b) =
                (exact.gains(at(f64::from(t))).unwrap(), plan.gains(at(f64::from(t))).unwrap());
            for (a, b) in [(a.attitude, b.attitude), (a.rate, b.rate), (a.torque, b.torque)] {
                assert!((b.cast::<f64>() - a).norm() < TOLERANCE * a.norm(), "{t}");
            }
        }
    }
}
