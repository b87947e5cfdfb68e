//! The covariance of N triples of states, kept as 3 × 3 blocks.
//!
//! Every state of the filter comes in threes (an axis each), so that its matrices are made of 3 × 3
//! blocks most of which are zero or the identity. What is zero is not multiplied:
//!
//! | step | equation | what is saved |
//! |---|---|---|
//! | [`Covariance::propagate`] | P⁺ = Φ P Φᵀ | only the first two triples (attitude, rate) move |
//! | [`Covariance::absorb`] | Joseph, one scalar after the other | hᵀ has one or two triples |
//!
//! A triple whose block is switched off has zero rows and columns and is passed over, so that a state
//! that does not fly costs memory alone.
//!
//! Source: Bierman (1977), §II.5, for the scalar Joseph update as two corrections of rank one.

use nalgebra::{ComplexField, Matrix3, RealField, Vector3, convert};

use super::block::{Block, COUNT};

/// One block for each triple.
pub(crate) type Triples<T> = [Matrix3<T>; COUNT];

/// A symmetric matrix of [`COUNT`] × [`COUNT`] blocks.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Covariance<T: RealField + Copy> {
    rows: [Triples<T>; COUNT],
}

/// How the two moving triples follow from all triples in one step: rows of Φ.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Transition<T: RealField + Copy> {
    /// Attitude after from every triple before; `None` where Φ is zero.
    pub(crate) attitude: [Option<Matrix3<T>>; COUNT],
    /// Rate after from every triple before.
    pub(crate) rate: [Option<Matrix3<T>>; COUNT],
}

/// One scalar measurement, linearised at the estimate.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Row<T: RealField + Copy> {
    /// What a small change of each triple does to the measurement; `None` where nothing.
    pub(crate) h: [Option<Vector3<T>>; COUNT],
    /// Measured minus expected.
    pub(crate) innovation: T,
    /// Variance of the measurement's noise.
    pub(crate) variance: T,
}

/// One vector for each triple.
pub(crate) type Step<T> = [Vector3<T>; COUNT];

impl<T: RealField + Copy> Row<T> {
    /// A measurement that sees these triples alone.
    pub(crate) fn new<const M: usize>(h: [(Block, Vector3<T>); M], innovation: T, variance: T) -> Self {
        let mut row = Self { h: [None; COUNT], innovation, variance };
        for (block, of_block) in h {
            if let Some(slot) = row.h.get_mut(block as usize) {
                *slot = Some(of_block);
            }
        }
        row
    }

    fn dot(&self, x: &Step<T>) -> T {
        let terms = self.h.iter().zip(x).filter_map(|(h, x)| h.map(|h| h.dot(x)));
        terms.fold(T::zero(), |sum, term| sum + term)
    }
}

impl<T: RealField + Copy> Covariance<T> {
    /// Nothing is uncertain.
    pub(crate) fn zeros() -> Self {
        Self { rows: [[Matrix3::zeros(); COUNT]; COUNT] }
    }

    /// The block of two triples.
    pub(crate) fn block(&self, row: Block, column: Block) -> Matrix3<T> {
        let found = self.rows.get(row as usize).and_then(|row| row.get(column as usize));
        found.copied().unwrap_or_else(Matrix3::zeros)
    }

    /// Sets a block and its mirror image.
    pub(crate) fn set(&mut self, row: Block, column: Block, block: &Matrix3<T>) {
        let mut put = |row: Block, column: Block, block: Matrix3<T>| {
            if let Some(slot) =
                self.rows.get_mut(row as usize).and_then(|row| row.get_mut(column as usize))
            {
                *slot = block;
            }
        };
        put(column, row, block.transpose());
        put(row, column, *block);
    }

    /// Adds to the block of one triple.
    pub(crate) fn add(&mut self, block: Block, more: &Matrix3<T>) {
        self.set(block, block, &(self.block(block, block) + more));
    }

    /// Forgets how a triple's error goes with the others', and gives it this covariance.
    pub(crate) fn renew(&mut self, block: Block, covariance: &Matrix3<T>) {
        for other in Block::ALL {
            self.set(block, other, &Matrix3::zeros());
        }
        self.set(block, block, covariance);
    }

    /// Variances of a triple.
    pub(crate) fn variance(&self, block: Block) -> Vector3<T> {
        self.block(block, block).diagonal()
    }

    /// P⁺ = Φ P Φᵀ, where `transition` moves attitude and rate and the others stay.
    pub(crate) fn propagate(&mut self, transition: &Transition<T>) {
        let attitude = self.times(&transition.attitude);
        let rate = self.times(&transition.rate);
        let corner = |left: &Triples<T>, right: &[Option<Matrix3<T>>; COUNT]| {
            let terms = left.iter().zip(right).filter_map(|(x, phi)| phi.map(|phi| x * phi.transpose()));
            terms.fold(Matrix3::zeros(), |sum, term| sum + term)
        };
        let half: T = convert(0.5);
        let symmetric = |m: Matrix3<T>| (m + m.transpose()) * half;
        let of_attitude = symmetric(corner(&attitude, &transition.attitude));
        let mixed = corner(&attitude, &transition.rate);
        let of_rate = symmetric(corner(&rate, &transition.rate));

        for (row, (of_attitude, of_rate)) in self.rows.iter_mut().zip(attitude.iter().zip(&rate)) {
            row[Block::Attitude as usize] = of_attitude.transpose();
            row[Block::Rate as usize] = of_rate.transpose();
        }
        self.rows[Block::Attitude as usize] = attitude;
        self.rows[Block::Rate as usize] = rate;
        self.set(Block::Attitude, Block::Attitude, &of_attitude);
        self.set(Block::Attitude, Block::Rate, &mixed);
        self.set(Block::Rate, Block::Rate, &of_rate);
    }

    /// A triple decays by `factor`.
    pub(crate) fn scale(&mut self, block: Block, factor: T) {
        for row in &mut self.rows {
            if let Some(slot) = row.get_mut(block as usize) {
                *slot *= factor;
            }
        }
        if let Some(row) = self.rows.get_mut(block as usize) {
            row.iter_mut().for_each(|slot| *slot *= factor);
        }
    }

    /// One row of Φ P.
    fn times(&self, phi: &[Option<Matrix3<T>>; COUNT]) -> Triples<T> {
        let mut sum = [Matrix3::zeros(); COUNT];
        for (phi, row) in phi.iter().zip(&self.rows) {
            let Some(phi) = phi else { continue };
            for (sum, p) in sum.iter_mut().zip(row) {
                *sum += phi * p;
            }
        }
        sum
    }

    /// P h.
    fn times_row(&self, row: &Row<T>) -> Step<T> {
        self.rows.map(|blocks| {
            let terms = blocks.iter().zip(&row.h).filter_map(|(p, h)| h.map(|h| p * h));
            terms.fold(Vector3::zeros(), |sum, term| sum + term)
        })
    }

    /// Absorbs one measurement; `step` is what earlier rows of the same instant have already added to
    /// the states, and takes what this one adds. Returns the squared innovation over its variance.
    ///
    /// `None`, and nothing changes, when the covariance gives the measurement a negative or no
    /// variance, or a number is not finite.
    pub(crate) fn absorb(&mut self, row: &Row<T>, step: &mut Step<T>) -> Option<T> {
        let ph = self.times_row(row);
        let innovation_variance = row.dot(&ph) + row.variance;
        let residual = row.innovation - row.dot(step);
        // Also refuses NaN.
        let sound = innovation_variance >= row.variance && row.variance > T::zero();
        if !(sound && innovation_variance.is_finite() && residual.is_finite()) {
            return None;
        }
        let gain = ph.map(|ph| ph / innovation_variance);
        for (step, gain) in step.iter_mut().zip(&gain) {
            *step += gain * residual;
        }
        // (I − k hᵀ) P, then times (I − k hᵀ)ᵀ, plus r k kᵀ.
        self.add_outer(&gain.map(|gain| -gain), &ph);
        let again = self.times_row(row);
        let mut rest = gain.map(|gain| gain * row.variance);
        for (rest, again) in rest.iter_mut().zip(&again) {
            *rest -= again;
        }
        self.add_outer(&rest, &gain);
        self.symmetrise();
        Some(residual * residual / innovation_variance)
    }

    /// P + x yᵀ.
    fn add_outer(&mut self, x: &Step<T>, y: &Step<T>) {
        for (row, x) in self.rows.iter_mut().zip(x) {
            if *x == Vector3::zeros() {
                continue;
            }
            for (block, y) in row.iter_mut().zip(y) {
                *block += x * y.transpose();
            }
        }
    }

    /// P = (P + Pᵀ) / 2.
    fn symmetrise(&mut self) {
        let half: T = convert(0.5);
        for row in Block::ALL {
            for column in Block::ALL.into_iter().take(row as usize + 1) {
                let mean = (self.block(row, column) + self.block(column, row).transpose()) * half;
                self.set(row, column, &mean);
            }
        }
    }

    /// Whether every number is finite and no variance negative.
    pub(crate) fn is_sound(&self) -> bool {
        let finite = self.rows.iter().flatten().flat_map(Matrix3::iter).all(ComplexField::is_finite);
        finite && Block::ALL.into_iter().all(|block| self.variance(block).min() >= T::zero())
    }
}
