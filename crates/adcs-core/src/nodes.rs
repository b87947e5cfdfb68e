//! Values at a slow rate, kept for the instants between them.
//!
//! What is costly is evaluated at *nodes*: instants at whole multiples of a spacing from an origin.
//! Nodes do not depend on when they were first needed, so that a value between them has the same
//! bits whatever was asked for before.

use crate::time::{MICROS_PER_SECOND, Utc};
use core::num::NonZeroU16;

/// The instants of the nodes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Grid {
    origin: Utc,
    spacing_s: NonZeroU16,
}

impl Grid {
    pub(crate) const fn new(origin: Utc, spacing_s: NonZeroU16) -> Self {
        Self { origin, spacing_s }
    }

    pub(crate) fn spacing_s(&self) -> f64 {
        f64::from(self.spacing_s.get())
    }

    fn spacing_micros(&self) -> i64 {
        i64::from(self.spacing_s.get()) * MICROS_PER_SECOND
    }

    /// The node at or before `now`, and how far on the way to the next one `now` is, 0 to 1.
    pub(crate) fn place(&self, now: Utc) -> (i64, f64) {
        let micros = now.micros_since(self.origin);
        let since_node = micros.rem_euclid(self.spacing_micros());
        let index = micros.div_euclid(self.spacing_micros());
        (index, since_node as f64 / self.spacing_micros() as f64)
    }

    /// The instant of a node.
    pub(crate) fn instant(&self, index: i64) -> Utc {
        self.origin.plus_micros(index.saturating_mul(self.spacing_micros()))
    }
}

/// The values at a node and at the next one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct NodePair<N> {
    pub(crate) index: i64,
    pub(crate) left: N,
    pub(crate) right: N,
}

impl<N: Copy> NodePair<N> {
    /// The pair at `index`: what is `held` is used again, so that the next or the previous pair
    /// costs one evaluation, any other two, and the same one none.
    pub(crate) fn at<E>(
        index: i64,
        held: Option<Self>,
        mut evaluate: impl FnMut(i64) -> Result<N, E>,
    ) -> Result<Self, E> {
        let next = index.saturating_add(1);
        let of_held = |node: i64| {
            let held = held?;
            match node {
                node if node == held.index => Some(held.left),
                node if node == held.index.saturating_add(1) => Some(held.right),
                _ => None,
            }
        };
        let left = of_held(index).map_or_else(|| evaluate(index), Ok)?;
        let right = of_held(next).map_or_else(|| evaluate(next), Ok)?;
        Ok(Self { index, left, right })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::convert::Infallible;
    use proptest::prelude::*;

    const SPACING_S: NonZeroU16 = NonZeroU16::new(60).unwrap();

    #[test]
    fn steps_to_a_neighbour_evaluate_one_node_and_jumps_two() {
        let mut held = None;
        for (index, evaluations) in
            [(5, 2), (5, 0), (6, 1), (5, 1), (100, 2), (98, 2), (99, 1), (99, 0)]
        {
            let mut asked = 0;
            let pair = NodePair::at(index, held, |node| {
                asked += 1;
                Ok::<i64, Infallible>(10 * node)
            });
            let pair = pair.unwrap();
            assert_eq!((pair.left, pair.right), (10 * index, 10 * index + 10));
            assert_eq!(asked, evaluations, "to {index}");
            held = Some(pair);
        }
    }

    #[test]
    fn a_node_that_fails_leaves_no_pair() {
        let fails = NodePair::at(7, None, |node| if node == 8 { Err("decayed") } else { Ok(node) });
        assert_eq!(fails, Err("decayed"));
    }

    proptest! {
        #[test]
        fn an_instant_lies_between_its_nodes(
            origin in -1_000_000_000_000_000_i64..1_000_000_000_000_000,
            now in -100_000_000_000_000_000_i64..100_000_000_000_000_000,
        ) {
            let grid = Grid::new(Utc::from_micros_since_2000(origin), SPACING_S);
            let now = Utc::from_micros_since_2000(now);
            let (index, fraction) = grid.place(now);
            prop_assert!((0.0..1.0).contains(&fraction));
            prop_assert!(grid.instant(index) <= now && now < grid.instant(index + 1));
            let seconds = now.seconds_since(grid.instant(index));
            prop_assert!((seconds - 60.0 * fraction).abs() < 1e-12);
        }

        #[test]
        fn no_instant_overflows(origin: i64, now: i64) {
            let grid = Grid::new(Utc::from_micros_since_2000(origin), SPACING_S);
            let (index, fraction) = grid.place(Utc::from_micros_since_2000(now));
            prop_assert!((0.0..1.0).contains(&fraction));
            let _ = grid.instant(index.saturating_add(1));
        }
    }
}
