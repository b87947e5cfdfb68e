//! Many positions, a block of them at a time.

use core::iter;

/// How many positions are evaluated side by side: what fills a vector register of 128 bits in f32,
/// and two of them in f64. More do not fit the registers of a processor that has sixteen.
pub(crate) const BLOCK: usize = 4;

/// Something for each position of a block.
pub(crate) type Block<T> = [T; BLOCK];

/// What `evaluate` gives for each of the positions, in their order. It is always given a whole
/// block; in the last one, places that are left over have the first position of the block again.
pub(crate) fn in_blocks<P: Copy, F>(
    positions: impl IntoIterator<Item = P>,
    evaluate: impl Fn(Block<P>) -> Block<F>,
) -> impl Iterator<Item = F> {
    let mut positions = positions.into_iter().fuse();
    iter::from_fn(move || {
        let mut block = [positions.next()?; BLOCK];
        let rest = block.iter_mut().skip(1).zip(&mut positions);
        let count = 1 + rest.map(|(slot, position)| *slot = position).count();
        Some((block, count))
    })
    .flat_map(move |(block, count)| evaluate(block).into_iter().take(count))
}
